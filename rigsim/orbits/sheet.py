"""The response sheet at single frequencies: what a rig does there at every force, found from rest and untold.

With the force left unknown, the balance equations at one frequency hold along lines in (coefficients, F): a *slice*
through the surface of all motions, of which the response at one force is a contour line. The line that begins at rest
is followed by arc length through every fold, to a ceiling well above the force wanted; wherever the determinant over
the even lines changes its sign along it, a line of asymmetric motions branches off, and is followed likewise. Each
passage of the wanted force is an orbit of a curve over frequency, also of one that single-term theory does not know.

A closed curve that lies between two slices surrounds a place where F is stationary on the surface, so an extremum
over frequency of F along a fold line. At a fold the slope dF/dOmega follows from the left null vector of the Jacobian;
two neighbouring slices are halved as long as the tangents to a fold line between them leave room for the wanted force,
or as long as the slices differ in how many folds they have.

What this covers: all that is connected with rest, at the frequencies of the slices, below the ceiling. Motions that
hang on nothing, as those of period three do, are not among them.
"""

import math
from dataclasses import dataclass

import numpy as np

from ..theory.cubic import dynamic_stiffness, fold_levels
from .continuation import (
    MIRROR,
    advance,
    breaking_direction,
    breaking_signs,
    correct_at,
    distance,
    locate_fold,
    trace,
    unit_tangent,
)
from .harmonic_balance import residual

_SLICES = 24  # over a band, to begin with
_HALVINGS = 6  # of an interval between two of them
_START = 1e-3  # of the wanted force, where a slice begins as the linear response
_CEILING = 3.0  # times the wanted force, and at least as often the upper fold level of single-term theory
_LONGEST = 0.1  # relative length of a step
_NEAR = 0.3  # of ln F: how near to the wanted force a fold must be to make slices that differ worth halving
_HIGHEST = 30.0  # times the wanted force, beyond which upper fold levels are not followed
_ROOM = 5_000  # orbits a line may have
_OFF = 0.03  # relative length of the first step off a symmetric line


@dataclass(frozen=True, eq=False)
class Line:
    """A line of motions at one frequency.

    Attributes
    ----------
    points, tangents : (k, n) array
        Unknowns of the `Balance` at the frequency, the last one F over the wanted force; and the unit tangents.
    folds : tuple of (float, float)
        F over the wanted force at each fold in the order of the line, and its slope over frequency (1/Hz) along the
        fold line.
    """

    points: np.ndarray
    tangents: np.ndarray
    folds: tuple


@dataclass(frozen=True, eq=False)
class Slice:
    """Every motion found at one frequency (Hz): the line from rest, and the asymmetric ones that branch off it."""

    frequency: float
    symmetric: Line
    asymmetric: tuple

    @property
    def lines(self):
        """All lines, that from rest first."""
        return (self.symmetric, *self.asymmetric)


def slice_at(symmetric, full, frequency, ceiling):
    """The `Slice` at a frequency (Hz), up to ``ceiling`` times the wanted force.

    Parameters
    ----------
    symmetric, full : Balance
        At the wanted force, with odd lines only and with every line.
    """
    odd, every = symmetric.at(frequency), full.at(frequency)
    x = np.full(odd.size + 1, 1e-3 * _START)  # not zero, since lengths are relative
    good, _, tangent = correct_at(*odd.system, x, _START, 60, np.inf)
    if not good:
        return Slice(frequency, Line(x[None], x[None], ()), ())
    tangent *= math.copysign(1.0, tangent[-1])
    points, tangents, _, _ = trace(*odd.system, x, tangent, 0.1 * _START, ceiling, _LONGEST, _ROOM, -1)
    rest = _line(odd, points, tangents)
    return Slice(frequency, rest, tuple(_branching_lines(odd, every, points, ceiling)))


def _line(equations, points, tangents):
    turning = np.flatnonzero(tangents[:-1, -1] * tangents[1:, -1] < 0)
    found = []
    for i in turning:
        good, x, _ = locate_fold(*equations.system, points[i], tangents[i], distance(points[i + 1], points[i]))
        found.append((float(x[-1]), _slope(equations, x)) if good else (float(points[i, -1]), math.nan))
    return Line(points, tangents, tuple(found))


def _slope(equations, x):
    """dF/df (1/Hz) along the fold line through the fold x, F over the wanted force."""
    _, jacobian = residual(equations.system, x)
    null = np.linalg.svd(jacobian[:, :-1])[0][:, -1]
    Omega, step = equations.numbers[3], 1e-6
    ahead, behind = (
        residual(equations.at(f * equations.hertz).system, x)[0] for f in (Omega * (1 + step), Omega * (1 - step))
    )
    return float(-null @ (ahead - behind) / (2 * step * Omega) / (null @ jacobian[:, -1])) / equations.hertz


