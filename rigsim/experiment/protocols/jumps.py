"""Jumps in a test: where z changes by more than the force's moving on explains."""

from dataclasses import dataclass

import numpy as np

_TALL = np.log(1.2)  # least change of an amplitude
_ABOVE = 4.0  # times the changes beside it
_BESIDE = 20.0  # s, on both sides of a sweep's jump
_LASTS = 3.0  # s: within so long of each other, changes are one jump


@dataclass(frozen=True)
class JumpSeen:
    """A jump as a test sees it, in frequency or in force.

    For parameters from jumps give `rigsim.identification.jumps.Jump.found_in` the force, ``frequency`` and ``relative``
    of a stepped test of one bench.

    Attributes
    ----------
    frequency, force : float
        Where z changes fastest (Hz, N).
    half_width : float
        Of what was moved (Hz, or N): between this and that value it happened.
    amplitude : {"rises", "falls"}
        What abs(z) does.
    sweep : {"up", "down"}
        How it was moved.
    """

    frequency: float
    force: float
    half_width: float
    amplitude: str
    sweep: str


def jumps_between(test):
    """Jumps from point to point of a `BenchTest` of one bench: a fifth at least, and far more than the steps beside.

    That is four times them, or twice them and another fifth: before a fold the steps grow. The first step and the last
    have none on one side, and are not judged. What a tap does is no jump.
    """
    moved, z = getattr(test, test.over), np.abs(test.relative)
    if len(z) < 3 or test.column("tries").any():
        return ()
    change = np.diff(np.log(z))
    size = np.abs(change)
    beside = np.maximum(np.append(size[1:], np.inf), np.insert(size[:-1], 0, np.inf))
    far = (size > _ABOVE * beside) | (size > _TALL + 2 * beside)
    places = np.flatnonzero((size > _TALL) & far & (np.diff(moved) != 0))
    return tuple(_jump(test, i, i + 1, change[i]) for i in places)


def jumps_in_passing(test):
    """Jumps of a `BenchTest` of one bench that moves on: more in a window than elsewhere within twenty seconds."""
    moved, z, time = getattr(test, test.over), np.abs(test.relative), test.time
    if len(z) < 12:
        return ()
    begun = time > time[0] + _LASTS  # until then it comes from rest
    change = np.log(z[4:] / z[:-4])  # over two windows, of the reading in their middle
    size, centre = np.abs(change), time[2:-2]
    usual = np.array([_usual(size, centre, i) for i in range(len(size))])
    places = np.flatnonzero((size > _TALL) & (size > _ABOVE * usual) & begun[:-4])
    groups = np.split(places, np.flatnonzero(np.diff(centre[places]) > _LASTS) + 1) if places.size else []
    found = []
    for group in groups:
        low, high = group[0], group[-1] + 4  # readings before and after all of it
        if (np.diff(moved[low : high + 1]) > 0).all() or (np.diff(moved[low : high + 1]) < 0).all():
            steepest = low + np.argmax(np.abs(np.diff(np.log(z[low : high + 1]))))
            found.append(_jump(test, steepest, steepest + 1, change[group[size[group].argmax()]], (low, high)))
    return tuple(found)


def _usual(size, time, i):
    away = np.abs(time - time[i])
    others = size[(away < _BESIDE) & (away > _LASTS)]
    return np.median(others) if others.size else 0.0


def _jump(test, before, after, change, ends=None):
    moved = getattr(test, test.over)
    low, high = ends or (before, after)
    middle = [float(0.5 * (values[before] + values[after])) for values in (test.frequency, test.force)]
    words = "rises" if change > 0 else "falls", "up" if moved[after] > moved[before] else "down"
    return JumpSeen(*middle, float(abs(moved[high] - moved[low]) / 2), *words)
