"""File formats of records, a module each. A new one belongs here: ``read``, ``write`` and its suffix.

``read(path)`` gives what the file says of the record (a dict), its channels (a dict of arrays) and the units that it
says for them (a dict of text); ``write(file, details, channels)`` puts details and channels, "time" (s) first, into a
file open for bytes. A reader answers only for the form: it raises `ValueError` or `OSError`, in one line that names
file and place, whatever the file is. What a record must hold is checked by `Record.load`, for all alike.
"""

from . import csv_text, netcdf

FORMATS = {".csv": csv_text, ".nc": netcdf}
