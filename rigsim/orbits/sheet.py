"""The response sheet explored: every motion of a rig over frequency and force, found from rest and untold.

With the force left unknown, the balance equations at one frequency hold along lines in (coefficients, F): a *slice*
of the surface of all motions, of which the response at one force is a contour line. In each slice the line that
begins at rest is followed by arc length through every fold, to a ceiling above the force wanted. Wherever the
determinant over the even lines changes its sign along it, a line of asymmetric motions branches off, and is followed
likewise; and from those the lines of motions of twice the period, if asked for.

Every fold, and every place where a line branches off, then starts a *locus* over frequency and force (see
`rigsim.orbits.loci`), followed beyond the band and to ten times the force. A closed curve of the response at one force
turns back in frequency twice at least, and it does so only where a fold locus passes that force. So curves between
two slices, however small, are found from there, and need no slice.

What this covers: all that is connected with rest over frequency and force together, as far as a slice meets its folds
or branchings. Motions that hang on nothing, as those of period three do, are not among them; see
`rigsim.orbits.subharmonics`.
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from ..theory.cubic import dynamic_stiffness, fold_levels
from .continuation import (
    MIRROR,
    advance,
    both_ways,
    breaking_direction,
    breaking_signs,
    correct_at,
    distance,
    locate_fold,
    trace,
    unit_tangent,
)
from .harmonic_balance import balance
from .loci import BREAKING, DOUBLING, FOLD, TORUS, Sheet, apart, locus
from .stability import IMAGINARY, hill_multipliers, test_values

SLICES = 24  # over a band
_BEYOND = 1.25  # loci are followed to this many times the band's upper end, and to its lower end over that
_START = 1e-3  # of the force wanted, where a slice begins as the linear response
_CEILING = 3.0  # times the force wanted, and at least as often the upper fold level of single-term theory
_HIGHEST = 30.0  # times the force wanted, beyond which no slice is followed
_LOCUS_CEILING = 10.0  # the same for loci
_LONGEST = 0.1  # relative length of a step
_ROOM = 5_000  # motions a line may have
_OFF = 0.03  # relative length of the first step off a line that another one leaves
_SAME = 1e-4  # relative distance of one fold found twice


@dataclass(frozen=True, eq=False)
class Line:
    """A line of motions at one frequency.

    Attributes
    ----------
    points, tangents : (k, n) array
        Unknowns of the `Balance` at the frequency, the last one F over the wanted force; and the unit tangents.
    """

    points: np.ndarray
    tangents: np.ndarray


@dataclass(frozen=True, eq=False)
class Exploration:
    """What was found over a band and up to a force; levels are 0 symmetric, 1 asymmetric, 2 of period two.

    Attributes
    ----------
    sheets : tuple of Sheet
        One a level.
    band : (float, float)
        Hz.
    frequencies : list of float
        Of the slices (Hz).
    lines : list of list of (float, Line)
        For each level its lines, and the frequency (Hz) of each.
    loci : list of list of Locus
        For each level.
    """

    sheets: tuple
    band: tuple
    frequencies: list
    lines: list = field(default_factory=list)
    loci: list = field(default_factory=list)

    def copied(self):
        """The same, whose loci can be added to without changing these."""
        return replace(self, loci=[list(known) for known in self.loci])

    def add_locus(self, level, kind, y):
        """Follow the locus through the point y, unless it is known."""
        if not any(known.kind == kind and known.holds(y) for known in self.loci[level]):
            low, high = (f / self.sheets[0].equations.hertz for f in self.band)
            inside = lambda y: low / _BEYOND < y[-2] < high * _BEYOND and y[-1] < _LOCUS_CEILING  # noqa: E731
            self.loci[level].append(locus(self.sheets[level], kind, y, inside))

    def folds(self, level, share):
        """Points (m + 2,) of a level at which the response at ``share`` times the force turns back in frequency."""
        return [y for known in self.loci[level] if known.kind == FOLD for y in known.passing(-1, share)]

    def passages(self, level, share):
        """Orbits, unknowns of the level's `Balance`, where its lines pass ``share`` times the force."""
        found, equations = [], self.sheets[level].equations
        for frequency, line in self.lines[level]:
            F = line.points[:, -1] - share
            for i in np.flatnonzero(F[:-1] * F[1:] <= 0):
                part = F[i] / (F[i] - F[i + 1])
                x = line.points[i] + part * (line.points[i + 1] - line.points[i])
                good, _, _ = correct_at(*equations.at(frequency).system, x, share, 20, 0.3)
                if good:
                    found.append(np.append(x[:-1], frequency / equations.hertz))
        return found


