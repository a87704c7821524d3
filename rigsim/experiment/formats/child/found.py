"""What a reader found: a column, and how to take its samples."""

import re
from dataclasses import dataclass, field

import numpy as np

_MOST = 512  # columns
_LONGEST = 1 << 16  # characters of a text


@dataclass
class Found:
    """A column: its samples are ``take()``, an array of ``samples`` numbers; ``why`` it has none, if so."""

    name: str
    samples: int
    take: object
    unit: str = ""
    interval: float | None = None  # s
    why: str = ""
    own: dict = field(default_factory=dict)


def fitting(found, most, size):
    """The list, if its samples take no more bytes than ``most``."""
    if len(found) > _MOST:
        raise ValueError(f"it holds more than {_MOST} variables")
    declared = sum(8 * one.samples for one in found if not one.why)
    if declared > most:
        raise ValueError(f"it declares {declared} bytes of samples; expected at most {most} in {size} bytes")
    return found


def arrays(named):
    """Columns and what is said beside them, of a dict of arrays, numbers and texts (or such dicts)."""
    found, said = [], {}
    for name, value in flat(named):
        array = np.asarray(value)
        if array.dtype.kind in "US" and array.size == 1:
            said[name] = str(array.ravel()[0])[:_LONGEST]
        elif array.size == 1 and array.dtype.kind in "iuf":
            said[name] = float(array.ravel()[0])
        elif array.size:
            found += columns(name, array)
    return found, said


def flat(named, before="", depth=0):
    """Names and values, those within values after a slash."""
    for name, value in named.items():
        if isinstance(value, dict) and depth < 4:
            yield from flat(value, f"{before}{name}/", depth + 1)
        else:
            yield f"{before}{name}", value


def columns(name, array):
    """`Found` of an array: itself, or its columns (or rows, where those are longer)."""
    if array.dtype.kind in "mM":
        array = np.ravel(array)
        seconds = (array - array[:1]) / np.timedelta64(1, "s")
        return [Found(name, seconds.size, lambda: seconds, "s")]
    if array.dtype.kind not in "iuf" or array.dtype.itemsize > 8:
        return [Found(name, 0, None, why=f"variable {name!r} holds no real numbers of at most 8 bytes; expected such")]
    array = np.squeeze(array)
    if array.ndim == 1:
        return [Found(name, array.size, lambda: array)]
    if array.ndim != 2:
        return [Found(name, 0, None, why=f"variable {name!r} has {array.ndim} dimensions; expected one or two")]
    array = array.T if array.shape[0] > array.shape[1] else array
    take = lambda index: lambda: array[index]  # noqa: E731
    return [Found(f"{name}.{index}", array.shape[1], take(index)) for index in range(min(len(array), _MOST + 1))]


def spoken(said):
    """What names of numbers and texts say of all samples, as details of a record: rate, hold, units."""
    details = {}
    for name, value in said.items():
        word = re.sub(r"[^a-z]", "", name.rpartition("/")[2].casefold())
        number = value if isinstance(value, float) and value > 0 and np.isfinite(value) else None
        if number and word in _RATES:
            details.setdefault("sample_rate", number)
        elif number and word in _STEPS:
            details.setdefault("sample_rate", 1 / number)
        elif isinstance(value, str) and word == "hold":
            details.setdefault("hold", value)
    return details


_RATES = (
    "fs",
    "samplerate",
    "samplingrate",
    "samplefrequency",
    "samplingfrequency",
    "samplefreq",
    "sr",
    "fsample",
    "rate",
)
_STEPS = ("dt", "ts", "sampletime", "samplingtime", "sampleinterval", "samplinginterval", "sampleperiod", "tsample",
          "samplingperiod", "timestep", "deltat", "deltax", "wfincrement", "increment")  # fmt: skip
