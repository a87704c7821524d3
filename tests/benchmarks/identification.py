"""Identification of a record of 200 000 samples (100 s at 2000 Hz), in a process of its own.

Unit: the Gram matrix of the record's block Hankel matrix (80 block rows of 4 channels) by plain matrix products.
"""

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from run import fastest

from rigsim import RigParameters, random_test
from rigsim.identification.subspace import dynamics, extended_gram

BLOCK_ROWS = 40

_CHILD = """
import json, resource, sys, time
from rigsim import Record, identify
record = Record.load(sys.argv[1])
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
begun = time.perf_counter()
identify(record)
first = time.perf_counter() - begun
seconds = {"all": [], "force": []}
for reading in 3 * ["all", "force"]:
    begun = time.perf_counter()
    identify(record, conversion=reading)
    seconds[reading].append(time.perf_counter() - begun)
estimate, second = min(seconds["all"]), min(seconds["force"])
after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
record = Record.joined(10 * [record])
begun = time.perf_counter()
identify(record)
long = time.perf_counter() - begun
most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
scale = 1 if sys.platform == "darwin" else 1024
print(json.dumps([first, estimate, second, long, *(scale * size for size in (before, after, most))]))
"""


def hankel_gram(channels, rows, columns=20_000):
    """Gram matrix of the block Hankel matrix of channels (n, q), its columns in pieces that fit in memory."""
    windows = np.lib.stride_tricks.sliding_window_view(channels, rows, axis=0)
    size = rows * channels.shape[1]
    gram = np.zeros((size, size))
    for start in range(0, len(windows), columns):
        piece = windows[start : start + columns].reshape(-1, size)
        gram += piece.T @ piece
    return gram


def measure():
    """Rows (name, value, unit, ratio)."""
    begun = time.perf_counter()
    record = random_test(RigParameters())
    print(f"(the record took {time.perf_counter() - begun:.0f} s)", file=sys.stderr)
    # First, since a child begins with the largest memory of its parent.
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "record.nc"
        record.save(file)
        done = subprocess.run([sys.executable, "-c", _CHILD, file], capture_output=True, text=True, check=True)
    first, estimate, second, long, before, after, most = json.loads(done.stdout)
    channels = np.stack([record.force, record.relative**3, record.shaker, record.mass], axis=1)
    channels /= channels.std(axis=0)
    unit = fastest(lambda: hankel_gram(channels, 2 * BLOCK_ROWS), 2)
    rows = 2 * BLOCK_ROWS
    step = fastest(lambda: dynamics(extended_gram(channels, rows), np.ones(4), 2, 4), 3)
    # A tenth of the Hankel matrix's columns: its time is proportional to them, and all would take a gigabyte.
    part = np.lib.stride_tricks.sliding_window_view(channels[: len(channels) // 10], rows, axis=0)
    part = part.reshape(len(part), -1)
    factored = fastest(lambda: np.linalg.qr(part, mode="r"), 2)
    return [
        ("unit: Gram matrix by matrix products", unit, "s", 1.0),
        ("Gram matrix, its root and the dynamics", step, "s", step / unit),
        ("numpy's QR of a tenth of the Hankel matrix", factored, "s", factored / unit),
        ("identify, first call", first, "s", first / unit),
        ("identify, again", second, "s", second / unit),
        ("of it the estimate", estimate, "s", estimate / unit),
        (
            "of it intervals and the search for troubles, against the estimate",
            second - estimate,
            "s",
            second / estimate - 1,
        ),
        ("identify ten times the record, against the record", long, "s", long / second),
        ("largest memory of the process", after / 2**20, "MiB", None),
        ("the same with ten times the record", most / 2**20, "MiB", None),
        ("of it before identify was called", before / 2**20, "MiB", None),
    ]
