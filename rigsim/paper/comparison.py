"""Tests laid over the periodic orbits: which pieces of the response each protocol found, and which it walked past."""

from dataclasses import dataclass
from string import ascii_uppercase

import numpy as np

from .. import checks
from ..experiment.driven import check_force
from ..experiment.protocols.result import BenchTest
from ..experiment.sine_test import SineTest
from ..orbits.branches import PeriodicOrbits
from ..results import Result, Status, frame

_NEAR = 0.1  # of z, complex: the largest distance of a point from the piece that it lies on
_BELOW = 0.1  # largest line below f, over z, of a reading in passing on an orbit of one period
_SEEN = 3  # readings in passing that make a piece found; of a settled motion one is enough


@dataclass(frozen=True, eq=False)
class Piece:
    """A stable stretch of a response curve.

    Attributes
    ----------
    name : str
        A letter.
    kind : str
        What it is a stretch of, in words.
    frequency : ndarray, shape (n,)
        Hz, ascending.
    relative : ndarray, complex, shape (n,)
        Line of z at the force's frequency (m).
    """

    name: str
    kind: str
    frequency: np.ndarray
    relative: np.ndarray

    def distance(self, frequency, relative):
        """Relative distance of points from it, infinite beside its ends."""
        f, z = self.frequency, self.relative
        own = np.interp(frequency, f, z.real) + 1j * np.interp(frequency, f, z.imag)
        return np.where((frequency >= f[0]) & (frequency <= f[-1]), np.abs(relative - own) / np.abs(own), np.inf)


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Result):
    """What `compare_tests` returns.

    Attributes
    ----------
    orbits : PeriodicOrbits
    tests : tuple of BenchTest or SineTest
    names : tuple of str
        Of the tests.
    pieces : tuple of Piece
        Ascending in frequency.
    on : tuple of ndarray of int
        For each point of each test the number of its piece, or -1.
    """

    orbits: PeriodicOrbits
    tests: tuple
    names: tuple
    pieces: tuple
    on: tuple

    plots = {"tests": "comparison_figure"}

    def found(self, i):
        """Whether test ``i`` found each piece, bool array."""
        test, on = self.tests[self._checked(i)], self.on[self._checked(i)]
        weight = np.where(test.status == Status.PASSING, 1 / _SEEN, 1.0)
        return np.array([weight[on == k].sum() > 1 - 1e-9 for k in range(len(self.pieces))])

    def walked_past(self, i):
        """Whether test ``i`` was at frequencies of each piece and did not find it, bool array."""
        f = self.tests[self._checked(i)].frequency
        there = [((f >= piece.frequency[0]) & (f <= piece.frequency[-1])).any() for piece in self.pieces]
        return np.array(there) & ~self.found(i)

    def _checked(self, i):
        return checks.integer("i", i, low=0, high=len(self.tests) - 1)

    def _letters(self, which):
        return " ".join(piece.name for piece, one in zip(self.pieces, which, strict=True) if one) or "-"

    def table(self):
        """`pandas.DataFrame` with a row a test: what it took, and what it found."""
        rows = []
        for i, (name, test, on) in enumerate(zip(self.names, self.tests, self.on, strict=True)):
            jumps = ", ".join(f"{j.frequency:.1f} ({j.amplitude}, {j.sweep})" for j in getattr(test, "jumps", ()))
            found, past = self._letters(self.found(i)), self._letters(self.walked_past(i))
            rows.append((name, test.bench_time / 60, on.size, found, past, (on < 0).sum(), jumps or "-"))
        columns = ["test", "bench [min]", "points", "found", "walked past", "points on no piece", "jumps [Hz]"]
        return frame(rows, columns)

    def pieces_table(self):
        """`pandas.DataFrame` with a row a piece: where it lies, and which tests found it."""
        rows = []
        for k, piece in enumerate(self.pieces):
            by = [name for i, name in enumerate(self.names) if self.found(i)[k]]
            z = 1e3 * np.abs(piece.relative)
            rows.append((piece.name, piece.kind, *piece.frequency[[0, -1]], z.min(), z.max(), ", ".join(by) or "none"))
        columns = ["piece", "of", "from [Hz]", "to [Hz]", "least |z| [mm]", "largest |z| [mm]", "found by"]
        return frame(rows, columns)

    def summary(self):
        """One line: what all tests together found."""
        found = np.any([self.found(i) for i in range(len(self.tests))], axis=0)
        missed = self._letters(~found)
        minutes = sum(test.bench_time for test in self.tests) / 60
        told = "none is missed" if found.all() else f"missed: {missed}"
        return (
            f"Comparison of {len(self.tests)} tests at {self.orbits.force:g} N: together they found {found.sum()} of "
            f"{len(self.pieces)} stable pieces in {minutes:.3g} min on the bench; {told}"
        )


