"""How a text file is laid out, from its first lines: what separates cells, where samples begin, what stands above them.

Samples begin at the first row of numbers that most of the next three lines are like. All that follows must be samples;
names and units stand right above, in rows of as many cells.
"""

import codecs
import csv
import re
from dataclasses import dataclass

from .units import is_unit, plain, role_of

SEPARATORS = ("\t", ";", ",", None, "|")  # None: blanks
_NAMED = {"\t": "tabs", ";": "semicolons", ",": "commas", None: "blanks", "|": "bars"}
_NUMBER = r"\s*[+-]?((\d+({0}\d*)?|{0}\d+)([eEdD][+-]?\d+)?|nan|inf(inity)?)\s*"
NUMBERS = {dot: re.compile(_NUMBER.format(re.escape(dot)), re.IGNORECASE | re.ASCII) for dot in ".,"}
_CLOCK = r"\d{1,3}:\d{2}(:\d{2})?([.,]\d+)?(\s*[AaPp][Mm])?"
_DATE = r"(\d{4}[-./]\d{1,2}[-./]\d{1,2}|\d{1,2}[-./]\d{1,2}[-./]\d{2,4})"
STAMP = re.compile(rf"\s*({_DATE}([T ]+{_CLOCK})?|{_CLOCK})(Z|[+-]\d\d:?\d\d)?\s*", re.ASCII)
# What instruments write where they have no number.
_NONE = re.compile(
    r"\s*(|-+|\?+|\*+|#+.*|n/?a|none|null|ovld|ovl|overl\w*|over|under|invalid|bad|error|err|1\.#\w+)\s*", re.IGNORECASE
)
_MOST = 4096  # cells of a row
_LABEL = re.compile(
    r"(channel|kanal|name|units?|einheit|title|label|signal|point|dof|type|description)\b", re.IGNORECASE
)
_COUNT = re.compile(r'^"?(\d+)"?\s', re.MULTILINE)
_MARKS = re.compile(r"^\s*(#|%|//|!|\*+)+\s*")
_MARKS_OF_BYTES = [(codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF32_LE, "utf-32"), (codecs.BOM_UTF32_BE, "utf-32"),
                   (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16")]  # fmt: skip


@dataclass(frozen=True)
class Layout:
    """Of a text file; lines count from 0."""

    separator: str | None
    decimal: str
    start: int  # line of the first sample
    width: int  # cells in a row
    names: list
    units: list
    header: list  # lines above the names
    stamps: frozenset  # columns that hold dates or times of day

    @property
    def form(self):
        """What was found, in words."""
        decimal = "commas" if self.decimal == "," else "points"
        return f"text with {_NAMED[self.separator]} between cells and decimal {decimal}"


def encoding_of(head):
    """How the first bytes of a file say text, None where they hold bytes that no text has."""
    for mark, name in _MARKS_OF_BYTES:
        if head.startswith(mark):
            return name
    if len(head) > 8 and head[1:64:2].count(0) > 0.9 * len(head[1:64:2]):
        return "utf-16-le"
    if len(head) > 8 and head[0:64:2].count(0) > 0.9 * len(head[0:64:2]):
        return "utf-16-be"
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head)
    except UnicodeDecodeError:
        return "cp1252" if not re.search(rb"[\x81\x8d\x8f\x90\x9d]", head) else "latin-1"
    return "utf-8"


def cells(line, separator):
    """Cells of a line, without the blanks around them."""
    if separator is None:
        return line.replace('"', "").split()
    if '"' in line:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])]
    return [cell.strip() for cell in line.split(separator)]


def layout_of(lines):
    """`Layout` of the first lines of a file; None where no row of numbers is found."""
    best, most = None, ()
    for separator in SEPARATORS:
        for decimal in ".,":
            if decimal == separator and not any('"' in line for line in lines):
                continue
            found = _rows(lines, separator, decimal)
            if found is not None and found[0] > most:
                most, best = found[0], (separator, decimal, *found[1:])
    return None if best is None else _named(lines, *best)


