"""File formats of records, a module each. A new one belongs here: ``read``, ``write`` and its suffix.

``read(path)`` gives what the file says of the record (a dict) and its channels (a dict of arrays); ``write(path,
details, channels)`` takes the same, "time" (s) first. What they must hold is checked by `Record.load`, for all alike.
"""

from . import csv_text, netcdf

FORMATS = {".csv": csv_text, ".nc": netcdf}
