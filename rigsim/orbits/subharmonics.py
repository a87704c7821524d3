"""Motions that repeat after two or three forcing periods: searched over a band, and each followed to its folds.

Single-term theory has no such motion, and none of its branches leads to one: their curves are closed on themselves.
So they are searched from many starts at every frequency of a grid, and a motion that lies on no curve found so far is
followed by harmonic balance until its curve closes or leaves the band.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .. import checks
from ..attraction.attractors import affordable_states, attractors, quasi_random
from ..blas import one_blas_thread
from ..campaign.run import run_chunks
from ..parameters import OscillatorParameters, RigParameters, law_of
from ..results import Result, frame
from ..theory.amplitude import frequency_response
from .branches import OrbitBranch
from .periodic_orbits import continue_orbit

PERIODS = (2, 3)
_SAME = 0.02  # of the largest line: how near a motion must come to a curve to lie on it
_HARMONICS = 7  # of the curves


@dataclass(frozen=True, eq=False)
class SubharmonicMotion:
    """A lasting motion of more than one forcing period, met at one frequency.

    Attributes
    ----------
    frequency : float
        Of the force (Hz).
    period : int
        In forcing periods.
    amplitude : float
        Largest abs(z) (m).
    relative : (l,) complex array
        Lines of z (m) at 0, f/period, 2 f/period, ...
    share : float
        Of the search's starts that lead to it.
    """

    frequency: float
    period: int
    amplitude: float
    relative: np.ndarray
    share: float

    @property
    def giveaway(self):
        """Strongest line of z off the harmonics of the force: (frequency in Hz, amplitude in m)."""
        size = np.abs(self.relative)
        size[:: self.period] = 0.0
        return float(size.argmax() * self.frequency / self.period), float(size.max())


@dataclass(frozen=True, eq=False, repr=False)
class SubharmonicFamily(Result):
    """A curve of subharmonic motions.

    Attributes
    ----------
    period : int
        In forcing periods.
    branch : OrbitBranch
        The curve, stable and unstable, with its folds.
    met : (k,) array
        Frequencies at which the search met it (Hz).
    """

    period: int
    branch: OrbitBranch
    met: np.ndarray

    @property
    def folds(self):
        """Frequencies at which the curve turns back (Hz), in its order."""
        return tuple(float(self.branch.frequency[i]) for i in self.branch.folds)

    def summary(self):
        """One line with its reach and where it was met."""
        low, high = self.branch.frequency.min(), self.branch.frequency.max()
        shape = "closed" if self.branch.closed else self.branch.message
        return (
            f"SubharmonicFamily of period {self.period}: {low:.3f} to {high:.3f} Hz, {len(self.folds)} folds, {shape}; "
            f"met at {self.met.min():g} to {self.met.max():g} Hz"
        )


@dataclass(frozen=True, eq=False, repr=False)
class Subharmonics(Result):
    """Subharmonic motions over a band; what `subharmonic_motions` returns.

    Attributes
    ----------
    parameters : RigParameters or OscillatorParameters
    law : str
    force : float
        N.
    frequency : (n,) array
        Where was searched (Hz).
    starts : int
        At each of them.
    motions : tuple of SubharmonicMotion
        Every one met, by frequency; those of more than three periods too, which are not followed.
    families : tuple of SubharmonicFamily
        The curves of period 2 and 3 that they lie on.
    """

    parameters: RigParameters | OscillatorParameters
    law: str
    force: float
    frequency: np.ndarray
    starts: int
    motions: tuple
    families: tuple

    plots = {"subharmonics": "subharmonics_figure"}

    @property
    def band(self):
        """What the search and the families reach over, and 2 Hz more on either side (pair in Hz)."""
        places = np.concatenate([self.frequency, *(family.branch.frequency for family in self.families)])
        return float(places.min()) - 2, float(places.max()) + 2

    @cached_property
    def response(self):
        """The `FrequencyResponse` of single-term theory over the `band`."""
        return frequency_response(self.parameters, self.force, np.linspace(*self.band, 400))

    def table(self):
        """`pandas.DataFrame`: every motion met, and the line of its spectrum that gives it away."""
        rows = [
            (m.frequency, m.period, 1e3 * m.amplitude, 1e3 * abs(m.relative[m.period]), f, 1e3 * z, 100 * m.share)
            for m in self.motions
            for f, z in [m.giveaway]
        ]
        columns = "frequency [Hz]", "period", "largest |z| [mm]", "|z| at f [mm]", "tell-tale line [Hz]", "its |z| [mm]"
        return frame(rows, [*columns, "share [%]"])

    def summary(self):
        """One line: how many motions and families."""
        told = ", ".join(
            f"period {one.period} from {one.branch.frequency.min():.2f} to {one.branch.frequency.max():.2f} Hz"
            for one in self.families
        )
        low, high = self.frequency.min(), self.frequency.max()
        return (
            f"Subharmonics at {self.force:g} N, {low:g} to {high:g} Hz: {len(self.motions)} motions met from "
            f"{self.starts} starts at each of {self.frequency.size} frequencies; families: {told or 'none'}"
        )


@one_blas_thread
def subharmonic_motions(
    parameters, force, frequency=None, *, law=None, starts=256, follow=(20.0, 200.0), seed=0, progress=False,
    executor=None, checkpoint=None,
):  # fmt: skip
    """Search a band for motions of two and three forcing periods, and follow each to both its folds.

    Parameters
    ----------
    parameters, force, law, starts, seed
        See `rigsim.attraction.attractors.attractors`; the starts are those at every frequency.
    frequency : (n,) array_like, optional
        Where to search (Hz); by default every 2 Hz from 40 to 110.
    follow : (float, float)
        Band in which curves are followed (Hz); widened to hold ``frequency``.
    progress, executor, checkpoint
        See `rigsim.campaign.run.run_chunks`; by default frequencies are searched one after the other, on every core.

    Returns
    -------
    Subharmonics

    Raises
    ------
    ValueError
        If an argument is not allowed.
    """
    progress, executor, checkpoint = checks.running(progress, executor, checkpoint)
    law, force = law_of(parameters, law), checks.positive("force", force, "N")
    starts, seed = checks.integer("starts", starts, low=1), checks.seed("seed", seed)
    frequency = np.arange(40.0, 110.5, 2.0) if frequency is None else frequency
    frequency = np.unique(checks.array("frequency", frequency, "Hz", low=0.0, low_open=True))
    follow = checks.pair("follow", follow, "Hz")
    shared = executor or checkpoint
    for count, name in ((1, "starts"), (frequency.size, f"starts at {frequency.size} frequencies")):
        states, highest = 2 * starts * count, float(frequency[-1])  # each is run twice; one frequency is not shared
        affordable_states(name, states, parameters, highest, count > 1 and shared, at_once=starts)
    band = min(follow[0], 0.99 * frequency[0]), max(follow[1], 1.01 * frequency[-1])
    common = {"parameters": parameters, "force": force, "law": law, "starts": starts, "seed": seed}
    chunks = [common | {"frequency": float(f)} for f in frequency]
    options = {"progress": progress, "executor": executor, "checkpoint": checkpoint, "label": "frequencies"}
    motions = []
    for f, found in zip(frequency, run_chunks(_search_chunk, chunks, **options), strict=True):
        for period, amplitude, relative, share in zip(*(found[name] for name in _KEPT), strict=True):
            lines = relative[: 9 * period + 1]
            motions.append(SubharmonicMotion(float(f), int(period), float(amplitude), lines, float(share)))
    families = _families(parameters, force, law, band, motions)
    return Subharmonics(parameters, law, force, frequency, starts, tuple(motions), families)


_KEPT = ("period", "amplitude", "relative", "share")


@one_blas_thread
def _search_chunk(chunk):
    """Motions of more than one period at one frequency, as arrays."""
    found = attractors(**chunk)
    several = [one for one in found if one.period > 1]
    count = 9 * max([3, *(one.period for one in several)]) + 1
    relative = [np.pad(one.relative, (0, count - one.relative.size)) for one in several]
    label, _ = found.settle(quasi_random(chunk["starts"], found.box, chunk["seed"]))
    return {
        "period": np.array([one.period for one in several], dtype=int),
        "amplitude": np.array([one.amplitude for one in several]),
        "relative": np.array(relative, dtype=complex).reshape(-1, count),
        "share": np.array([(label == one.motion).mean() for one in several]),
    }


def _families(parameters, force, law, band, motions):
    """Follow every motion of two or three periods that lies on no curve yet."""
    branches, met = [], []
    for one in motions:
        if one.period not in PERIODS:
            continue
        at = next((i for i, branch in enumerate(branches) if _lies_on(one, branch)), None)
        if at is None:
            at = len(branches)
            known = one.frequency, one.relative
            branches.append(continue_orbit(parameters, force, *known, band, _HARMONICS, law, period=one.period))
            met.append([])
        met[at].append(one.frequency)
    families = [SubharmonicFamily(one.period, one, np.array(places)) for one, places in zip(branches, met, strict=True)]
    return tuple(sorted(families, key=lambda one: (one.period, one.branch.frequency.min())))


def _lies_on(motion, branch):
    """Whether a curve passes through a motion, whichever of its periods or twins either begins with."""
    if branch.period != motion.period:
        return False
    # A shift by a forcing period and the mirror image change phases only.
    own = np.abs(motion.relative[: branch.relative.shape[1]])
    sizes, f = np.abs(branch.relative), branch.frequency
    for i in np.flatnonzero((f[:-1] - motion.frequency) * (f[1:] - motion.frequency) <= 0):
        share = (motion.frequency - f[i]) / (f[i + 1] - f[i]) if f[i + 1] != f[i] else 0.5
        there = (1 - share) * sizes[i] + share * sizes[i + 1]
        if np.abs(there - own).max() < _SAME * own.max():
            return True
    return False
