"""netCDF 4 by xarray, written: a variable a channel, details as JSON in an attribute. `binary` reads it."""

import io
import json


def write(file, details, channels, units):
    """Write channels as variables over time, with their units."""
    import xarray as xr

    variables = {name: ("time", values, {"units": units[name]}) for name, values in channels.items()}
    dataset = xr.Dataset(variables, attrs={"rigsim_record": json.dumps(details)})
    dump(file, dataset)


def dump(file, dataset):
    """Write an `xarray.Dataset` to a file open for bytes."""
    whole = io.BytesIO()  # libhdf5 does not survive a full disk; writing bytes does
    dataset.to_netcdf(whole, engine="h5netcdf")
    file.write(whole.getbuffer())