def compare_tests(orbits, *tests, names=None):
    """`Comparison` of tests at one force with the periodic orbits there: what each found, walked past, and took.

    A point lies on the stable piece that its line of z is nearest to, within a tenth of it, phase included; only where
    it settled, or was read in passing without a line below f. A piece is walked past by a test that was at its
    frequencies and has no point on it (in passing, fewer than three).

    Parameters
    ----------
    orbits : PeriodicOrbits
        Of the rig, at the force of the tests.
    *tests : BenchTest or SineTest
        One a row: ``*test.runs`` makes each bench a row of its own.
    names : sequence of str, optional
        What to call the tests, by default by their calls.

    Raises
    ------
    ValueError
        If there is no test, or one of another rig or force, or not as many names as tests.
    """
    orbits = checks.instance("orbits", orbits, PeriodicOrbits, "PeriodicOrbits")
    tests = tuple(checks.one_or_many("tests", tests, (BenchTest, SineTest), "a BenchTest or a SineTest"))
    if not tests:
        raise ValueError("tests is empty; expected at least one BenchTest or SineTest")
    for test in tests:
        check_force("tests", test.shakers, ("current", "force"))
        if any(rig != orbits.parameters for rig in test.parameters):
            raise ValueError("tests of another rig than that of the orbits are not allowed; expected tests of one rig")
        if not np.allclose(test.force, orbits.force, rtol=1e-9):
            low, high = test.force.min(), test.force.max()
            raise ValueError(
                f"tests at {low:g} to {high:g} N are not allowed; expected {orbits.force:g} N, that of the orbits"
            )
    if names is None:
        names = tuple(_called(test) for test in tests)
    names = tuple(checks.one_or_many("names", names, str, "text"))
    if len(names) != len(tests):
        raise ValueError(f"names has {len(names)} elements; expected {len(tests)}, one a test")
    pieces = _pieces(orbits)
    return Comparison(orbits, tests, names, pieces, tuple(_on(test, pieces) for test in tests))


def _called(test):
    if isinstance(test, SineTest):
        return "sine_test" if all(tap is None for tap in test.tap) else "sine_test, tapped"
    first, last = test.frequency[[0, -1]]
    way = "" if len(test.parameters) > 1 else ", up" if last > first else ", down" if last < first else ""
    return f"{test.protocol}{way}"


def _pieces(orbits):
    found = []
    for branch in orbits:
        runs = [np.arange(branch.frequency.size)[run] for run, stable in branch.runs if stable]
        if branch.closed and len(runs) > 1 and branch.stable[0] and branch.stable[-1]:
            runs = [np.concatenate([runs[-1][:-1], runs[0]]), *runs[1:-1]]  # through the place where it closes
        kind = "a detached curve" if branch.closed else "an open curve"
        kind += "" if branch.period == 1 else f" of period {branch.period}"
        for run in runs:
            stable = run[branch.stable[run]]  # without the first orbit of the next run, which it is drawn up to,
            ends = [p for p in branch.special_points if np.isin([p.index, p.index + 1], stable).any()]  # up to these
            frequency = np.append(branch.frequency[stable], [p.frequency for p in ends])
            relative = np.append(branch.relative[stable, branch.period], [p.relative for p in ends])
            order = np.argsort(frequency, kind="stable")
            found.append((kind, frequency[order], relative[order]))
    found.sort(key=lambda piece: piece[1][0])
    return tuple(Piece(_name(i), *piece) for i, piece in enumerate(found))


def _name(i):
    letter = ascii_uppercase[i % len(ascii_uppercase)]
    return letter if i < len(ascii_uppercase) else f"{letter}{i // len(ascii_uppercase)}"


def _on(test, pieces):
    below = (test.column("subharmonic") if isinstance(test, BenchTest) else test.subharmonic)[:, 0]
    orbit = (test.status == Status.SETTLED) | ((test.status == Status.PASSING) & (below < _BELOW))
    if not pieces:
        return np.full(test.frequency.size, -1)
    distance = np.array([piece.distance(test.frequency, test.relative) for piece in pieces])
    nearest = distance.argmin(axis=0)
    return np.where(orbit & (distance.min(axis=0) <= _NEAR), nearest, -1)
