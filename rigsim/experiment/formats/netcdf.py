"""netCDF 4 by xarray: a variable a channel, details as JSON in an attribute."""

import json

UNITS = {"time": "s", "force": "N", "shaker": "m", "mass": "m", "tilt": "rad"}


def write(path, details, channels):
    """Write channels as variables over time, with their units."""
    import xarray as xr

    variables = {name: ("time", values, {"units": UNITS[name]}) for name, values in channels.items()}
    dataset = xr.Dataset(variables, attrs={"rigsim_record": json.dumps(details)})
    dataset.to_netcdf(path, engine="h5netcdf")


def read(path):
    """Details and channels of a file in that form."""
    import xarray as xr

    try:
        # decode_times would turn a time in seconds into calendar differences.
        with xr.open_dataset(path, engine="h5netcdf", decode_times=False) as dataset:
            details = json.loads(dataset.attrs.get("rigsim_record", "null"))
            channels = {str(name): dataset[name].values for name in dataset.data_vars}
    except FileNotFoundError:
        raise
    except (OSError, ValueError, TypeError) as error:
        raise ValueError(f"{path} cannot be read as a record: {' '.join(str(error).split())}") from None
    if not isinstance(details, dict):
        raise ValueError(f"{path} is not a record; expected an attribute rigsim_record")
    return details, channels
