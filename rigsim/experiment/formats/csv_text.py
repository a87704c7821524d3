"""Text: what `Record.save` writes, and rows of numbers as other programs write them.

Saved records begin with a line ``# {...}`` of details as JSON, then a line of channel names, then a line a sample. Of
other files `sniff` finds out how they are laid out. Samples are read in pieces, and no row is passed over: what is no
row of numbers is named with its line and column.
"""

import contextlib
import csv
import gzip
import io
import json
import re
import reprlib
import zlib
from contextlib import contextmanager

import numpy as np

from ..on_disk import Room
from . import details as json_details
from . import headings, sniff
from .contents import Column, Contents
from .regular import opened

_LONGEST, _MOST = json_details.LONGEST, 512  # characters in a line, columns
_HEAD = 400  # lines that are looked at first
_PIECE = 1 << 22  # characters read at once
_EXPANDS = 300  # how much larger than the file its text may be
_FORTRAN = re.compile(r"\d[dD][+-]?\d")
_BINARY = {b"\x89HDF": "HDF5", b"PK\x03\x04": "a zip archive such as .xlsx or .npz", b"TDSm": "TDMS", b"MATLAB": "MAT"}


def write(file, details, channels, units):  # noqa: ARG001
    """Write every digit of every channel but the time, which the sample rate gives, and how many samples there are."""
    names = [name for name in channels if name != "time"]
    values = np.column_stack([channels[name] for name in names])
    header = f"# {json.dumps(details)}\n{','.join(names)}"
    np.savetxt(file, values, fmt="%.17g", delimiter=",", header=header, comments="", encoding="utf-8")


def write_compressed(file, details, channels, units):
    """The same in gzip's form."""
    with gzip.GzipFile(filename="", fileobj=file, mode="wb", mtime=0) as packed:
        write(packed, details, channels, units)


@contextmanager
def look(path):
    """`Contents` of a text file, to be read within the block."""
    with opened(path) as (file, size), _told(path), _unpacked(file, size) as (plain, most):
        head = plain.peek(1 << 16)[: 1 << 16]
        for mark, kind in _BINARY.items():
            if head.startswith(mark):
                raise ValueError(f"{path} cannot be read as text: it is {kind}; expected a name that ends so")
        encoding = sniff.encoding_of(head)
        text = io.TextIOWrapper(plain, encoding=encoding, errors="surrogateescape", newline=None)
        yield _Text(path, text, most, size, encoding).contents()


@contextmanager
def _told(path):
    """What a damaged archive or another encoding makes of reading, in one line."""
    try:
        yield
    except (EOFError, zlib.error, gzip.BadGzipFile, UnicodeError) as error:
        raise ValueError(f"{path} cannot be read as a record: {' '.join(str(error).split())}") from None


@contextmanager
def _unpacked(file, size):
    """The file or, where it is compressed, what it holds, and how many characters that may be."""
    if file.peek(2)[:2] != b"\x1f\x8b":
        yield file, size
        return
    with gzip.GzipFile(fileobj=file) as plain:
        yield io.BufferedReader(plain, 1 << 16), 1_000_000 + _EXPANDS * size


