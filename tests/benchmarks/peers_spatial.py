"""The rig in three dimensions and in Exudyn: one wire set, 1 s at 44 Hz, begun with 1 rad/s of roll and 2 of yaw.

Runs only when asked for by name, in the environment that the benchmark peers makes. Unit: the referee,
`rigsim.model.spatial`, at a step of 50 us. Errors are the largest difference of any coordinate of three points of the
mass against the referee at a step of 10 us, over the largest travel; the referee's own show that this has converged,
and a fixed-step method of Exudyn's that its error falls to nothing with the step.

- Exudyn 1.13.6: a rigid body of rotation angles on spring-dampers from a frame on a coordinate of its own, no
  constraints; the shaker's force is a symbolic function, so that no Python runs in a step. Timed are solver and
  sensors, without imports and assembly.
"""

import json
import subprocess

import numpy as np
from peers import FOLDER, environment
from run import fastest

from rigsim import RigParameters
from rigsim.model import spatial

FREQUENCY, FORCE, DURATION, SAMPLES, RATES = 44.0, 3.18, 1.0, 1000, (1.0, 2.0, 0.0)
RUNS = (("RK67", 5e-5), ("RK67", 2.5e-5), ("RK44", 5e-5), ("TrapezoidalIndex2", 5e-5), ("GeneralizedAlpha", 5e-5))


def ours(rig, points, step):
    """Positions (samples, 1 + points, 3) of frame and points."""
    rigs, wires = spatial.pack([rig])
    state, trace = spatial.planar_state([0, rig.LG, 0, 0]), np.empty((SAMPLES, spatial.SIZE))
    state[12:] = RATES
    drive = spatial.drive(FORCE, FREQUENCY)
    spatial.march(state, 0.0, step, round(DURATION / step), rigs[0], wires[0], drive, False, trace)
    w, vector = trace[:, 4, None], trace[:, 5:8]
    placed = [trace[:, :1] * [1, 0, 0]]
    for point in points:
        once = 2 * np.cross(vector, point)
        placed.append(trace[:, 1:4] + point + w * once + np.cross(vector, once))
    return np.stack(placed, axis=1)


def measure():
    """Rows (name, value, unit, ratio)."""
    python, rig = environment(), RigParameters().single_set()
    points = [[-rig.LG, 0, 0], [rig.Lm / 2, 0, 0], [0, rig.Rm, 0]]
    known = ("ms", "ks", "cs", "m", "c", "Lm", "Rm", "LG", "d0", "gravity", "wire_damping")
    numbers = {name: getattr(rig, name) for name in known}
    numbers |= {"wires": spatial.pack([rig])[1][0, :4].tolist(), "rates": RATES, "points": points, "force": FORCE}
    numbers |= {"frequency": FREQUENCY, "duration": DURATION, "tries": 3}
    numbers["runs"] = [(method, step, round(DURATION / step / SAMPLES)) for method, step in RUNS]
    unit = fastest(lambda: ours(rig, points, 5e-5), 5)
    right = ours(rig, points, 1e-5)
    error = lambda found: np.abs(found - right).max() / np.ptp(right, axis=0).max()  # noqa: E731
    rows = [("unit: referee, 50 us, a second of the rig", 1e3 * unit, "ms", 1.0)]
    rows += [(f"referee, {1e6 * step:g} us: error", error(ours(rig, points, step)), "", None) for step in (5e-5, 1e-4)]
    done = subprocess.run(
        [python, "-W", "ignore", str(FOLDER / "peers" / "exudyn_rig.py")], input=json.dumps(numbers),
        capture_output=True, text=True, check=False, timeout=600,
    )  # fmt: skip
    if done.returncode:
        raise RuntimeError(f"Exudyn failed: {done.stderr.strip().splitlines()[-1]}")
    for (method, step), result in zip(RUNS, json.loads(done.stdout), strict=True):
        name, found = f"Exudyn, {method}, {1e6 * step:g} us", np.array(result["positions"])[1 : SAMPLES + 1]
        rows.append((f"{name}, a second of the rig", 1e3 * result["seconds"], "ms", result["seconds"] / unit))
        rows.append((f"{name}: error", error(found), "", None))
    return rows