def _branching_lines(odd, every, points, ceiling):
    """Lines of asymmetric motions that leave the symmetric one below the ceiling; of a pair of mirror images one."""
    whole = np.array([every.widened(odd, x) for x in points])
    signs = breaking_signs(*every.system, whole, 0)
    places = [_breaking_point(odd, every, points[i], points[i + 1], signs[i]) for i in np.flatnonzero(np.diff(signs))]
    used = set()
    for number, place in enumerate(places):
        if number in used:
            continue
        direction = breaking_direction(*every.system, place, 0)
        for step in (_OFF, 0.3 * _OFF, 0.1 * _OFF):
            sign, _, first, tangent = advance(*every.system, place, direction, step)
            if sign != 0 and first[-1] < ceiling and distance(first, place) < 3 * step:
                break
        else:
            continue
        line, tangents, _, code = trace(*every.system, first, tangent, 0.1 * _START, ceiling, _LONGEST, _ROOM, 0)
        if code == MIRROR:
            used.add(min(range(len(places)), key=lambda i, end=line[-1]: distance(places[i], end)))
        yield _line(
            every,
            np.concatenate([place[None], line]),
            np.concatenate([unit_tangent(place, direction)[None], tangents]),
        )


def _breaking_point(odd, every, start, end, sign):
    length = distance(end, start)
    chord = (end - start) / length
    left, right = 0.0, length
    while right - left > 1e-9:
        middle = 0.5 * (left + right)
        _, _, x, _ = advance(*odd.system, start, chord, middle)
        x = every.widened(odd, x)
        left, right = (middle, right) if breaking_signs(*every.system, x[None], 0)[0] == sign else (left, middle)
    return x


def slices(symmetric, full, low, high):
    """Slices from ``low`` to ``high`` (Hz), so close that every curve at the wanted force passes one.

    Returns
    -------
    list of Slice
        Ascending in frequency.
    """
    cut = lambda f: slice_at(symmetric, full, f, _ceiling(symmetric, f))  # noqa: E731
    first = [cut(float(f)) for f in np.geomspace(low, high, _SLICES)]
    result = first[:1]
    for right in first[1:]:
        result += _halved(cut, result[-1], right, _HALVINGS)
    return result


def _halved(cut, left, right, halvings):
    """Slices between two neighbours (without the left one), halved where something may hide between them."""
    if halvings == 0 or not _may_hide(left, right):
        return [right]
    middle = cut(math.sqrt(left.frequency * right.frequency))
    return _halved(cut, left, middle, halvings - 1) + _halved(cut, middle, right, halvings - 1)


def _may_hide(left, right):
    """Whether a closed curve at the wanted force, F = 1, may lie between two slices and pass neither."""
    alike = len(left.lines) == len(right.lines)
    width = right.frequency - left.frequency
    for one, other in zip(left.lines, right.lines, strict=False):
        if len(one.folds) != len(other.folds):
            alike = False
            continue
        for (F, slope), (G, rise) in zip(one.folds, other.folds, strict=True):
            if (F - 1) * (G - 1) <= 0 or not slope * rise < 0:
                continue
            # The tangents at both ends meet where an extremum between them cannot lie beyond.
            meet = (G - F - rise * width) / (slope - rise)
            if 0 < meet < width and (F + slope * meet - 1) * (F - 1) <= 0:
                return True
    return not alike and any(
        abs(math.log(F)) < _NEAR for at in (left, right) for line in at.lines for F, _ in line.folds
    )


def _ceiling(symmetric, frequency):
    """Force over the wanted one to which the slice at a frequency (Hz) is followed."""
    group = symmetric.parameters.nondimensional(symmetric.force)
    r, s, e = dynamic_stiffness(group.mu, group.zeta_s, group.zeta, group.Omega0, (frequency / symmetric.hertz) ** 2)
    if group.gamma == 0 or r >= -math.sqrt(3) * s:
        return _CEILING
    upper = 4 / 3 * e / (frequency / symmetric.hertz) ** 4 * fold_levels(r, s)[1]
    return _CEILING * max(1.0, min(math.sqrt(upper / group.gamma), _HIGHEST))


def passages(equations, slices, kind):
    """Orbits (k, n) of ``equations`` where lines of a ``kind``, "symmetric" or "asymmetric", pass the wanted force."""
    found = []
    for cut in slices:
        at = equations.at(cut.frequency)
        for line in [cut.symmetric] if kind == "symmetric" else cut.asymmetric:
            F = line.points[:, -1] - 1
            for i in np.flatnonzero(F[:-1] * F[1:] <= 0):
                share = F[i] / (F[i] - F[i + 1])
                x = line.points[i] + share * (line.points[i + 1] - line.points[i])
                good, _, _ = correct_at(*at.system, x, 1.0, 20, 0.3)
                if good:
                    found.append(np.append(x[:-1], cut.frequency / equations.hertz))
    return found
