"""Universal files, data sets 58 and 58b, by pyuff."""

import io
import itertools
import os
import warnings

import numpy as np
import pyuff
import pyuff.pyuff

from .found import Found, fitting

_TIME = 1  # of a function's types: a response in time


def contents(file, most):
    """Functions of time of a universal file, by their names or their nodes."""
    size = file.seek(0, 2)
    # pyuff opens a name: it gets the file that is open.
    pyuff.pyuff.open = lambda *_, **__: _Kept(file)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        opened = pyuff.UFF(os.fspath(__file__))
        types = [str(kind).strip() for kind in opened.get_set_types()]
        numbers = [index for index, kind in enumerate(types) if kind in ("58", "58b", "58.0")]
        sets = [opened.read_sets(number) for number in numbers[:513]]
    if not sets:
        raise ValueError("it holds no data set 58 or 58b")
    found, names = [], {}
    for one in sets:
        number = names[_name(one)] = names.get(_name(one), 0) + 1
        name = _name(one) if number == 1 else f"{_name(one)} ({number})"
        found.append(_column(name, one))
    return fitting(found, most, size), {}


def _name(one):
    """What a data set is called: its first line, or the place of the response."""
    text = str(one.get("id1", "")).strip()
    if text and text.casefold() not in ("none", "null"):
        return text
    return f"{str(one.get('rsp_ent_name', '')).strip()}:{one.get('rsp_node')}:{one.get('rsp_dir')}".strip(":")


def _column(name, one):
    data = np.asarray(one["data"])
    if np.iscomplexobj(data) or int(one.get("func_type", _TIME)) not in (0, _TIME):
        return Found(name, 0, None, why=f"data set {name!r} is no function of time but a spectrum or the like")
    said = int(one.get("num_pts") or data.size)
    if said != data.size:
        why = f"data set {name!r} has {data.size} samples; expected {said}, as it says"
        return Found(name, 0, None, why=why)
    unit = str(one.get("ordinate_axis_units_lab", "")).strip()
    unit = "" if unit.casefold() in ("none", "null", "nounit") else unit
    x = np.asarray(one["x"], dtype=float)
    steps = np.diff(x)
    even = x.size > 1 and abs(steps - steps.mean()).max() <= 1e-3 * abs(steps.mean())
    if not even:
        return Found(name, 0, None, why=f"data set {name!r} is not evenly spaced in time")
    return Found(name, data.size, lambda: data, unit, float(steps.mean()))


class _Kept(io.BufferedIOBase):
    """An open file that stays open, from its beginning."""

    def __init__(self, file):
        self._file = file
        file.seek(0)

    def __getattr__(self, name):
        return getattr(self._file, name)

    def read(self, *size):
        """As the file."""
        return self._file.read(*size)

    def readline(self, *size):
        """As the file."""
        return self._file.readline(*size)

    def seek(self, *place):
        """As the file."""
        return self._file.seek(*place)

    def tell(self):
        """As the file."""
        return self._file.tell()

    def readlines(self, *size):
        """As the file."""
        return self._file.readlines(*size)

    def close(self):
        """Not at all."""


def rehearse():
    """Load what reading needs."""
    fields = {
        2: "force", 3: "NONE", 4: "NONE", 5: "NONE", 6: "NONE",
        7: "    1         0    1         0       NONE         1   3       NONE         0   0",
        8: "         4         3         1  0.00000e+00  5.00000e-04  0.00000e+00",
        9: "        17    0    0    0                 NONE                    s",
        10: "        13    0    0    0                 NONE                    N",
        11: "         0    0    0    0                 NONE                 NONE",
        12: "         0    0    0    0                 NONE                 NONE",
    }  # fmt: skip
    lines = ["    -1", "    58", *fields.values(), "".join(f"{value:20.11e}" for value in (1, 2, 3)), "    -1", ""]
    contents(io.BytesIO("\n".join(itertools.chain(lines)).encode()), 1000)
