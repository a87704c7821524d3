"""netCDF 4 by xarray: a variable a channel, details as JSON in an attribute.

A damaged or hostile file makes libhdf5 crash, hang or take all memory, and can make it read other files: so a process
of its own reads (`netcdf_child`), with limits on time, memory and open files, and what ends it is one line here.
"""

import io
import json
import os
import subprocess
import sys
import threading
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from . import details as json_details
from .regular import opened

UNITS = {"time": "s", "force": "N", "shaker": "m", "mass": "m", "tilt": "rad"}
_HEADER = 1 << 20  # bytes of the child's answer before the samples
_START = 60.0  # s, for Python to start and to import: no file decides that


def allowed(size):
    """Bytes of samples that a file of ``size`` bytes may hold: compressed ones expand, measured ones hardly twice."""
    return 16_000_000 + 20 * size


def seconds(size):
    """How long a processor may work at reading a file of ``size`` bytes (s); it may take three times as long."""
    return 2 + size / 20e6


def write(file, details, channels, units):
    """Write channels as variables over time, with their units."""
    import xarray as xr

    variables = {name: ("time", values, {"units": units[name]}) for name, values in channels.items()}
    dataset = xr.Dataset(variables, attrs={"rigsim_record": json.dumps(details)})
    whole = io.BytesIO()  # libhdf5 does not survive a full disk; writing bytes does
    dataset.to_netcdf(whole, engine="h5netcdf")
    file.write(whole.getbuffer())


def read(path):
    """Details and channels of a file in that form, and the units that it says."""
    with opened(path) as (file, size), _child(path, file, size) as answer:
        header = json.loads(answer.readline(_HEADER) or '{"error": ""}')
        if "error" in header:
            raise ValueError(f"{path} cannot be read as a record: {header['error'] or 'reading it ended early'}")
        if sum(8 * count for _, count, _ in header["channels"]) > allowed(size):
            raise ValueError(f"{path} cannot be read as a record: reading it gave more than it can hold")
        channels = {name: np.empty(count) for name, count, _ in header["channels"]}
        for values in channels.values():
            if answer.readinto(values.view("u1")) != values.nbytes:
                raise ValueError(f"{path} cannot be read as a record: reading it ended early")
    if not header["details"]:
        raise ValueError(f"{path} is not a record; expected an attribute rigsim_record")
    units = {name: unit for name, _, unit in header["channels"] if unit}
    return json_details.parse(header["details"], f"rigsim_record in {path}"), channels, units


@contextmanager
def _child(path, file, size):
    """Answers of a process that reads ``file``; `ValueError` if it takes too long."""
    program = [sys.executable, "-P", str(Path(__file__).with_name("netcdf_child.py"))]
    arguments = [str(allowed(size)), str(seconds(size)), *UNITS]
    settings = {name: value for name, value in os.environ.items() if name != "HDF5_PLUGIN_PATH"}
    settings |= {
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
        "OPENBLAS_NUM_THREADS": "1",
        "HDF5_PLUGIN_PRELOAD": "::",  # loads no code that a file asks for
    }
    pipes = {"stdin": file, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
    with subprocess.Popen(program + arguments, env=settings, **pipes) as process:
        late = []
        try:
            with _within(_START, process, late):
                ready = process.stdout.readline(_HEADER)
            if ready != b"ready\n":
                raise OSError(f"{path} cannot be read: another Python with h5py does not start")
            with _within(3 * seconds(size), process, late):
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