def sheets_of(parameters, force, harmonics, law, levels=2):
    """The first two or three `Sheet`: symmetric, asymmetric, of period two."""
    equations = [
        balance(parameters, force, harmonics, law, *how) for how in ((1, True), (1, False), (2, False))[:levels]
    ]
    return tuple(Sheet(one, wider) for one, wider in zip(equations, [*equations[1:], None], strict=True))


def explored(sheets, band, branchings=False, report=None):
    """The `Exploration` of some `Sheet` over a band (Hz), up to the force of their equations and beyond.

    ``branchings``: whether loci are followed where lines branch off, too, which no curve needs.
    """
    frequencies = np.geomspace(*band, SLICES).tolist()
    found = Exploration(sheets, band, frequencies, [[] for _ in sheets], [[] for _ in sheets])
    for number, frequency in enumerate(frequencies):
        _explore_slice(found, frequency, branchings)
        if report:
            report(number + 1)
    for edge in (frequencies[0], frequencies[-1]):
        _close_loops(found, edge)
    return found


def _explore_slice(found, frequency, branchings):
    ceiling = _ceiling(found.sheets[0].equations, frequency)
    lines = from_rest(found.sheets[0].equations.at(frequency), ceiling)
    for level, sheet in enumerate(found.sheets):
        places = []
        for line in lines:
            found.lines[level].append((frequency, line))
            for x in _folds(sheet.equations.at(frequency), line):
                found.add_locus(level, FOLD, _point(sheet.equations, frequency, x))
            places += _branchings(sheet, level, frequency, line) if sheet.wider else []
        kind = (BREAKING, DOUBLING)[min(level, 1)]
        for place in places if branchings else ():
            found.add_locus(level, kind, _point(sheet.equations, frequency, place))
        if branchings and level < 2:
            for line in lines:
                for y in _modulations(sheet.equations, frequency, line):
                    found.add_locus(level, TORUS, y)
        if sheet.wider:
            lines = list(_leaving(sheet, level, frequency, places, ceiling))


def _point(equations, frequency, x):
    return np.append(x[: equations.size], [frequency / equations.hertz, x[-1]])


def from_rest(equations, ceiling):
    """The `Line` of a slice that begins at rest, up to a force over the wanted one; a list of one, or none."""
    x = np.full(equations.size + 1, 1e-3 * _START)  # not zero, since lengths are relative
    good, _, tangent = correct_at(*equations.system, x, _START, 60, np.inf)
    if not good:
        return []
    tangent *= math.copysign(1.0, tangent[-1])
    points, tangents, _ = trace(*equations.system, x, tangent, 0.1 * _START, ceiling, _LONGEST, _ROOM, -1)
    return [Line(points, tangents)]


def _folds(equations, line):
    points, tangents = line.points, line.tangents
    for i in np.flatnonzero(tangents[:-1, -1] * tangents[1:, -1] < 0):
        good, x, _ = locate_fold(*equations.system, points[i], tangents[i], distance(points[i + 1], points[i]))
        if good:
            yield x


def _branchings(sheet, level, frequency, line):
    """Motions on a line, unknowns of its own equations, at which lines of the next level leave it."""
    one, wider = sheet.equations.at(frequency), sheet.wider.at(frequency)
    parity = min(level, 1)
    signs = breaking_signs(*wider.system, wider.widened(one, line.points), parity)
    return [branching(one, wider, *line.points[i : i + 2], signs[i], parity) for i in np.flatnonzero(np.diff(signs))]


def _modulations(equations, frequency, line):
    """Points between which a complex pair of multipliers crosses the unit circle along a line."""
    points = np.column_stack([line.points[:, :-1], np.full(len(line.points), frequency / equations.hertz)])
    pairs = test_values(equations, points)[:, 1]
    for i in np.flatnonzero(pairs[:-1] * pairs[1:] < 0):
        if abs(hill_multipliers(equations, points[i : i + 1])[0].imag).max() > IMAGINARY:
            y = Sheet(equations).corrected_at(TORUS, np.append(points[i], line.points[i, -1]), -2)
            if y is not None:
                yield y


