"""The subspace step of other packages on the extended inputs and outputs of the paper's record, 200 000 samples.

Runs only when asked for by name, in the environment that the benchmark peers makes. Every process keeps to one BLAS
thread; the peers are timed without their imports. Unit: the estimate of `identify` at 40 block rows, without intervals
and the search for troubles, which is more than a subspace step: z about the springs' zero, a refinement over the band
and parameters. Frequencies are the modes that a step finds, which says that it did the same thing.

- llsi 0.5.0: PO-MOESP, whose window follows from the order: 18 block rows at order 4, and 38 at order 9.
- sippy-unipi 1.0.1: N4SID with 40 block rows of past and future.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from identification import BLOCK_ROWS
from peers import FOLDER, environment
from run import fastest

from rigsim import RigParameters, identify, random_test
from rigsim.identification.nsi import extended_inputs

RATE = 2000.0
STEPS = (
    ("llsi, PO-MOESP, 18 block rows", {"peer": "llsi", "order": 4}),
    ("llsi, PO-MOESP, 38 block rows", {"peer": "llsi", "order": 9}),
    (f"sippy-unipi, N4SID, {BLOCK_ROWS} block rows", {"peer": "sippy", "rows": BLOCK_ROWS}),
)


def measure():
    """Rows (name, value, unit, ratio)."""
    python, record = environment(), random_test(RigParameters())
    unit = fastest(lambda: identify(record, conversion="all"), 3)
    whole = fastest(lambda: identify(record), 3)
    rows = [("unit: estimate of identify", unit, "s", 1.0), ("identify", whole, "s", whole / unit)]
    inputs = extended_inputs(record.force, record.relative - record.relative.mean())
    outputs = np.column_stack([record.shaker, record.mass])
    with tempfile.TemporaryDirectory() as folder:
        file = str(Path(folder) / "channels.npz")
        scaled = {
            "inputs": inputs / inputs.std(axis=0),
            "outputs": (outputs - outputs.mean(axis=0)) / outputs.std(axis=0),
        }
        np.savez(file, **scaled)
        for name, how in STEPS:
            done = subprocess.run(
                [python, str(FOLDER / "peers" / "subspace_step.py")],
                input=json.dumps({"file": file, "rate": RATE, **how}), env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
                capture_output=True, text=True, check=False, timeout=600,
            )  # fmt: skip
            if done.returncode:
                print(f"{name} failed: {done.stderr.strip().splitlines()[-1]}", file=sys.stderr)
                continue
            result = json.loads(done.stdout)
            rows.append((name, result["seconds"], "s", result["seconds"] / unit))
            rows += [(f"{name}: a mode", hertz, "Hz", None) for hertz in result["frequency"]]
    return rows
