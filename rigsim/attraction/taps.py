"""Which motion a tap leads to, by its size and its instant, and the smallest tap that leads to a given one."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import distance_transform_cdt

from .. import checks
from ..campaign.cost import affordable
from ..campaign.progress import reporting
from ..model.excitation import Tap
from ..parameters import law_of
from ..results import Result, frame
from .attractors import affordable_states, attractors, settle_and_learn
from .motions import Attractors

_SEARCHES = 8  # for the smallest tap, each from where a fresh grid still finds a smaller one


@dataclass(frozen=True, eq=False, repr=False)
class TapMap(Result):
    """Motions reached by taps on the suspended mass.

    Attributes
    ----------
    attractors : Attractors
        The motions and the flow.
    motion : int
        That is tapped.
    velocity : (v,) array
        Impulse of the tap over m (m/s); see `Tap`.
    instant : (i,) array
        When the pulse begins, in forcing periods after a peak of the force.
    duration : float
        Of the pulse (s).
    label : (v, i) array of int
        Motion reached, -1 for none.
    """

    attractors: Attractors
    motion: int
    velocity: np.ndarray
    instant: np.ndarray
    duration: float
    label: np.ndarray

    plots = {"taps": "tap_map_figure"}

    def reached(self, motion):
        """Whether each tap leads to a motion, of this number or name that only one bears, (v, i) bool."""
        return self.label == self.attractors.find(motion).motion

    def tap(self, row, column, after=1.0):
        """One tap of the map as a `Tap` for a test bench: by the first such instant ``after`` (s) or later.

        ``row`` and ``column`` are indices of ``velocity`` and ``instant``.
        """
        row = checks.integer("row", row, low=0, high=self.velocity.size - 1)
        column = checks.integer("column", column, low=0, high=self.instant.size - 1)
        return _bench_tap(self, self.velocity[row], self.instant[column], after)

    def surest(self, motion):
        """Indices (row, column) of the tap farthest, in cells of the map, from any that leads elsewhere.

        `ValueError` if none leads to the motion of this number or name.
        """
        there = self._surely_reached(motion)
        # Instants go round; beyond the largest velocities nothing is known.
        around = np.pad(np.tile(there, 3), ((1, 1), (0, 0)))
        depth = distance_transform_cdt(around)[1:-1, there.shape[1] : 2 * there.shape[1]]
        row, column = np.unravel_index(depth.argmax(), depth.shape)
        return int(row), int(column)

    def paths(self, instant, velocity, periods, samples):
        """What follows taps of several sizes ``velocity`` (n,) (m/s) at one ``instant``.

        The pulse begins ``instant`` forcing periods after a peak of the force. Returns the motions reached (n,), -1 for
        none, and the states (n, periods * samples, 4): xs, z (m) and their velocities (m/s) over so many ``periods``
        after the tap, from the next peak of the force on, at ``samples`` instants in each.
        """
        instant = checks.real("instant", instant, low=0.0, high=1.0)
        velocity, samples = checks.array("velocity", velocity, "m/s"), checks.integer("samples", samples, low=1)
        periods = checks.integer("periods", periods, low=1)
        count = velocity.size * periods * samples
        affordable(f"periods = {periods}", memory=100 * count, seconds=1e-5 * count, instead="fewer periods or samples")
        flow, start = self.attractors.flow, self.attractors[self.motion].orbit[0]
        states, _ = flow.tapped(start, instant, velocity, self.duration)
        return self.attractors.settled(states)[0], flow.trace(states, periods, samples)

    def _surely_reached(self, motion):
        there = self.reached(motion)
        if not there.any():
            raise ValueError(
                f"no tap of the map leads to {checks.shown(motion)}; expected larger velocities or more instants"
            )
        return there

    def table(self):
        """`pandas.DataFrame`: how many of the taps lead to each motion, and the smallest of them on the grid."""
        rows = []
        for one in self.attractors:
            there = self.reached(one.motion)
            sizes = np.abs(self.velocity)[there.any(axis=1)]
            rows.append((one.motion, one.name, 100 * there.mean(), sizes.min() if sizes.size else np.nan))
        return frame(rows, ["motion", "name", "taps [%]", "smallest on the grid [m/s]"])

    def summary(self):
        """One line: where the taps lead."""
        flow, names = self.attractors.flow, self.attractors.names
        told = ", ".join(f"{name} {self.reached(i).mean():.1%}" for i, name in enumerate(names))
        return f"TapMap at {flow.frequency:g} Hz and {flow.force:g} N, from '{names[self.motion]}': {told} of the taps"


@dataclass(frozen=True, eq=False, repr=False)
class SmallestTap(Result):
    """The smallest tap found that leads from one motion to another.

    Attributes
    ----------
    attractors : Attractors
        The motions and the flow.
    motion, target : int
        Motion tapped and motion reached.
    velocity : float
        m/s; positive if the motion tapped is its own mirror image, for then the opposite tap half a period later leads
        there as well.
    instant : float
        In forcing periods after a peak of the force.
    duration : float
        s.
    verified : bool
        Whether the same tap leads there also by twice as many steps.
    spared : float
        Share of the taps up to 0.98 of that size, of either sign and at any instant, that were seen not to lead there:
        1 if all.
    """

    attractors: Attractors
    motion: int
    target: int
    velocity: float
    instant: float
    duration: float
    verified: bool
    spared: float

    def tap(self, after=1.0):
        """As a `Tap` for a test bench: by the first such instant ``after`` (s) or later."""
        return _bench_tap(self, self.velocity, self.instant, after)

    def summary(self):
        """One line with size and instant."""
        names = self.attractors.names
        return (
            f"SmallestTap from '{names[self.motion]}' to '{names[self.target]}': {self.velocity:.4g} m/s, "
            f"{self.instant:.3f} periods after a peak of the force at {self.attractors.flow.frequency:g} Hz, "
            f"{'' if self.verified else 'not '}verified"
        )


def _bench_tap(taps, velocity, instant, after):
    frequency, after = taps.attractors.flow.frequency, checks.real("after", after, "s", low=0.0)
    return Tap(velocity, taps.duration, (np.ceil(after * frequency - instant - 1e-9) + instant) / frequency)


def tap_map(
    parameters, force, frequency, motion=0, *, velocity=None, instants=48, duration=2e-3, law=None, starts=256, seed=0,
    progress=False, executor=None, checkpoint=None,
):  # fmt: skip
    """Tap the mass while a motion lasts, by every size and at every instant of a period, and see where it leads.

    Parameters
    ----------
    parameters, force, frequency, law, starts, seed
        See `attractors`.
    motion : int or str
        That is tapped: its number, or a name that only one bears; see `attractors`.
    velocity : (v,) array_like, optional
        Sizes of the taps (m/s), of either sign; by default 81 from -1 to 1.
    instants : int
        Instants, evenly over one forcing period.
    duration : float
        Of the half-sine pulse (s).
    progress, executor, checkpoint
        See `rigsim.campaign.run.run_chunks`; by default a thread a core. Results do not depend on it.

    Returns
    -------
    TapMap

    Raises
    ------
    ValueError
        If an argument is not allowed, or names no motion.
    """
    progress, executor, checkpoint = checks.running(progress, executor, checkpoint)
    frequency, law = checks.positive("frequency", frequency, "Hz"), law_of(parameters, law)
    velocity = np.linspace(-1, 1, 81) if velocity is None else checks.array("velocity", velocity, "m/s")
    instants = checks.integer("instants", instants, low=1)
    duration = checks.real("duration", duration, "s", low=1e-9, high=100 / frequency)
    count, shared = instants * velocity.size, executor or checkpoint
    affordable_states("instants x velocity", count, parameters, frequency, shared)
    found = attractors(parameters, force, frequency, law=law, starts=starts, seed=seed)
    motion, instant = found.find(motion).motion, np.arange(instants) / instants
    states = _tapped(found, motion, velocity, instant, duration)
    options = {"progress": progress, "executor": executor, "checkpoint": checkpoint, "label": "taps"}
    found, label = settle_and_learn(found, states, **options)
    return TapMap(found, motion, velocity, instant, duration, label.reshape(instants, -1).T)


def _tapped(found, motion, velocity, instant, duration):
    """States (i v, 4) after taps of some sizes at some instants."""
    state = found[motion].orbit[0]
    return np.concatenate([found.flow.tapped(state, at % 1.0, velocity, duration)[0] for at in instant])


def _lead(found, motion, velocity, instant, duration):
    """Labels (v, i) of all taps of some sizes at some instants."""
    label, _ = found.settled(_tapped(found, motion, velocity, instant, duration))
    return label.reshape(len(instant), len(velocity)).T


def smallest_tap(taps, target, *, rounds=6, progress=False):
    """Refine the smallest tap of a map that leads to a motion.

    Around the smallest found so far a finer grid of sizes and instants is laid, four times as fine in every round; in
    the end a fresh grid of smaller taps over the whole period is tried, and the search goes on from any that leads
    there.

    Parameters
    ----------
    taps : TapMap
    target : int or str
        The motion wanted: its number, or a name that only one bears.
    rounds : int
    progress : bool or callable
        True shows a bar; a callable is told (searches done, searches to do at most).

    Returns
    -------
    SmallestTap

    Raises
    ------
    ValueError
        If no tap of the map leads there.
    """
    taps = checks.instance("taps", taps, TapMap, "a TapMap")
    rounds = checks.integer("rounds", rounds, low=1, high=20)
    there, found, motion = taps._surely_reached(target), taps.attractors, taps.motion
    wanted = found.find(target).motion
    best = _smallest(taps.velocity, taps.instant, there)
    reach = np.abs(taps.velocity).max() / 8, 1 / 16
    with reporting(progress, _SEARCHES, "searches at most") as report:
        for search in range(_SEARCHES):
            report(search)
            best = _refine(found, motion, wanted, best, reach, rounds, taps.duration)
            below = 0.98 * abs(best[0]) * np.concatenate([np.linspace(-1, -0.3, 24), np.linspace(0.3, 1, 24)])
            phases = (np.arange(32) + 0.5) / 32
            counter = _lead(found, motion, below, phases, taps.duration) == wanted
            if not counter.any():
                break
            best, reach = _smallest(below, phases, counter), (0.1 * abs(best[0]), 1 / 32)
        report(_SEARCHES)
    velocity, instant = best
    if velocity < 0 and found[motion].symmetric:  # the mirror image of the same tap
        velocity, instant = -velocity, (instant + 0.5) % 1.0
    finer = replace(found, flow=found.flow.refined())
    verified = bool((_lead(finer, motion, np.array([velocity]), [instant], taps.duration) == wanted).all())
    spared = 1 - float(counter.mean())
    return SmallestTap(found, motion, wanted, velocity, instant, taps.duration, verified, spared)


def _smallest(velocity, instant, there):
    rows, columns = np.nonzero(there)
    at = np.abs(velocity[rows]).argmin()
    return float(velocity[rows[at]]), float(instant[columns[at]])


def _refine(found, motion, wanted, best, reach, rounds, duration):
    for power in range(rounds):
        size, phase = reach[0] / 4**power, reach[1] / 4**power
        signed = np.sign(best[0])
        # The present best belongs to the grid, so that no round can lose it.
        velocity = signed * np.linspace(max(abs(best[0]) - size, 0.0), abs(best[0]), 17)
        instant = best[1] + phase * np.linspace(-1, 1, 17)
        best = _smallest(velocity, instant, _lead(found, motion, velocity, instant, duration) == wanted)
    return best[0], best[1] % 1.0
