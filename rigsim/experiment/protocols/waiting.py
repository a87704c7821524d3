"""At one force and one frequency: shake until the motion has settled, or for a while, and read it."""

import math
from dataclasses import dataclass

import numpy as np

from ...results import Status
from ..driven import NOTHING, read_sent
from ..lines import fit_sines
from ..steady import WINDOW, read_or_parted, sampling
from .bench import Request

_PART = 0.5  # s; the motion of each half window is compared with that of the last ones
_TURNS = 3  # periods of the force in a part at least, so that a third of its frequency is told from the mean
_MULTIPLES = np.array([1 / 3, 1 / 2, 2 / 3, 1, 4 / 3, 3 / 2, 5 / 3, 2, 3, 4, 5])
_ITSELF = 3  # of the multiples
_STILL = 1e-5  # change from part to part, of z, that is none
_OTHER = 0.1  # of z: by so much two motions differ


@dataclass(frozen=True)
class Patience:
    """How long a point lasts: ``dwell`` s, or until it has "settled".

    Settled is what comes within ``tolerance`` of what it goes to: with the lines z1, z2, z3 of z at the force's
    frequency over the last three half windows, a motion that decays as q^k has q = (z3 - z2)/(z2 - z1), a complex
    number, and (z3 - z2) q/(1 - q) left to go. That and the last change are together below ``tolerance`` of z, and so
    are changes of lines below f, of two and three periods; for at most ``limit`` s.
    """

    dwell: float | str
    tolerance: float
    limit: float

    @property
    def waits(self):
        """Whether points last until they have settled."""
        return self.dwell == "settled"

    @property
    def longest(self):
        """s, of a point."""
        return self.limit if self.waits else self.dwell

    def steps(self, part, window, step):
        """Of the leapfrog, the least and the most of a point."""
        if self.waits:
            return 3 * part, max(round(self.limit / step), 3 * part)
        steps = max(math.ceil(self.dwell / step * (1 - 1e-12)), window + 1, part)
        return steps, steps


def wait(drive, began, patience, sensors, number):
    """Operate a stretch at one force and frequency: its drive as it ended, its reading, its lines in the last part.

    A generator as `bench.run_bench` wants them, ``began`` steps into the test; the reading is the ``number``-th.
    """
    f, step = drive.frequency, drive.step
    every = sampling(f, step)
    grid = every * step
    window, part = (math.ceil(s / grid * (1 - 1e-12)) * every for s in (WINDOW, max(_PART, _TURNS / f)))
    least, most = patience.steps(part, window, step)
    kept, lines, done = None, [], 0
    while True:
        # A first part of odd length brings the end of the last one to where the dwell ends.
        count = least % part if done == 0 and least % part else part
        told = yield Request(drive, done, count)
        done += count
        kept = told.samples if kept is None else np.concatenate([kept, told.samples])[-window - part :]
        if count == part:
            lines.append(_lines(drive, done, every, told.samples))
        parted, left, late = not np.isnan(told.parted), _left(lines), done + part > most
        near = patience.waits and left < patience.tolerance
        if not (parted or (done >= least and (near or late))):
            continue
        own = kept[: -window - 2 : -every][::-1]
        time = step * np.arange(done - 1 - every * (len(own) - 1), done, every)
        phased = time + drive.turns / f  # so that phases count from the force
        read = read_or_parted(phased, own[:, :2], f, told.parted)
        if parted or late or read[-2] != Status.STILL_DRIFTING.name:
            break
    *_, status, message = read  # of the motion, whatever it is measured with
    if sensors is not None:
        read = read_or_parted(phased, sensors.measured(began * step + time, own[:, :2], number), f, told.parted)
    (shaker, mass, relative), distortion, subharmonic, drift, *_ = read
    if patience.waits and not near and status == Status.SETTLED.name:
        status, message = Status.STILL_DRIFTING.name, f"{left:.2g} of z left to go after {done * step:.3g} s; {message}"
    reading = {
        "time": (began + done) * step, "force": drive.force, "frequency": f, "shaker": shaker, "mass": mass,
        "relative": relative, "tilt": np.abs(own[:, 2]).max(), "distortion": distortion, "subharmonic": subharmonic,
        "drift": drift, "left": left, "dwell": done * step, "velocity": drive.velocity, "tries": 0, "error": np.nan,
        "status": status, "message": message, "given": NOTHING,
    }  # fmt: skip
    if own.shape[1] > 3:
        sent, harmonics = read_sent(phased, own[:, 3:], f, told.parted)
        reading["given"] = np.append(sent, harmonics)
    return drive.ended(done), reading, lines[-1] if lines else None


def _lines(drive, done, every, samples):
    """Lines of z (m) at `_MULTIPLES` of the frequency over a part that ends after ``done`` steps."""
    own = samples[::-every][::-1]
    time = drive.step * np.arange(done - 1 - every * (len(own) - 1), done, every) + drive.turns / drive.frequency
    return fit_sines(time, (own[:, 0] - own[:, 1])[:, None], drive.frequency * _MULTIPLES)[0][:, 0]


def _left(lines):
    """Share of z that is left to go, and that it went in the last part, NaN where that cannot be told yet."""
    if len(lines) < 3:
        return np.nan
    first, second, third = (line[_ITSELF] for line in lines[-3:])
    before, last, size = second - first, third - second, abs(third)
    below = np.abs(np.diff(np.abs(lines[-2:]), axis=0)[0, :_ITSELF]).max()  # of a subharmonic, or of a start's ringing
    if max(abs(before), abs(last)) < _STILL * size:
        return float(max(abs(before), abs(last), below) / size)
    ratio = last / before if before else np.inf
    if not abs(ratio) < 1:
        return np.inf
    return float(max(abs(last) * (1 + abs(ratio / (1 - ratio))), below) / size)


def differ(one, other):
    """Whether two motions, by their lines in a part, are others: at the frequency itself or below it."""
    below = np.abs(np.abs(one[:_ITSELF]) - np.abs(other[:_ITSELF])).max()
    return max(abs(one[_ITSELF] - other[_ITSELF]), below) > _OTHER * max(abs(one[_ITSELF]), abs(other[_ITSELF]))
