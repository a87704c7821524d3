"""File formats of records, a module each. A new one belongs here: ``look``, perhaps ``write``, and its suffixes.

``look(path)`` is a context that gives the `Contents` of a file: what columns it holds, and what it says beside them.
``write(file, details, channels, units)`` puts details and channels, "time" (s) first, into a file open for bytes. A
reader answers only for the form: it raises `ValueError` or `OSError`, in one line that names file and place, whatever
the file is. What the columns mean, and whether all that a file says agrees, `rigsim.experiment.reading` finds, for all
alike.
"""

import importlib.util
from functools import partial

from . import binary, csv_text, netcdf

_TEXT = (".csv", ".txt", ".tsv", ".dat", ".asc", ".prn", ".lvm")
READERS = {ending: csv_text.look for suffix in _TEXT for ending in (suffix, f"{suffix}.gz")} | {
    suffix: partial(binary.look, suffix=suffix) for suffix in binary.SUFFIXES
}
WRITERS = {".csv": csv_text.write, ".csv.gz": csv_text.write_compressed, ".nc": netcdf.write}


def chosen(path, table, what="suffix"):
    """What a table has for the ending of a file's name; `ValueError` lists those that it knows."""
    name = path.name.lower()
    for ending in sorted(table, key=len, reverse=True):
        if name.endswith(ending):
            return table[ending]
    suffix = "".join(path.suffixes[-2:]) if name.endswith(".gz") else path.suffix
    known = ", ".join(repr(ending) for ending in table if table is WRITERS or not ending.endswith(".gz"))
    told = "; a spreadsheet can save its sheet as .csv" if suffix.lower() in (".xlsx", ".xls", ".ods") else ""
    raise ValueError(f"{what} of {path.name} = {suffix!r} is not allowed; expected one of {known}{told}")


def require(module, extra):
    """Say in one line how to get a package that only some files need, where it is not there."""
    if importlib.util.find_spec(module) is None:
        raise ModuleNotFoundError(
            f"{module} is not installed, which this file needs; run: pip install 'rigsim[{extra}]' (or pip install "
            f"{module})",
            name=module,
        )
