"""New Python processes: how long a first answer takes, with its machine code at hand and without.

Unit: ``import numba, scipy.linalg, scipy.optimize`` in a new process.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from run import fastest

import rigsim

ROOT = Path(rigsim.__file__).parents[1]
UNIT = "import numba, scipy.linalg, scipy.optimize"
CURVES = "from rigsim import RigParameters, detached_curves; assert len(detached_curves(RigParameters(), 3.18)) == 1"
SINE = "from rigsim import RigParameters, sine_test; sine_test(RigParameters(), 3.18, 20.0, duration=1)"
ALL = "import runpy; runpy.run_module('rigsim.first_use', run_name='__main__')"


def process(code, folder=None):
    """Seconds of a new Python, with machine code in a folder of its own if one is given."""
    settings = {**os.environ, "PYTHONPATH": str(ROOT), **({"NUMBA_CACHE_DIR": folder} if folder else {})}
    begun = time.perf_counter()
    subprocess.run([sys.executable, "-c", code], env=settings, cwd=ROOT, check=True, capture_output=True)
    return time.perf_counter() - begun


def cold(code):
    """Seconds of a new Python without any machine code."""
    with tempfile.TemporaryDirectory() as folder:
        return process(code, folder)


def measure():
    """Rows (name, value, unit, ratio)."""
    unit = fastest(lambda: process(UNIT), 3)
    timed = {
        "unit: imports in a new process": unit,
        "detached_curves in a new process": fastest(lambda: process(CURVES), 3),
        "detached_curves, nothing compiled": cold(CURVES),
        "sine_test in a new process": fastest(lambda: process(SINE), 3),
        "sine_test, nothing compiled": cold(SINE),
        "all that the notebooks use, nothing compiled": cold(ALL),
    }
    return [(name, seconds, "s", seconds / unit) for name, seconds in timed.items()]
