"""Binary files: HDF5, netCDF, MAT, NPZ, universal files and TDMS.

A damaged or hostile file makes libhdf5 crash, hang or take all memory, and can make it read other files: so a process
of its own reads (`child`), with limits on time, memory and open files, and what ends it is one line here.
"""

import json
import os
import subprocess
import sys
import threading
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from ...campaign.stop import sliced
from ..on_disk import Room
from . import details as json_details
from .contents import Column, Contents
from .regular import opened

_HEADER = 1 << 22  # bytes of the child's answer before the samples
_PIECE = 1 << 20  # samples at a time
_START = 60.0  # s, for Python to start and to import: no file decides that
_HDF5 = b"\x89HDF\r\n\x1a\n"
# By the ending of a name: how such a file may begin, what reads it and what it is called; MAT files say it further on.
_NETCDF = [(b"CDF", "netcdf3", "netCDF 3"), (_HDF5, "hdf5", "netCDF 4")]
_HDF = [(_HDF5, "hdf5", "HDF5")]
_MAT = [(_HDF5, "hdf5", "MAT 7.3"), (b"MATLAB 7.3", "hdf5", "MAT 7.3"), (b"", "matlab", "MAT")]
_UNIVERSAL = [(b"    -1", "uff", "a universal file")]
SUFFIXES = {
    ".nc": _NETCDF, ".nc4": _NETCDF, ".cdf": _NETCDF, ".h5": _HDF, ".hdf5": _HDF, ".hdf": _HDF, ".mat": _MAT,
    ".npz": [(b"PK", "npz", "NumPy arrays")], ".uff": _UNIVERSAL, ".unv": _UNIVERSAL, ".uf": _UNIVERSAL,
    ".tdms": [(b"TDSm", "tdms", "TDMS")],
}  # fmt: skip
PACKAGES = {"uff": "pyuff", "tdms": "nptdms"}
PROGRAM = [sys.executable, "-P", "-m", f"{__package__}.child"]


def allowed(size):
    """Bytes of samples that a file of ``size`` bytes may hold: compressed ones expand, measured ones hardly twice."""
    return 16_000_000 + 20 * size


def seconds(size, reader="hdf5"):
    """How long a processor may work at reading a file of ``size`` bytes (s); it may take three times as long."""
    return 2 + size / (20e6 if reader != "uff" else 1e6)


@contextmanager
def look(path, suffix):
    """`Contents` of a binary file, to be read within the block."""
    with opened(path) as (file, size):
        reader, form = _reader(path, suffix, file.peek(8)[:1024])
        with _child(path, file, size, reader) as answer:
            yield _contents(path, answer, size, form)


def _reader(path, suffix, head):
    """Module that reads a file which begins so, and what the form is called."""
    for mark, reader, form in SUFFIXES[suffix]:
        if head.lstrip(b"\r\n").startswith(mark) or (mark == _HDF5 and head[512:520] == mark):
            if reader in PACKAGES:
                from . import require

                require(PACKAGES[reader], "formats")
            return reader, form
    raise ValueError(f"{path} cannot be read as a record: it does not begin as {SUFFIXES[suffix][-1][2]} does")


def _contents(path, answer, size, form):
    """What the child says of the file."""
    told = f"{path} cannot be read as a record"
    header = json.loads(answer.readline(_HEADER) or '{"error": ""}')
    if "error" in header:
        raise ValueError(f"{told}: {header['error'] or 'reading it ended early'}")
    columns = [Column(name, unit, count, interval, why=why) for name, count, unit, interval, why in header["columns"]]
    if sum(8 * column.samples for column in columns if not column.why) > allowed(size):
        raise ValueError(f"{told}: reading it gave more than it can hold")
    said, own = header["said"], "rigsim_record" in header["said"]
    notes = said.pop("notes", [])
    details = json_details.parse(said["rigsim_record"], f"rigsim_record in {path}") if own else said

    def values(indices, use=None):
        """What ``use`` makes of the samples of columns, which come one after the other."""
        found = {}
        for index, column in enumerate(columns):
            if column.why:
                continue
            said = json.loads(answer.readline(_HEADER) or '{"error": "reading it ended early"}')
            if "error" in said:
                if index in indices:
                    raise ValueError(f"{told}: {said['error']}")
                column.why = said["error"]
                continue
            column.first, room = said["first"], Room(column.samples)
            for part in sliced(column.samples, _PIECE):
                samples = np.empty(part.stop - part.start)
                if answer.readinto(samples.view("u1")) != samples.nbytes:
                    raise ValueError(f"{told}: reading it ended early")
                room.add(samples)
            if index in indices:
                found[index] = use(index, room.whole())
            if len(found) == len(indices) and indices:
                break
        return [found[index] for index in indices]

    place = lambda index, sample: f"sample {sample} of {columns[index].name!r}"  # noqa: E731
    return Contents(form, columns, values, place, details, own, notes, count=lambda: values([]))


@contextmanager
def _child(path, file, size, reader):
    """Answers of a process that reads ``file``; `ValueError` if it takes too long."""
    limit = seconds(size, reader)
    arguments = [str(allowed(size)), str(limit), reader]
    settings = {name: value for name, value in os.environ.items() if name != "HDF5_PLUGIN_PATH"}
    root = str(Path(__file__).parents[3])
    settings |= {
        "PYTHONPATH": os.pathsep.join([root, *filter(None, sys.path)]),
        "OPENBLAS_NUM_THREADS": "1",
        "HDF5_PLUGIN_PRELOAD": "::",  # loads no code that a file asks for
    }
    pipes = {"stdin": file, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
    with subprocess.Popen(PROGRAM + arguments, env=settings, **pipes) as process:
        late = []
        try:
            with _within(_START, process, late):
                ready = process.stdout.readline(_HEADER)
            if ready != b"ready\n":
                raise OSError(f"{path} cannot be read: another Python with what reads it does not start")
            with _within(3 * limit, process, late):
                yield process.stdout
        except ValueError:
            if not late:
                raise
            raise ValueError(f"{path} cannot be read as a record: it takes longer than {late[0]:.0f} s") from None
        finally:
            process.kill()


@contextmanager
def _within(limit, process, late):
    """End the process if the block takes longer than ``limit`` (s), which ``late`` (a list) then holds."""
    timer = threading.Timer(limit, lambda: (late.append(limit), process.kill()))
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
