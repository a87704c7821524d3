"""One rig on a bench: an operator asks for the next stretch of force, and is told the motion."""

from collections import namedtuple

import numpy as np

from ...campaign.stop import look
from ...model.chipmunk import RigSpace

Request = namedtuple("Request", "drive first count")  # kicks first to first + count - 1 of a Drive
Told = namedtuple("Told", "samples parted")  # xs, x, tilt at each of these kicks (count, 3); when it flew apart, or NaN

# What is read of a motion: a column each of the arrays that a bench returns.
COLUMNS = (
    "time", "force", "frequency", "shaker", "mass", "relative", "tilt", "distortion", "subharmonic", "drift", "left",
    "dwell", "velocity", "tries", "error", "status", "message",
)  # fmt: skip
_BLOCK = 2500  # steps between two looks at the keyboard


def run_bench(chunk):
    """Run the plan of one bench to its end: arrays of all readings, and of all stretches of force.

    ``chunk`` has the "rig", its "plan" (with ``operate(step)``, a generator of `Request` that is sent `Told` and
    returns its readings and drives), the "number" of the bench, the "start" and the "step".
    """
    space = RigSpace([chunk["rig"]], chunk["step"], chunk["start"])
    operator = chunk["plan"].operate(chunk["step"])
    request = next(operator)
    while True:
        blocks = _blocks(request.first, request.first + request.count)
        seen = [_advanced(space, chunk["rig"], request.drive, *block) for block in blocks]
        samples, parted = [motion[:, 1:] for motion, _ in seen], seen[-1][1]
        try:
            request = operator.send(Told(np.concatenate(samples), parted))
        except StopIteration as end:
            readings, drives = end.value
            break
    columns = {name: np.array([reading[name] for reading in readings]) for name in COLUMNS}
    rows = np.array([[chunk["number"], *drive.row()] for drive in drives])
    return columns | {"run": np.full(len(readings), chunk["number"]), "drives": rows}


def _blocks(first, end):
    """(first, count) of blocks of steps, with a look before each."""
    for begin in range(first, end, _BLOCK):
        look()
        yield begin, min(_BLOCK, end - begin)


def _advanced(space, rig, drive, first, count):
    """Force (N), shaker, mass (m) and tilt (rad) at each kick of a block (count, 4), and when the rig flew apart."""
    push, tap = drive.kicks(first, count), drive.pulses(rig.m, first, count)
    motion = space.advance(push[:, None], tap[:, None], 1)
    return np.column_stack([push, motion.shaker, motion.mass, motion.tilt]), motion.parted[0]


def replay(rig, drives, start, step, every):
    """Force (N), shaker, mass (m) and tilt (rad) of one bench at each ``every``-th step (n, 4): its motion again."""
    space, kept, passed = RigSpace([rig], step, start), [], 0
    for drive in drives:
        for first, count in _blocks(0, drive.steps):
            kept.append(_advanced(space, rig, drive, first, count)[0][-passed % every :: every])
            passed += count
    return np.concatenate(kept)
