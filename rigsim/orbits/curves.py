"""One curve of periodic orbits over a band: traced both ways from an orbit, its folds located, its ends told."""

from typing import NamedTuple

import numpy as np

from ..results import Status
from .branches import OrbitBranch
from .continuation import (
    CLOSED,
    FULL,
    HIGH,
    LOW,
    MIRROR,
    STUCK,
    advance,
    both_ways,
    breaking_signs,
    distance,
    locate_fold,
    place_on,
    sizes,
    trace,
    unit_tangent,
)
from .harmonic_balance import residual
from .sheet import branching, leaving

_LONGEST = 0.06  # relative length of a step
_ROOM = 20_000  # orbits a curve may have
_SAME = 1e-6  # relative distance below which two orbits are one
_FOLD = 1e-4  # the same for two folds, which are known to the square root of that only
_ASIDE = (3e-3, 3e-4, 3e-5, 3e-6)  # relative lengths by which a curve that is known by its fold begins beside it
# The first that an end has.
_STATUS = {
    frozenset({CLOSED}): Status.CLOSED,
    frozenset({STUCK, FULL}): Status.STOPPED,
    frozenset({MIRROR}): Status.BRANCHES_OFF,
    frozenset({LOW, HIGH}): Status.LEAVES_THE_BAND,
}


class Curve(NamedTuple):
    """Orbits (k, n) along a curve, unit tangents, why it ends at its two ends, and indices of its folds."""

    points: np.ndarray
    tangents: np.ndarray
    ends: tuple
    folds: tuple

    @property
    def closed(self):
        """Whether it closes on itself."""
        return CLOSED in self.ends


def corrected(equations, x):
    """The orbit nearest to x, at a fold, too, and the curve's unit tangent there; None if there is none near."""
    along = np.linalg.svd(residual(equations.system, x)[1])[2][-1]
    sign, _, found, tangent = advance(*equations.system, x, unit_tangent(x, along), 0.0)
    return (found, unit_tangent(found, tangent)) if sign != 0 and distance(found, x) < 0.3 else None


def curve_through(equations, x, tangent, low, high):
    """The whole `Curve` through the orbit x from ``low`` to ``high`` (Hz)."""
    edges = low / equations.hertz, high / equations.hertz
    points, tangents, ends = both_ways(equations.system, x, tangent, *edges, _LONGEST, _ROOM)
    if CLOSED not in ends:
        keep = np.append(True, [distance(a, b) > 1e-12 for a, b in zip(points, points[1:], strict=False)])
        points, tangents = points[keep], tangents[keep]
        if points[0, -1] > points[-1, -1]:
            points, tangents, ends = points[::-1].copy(), -tangents[::-1], ends[::-1]
    return _with_folds(equations, points, tangents, ends)


def _with_folds(equations, points, tangents, ends):
    """The curve with an orbit put in at every fold; one that is not located counts as the nearer of its neighbours."""
    turning = np.flatnonzero(tangents[:-1, -1] * tangents[1:, -1] < 0)
    extra, extra_tangents = [], []
    for i in turning:
        length = float(np.sum(tangents[i] * (points[i + 1] - points[i]) / sizes(points[i]) ** 2))
        good, point, tangent = locate_fold(*equations.system, points[i], tangents[i], length)
        if not good:
            point, tangent = min(
                (abs(t[-1]), j, p, t)
                for j, (p, t) in enumerate(zip(points[i : i + 2], tangents[i : i + 2], strict=True))
            )[2:]
        extra.append(point)
        extra_tangents.append(unit_tangent(point, tangent))
    if extra:
        points = np.insert(points, turning + 1, extra, axis=0)
        tangents = np.insert(tangents, turning + 1, extra_tangents, axis=0)
    return Curve(points, tangents, ends, tuple((turning + 1 + np.arange(turning.size)).tolist()))


def add_curve(equations, curves, x, low, high):
    """Add the curve through the orbit near x, unless it, or an image of it, lies on one of the curves."""
    found = corrected(equations, x)
    if found and low < found[0][-1] * equations.hertz < high and not _known(equations, curves, found[0]):
        curves.append(curve_through(equations, *found, low, high))


def _known(equations, curves, x):
    images = equations.images(x)
    return any(place_on(*equations.system, *curve[:2], image) >= 0 for curve in curves for image in images)


