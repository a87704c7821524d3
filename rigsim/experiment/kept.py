"""Results of tests as files that explain themselves: numbers of every point, units, settings, rigs and versions."""

import enum
import json
import platform
from dataclasses import fields, is_dataclass
from importlib.metadata import version
from pathlib import Path

import numpy as np

from .. import __version__, checks
from ..results import frame
from .formats import chosen, netcdf
from .saving import written

_PACKAGES = ("numpy", "scipy", "numba", "pymunk")  # whose versions may change the last digits
_LONG = 1000  # numbers of a setting that are told by their first and last, being even steps
# Of what a point has, by the name of the field: what is counted or said has no unit, and all else is a share.
_UNITS = {
    "frequency": "Hz", "force": "N", "feedback": "N", "phase": "deg", "shaker": "m", "mass": "m",
    "relative": "m", "amplitude": "m", "tilt": "rad", "velocity": "m/s", "time": "s", "begin": "s", "dwell": "s",
    "sample_rate": "Hz", "gains": "N/m, N s/m, N/m, N s/m", "suspension": "N s/m, N/m, N/m^3",
    "given": "N, V, 1", "traces": "m, m, rad", "trace": "N, m, m",
} | dict.fromkeys(("run", "rig", "tries", "segments", "status", "message"), "")  # fmt: skip


class Kept:
    """Results of tests of rigs, a sequence of points or arrays with a row a point, which can be kept as files.

    ``units`` are those of points' fields by name, where a class means something else by it than the others do.
    """

    units = {}

    def points(self):
        """What is known of each point: values by name, one a point. Those of a sequence are fields of its members."""
        names = [field.name for field in fields(self[0]) if field.name != "parameters"] if len(self) else []
        return {name: [getattr(one, name) for one in self] for name in names}

    def save(self, path):
        """Write the numbers of every point, whole or not at all; the suffix chooses the format.

        ``.nc``: netCDF 4, a variable for each quantity over "point", with its unit, complex ones as two, real and
        imaginary. Rigs, settings, seeds and the versions of what computed them are one attribute, "rigsim", as JSON.
        ``.csv``: the same details in a first line ``# {...}``, then a table with units in its head; without traces.

        Parameters
        ----------
        path : str or path
            An existing file is replaced.

        Raises
        ------
        ValueError
            If the suffix is neither.
        """
        path = Path(checks.path("path", path))
        write = chosen(path, {".nc": _write_netcdf, ".csv": _write_csv})
        known = self.points()
        numbers, details = _numbers(known, _UNITS | self.units), json.dumps(_details(self, known))
        written(path, lambda file: write(file, numbers, details), "result")


def _numbers(points, units):
    """Arrays with a row a point and their units, by name; complex ones as two."""
    found = {}
    for name, values in points.items():
        unit = units.get(name, "1")
        shape = next((np.shape(value) for value in values if value is not None), ())
        if any(isinstance(value, (str, enum.Enum)) for value in values):
            found[name] = np.array([str(value) for value in values]), unit
            continue
        # Points without a trace, or with shorter ones, beside those that have some.
        longest = max((np.shape(value)[-1] for value in values if value is not None), default=0) if shape else 0
        rows = np.full((len(values), *shape[:-1], longest) if shape else len(values), np.nan, complex)
        for row, value in zip(rows if shape else rows[:, None], values, strict=True):
            if value is not None:
                row[..., : np.shape(value)[-1] if shape else 1] = value
        if any(np.iscomplexobj(value) for value in values):
            found |= {f"{name}_real": (rows.real, unit), f"{name}_imaginary": (rows.imag, unit)}
        else:
            whole = all(isinstance(value, (int, np.integer)) for value in values)
            found[name] = rows.real.astype(int) if whole else rows.real, unit
    return found


def _details(result, points):
    """Kind, versions and settings of a result, as JSON has them."""
    versions = {"rigsim": __version__, "python": platform.python_version()}
    versions |= {package: version(package) for package in _PACKAGES}
    others = [field.name for field in fields(result) if field.name not in points and field.name != "members"]
    settings = {name: _plain(getattr(result, name)) for name in others}
    if "rig" in points:  # the number of one among those that differ
        settings["parameters"] = _plain(tuple(dict.fromkeys(result.parameters)))
    return {"kind": type(result).__name__, "summary": result.summary(), "versions": versions, "settings": settings}


def _plain(value):
    """A setting as JSON can have it."""
    if is_dataclass(value):
        return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, np.ndarray) and value.ndim == 1 and value.size > _LONG:
        return {"first": float(value[0]), "last": float(value[-1]), "count": value.size}
    if isinstance(value, (tuple, list, np.ndarray)):
        return [_plain(one) for one in value]
    if isinstance(value, dict):
        return {str(name): _plain(one) for name, one in value.items()}
    if isinstance(value, enum.Enum):
        return str(value)
    return value.item() if isinstance(value, np.generic) else value


def _write_netcdf(file, numbers, details):
    import xarray as xr

    variables = {}
    for name, (values, unit) in numbers.items():
        within = [f"{name.removesuffix('_real').removesuffix('_imaginary')}_{axis}" for axis in range(1, values.ndim)]
        variables[name] = (["point", *within], values, {"units": unit} if unit else {})
    netcdf.dump(file, xr.Dataset(variables, attrs={"rigsim": details}))


def _write_csv(file, numbers, details):
    columns = {}
    for name, (values, unit) in numbers.items():
        if name in ("trace", "traces"):
            continue
        flat = values.reshape(len(values), -1)
        told = unit.split(", ") if ", " in unit else [unit] * flat.shape[1]
        for number, column in enumerate(flat.T):
            head = name if values.ndim == 1 else f"{name}_{number}"
            columns[f"{head} [{told[number]}]" if told[number] else head] = column
    file.write(f"# {details}\n".encode())
    file.write(frame(columns).to_csv(index=False, float_format="%.17g").encode())