class _Text:
    """Lines of a text file, none longer than is allowed, no more than the file held when it was opened."""

    def __init__(self, path, text, most, size, encoding):
        self.path, self._text, self._left, self._size = path, text, most, size
        self.encoding, self.blank, self.gaps = encoding, None, False

    def fault(self, number, text):
        """The error that says what is wrong with the line of that number, from 1."""
        return ValueError(f"{self.path} cannot be read as a record: line {number}, {text}")

    def _read(self, how, size):
        """Characters read."""
        text = how(size)
        self._left -= len(text)
        if self._left < 0:
            raise OSError(f"{self.path} grew while it was read, or holds much more text than its size allows")
        return text

    def contents(self):
        """Look at the first lines."""
        self.lines = []
        while len(self.lines) < _HEAD and (line := self._read(self._text.readline, _LONGEST + 1)):
            if len(line) > _LONGEST:
                raise self.fault(len(self.lines) + 1, f"longer than {_LONGEST} characters")
            self.lines.append(line)
        first = _joined(self.lines[0]) if self.lines else ""
        details, own = {}, bool(re.match(r"#\s*\{", first))
        if own:
            details = _own_details(first, self.path)
        plain = [line.rstrip("\n") for line in self.lines]
        self.layout = layout = sniff.layout_of(plain[own:])
        if layout is None:
            told = f"begins with {reprlib.repr(plain[0].strip())}" if plain else "it is empty"
            raise ValueError(
                f"{self.path} cannot be read as a record: no rows of numbers, as many in each, are found ({told}); "
                f"expected names of channels and a line a sample, perhaps after a line # {json_details.EXAMPLE}"
            )
        if layout.width > _MOST:
            raise self.fault(layout.start + own + 1, f"{layout.width} columns; expected at most {_MOST}")
        self.start = layout.start + own
        if own and not any(layout.names) and self.start > 1:
            names = len(sniff.cells(plain[self.start - 1], layout.separator))
            raise self.fault(self.start + 1, f"{layout.width} columns below {names} names; expected as many columns")
        said, notes = headings.said_in(layout.header, self.path)
        for key, value in said.items():
            details.setdefault(key, value)
        rows = [sniff.cells(line, layout.separator) for line in plain[self.start : self.start + 3] if line.strip()]
        columns = [
            Column(name, layout.units[index], first=[row[index] if index < len(row) else "" for row in rows])
            for index, name in enumerate(layout.names)
        ]
        self.said = details
        if not own or layout.separator != ",":
            notes.insert(0, layout.form)
        if self.encoding in ("cp1252", "latin-1"):
            notes.append("characters of Western Europe")
        return Contents(
            layout.form, columns, self.values, self.place, details, own, notes, self.count, stamps=layout.stamps
        )

    def _pieces(self):
        """Lists of whole lines of samples, each with the number of its first line, from 1."""
        number, rest = self.start + 1, "".join(self.lines[self.start :])
        while True:
            more = self._read(self._text.read, _PIECE)
            lines = (rest + more).split("\n")
            rest = lines.pop() if more else ""
            if len(rest) > _LONGEST:
                raise self.fault(number + len(lines), f"longer than {_LONGEST} characters")
            if not more and lines and not lines[-1]:
                lines.pop()
            elif not more:
                self.cut = number + len(lines) - 1
            yield number, lines
            number += len(lines)
            if not more:
                return

    def count(self):
        """How many rows there are; takes them away."""
        return sum(sum(not _blank(line) for line in lines) for _, lines in self._pieces())

    def place(self, column, sample):
        """Where a sample stands."""
        return f"row {sample + 1} of numbers" if self.gaps else f"line {self.start + 1 + sample}, column {column + 1}"

    def values(self, indices, use):
        """What ``use`` makes of the samples of those columns; those of stamps are seconds."""
        per_row = max(np.mean([len(line) for line in self.lines[self.start :]]), 2)
        expected = int(1.02 * self._size / per_row) + 1000
        found, self.cut = [Room(expected) for _ in indices], None
        for number, lines in self._pieces():
            for part in _numbers(self, number, lines, indices):
                for channel, values in zip(found, part, strict=True):
                    channel.add(values)
        count = found[0].size if found else 0
        if not count:
            raise self.fault(self.start + 1, "no samples follow; expected a line a sample")
        if self.cut and "samples" in self.said and self.layout.separator == ",":
            raise self.fault(self.cut, "the file is cut off here; expected the end of a line")
        return [use(index, found.pop(0).whole()) for index in indices]


def _blank(line):
    return not line.strip(' \t;,|"')


def _numbers(text, number, lines, indices):
    """Yield the columns of a piece as lists of arrays; `ValueError` names the first cell that is none."""
    layout = text.layout
    kept = [line for line in lines if not _blank(line)]
    for offset, line in enumerate(lines if text.blank or len(kept) < len(lines) else ()):
        if _blank(line) and line.strip():
            text.blank = text.blank or number + offset
        elif text.blank and line.strip():
            raise text.fault(text.blank, "all cells are blank; expected samples")
    if not kept:
        return
    text.gaps = text.gaps or len(kept) < len(lines)
    try:
        table = _uniform(kept, layout)
        stamps = [index for index in indices if index in layout.stamps]
        plain = [index for index in indices if index not in layout.stamps]
        values = np.loadtxt(table, delimiter="\t" if layout.separator else None, comments=None, usecols=plain, ndmin=2)
        if not np.isfinite(values).all():
            raise ValueError
        columns = dict(zip(plain, values.T, strict=True))
        columns |= {index: _seconds([line.split("\t")[index] for line in table]) for index in stamps}
    except (ValueError, IndexError) as error:
        raise _fault(text, number, lines, indices, error) from None
    yield [columns[index] for index in indices]