def branching(one, wider, start, end, sign, parity):
    """The motion between two of a line of ``one`` where the sign among ``wider`` changes; by bisection."""
    length = distance(end, start)
    chord = (end - start) / length
    left, right = 0.0, length
    while right - left > 1e-12:
        middle = 0.5 * (left + right)
        _, _, x, _ = advance(*one.system, start, chord, middle)
        same = breaking_signs(*wider.system, wider.widened(one, x)[None], parity)[0] == sign
        left, right = (middle, right) if same else (left, middle)
    return x


def _leaving(sheet, level, frequency, places, ceiling):
    """Lines of the next level that leave at some places; of a pair of mirror images one."""
    wider, parity = sheet.wider.at(frequency), min(level, 1)
    places = [wider.widened(sheet.equations, place) for place in places]
    for points, tangents, _ in leaving(wider, places, parity, (0.1 * _START, ceiling), _LONGEST, _ROOM):
        yield Line(points, tangents)


def leaving(equations, places, parity, reach, longest, room):
    """Lines of motions that leave others at ``places``, unknowns of ``equations``, each traced from there.

    Those that end at another of the places have it for their last point, and are not traced from there again.

    Yields
    ------
    tuple of ((k, n) array, (k, n) array, int)
        Points, tangents, and why it ends.
    """
    used = set()
    for number, place in enumerate(places):
        if number in used:
            continue
        direction = breaking_direction(*equations.system, place, parity)
        for step in (_OFF, 0.3 * _OFF, 0.1 * _OFF):
            sign, _, first, tangent = advance(*equations.system, place, direction, step)
            if sign != 0 and reach[0] < first[-1] < reach[1] and distance(first, place) < 3 * step:
                break
        else:
            continue  # they leave what is followed at once
        points, tangents, code = trace(*equations.system, first, tangent, *reach, longest, room, parity)
        points = np.concatenate([place[None], points])
        tangents = np.concatenate([unit_tangent(place, direction)[None], tangents])
        if code == MIRROR:
            last = min(range(len(places)), key=lambda i: distance(places[i], points[-1]))
            used.add(last)
            inwards = breaking_direction(*equations.system, places[last], parity)
            inwards *= np.sign(np.dot(inwards, points[-1] - points[-2]))
            points = np.concatenate([points, places[last][None]])
            tangents = np.concatenate([tangents, inwards[None]])
        yield points, tangents, code


def _close_loops(found, frequency):
    """Add lines that are closed within the slice at a frequency, so not connected with rest there: fold loci tell."""
    for level, sheet in enumerate(found.sheets):
        at = sheet.equations.at(frequency)
        known = [line for f, line in found.lines[level] if f == frequency]
        folds = [_point(sheet.equations, frequency, x) for line in known for x in _folds(at, line)]
        for y in [y for one in found.loci[level] if one.kind == FOLD for y in one.passing(-2, frequency / at.hertz)]:
            if not 0.1 * _START < y[-1] < _HIGHEST or any(apart(y, other) < _SAME for other in folds):
                continue
            x = np.append(y[:-2], y[-1])
            along = np.append(np.linalg.svd(sheet.at(y)[1][:, :-2])[2][-1], 0.0)
            reach = 0.1 * _START, _HIGHEST
            line = Line(*both_ways(at.system, x, unit_tangent(x, along), *reach, _LONGEST, _ROOM)[:2])
            found.lines[level].append((frequency, line))
            folds += [_point(sheet.equations, frequency, x) for x in _folds(at, line)]
            folds.append(y)


def _ceiling(equations, frequency):
    """Force over the wanted one to which the slice at a frequency (Hz) is followed."""
    group = equations.parameters.nondimensional(equations.force)
    X = (frequency / equations.hertz) ** 2
    r, s, e = dynamic_stiffness(group.mu, group.zeta_s, group.zeta, group.Omega0, X)
    if group.gamma == 0 or r >= -math.sqrt(3) * s:
        return _CEILING
    upper = 4 / 3 * e / X**2 * fold_levels(r, s)[1]
    return _CEILING * max(1.0, min(math.sqrt(upper / group.gamma), _HIGHEST / _CEILING))