def _rows(lines, separator, decimal):
    """How well the separators fit (a tuple to compare), the first row of numbers and its cells."""
    rows = {index: cells(line, separator) for index, line in enumerate(lines) if line.strip()}
    kinds = {index: _is_row(row, decimal) for index, row in rows.items()}
    written = list(rows)
    for at, index in enumerate(written):
        alike = [kinds[i] and _like(rows[i], rows[index]) for i in written[at : at + 4]]
        if alike[0] and sum(alike) > len(alike) / 2:
            run = [i for i in written[at:] if kinds[i] and _like(rows[i], rows[index])]
            numbers = sum(NUMBERS[decimal].fullmatch(cell) is not None for i in run for cell in rows[i])
            share = numbers / sum(len(list(filter(None, rows[i]))) for i in run)
            return (len(rows[index]) > 1, round(share, 1), len(run), share, numbers), index, rows[index]
    return None


def _like(one, other):
    return len(one) == len(other) or (abs(len(one) - len(other)) == 1 and "" in (one[-1], other[-1]))


def _is_row(row, decimal):
    """Whether cells are samples: numbers, instants, or what stands for none, rather than words."""
    if len(row) > _MOST:
        return False
    numbers = sum(NUMBERS[decimal].fullmatch(cell) is not None for cell in row)
    if not numbers:
        return False
    words = sum(_is_word(cell, decimal) for cell in row)
    return words == 0 or (numbers > words and not _is_word(row[0], decimal))


def _is_word(cell, decimal):
    return not (NUMBERS[decimal].fullmatch(cell) or STAMP.fullmatch(cell) or _NONE.fullmatch(cell))


def _named(lines, separator, decimal, start, first):
    """The layout: what stands above the samples is split as they are."""
    width = len(first)
    numbered = [line.strip() for line in _COUNT.findall("\n".join(lines[start : start + 2]))] == ["1", "2"]
    above, odd, at = [], 0, start - 1
    while at >= 0 and len(above) < 16 and odd < 8:
        row = _header_cells(lines[at], separator, first, numbered)
        if row is not None:
            above.append((at, row))
        elif lines[at].strip():  # a remark between names and samples, or what stands above all
            odd += 1
        at -= 1
    units = next((row for _, row in above if _are_units(row)), [""] * width)
    units = ["" if "unit" in cell.casefold() else cell for cell in units]
    words = [(at, row) for at, row in above if not _are_units(row)]
    known = lambda row: sum(bool(role_of(plain(name))[0]) for name in row)  # noqa: E731
    at, names = max(words, key=lambda item: known(item[1]), default=(start, [""] * width))
    names = [name or "" for name in names]
    stamps = frozenset(
        index for index, cell in enumerate(first) if STAMP.fullmatch(cell) and not NUMBERS[decimal].fullmatch(cell)
    )
    return Layout(separator, decimal, start, width, names, units, lines[: at if words else start], stamps)


def _header_cells(line, separator, first, numbered):
    """A line above the samples as so many cells as their first row has, None where it has not as many."""
    line, width = _MARKS.sub("", line), len(first)
    for row in (cells(line, separator), *(cells(line, other) for other in ("\t", ";", ",") if other != separator),
                [cell.strip() for cell in re.split(r"\t|\s{2,}", line.strip())]):  # fmt: skip
        while len(row) > width and not row[-1]:
            row = row[:-1]
        if len(row) == width + 1 and _LABEL.match(row[0]):
            row = row[1:]
        if len(row) == width + 1 and row[-1].casefold() == "comment":  # LabVIEW's, which few rows have
            row = row[:-1]
        if len(row) == width - 1 and not first[-1]:
            row = [*row, ""]
        if len(row) == width - 1 and numbered:
            row = ["", *row]
        if len(row) == width and any(row):
            return row
    return None


def _are_units(row):
    row = row[1:] if "unit" in row[0].casefold() else row
    return any(is_unit(cell) for cell in row) and all(not cell or is_unit(cell) for cell in row)