def _uniform(lines, layout):
    """The lines with tabs between cells and points in numbers, if each has as many cells as it should."""
    separator, width = layout.separator, layout.width
    joined = "\n".join(lines)
    if '"' in joined and separator is not None:
        rows = [_row(line, separator) for line in lines]
        if not all(_fits(len(row), row[-1], layout) for row in rows):
            raise ValueError
        joined = "\n".join("\t".join(row) for row in rows)
    elif separator is None:
        joined = joined.replace('"', "")
        if {len(line.split()) for line in lines} != {width}:
            raise ValueError
    else:
        if {line.count(separator) for line in lines} != {width - 1} and not all(
            _fits(line.count(separator) + 1, line.rpartition(separator)[2].strip(), layout) for line in lines
        ):
            raise ValueError
        joined = joined.replace(separator, "\t")
    if layout.decimal == ",":
        joined = joined.replace(",", ".")
    if ("d" in joined or "D" in joined) and _FORTRAN.search(joined):
        joined = re.sub(r"(?<=[\d.])[dD](?=[+-]?\d)", "e", joined)
    return joined.split("\n")


def _row(line, separator):
    if line.count('"') % 2:
        raise ValueError
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])]


def _fits(count, last, layout):
    """Whether a row has as many cells as it should, or one more or less where separators stand at the ends of rows."""
    extra = (count == layout.width + 1 and not last) or (count == layout.width - 1 and not layout.names[-1])
    return count == layout.width or extra


def _seconds(texts):
    """Instants of dates and times of day (s), from the first day's beginning or from the first date's instant."""
    import pandas as pd

    plain = [text.strip().replace(",", ".") for text in texts]
    if all(re.fullmatch(r"\d{1,3}:\d{2}(:\d{2})?(\.\d+)?", text) for text in plain):
        clocks = [text if text.count(":") == 2 else f"00:{text}" for text in plain]
        return pd.to_timedelta(clocks).total_seconds().to_numpy(float)
    day_first = re.match(r"\d{1,2}\.", plain[0]) is not None
    stamps = pd.DatetimeIndex(pd.to_datetime(plain, dayfirst=day_first, format="mixed", utc=True))
    return (stamps - pd.Timestamp("2000-01-01", tz="UTC")).total_seconds().to_numpy(float)


def _fault(text, number, lines, indices, error):
    """What is wrong with the first line of samples that is wrong."""
    layout = text.layout
    pattern = sniff.NUMBERS[layout.decimal]
    for at, line in enumerate(lines, number):
        if _blank(line):
            continue
        if line.count('"') % 2:
            return text.fault(at, "a quote is not closed")
        row = sniff.cells(line, layout.separator)
        if not _fits(len(row), row[-1], layout):
            told = f": {reprlib.repr(line.strip())}" if re.search("[^\\W\\d_]{3}", line) else ""
            cut = "; the file is cut off here" if text.cut == at else ""
            return text.fault(at, f"{len(row)} columns; expected {layout.width}, as in the first row{told}{cut}")
        for index in sorted(indices):
            cell, name = row[index], layout.names[index] or str(index)
            good = sniff.STAMP.fullmatch(cell) if index in layout.stamps else pattern.fullmatch(cell)
            if not good or cell.strip("+- ")[:3].casefold() in ("nan", "inf") or _beyond(cell, layout, index):
                wanted = "an instant as before" if index in layout.stamps else "one as 1.5e-3"
                what = f"{reprlib.repr(cell)} is not a number" if cell else "'' is not a number: the cell is blank"
                return text.fault(at, f"column {index + 1} ({reprlib.repr(name)}): {what}; expected {wanted}")
    return text.fault(number, " ".join(str(error).split()) or "no samples")


def _beyond(cell, layout, index):
    if index in layout.stamps:
        return False
    number = cell.replace(",", ".") if layout.decimal == "," else cell
    return not np.isfinite(float(re.sub("[dD]", "e", number)))


def _joined(line):
    """The first line as it was before a spreadsheet split it into cells, quoted and padded them."""
    line = line.strip()
    if line.startswith('"'):
        for separator in ",;\t":
            row = next(csv.reader([line], delimiter=separator), [])
            for between in dict.fromkeys((separator, ",")):
                text = between.join(row).rstrip(between + " ")
                with contextlib.suppress(ValueError, RecursionError):
                    json.loads(text[1:])
                    return text
    return line.rstrip(",;\t ") if line.endswith((",", ";", "\t")) else line


def _own_details(first, path):
    # A blank in place of the mark keeps the count of characters.
    return json_details.parse(" " + first[1:], f"{path}: line 1")
