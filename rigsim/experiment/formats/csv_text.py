"""Comma-separated text: a line ``# {...}`` of details as JSON, a line of channel names, then a line a sample."""

import csv
import json

import numpy as np


def write(path, details, channels):
    """Write every digit of every channel but the time, which the sample rate gives."""
    names = [name for name in channels if name != "time"]
    values = np.column_stack([channels[name] for name in names])
    header = f"# {json.dumps(details)}\n{','.join(names)}"
    np.savetxt(path, values, fmt="%.17g", delimiter=",", header=header, comments="")


def read(path):
    """Details and channels of a file in that form, or in what a spreadsheet makes of it."""
    # Spreadsheets put a byte order mark first.
    with open(path, encoding="utf-8-sig", newline="") as file:
        try:
            first, names = file.readline(), file.readline()
            details = json.loads(first.removeprefix("#"))
            values = np.loadtxt(file, delimiter=",", quotechar='"', ndmin=2)
        except ValueError as error:
            raise ValueError(f"{path} cannot be read as a record: {error}") from None
    names = [name.strip() for name in next(csv.reader([names], skipinitialspace=True), [])]
    if not first.startswith("#") or not isinstance(details, dict) or len(names) != values.shape[1]:
        expected = "a line # {...}, a line of channel names and as many columns"
        raise ValueError(f"{path} is not a record; expected {expected}")
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"{path} names the channel {name} {names.count(name)} times; expected each once")
    return details, dict(zip(names, values.T, strict=True))
