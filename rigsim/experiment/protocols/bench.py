"""Benches side by side, one rig on each: operators ask for the next stretch of force, and are told the motion."""

from collections import namedtuple

import numpy as np

from ...campaign.stop import look
from ...model.chipmunk import RigSpace

Request = namedtuple("Request", "drive first count")  # kicks first to first + count - 1 of a Drive
# xs, x, tilt at each of these kicks (count, 3), with a shaker's drive its force (N) and voltage (V), too (count, 5);
# when the rig flew apart, or NaN
Told = namedtuple("Told", "samples parted")

# What is read of a motion: a column each of the arrays that a chunk of benches returns.
COLUMNS = (
    "time", "force", "frequency", "shaker", "mass", "relative", "tilt", "distortion", "subharmonic", "drift", "left",
    "dwell", "velocity", "tries", "error", "status", "message",
    "given",
)  # fmt: skip
CHUNK = 4  # benches a Space: they end at different times, and the last ones keep all others going
_BLOCK = 2500  # steps between two looks at the keyboard


def run_benches(chunk):
    """Run the plans of a chunk to their ends: arrays of all readings, of all stretches of force, and whose they are.

    ``chunk`` has the "rigs", their "plans" (each with ``operate(step)``, a generator of `Request` that is sent `Told`
    and returns its readings and drives), their "numbers", the "start" and the "step", and where there are such their
    "shakers".
    """
    rigs, step, shakers = chunk["rigs"], chunk["step"], chunk.get("shakers", (None,) * len(chunk["rigs"]))
    space = RigSpace(rigs, step, chunk["start"], shakers)
    operators = [plan.operate(step) for plan in chunk["plans"]]
    asked, told, ends = [next(operator) for operator in operators], [[] for _ in rigs], [None] * len(rigs)
    done = np.zeros(len(rigs), dtype=int)
    while any(request is not None for request in asked):
        look()
        count = min([_BLOCK, *(r.count - done[i] for i, r in enumerate(asked) if r is not None)])
        push, tap = np.zeros((2, count, len(rigs)))
        nominal = np.zeros(push.shape, dtype=complex) if any(shakers) else None
        for i, request in enumerate(asked):
            if request is not None:
                push[:, i] = request.drive.kicks(request.first + done[i], count)
                tap[:, i] = request.drive.pulses(rigs[i].m, request.first + done[i], count)
                if shakers[i]:
                    nominal[:, i] = request.drive.between(request.first + done[i], count)
        motion = space.advance(push, tap, 1, nominal)
        seen = np.stack([motion.shaker, motion.mass, motion.tilt, motion.force, motion.voltage], axis=2)
        for i, request in enumerate(asked):
            if request is None:
                continue
            told[i].append(seen[:, i] if shakers[i] else seen[:, i, :3])
            done[i] += count
            if done[i] == request.count:
                answer = Told(np.concatenate(told[i]), motion.parted[i])
                told[i], done[i] = [], 0
                try:
                    asked[i] = operators[i].send(answer)
                except StopIteration as end:
                    asked[i], ends[i] = None, end.value
    return _columns(chunk["numbers"], ends)


def _columns(numbers, ends):
    read = [(number, reading) for number, (readings, _) in zip(numbers, ends, strict=True) for reading in readings]
    drives = [[number, *drive.row()] for number, (_, drives) in zip(numbers, ends, strict=True) for drive in drives]
    columns = {name: np.array([reading[name] for _, reading in read]) for name in COLUMNS}
    return columns | {"run": np.array([number for number, _ in read]), "drives": np.array(drives)}


def replay(rig, drives, start, step, every, shaker=None):
    """Force (N), shaker, mass (m), tilt (rad) and voltage (V) of one bench at each ``every``-th step (n, 5), again."""
    space, kept, passed = RigSpace([rig], step, start, [shaker]), [], 0
    for drive in drives:
        for first in range(0, drive.steps, _BLOCK):
            look()
            count = min(_BLOCK, drive.steps - first)
            push, tap = drive.kicks(first, count), drive.pulses(rig.m, first, count)
            nominal = drive.between(first, count)[:, None] if shaker else None
            motion = space.advance(push[:, None], tap[:, None], 1, nominal)
            own = slice(-passed % every, None, every)
            seen = motion.force, motion.shaker, motion.mass, motion.tilt, motion.voltage
            kept.append(np.concatenate(seen, axis=1)[own])
            passed += count
    return np.concatenate(kept)
