"""A program that reads one binary file; `binary.look` runs it, and says why in a process of its own.

The file is its standard input. Its arguments are the bytes that samples may take, the seconds that it may compute and
the module that reads. To standard output go a line when it is ready, then a line of JSON, ``{"columns": [[name,
samples, unit, interval, why], ...], "said": {...}}`` or ``{"error": text}``, then of every column without a "why" a
line ``{"first": [...]}`` or ``{"error": text}``, and its samples as float64.
"""

import importlib
import io
import json
import math
import os
import sys

import numpy as np


class Whole(io.BufferedReader):
    """A file whose reads give every byte or fail: HDF5 takes what it asked for as given."""

    def readinto(self, buffer):
        """Fill the buffer."""
        got = super().readinto(buffer)
        if got != len(buffer):
            raise OSError("the file ends before what it holds")
        return got


def limit(most, seconds):
    """Take from this process what reading does not need, where the platform can."""
    try:
        import resource
    except ImportError:
        return
    free = os.dup(0)
    os.close(free)
    used = sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
    limits = {"RLIMIT_NOFILE": free, "RLIMIT_CORE": 0, "RLIMIT_CPU": math.ceil(used + seconds)}
    try:
        with open("/proc/self/statm") as file:
            pages = int(file.read().split()[0])
        limits["RLIMIT_AS"] = pages * resource.getpagesize() + 64_000_000 + 4 * most
    except OSError:
        pass
    for name, value in limits.items():
        try:
            resource.setrlimit(getattr(resource, name), (value, value))
        except (OSError, ValueError):
            continue


def answer(reader, file, out, most):
    """Write the header to ``out``, then the samples; whatever happens, a header."""
    try:
        found, said = reader.contents(file, most)
        found.sort(key=lambda one: one.name.casefold() != "time")  # which is used up before the others come
        header = {"columns": [[one.name, one.samples, one.unit, one.interval, one.why] for one in found], "said": said}
        text = json.dumps(header).encode("utf-8", "backslashreplace")
    except BaseException as error:
        found, text = [], json.dumps({"error": _words(error)}).encode()
    out.write(text + b"\n")
    for one in found:
        if not one.why:
            _column(one, out)


def _column(one, out):
    try:
        values = np.ascontiguousarray(one.take(), dtype=float)
        if values.shape != (one.samples,):
            raise ValueError(f"{one.name!r} has samples of shape {values.shape}; expected {one.samples}")
        text = json.dumps({"first": [f"{value:.9g}" for value in values[:3]]}).encode()
    except BaseException as error:
        values, text = np.empty(0), json.dumps({"error": _words(error)}).encode()
    out.write(text + b"\n")
    out.write(values)


def _words(error):
    return " ".join(f"{error or type(error).__name__}".split())[:400]


def main(most, seconds, name):
    """Say when all is loaded, then answer, on standard output."""
    out = sys.stdout.buffer
    sys.stdout = sys.stderr  # whatever a package prints
    reader = importlib.import_module(f"{__package__}.{name}")
    reader.rehearse()
    out.write(b"ready\n")
    out.flush()
    limit(int(most), float(seconds))
    with Whole(io.FileIO(0, closefd=False)) as file:
        answer(reader, file, out, int(most))
    out.flush()


if __name__ == "__main__":
    main(*sys.argv[1:])
