"""Comma-separated text: a line ``# {...}`` of details as JSON, a line of channel names, then a line a sample."""

import csv
import io
import itertools
import json
import re
import reprlib

import numpy as np

from . import details as json_details
from .regular import opened

_NUMBER = re.compile(r"\s*[+-]?((\d+\.?\d*|\.\d+)(e[+-]?\d+)?|nan|inf(inity)?)\s*", re.IGNORECASE | re.ASCII)
_LONGEST, _MOST = json_details.LONGEST, 64  # characters in a line, columns
_ENDS = ("\n", "\r")


def write(file, details, channels, units):  # noqa: ARG001
    """Write every digit of every channel but the time, which the sample rate gives, and how many samples there are."""
    names = [name for name in channels if name != "time"]
    values = np.column_stack([channels[name] for name in names])
    header = f"# {json.dumps(details | {'samples': len(values)})}\n{','.join(names)}"
    np.savetxt(file, values, fmt="%.17g", delimiter=",", header=header, comments="", encoding="utf-8")


def read(path):
    """Details and channels of a file in that form, or in what a spreadsheet makes of it; it says no units."""
    with opened(path) as (file, size):
        # Spreadsheets put a byte order mark first; bytes that are no text fail where they stand.
        text = io.TextIOWrapper(file, encoding="utf-8-sig", errors="surrogateescape", newline="")
        lines = _Lines(path, text, size)
        details, names = _details(lines), _names(lines)
        values = _values(lines, names)
        if "samples" in details and not lines.line.endswith(_ENDS):
            raise lines.fault("the file is cut off here; expected the end of a line")
    return details, dict(zip(names, values.T, strict=True)), {}


class _Lines:
    """Lines of a text file, none longer than is allowed, no more than the file held when it was opened."""

    def __init__(self, path, text, size):
        self.path, self._text, self._left = path, text, size
        self.line, self.number, self.faulty = "", 0, False

    def __iter__(self):
        return self

    def __next__(self):
        line = self._text.readline(_LONGEST + 1)
        if not line:
            raise StopIteration
        self.line, self.number, self._left = line, self.number + 1, self._left - len(line)
        if self._left < 0:
            raise OSError(f"{self.path} grew while it was read")
        if len(line) > _LONGEST:
            raise self.fault(f"longer than {_LONGEST} characters")
        if line.count('"') % 2:
            raise self.fault("a quote is not closed")
        return line

    def fault(self, text):
        """The error that says what is wrong with the line last read."""
        self.faulty = True
        return ValueError(f"{self.path} cannot be read as a record: line {self.number or 1}, {text}")


def _details(lines):
    first = next(lines, "")
    _utf8(lines)
    if not first.startswith("#"):
        expected = f"a line such as # {json_details.EXAMPLE}, a line of channel names and as many columns"
        raise lines.fault(f"{reprlib.repr(first.strip())} begins no record; expected {expected}")
    # A blank in place of the mark keeps the count of characters.
    return json_details.parse(" " + first[1:], f"{lines.path}: line 1")


def _names(lines):
    line = next(lines, "")
    _utf8(lines)
    names = [name.strip() for name in _cells(line)]
    if not 1 < len(names) <= _MOST:
        said = f"{reprlib.repr(line.strip())} names {len(names)} channel(s)"
        raise lines.fault(f"{said}; expected 2 to {_MOST} names with commas between them")
    for name in names:
        if names.count(name) > 1:
            raise lines.fault(
                f"names the channel {reprlib.repr(name)[1:-1]} {names.count(name)} times; expected each once"
            )
    return names


def _utf8(lines):
    try:
        lines.line.encode()
    except UnicodeEncodeError as error:
        raise lines.fault(f"character {error.start + 1} is not UTF-8 text") from None


def _values(lines, names):
    """Samples, shape (n, names)."""
    try:
        first = next((line for line in lines if line.strip()), None)
        if first is None:
            raise lines.fault("no samples follow; expected a line a sample")
        if len(_cells(first)) != len(names):
            raise ValueError
        # No comments: a remark between samples says that something happened there.
        every = itertools.chain([first], lines)
        return np.loadtxt(every, delimiter=",", quotechar='"', comments=None, ndmin=2)
    except ValueError as error:
        if lines.faulty:
            raise
        raise lines.fault(_trouble(lines.line, names) or error) from None


def _trouble(line, names):
    """What is wrong with a line of samples."""
    cells = _cells(line)
    if len(cells) != len(names):
        return f"{len(cells)} columns; expected {len(names)}, as many columns as names, with commas between them"
    for column, (cell, name) in enumerate(zip(cells, names, strict=True), 1):
        if not _NUMBER.fullmatch(cell):
            return (
                f"column {column} ({reprlib.repr(name)}): {reprlib.repr(cell)} is not a number; expected one as 1.5e-3"
            )
    return None


def _cells(line):
    return next(csv.reader([line.rstrip("\r\n")], skipinitialspace=True), [])
