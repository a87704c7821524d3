"""Connected curves of periodic orbits, what each says of its stability, and where single-term theory says otherwise."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .. import checks
from ..parameters import OscillatorParameters, RigParameters
from ..results import Result, ResultSequence, Status, frame
from ..theory.amplitude import frequency_response
from ..theory.floquet import is_stable, runs_of
from .accuracy import neglected
from .harmonic_balance import balance
from .shooting import shoot_orbit
from .stability import hill_multipliers, stability_changes

_CLOSE = 5e-3  # of a largest multiplier to the unit circle, where its verdict is judged again
_ROUGH = 1e-4  # largest error of an orbit whose verdict is judged again
_ROUNDED = 1 + 1e-9  # relative: two frequencies that are one
_NEAR = 0.3  # relative distance within which a single-term solution is an orbit's counterpart


@dataclass(frozen=True)
class Disagreement:
    """A stretch of a curve over which single-term balance gives another verdict on stability.

    Attributes
    ----------
    low, high : float
        Hz.
    stable : bool
        Verdict of the converged orbits; single-term balance says the contrary.
    """

    low: float
    high: float
    stable: bool


@dataclass(frozen=True, eq=False, repr=False)
class OrbitBranch(Result):
    """A connected curve of periodic orbits inside a band, ordered along itself; what `periodic_orbits` returns.

    Lines are complex: u(t) = Re(sum_k U[k] exp(2 pi i k f t / period)), so column 0 is the mean and column ``period``
    the line at the forcing frequency f, zero to peak, phase against the force F cos(2 pi f t).

    Attributes
    ----------
    parameters : RigParameters or OscillatorParameters
    force : float
        Amplitude F (N).
    law : {"exact", "cubic"}
    frequency : (n,) array
        Forcing frequency (Hz); turns back at every fold. The last orbit of a closed curve is its first.
    shaker, mass, relative : (n, period harmonics + 1) complex array
        Lines of xs, x and z (m).
    period : int
        Period of the orbits, in forcing periods.
    folds : tuple of int
        Indices of the orbits at which the frequency turns, located to 1e-6 Hz and better.
    status : Status
        CLOSED, LEAVES_THE_BAND, BRANCHES_OFF or STOPPED.
    message : str
        How it ends, at both ends, and why; and single-term solutions nearby from which no orbit was found, as happens
        where these have folds that converged orbits do not.
    joins : tuple of int
        Positions, in the sequence it came in, of the curves that it joins outside the band.
    """

    parameters: RigParameters | OscillatorParameters
    force: float
    law: str
    frequency: np.ndarray
    shaker: np.ndarray
    mass: np.ndarray
    relative: np.ndarray
    period: int
    folds: tuple
    status: Status
    message: str
    joins: tuple = ()

    plots = {"orbits": "orbits_figure"}

    @property
    def closed(self):
        """Whether it closes on itself inside the band."""
        return self.status is Status.CLOSED

    @property
    def harmonics(self):
        """Multiples of the forcing frequency that were kept."""
        return (self.relative.shape[1] - 1) // self.period

    @property
    def symmetric(self):
        """Whether the second half of every orbit mirrors its first: all even lines are zero."""
        return not self.relative[:, ::2].any()

    @cached_property
    def multipliers(self):
        """(n, 4) complex Floquet multipliers about these orbits, over their period, by Hill's determinant.

        See `rigsim.orbits.stability`. Where a verdict could turn, the largest being close to one, they are those of
        the same orbit found by shooting, unless its `error` is too large for it to be the same.
        """
        equations, points = self.equations()
        values = hill_multipliers(equations, points)
        close = np.flatnonzero(abs(abs(values[:, 0]) - 1) < _CLOSE)
        for i in close[neglected(equations, points[close]) < _ROUGH]:
            shot, line = self.shoot(i), self.relative[i, self.period]
            if shot.converged and abs(shot.relative[self.period] - line) < 10 * _ROUGH * abs(line):
                values[i] = shot.multipliers
        return values

    @cached_property
    def error(self):
        """(n,) estimated relative error of each orbit by the lines it neglects; see `rigsim.orbits.accuracy`."""
        return neglected(*self.equations())

    @cached_property
    def stable(self):
        """(n,) bool: whether all `multipliers` lie inside the unit circle."""
        return is_stable(self.multipliers)

    @property
    def runs(self):
        """Runs of equal stability; see `rigsim.theory.floquet.runs_of`."""
        return runs_of(self.stable)

    @cached_property
    def special_points(self):
        """Tuple of `SpecialPoint` in the order of the curve: folds, and every change of stability."""
        return stability_changes(*self.equations(), self.folds)

    @cached_property
    def disagreements(self):
        """Tuple of `Disagreement`: where the paper's way to judge stability errs on this curve.

        Symmetric orbits of period 1 have a single-term counterpart: the solution nearest to their line at the forcing
        frequency, unless that lies further than 30 % away. A stretch ends at a special point, or half-way between two
        orbits.
        """
        if self.period != 1 or not self.symmetric:
            return ()
        theory = frequency_response(self.parameters, self.force, self.frequency)
        apart = abs(theory.relative - self.relative[:, 1:2])
        nearest = np.nanargmin(apart, axis=1)[:, None]
        verdict = np.take_along_axis(theory.stable, nearest, axis=1)[:, 0]
        near = np.take_along_axis(apart, nearest, axis=1)[:, 0] < _NEAR * abs(self.relative[:, 1])
        differs = near & (verdict != self.stable)
        cuts = np.flatnonzero(np.diff(differs) | np.diff(self.stable))
        known = {point.index: point.frequency for point in self.special_points}
        edges = {i: known.get(int(i), 0.5 * (self.frequency[i] + self.frequency[i + 1])) for i in cuts}
        found = []
        for run in np.split(np.arange(differs.size), cuts + 1):
            if differs[run[0]]:
                places = [*self.frequency[run], *(edges[i] for i in (run[0] - 1, run[-1]) if i in edges)]
                found.append(Disagreement(float(min(places)), float(max(places)), bool(self.stable[run[0]])))
        return tuple(found)

    def shoot(self, i):
        """Orbit ``i`` found again by shooting in time, as a `ShotOrbit`."""
        i = checks.integer("i", i, low=0, high=self.frequency.size - 1)
        rate = 2j * np.pi * self.frequency[i] / self.period * np.arange(self.relative.shape[1])
        motion = np.array([self.shaker[i], self.mass[i]])
        state = np.concatenate([motion.real.sum(axis=1), (rate * motion).real.sum(axis=1)])
        return shoot_orbit(self.parameters, self.force, self.frequency[i], state, self.law, period=self.period)

    def equations(self):
        """The balance equations that the curve obeys, and its unknowns (n, ...)."""
        equations = balance(
            self.parameters, self.force, self.harmonics, self.law, self.period, self.period != 2 and self.symmetric
        )
        points = [equations.unknowns(f, lines) for f, lines in zip(self.frequency, self.relative, strict=True)]
        return equations, np.array(points)

    def table(self):
        """`pandas.DataFrame` of the special points."""
        rows = [(p.kind, p.frequency, 1e3 * abs(p.relative), abs(p.multipliers[0])) for p in self.special_points]
        return frame(rows, ["special point", "frequency [Hz]", "|z| [mm]", "largest |multiplier|"])

    def summary(self):
        """One line: reach, folds, and how it ends."""
        low, high = self.frequency.min(), self.frequency.max()
        return (
            f"OrbitBranch: {self.frequency.size} orbits of period {self.period} from {low:.4f} to {high:.4f} Hz, "
            f"{len(self.folds)} folds, {self.message}"
        )


@dataclass(frozen=True, eq=False, repr=False)
class PeriodicOrbits(ResultSequence):
    """Every `OrbitBranch` found over a band, single-term theory's first; what `periodic_orbits` returns.

    Attributes
    ----------
    members : tuple of OrbitBranch
    parameters : RigParameters or OscillatorParameters
    force : float
        Amplitude F (N).
    law : {"exact", "cubic"}
    band : (float, float)
        Hz.
    harmonics : int
    """

    members: tuple
    parameters: RigParameters | OscillatorParameters
    force: float
    law: str
    band: tuple
    harmonics: int

    plots = {"orbits": "orbits_figure"}

    @cached_property
    def without_stable(self):
        """Tuple of (low, high) in Hz: the parts of the band where no orbit on these curves is stable."""
        low, high = self.band
        runs = [b.frequency[run] for b in self for run, stable in b.runs if stable]
        reached, gaps = low, []
        for start, stop in sorted((float(f.min()), float(f.max())) for f in runs):
            if start > reached * _ROUNDED:
                gaps.append((reached, start))
            reached = max(reached, stop)
        return tuple(gaps) + (((reached, high),) if reached * _ROUNDED < high else ())

    def verdict(self, frequencies=None, **options):
        """The `Verdict` on these orbits by integration in time; see `rigsim.orbits.verdict.verdict`."""
        from .verdict import verdict  # which is built on these

        return verdict(self, frequencies, **options)

    def table(self):
        """`pandas.DataFrame`, a row a branch."""
        rows = []
        for b in self:
            reach = b.frequency.min(), b.frequency.max()
            rows.append((b.period, b.symmetric, *reach, len(b.folds), b.stable.mean(), b.message))
        columns = ["period", "symmetric", "from [Hz]", "to [Hz]", "folds", "share stable", "how it ends"]
        return frame(rows, columns)

    def summary(self):
        """One line: how many branches."""
        low, high = self.band
        return (
            f"PeriodicOrbits: {len(self)} branches from {low:g} to {high:g} Hz at {self.force:g} N, {self.harmonics} "
            f"harmonics, {self.law} law"
        )