def add_curve_at_fold(equations, curves, x, low, high):
    """Add the curve that turns back at the orbit x, unless one of the curves, or an image, is known to do so there.

    A fold of a known curve that lay unseen between two of its orbits, beside another one, becomes an orbit of it.
    """
    found = corrected(equations, x)
    if not found or not low < x[-1] * equations.hertz < high:
        return
    for image in equations.images(found[0]):
        for number, curve in enumerate(curves):
            if any(distance(curve.points[i], image) < _FOLD for i in curve.folds):
                return
            i = place_on(*equations.system, *curve[:2], image)
            if i >= 0:
                along = corrected(equations, image)[1]
                along *= np.sign(along @ (curve.points[i + 1] - curve.points[i]))
                points, tangents = (np.insert(a, i + 1, b, axis=0) for a, b in zip(curve, (image, along), strict=False))
                turns = [*(j for j in curve.folds if j <= i), i + 1, *(j + 1 for j in curve.folds if j > i)]
                curves[number] = Curve(points, tangents, curve.ends, tuple(turns))
                return
    for step in _ASIDE:
        sign, _, beside, tangent = advance(*equations.system, *found, step)
        if sign != 0 and distance(beside, x) < 2 * step and low < beside[-1] * equations.hertz < high:
            curves.append(curve_through(equations, beside, unit_tangent(beside, tangent), low, high))
            return


def branching_curves(base, equations, curves, low, high):
    """Curves that leave ``curves`` of ``base``, from symmetric orbits to others, or from those to twice the period."""
    parity = 0 if equations.period == base.period else 1
    places = []
    for points, _, _, _ in curves:
        signs = breaking_signs(*equations.system, equations.widened(base, points), parity)
        for i in np.flatnonzero(signs[:-1] * signs[1:] < 0):
            place = branching(base, equations, points[i], points[i + 1], signs[i], parity)
            places.append(equations.widened(base, place))
    edges = low / equations.hertz, high / equations.hertz
    return [
        _with_folds(equations, points, tangents, (MIRROR, code))
        for points, tangents, code in leaving(equations, places, parity, edges, _LONGEST, _ROOM)
    ]


def branch_of(equations, parameters, law, curve, joins=(), remark=""):
    """The `OrbitBranch` of a curve."""
    frequency, shaker, mass, relative = equations.lines(curve.points)
    status = next(status for codes, status in _STATUS.items() if codes & {*curve.ends})
    message = str(status)
    if status is not Status.CLOSED:
        message = f"{_end(curve.ends[0], frequency[0])}, {_end(curve.ends[1], frequency[-1])}"
    force = equations.force * float(equations.numbers[4])
    lines = frequency, shaker, mass, relative
    return OrbitBranch(
        parameters, force, law, *lines, equations.period, curve.folds, status, message + remark, tuple(joins)
    )


def _end(code, frequency):
    return {
        LOW: f"reaches {frequency:g} Hz",
        HIGH: f"reaches {frequency:g} Hz",
        STUCK: f"stopped at {frequency:.6f} Hz, where Newton's method did not converge at the shortest step",
        MIRROR: f"branches off at {frequency:.6f} Hz",
        FULL: f"stopped at {frequency:.6f} Hz, after {_ROOM} orbits",
    }[code]


def joined(equations, curves, low, high):
    """For each curve, those it joins outside the band, and a remark on how far that was looked into."""
    joins, remarks = [set() for _ in curves], ["" for _ in curves]
    for code, edge, limit in ((LOW, low, 0.5 * low), (HIGH, high, 2 * high)):
        ends = [(i, end) for i, curve in enumerate(curves) for end in (0, 1) if curve.ends[end] == code]
        if len(ends) < 2:
            continue
        within = sorted((edge / equations.hertz, limit / equations.hertz))
        for i, end in ends:
            points, tangents, _, _ = curves[i]
            x, tangent = (points[0], -tangents[0]) if end == 0 else (points[-1], tangents[-1])
            outside, _, why = trace(*equations.system, x, tangent, *within, _LONGEST, _ROOM, -1)
            back = [
                j
                for j, other in ends
                if (j, other) != (i, end) and distance(outside[-1], curves[j].points[-other]) < _SAME
            ]
            joins[i].update(back)
            if not back and why not in (LOW, HIGH):
                where = outside[-1, -1] * equations.hertz
                remarks[i] += f"; beyond {edge:g} Hz followed only to {_end(why, where)}"
    return [tuple(sorted(join)) for join in joins], remarks
