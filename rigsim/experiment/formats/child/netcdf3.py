"""netCDF of the classic form, by SciPy."""

import io

import numpy as np
from scipy.io import netcdf_file

from .found import columns, fitting, spoken


def contents(file, most):
    """Columns of a netCDF 3 file, and what it says beside them."""
    size = file.seek(0, 2)
    file.seek(0)
    found, said = [], {}
    with netcdf_file(file, mmap=False, maskandscale=True) as opened:
        for name, variable in opened.variables.items():
            values = np.ma.filled(np.ma.asarray(variable[...], dtype=float), np.nan)
            unit = getattr(variable, "units", b"")
            for one in columns(name, np.asarray(values)):
                one.unit = unit.decode("utf-8", "replace") if isinstance(unit, bytes) else str(unit)
                found.append(one)
        for name, value in opened._attributes.items():
            said[name] = value.decode("utf-8", "replace") if isinstance(value, bytes) else float(np.ravel(value)[0])
    return fitting(found, most, size), {"rigsim_record": said["rigsim_record"]} if "rigsim_record" in said else spoken(
        said
    )


def rehearse():
    """Load what reading needs."""
    with io.BytesIO() as file:
        opened = netcdf_file(file, "w")
        opened.createDimension("time", 4)
        opened.createVariable("force", "d", ("time",))[:] = 1.0
        opened.flush()
        made = io.BytesIO(file.getvalue())
    contents(made, 1000)
