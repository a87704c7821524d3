"""One rig on a bench: an operator asks for the next stretch of force, and is told the motion."""

from collections import namedtuple

import numpy as np

from ...campaign.stop import look
from ...model.chipmunk import RigSpace

Request = namedtuple("Request", "drive first count")  # kicks first to first + count - 1 of a Drive
# xs, x, tilt at each of these kicks (count, 3), with a shaker's drive its force (N) and voltage (V), too (count, 5);
# when the rig flew apart, or NaN
Told = namedtuple("Told", "samples parted")

# What is read of a motion: a column each of the arrays that a bench returns.
COLUMNS = (
    "time", "force", "frequency", "shaker", "mass", "relative", "tilt", "distortion", "subharmonic", "drift", "left",
    "dwell", "velocity", "tries", "error", "status", "message",
    "given",
)  # fmt: skip
_BLOCK = 2500  # steps between two looks at the keyboard


def run_bench(chunk):
    """Run the plan of one bench to its end: arrays of all readings, and of all stretches of force.

    ``chunk`` has the "rig", its "plan" (with ``operate(step)``, a generator of `Request` that is sent `Told` and
    returns its readings and drives), the "number" of the bench, the "start" and the "step", and maybe a "shaker".
    """
    shaker = chunk.get("shaker")
    space = RigSpace([chunk["rig"]], chunk["step"], chunk["start"], [shaker])
    operator = chunk["plan"].operate(chunk["step"])
    request = next(operator)
    while True:
        blocks = _blocks(request.first, request.first + request.count)
        seen = [_advanced(space, chunk["rig"], request.drive, shaker, *block) for block in blocks]
        samples, parted = [motion if shaker else motion[:, :3] for motion, _ in seen], seen[-1][1]
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


def _advanced(space, rig, drive, shaker, first, count):
    """Shaker, mass (m), tilt (rad), force (N) and voltage (V) at each kick (count, 5), and when the rig flew apart."""
    push, tap = drive.kicks(first, count), drive.pulses(rig.m, first, count)
    nominal = drive.between(first, count)[:, None] if shaker else None
    motion = space.advance(push[:, None], tap[:, None], 1, nominal)
    seen = motion.shaker, motion.mass, motion.tilt, motion.force, motion.voltage
    return np.column_stack(seen), motion.parted[0]


def replay(rig, drives, start, step, every, shaker=None):
    """Shaker, mass (m), tilt (rad), force (N) and voltage (V) of one bench at each ``every``-th step (n, 5), again."""
    space, kept, passed = RigSpace([rig], step, start, [shaker]), [], 0
    for drive in drives:
        for first, count in _blocks(0, drive.steps):
            kept.append(_advanced(space, rig, drive, shaker, first, count)[0][-passed % every :: every])
            passed += count
    return np.concatenate(kept)
