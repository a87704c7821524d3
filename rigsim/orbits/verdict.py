"""Is that all? Orbits found by harmonic balance held against motions that integration in time leads to."""

from dataclasses import dataclass, replace

import numpy as np

from .. import checks
from ..attraction.attractors import affordable_states, attractors
from ..blas import one_blas_thread
from ..campaign.progress import reporting
from ..results import ResultSequence, Status, frame
from .branches import PeriodicOrbits
from .continuation import correct_at
from .periodic_orbits import continue_orbit

_FREQUENCIES = 8
_SAME = 1e-2  # relative distance of lines at the forcing frequency that are one motion's


@dataclass(frozen=True, eq=False, repr=False)
class AtFrequency:
    """What was found at one frequency.

    Attributes
    ----------
    frequency : float
        Hz.
    orbits, stable : int
        Periodic orbits on the curves, and how many of them are stable.
    missed : tuple of Attractor
        Motions that last and lie on no stable orbit of the curves.
    unmet : tuple of complex
        Lines of z (m) of stable orbits that no start came to: their basins are small, or they are not.
    """

    frequency: float
    orbits: int
    stable: int
    missed: tuple
    unmet: tuple


@dataclass(frozen=True, eq=False, repr=False)
class Verdict(ResultSequence):
    """What `verdict` returns.

    Attributes
    ----------
    members : tuple of AtFrequency
    orbits : PeriodicOrbits
        What was judged, and the curves through motions it had missed, of up to three periods.
    starts : int
        At each frequency.
    status : Status
        FOUND if every motion met lies on a curve that was there before, else DOUBTFUL.
    message : str
    """

    members: tuple
    orbits: PeriodicOrbits
    starts: int
    status: Status
    message: str

    def summary(self):
        """One line: whether integration met anything that the curves lack."""
        return f"Verdict from {self.starts} starts at each of {len(self)} frequencies: {self.message}"

    def table(self):
        """`pandas.DataFrame`, a row a frequency."""
        rows = [
            (
                one.frequency,
                one.orbits,
                one.stable,
                ", ".join(a.name for a in one.missed) or "none",
                ", ".join(f"{1e3 * abs(z):.4g} mm" for z in one.unmet) or "none",
            )
            for one in self
        ]
        return frame(rows, ["frequency [Hz]", "orbits", "stable", "missed motions", "stable orbits not met"])


@one_blas_thread
def verdict(orbits, frequencies=None, *, starts=64, seed=0, progress=False):
    """Compare the stable orbits of curves with the motions that many starts lead to, and follow what was missed.

    Parameters
    ----------
    orbits : PeriodicOrbits
    frequencies : (n,) array_like, optional
        Hz; by default eight across the band, and the middle of every part of it where no orbit is stable.
    starts : int
        At each frequency; see `rigsim.attraction.attractors.attractors`.
    seed : int
    progress : bool or callable
        Counts frequencies.

    Returns
    -------
    Verdict
    """
    orbits = checks.instance("orbits", orbits, PeriodicOrbits, "PeriodicOrbits")
    low, high = orbits.band
    starts, seed = checks.integer("starts", starts, low=1), checks.seed("seed", seed)
    progress = checks.progress(progress)
    if frequencies is None:
        middles = [0.5 * sum(gap) for gap in orbits.without_stable]
        frequencies = np.sort([*np.geomspace(low, high, _FREQUENCIES + 2)[1:-1], *middles])
    frequencies = checks.array("frequencies", frequencies, "Hz", low=low, high=high)
    count, name = starts * frequencies.size, f"starts at {frequencies.size} frequencies"
    affordable_states(name, count, orbits.parameters, high, at_once=starts)
    members, more, lost = [], [], []
    with reporting(progress, frequencies.size, "verdict") as report:
        for number, frequency in enumerate(frequencies.tolist()):
            members.append(_at(replace(orbits, members=(*orbits, *more)), frequency, starts, seed))
            for one in members[-1].missed:
                if not 1 <= one.period <= 3 or any(_lies_on(one, branch, frequency) for branch in more):
                    continue
                known = orbits.parameters, orbits.force, frequency, one.relative
                settings = orbits.band, orbits.harmonics, orbits.law
                try:
                    more.append(continue_orbit(*known, *settings, period=one.period))
                except ValueError:  # with these harmonics there is no such orbit
                    lost.append(f"'{one.name}' at {frequency:g} Hz")
            report(number + 1)
    missed = [(one.frequency, a.name) for one in members for a in one.missed]
    told = ", ".join(f"'{name}' at {frequency:g} Hz" for frequency, name in missed)
    message = f"the curves lack {told}" if missed else "every motion met lies on a stable stretch of the curves"
    if lost:
        message += f"; with {orbits.harmonics} harmonics no curve was found through {', '.join(lost)}"
    unmet = sum(len(one.unmet) for one in members)
    if unmet:
        message += f"; {unmet} stable orbits were met by no start"
    status = Status.DOUBTFUL if missed else Status.FOUND
    return Verdict(tuple(members), replace(orbits, members=(*orbits, *more)), starts, status, message)


def _lies_on(motion, branch, frequency):
    line = motion.relative[motion.period]
    known = passing(branch, frequency)
    return any(period == motion.period and abs(z - line) < _SAME * abs(line) for period, z, _ in known)


def _at(orbits, frequency, starts, seed):
    found = [one for branch in orbits for one in passing(branch, frequency)]
    stable = [(period, line) for period, line, lasts in found if lasts]
    met = attractors(orbits.parameters, orbits.force, frequency, law=orbits.law, starts=starts, seed=seed)
    lines = [(one.period, one.relative[one.period] if one.period else np.nan) for one in met]
    same = np.array([[p == q and abs(z - w) < _SAME * abs(w) for q, w in stable] for p, z in lines], dtype=bool)
    same = same.reshape(len(lines), len(stable))
    missed = tuple(one for one, known in zip(met, same.any(axis=1), strict=True) if not known)
    unmet = tuple(z for (_, z), known in zip(stable, same.any(axis=0), strict=True) if not known)
    return AtFrequency(frequency, len(found), len(stable), missed, unmet)


def passing(branch, frequency):
    """(period, line of z at f in m, whether it is stable) of every orbit of a branch at a frequency (Hz)."""
    equations, points = branch.equations()
    off = branch.frequency - frequency
    for i in np.flatnonzero(np.sign(off[:-1]) != np.sign(off[1:])):
        share = off[i] / (off[i] - off[i + 1])
        x = points[i] + share * (points[i + 1] - points[i])
        good, _, _ = correct_at(*equations.system, x, frequency / equations.hertz, 20, 0.3)
        if good:
            line = equations.lines(x[None])[3][0, branch.period]
            yield branch.period, line, bool(branch.stable[i if share < 0.5 else i + 1])
