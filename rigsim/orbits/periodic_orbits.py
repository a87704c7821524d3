"""Periodic orbits of Eqs. (3a, b) with any number of harmonics: every piece of the response, untold.

Algorithm:

1. seed: every solution of the single-term equation (5a), at frequencies across the band, at its ends, and inside
   every interval with three solutions (so inside every detached curve), is corrected to a converged orbit, by way of
   fewer harmonics if need be;
2. compare: a seed that lies on a curve already traced is dropped;
3. trace: arc-length continuation both ways to the ends of the band, or until the curve closes;
4. fold: every turning point is located and becomes an orbit of the curve;
5. branch off: where orbits can lose their symmetry, the curve of asymmetric ones (even lines and a mean) is traced
   until it meets the symmetric curve again; its mirror image, half a period later, is not repeated. Where these can
   double their period, the curves of twice the period are traced likewise, if asked for;
6. join: where several curves end at one end of the band, they are followed beyond it to twice its upper frequency
   or half its lower one, to learn which of them are one curve.
"""

from dataclasses import replace

import numpy as np

from .. import checks
from ..campaign.progress import reporting
from ..parameters import law_of, oscillator_of
from ..results import Status
from ..theory.amplitude import frequency_response
from ..theory.detached import folds
from .branches import OrbitBranch, PeriodicOrbits
from .continuation import (
    CLOSED,
    FULL,
    HIGH,
    LOW,
    MIRROR,
    STUCK,
    advance,
    breaking_direction,
    breaking_sign,
    correct_at,
    distance,
    lies_on,
    locate_fold,
    trace,
    unit_tangent,
)
from .harmonic_balance import balance, residual
from .sheet import passages, slices

_SEEDS = 24
_SHARES = (0.03, 0.2, 0.5, 0.8, 0.97)  # of an interval with three solutions
_LONGEST = 0.06  # relative length of a step
_ROOM = 20_000  # orbits a curve may have
_SAME = 1e-6  # relative distance below which two orbits are one


_ROUNDING = 1e-8  # even lines below this share of an orbit's largest are none
_OFF = 0.03  # relative length of the first step off a symmetric curve
# The first that an end has.
_STATUS = {
    frozenset({CLOSED}): Status.CLOSED,
    frozenset({STUCK, FULL}): Status.STOPPED,
    frozenset({MIRROR}): Status.BRANCHES_OFF,
    frozenset({LOW, HIGH}): Status.LEAVES_THE_BAND,
}


def periodic_orbits(
    parameters, force, band=(5, 80), harmonics=9, law=None, *, period=1, search="complete", progress=False
):
    """Every curve of periodic orbits over a band of frequencies, by harmonic balance and continuation.

    Parameters
    ----------
    parameters : RigParameters or OscillatorParameters
    force : float
        Force amplitude F (N, above zero).
    band : (float, float)
        Forcing frequencies (Hz).
    harmonics : int
        Multiples of the forcing frequency kept besides the mean, odd and even; 1 is single-term theory (and a mean).
    law : {"exact", "cubic"}, optional
        Eq. (1) or Eq. (2); by default what the parameters carry, see `rigsim.parameters.law_of`.
    period : {1, 2}
        1: every curve above; 2: the curves of twice the period that branch off them inside the band. Subharmonic
        motions that are connected to none of these need a first orbit, see `continue_orbit`.
    search : {"complete", "seeds"}
        "seeds": curves that pass a solution of single-term theory, or branch off such a curve inside the band.
        "complete": also every other that is connected with rest over frequency and force together; see
        `rigsim.orbits.sheet` for what that covers.
    progress : bool or callable
        See `rigsim.campaign.progress.reporting`; counts seeds.

    Returns
    -------
    PeriodicOrbits

    Raises
    ------
    ValueError
        If an input is not allowed, the exact law is asked of a set without wires, or the shaker is undamped.
    """
    checks.one_of("period", period, (1, 2))
    checks.one_of("search", search, ("complete", "seeds"))
    law = law_of(parameters, law)
    equations = balance(parameters, force, harmonics, law, symmetric=True)
    low, high = _checked_band(band)
    # Seeds that do not lead to an orbit at once are led there by way of fewer harmonics.
    fewer = [balance(parameters, force, h, law, symmetric=True) for h in range(1, equations.harmonics, 2)]
    curves, lost = [], []
    seeds = _seeds(parameters, force, low, high)
    with reporting(progress, len(seeds), "periodic orbits") as report:
        for number, (frequency, relative) in enumerate(seeds):
            good, x, tangent = _seed_orbit(equations, fewer, frequency, [0, relative])
            if not good:
                lost.append((frequency, relative))
            elif not any(lies_on(*equations.system, *curve[:2], x) for curve in curves):
                curves.append(_curve(equations, x, tangent, low, high))
            report(number + 1)
    every_line = balance(parameters, force, harmonics, law)
    cuts = slices(equations, every_line, low, high) if search == "complete" else []
    for x in passages(equations, cuts, "symmetric"):
        _add_curve(equations, curves, x, low, high)
    if not curves:
        raise RuntimeError(f"no single-term solution from {low:g} to {high:g} Hz led to a converged orbit")
    bent = _branching_curves(equations, every_line, curves, low, high)
    for x in passages(every_line, cuts, "asymmetric"):
        _add_curve(every_line, bent, x, low, high)
    groups = [(equations, curves), (every_line, bent)]
    if period == 2:
        doubled = balance(parameters, force, harmonics, law, period)
        groups, lost = [(doubled, _branching_curves(every_line, doubled, bent, low, high))], []
    branches = []
    for system, members in groups:
        joins, remarks = _joins(system, members, low, high)
        first = len(branches)
        for curve, join, remark in zip(members, joins, remarks, strict=True):
            branch = _branch(system, parameters, law, *curve)
            joined = tuple(first + i for i in join)
            branches.append(replace(branch, joins=joined, message=branch.message + remark))
    for frequency, relative in lost:
        gaps = [np.hypot(b.frequency / frequency - 1, abs(b.relative[:, 1] / relative - 1)).min() for b in branches]
        near = int(np.argmin(gaps))
        remark = (
            f"; no orbit was found from the single-term solution {abs(relative):.4g} m at {frequency:.6g} Hz nearby"
        )
        branches[near] = replace(branches[near], message=branches[near].message + remark)
    return PeriodicOrbits(tuple(branches), parameters, equations.force, law, (low, high), harmonics)


def continue_orbit(parameters, force, frequency, relative, band=(5, 80), harmonics=9, law=None, *, period=1):
    """The curve of periodic orbits through one that is roughly known, such as a subharmonic motion.

    Parameters
    ----------
    parameters : RigParameters or OscillatorParameters
    force : float
        Force amplitude F (N, above zero).
    frequency : float
        Forcing frequency of the known orbit (Hz), inside the band.
    relative : (k,) array_like of complex
        Its lines of z (m) at the multiples 0, 1, ... of frequency/period; missing ones are taken as zero.
    band : (float, float)
        Forcing frequencies (Hz).
    harmonics : int
        Multiples of the forcing frequency kept; so ``period`` times as many lines.
    law : {"exact", "cubic"}, optional
    period : {1, 2, 3}
        Period of the orbit, in forcing periods.

    Returns
    -------
    OrbitBranch

    Raises
    ------
    ValueError
        If an input is not allowed, or no orbit is found from the given lines.
    """
    law = law_of(parameters, law)
    equations = balance(parameters, force, harmonics, law, period)
    low, high = _checked_band(band)
    frequency = checks.real("frequency", frequency, "Hz", low=low, high=high)
    relative = np.atleast_1d(np.asarray(relative, dtype=complex))
    if relative.ndim != 1 or not np.isfinite(relative).all():
        raise ValueError(f"relative has shape {relative.shape}; expected one row of finite lines (m)")
    x = equations.unknowns(frequency, relative)
    good, steps, tangent = correct_at(*equations.system, x, x[-1], 60, 0.3)
    if not good:  # at a fold the frequency does not tell the orbit: corrected across the curve instead
        x = equations.unknowns(frequency, relative)
        along = np.linalg.svd(residual(equations.system, x)[1])[2][-1]
        good, _, x, tangent = advance(*equations.system, x, unit_tangent(x, along), 0.0)
    if not good:
        raise ValueError(
            f"relative at frequency = {frequency:g} Hz is not allowed; expected lines close enough to an orbit, "
            f"but Newton's method found none in {steps} steps"
        )
    lines = abs(equations.lines(x[None])[3][0])
    if period != 2 and lines[::2].max() < _ROUNDING * lines.max():
        symmetric = balance(parameters, force, harmonics, law, period, symmetric=True)
        mirrored = symmetric.unknowns(frequency, equations.lines(x[None])[3][0])
        again, _, tangent_there = correct_at(*symmetric.system, mirrored, mirrored[-1], 10, 0.3)
        if again:
            equations, x, tangent = symmetric, mirrored, tangent_there
    return _branch(equations, parameters, law, *_curve(equations, x, tangent, low, high))


def _checked_band(band):
    band = checks.array("band", band, "Hz", low=0.0, low_open=True)
    if band.size != 2 or not band[0] < band[1]:
        raise ValueError(f"band = {tuple(band.tolist())} Hz is not allowed; expected two frequencies, ascending")
    return float(band[0]), float(band[1])


def _seeds(parameters, force, low, high):
    """Single-term solutions (Hz, complex z in m): the ends of the band, detached curves, then a grid."""
    oscillator = oscillator_of(parameters)
    points = [fold.frequency for fold in folds(oscillator, force)]
    inside = []
    for left, right in zip(points[::2], points[1::2], strict=True):
        left, right = max(left, low), min(right, high)
        if left < right:
            inside += [left + share * (right - left) for share in _SHARES]
    frequency = np.array([low, high, *inside, *np.geomspace(low, high, _SEEDS)[1:-1]])
    response = frequency_response(oscillator, force, frequency)
    return [(f, z) for f, row in zip(frequency, response.relative, strict=True) for z in row if np.isfinite(z)]


def _seed_orbit(equations, fewer, frequency, lines):
    """(Whether it converged, orbit, tangent) from approximate lines of z (m) at Hz."""
    x = equations.unknowns(frequency, lines)
    good, _, tangent = correct_at(*equations.system, x, x[-1], 30, 0.3)
    if not good:
        for system in [*fewer, equations]:
            x = system.unknowns(frequency, lines)
            good, _, tangent = correct_at(*system.system, x, x[-1], 60, 0.1)
            if not good:
                break
            lines = system.lines(x[None])[3][0]
    return good, x, tangent


def _add_curve(equations, curves, x, low, high):
    """Add the curve through the orbit x, unless it, or its mirror image, lies on one of the curves."""
    images = [x] if equations.orders[0] else [x, equations.mirrored(x)]
    if not any(lies_on(*equations.system, *curve[:2], image) for curve in curves for image in images):
        good, _, tangent = correct_at(*equations.system, x, x[-1], 30, 0.3)
        if good:
            curves.append(_curve(equations, x, tangent, low, high))


def _curve(equations, x, tangent, low, high):
    """Orbits of the whole curve through x, their tangents, why it ends at its two ends, indices of its folds."""
    edges = low / equations.hertz, high / equations.hertz
    system = equations.system
    points, tangents, _, code = trace(*system, x, tangent, *edges, _LONGEST, _ROOM, -1)
    ends = code, code
    if code != CLOSED:
        back, back_tangents, _, other = trace(*system, x, -tangent, *edges, _LONGEST, _ROOM, -1)
        points = np.concatenate([back[:0:-1], points])
        tangents = np.concatenate([-back_tangents[:0:-1], tangents])
        ends = other, code
        keep = np.append(True, [distance(a, b) > 1e-12 for a, b in zip(points, points[1:], strict=False)])
        points, tangents = points[keep], tangents[keep]
    if code != CLOSED and points[0, -1] > points[-1, -1]:
        points, tangents, ends = points[::-1].copy(), -tangents[::-1], ends[::-1]
    points, tangents, turns = _with_folds(system, points, tangents)
    return points, tangents, ends, turns


def _with_folds(system, points, tangents):
    """The curve with an orbit put in at every fold; indices of those."""
    turning = np.flatnonzero(tangents[:-1, -1] * tangents[1:, -1] < 0)
    extra, extra_tangents = [], []
    for i in turning:
        sizes = np.append(np.full(points.shape[1] - 1, np.linalg.norm(points[i, :-1])), points[i, -1])
        length = float(np.sum(tangents[i] * (points[i + 1] - points[i]) / sizes**2))
        good, point, tangent = locate_fold(*system, points[i], tangents[i], length)
        if not good:  # never seen: both ends were corrected in planes next to these
            raise RuntimeError(f"the fold between Omega = {points[i, -1]} and {points[i + 1, -1]} was not located")
        extra.append(point)
        extra_tangents.append(unit_tangent(point, tangent))
    if not extra:
        return points, tangents, ()
    points = np.insert(points, turning + 1, extra, axis=0)
    tangents = np.insert(tangents, turning + 1, extra_tangents, axis=0)
    return points, tangents, tuple((turning + 1 + np.arange(turning.size)).tolist())


def _branch(equations, parameters, law, points, _, ends, turns):
    frequency, shaker, mass, relative = equations.lines(points)
    status = next(status for codes, status in _STATUS.items() if codes & {*ends})
    message = str(status)
    if status is not Status.CLOSED:
        message = f"{_end(ends[0], frequency[0])}, {_end(ends[1], frequency[-1])}"
    return OrbitBranch(
        parameters, equations.force, law, frequency, shaker, mass, relative, equations.period, turns, status, message
    )


def _end(code, frequency):
    return {
        LOW: f"reaches {frequency:g} Hz",
        HIGH: f"reaches {frequency:g} Hz",
        STUCK: f"stopped at {frequency:.6f} Hz, where Newton's method did not converge at the shortest step",
        MIRROR: f"branches off at {frequency:.6f} Hz",
        FULL: f"stopped at {frequency:.6f} Hz, after {_ROOM} orbits",
    }[code]


def _branching_curves(base, equations, curves, low, high):
    """Curves that branch off ``curves`` of ``base``, of the form of `_curve`, each from where it does so.

    From symmetric orbits to those with every line, or from those to orbits of twice the period.
    """
    places, parity = [], 0 if equations.period == base.period else 1
    for points, _, _, _ in curves:
        full = _with_every_line(base, equations, points)
        signs = np.array([breaking_sign(*equations.system, x, parity) for x in full])
        turns = np.flatnonzero(signs[:-1] * signs[1:] < 0)
        places += [_breaking_point(base, equations, points[i], points[i + 1], signs[i], parity) for i in turns]
    found, used = [], set()
    edges = low / equations.hertz, high / equations.hertz
    for number, place in enumerate(places):
        if number in used:
            continue
        direction = breaking_direction(*equations.system, place, parity)
        for step in (_OFF, 0.3 * _OFF, 0.1 * _OFF):
            sign, _, first, tangent = advance(*equations.system, place, direction, step)
            if sign != 0 and edges[0] < first[-1] < edges[1] and distance(first, place) < 3 * step:
                break
        else:
            continue  # they leave the band at once
        points, tangents, _, code = trace(*equations.system, first, tangent, *edges, _LONGEST, _ROOM, parity)
        points = np.concatenate([place[None], points])
        tangents = np.concatenate([unit_tangent(place, direction)[None], tangents])
        if code == MIRROR:
            last = min(range(len(places)), key=lambda i: distance(places[i], points[-1]))
            used.add(last)
            inwards = breaking_direction(*equations.system, places[last], parity)
            inwards *= np.sign(np.dot(inwards, points[-1] - points[-2]))
            points = np.concatenate([points, places[last][None]])
            tangents = np.concatenate([tangents, inwards[None]])
        points, tangents, turns = _with_folds(equations.system, points, tangents)
        found.append((points, tangents, (MIRROR, code), turns))
    return found


def _with_every_line(base, equations, points):
    frequency, _, _, relative = base.lines(points)
    lines = np.zeros((len(points), equations.harmonics + 1), dtype=complex)
    lines[:, :: equations.period // base.period] = relative
    return np.array([equations.unknowns(f, z) for f, z in zip(frequency, lines, strict=True)])


def _breaking_point(base, equations, start, end, sign, parity):
    """The orbit, with every line, between two of ``base`` at which the `breaking_sign` changes; by bisection."""
    length = distance(end, start)
    chord = (end - start) / length
    left, right = 0.0, length
    while right - left > 1e-12:
        middle = 0.5 * (left + right)
        _, _, x, _ = advance(*base.system, start, chord, middle)
        x = _with_every_line(base, equations, x[None])[0]
        if breaking_sign(*equations.system, x, parity) == sign:
            left = middle
        else:
            right = middle
    return x


def _joins(equations, curves, low, high):
    """For each curve, those it joins outside the band, and a remark on how far that was looked into."""
    joins, remarks = [set() for _ in curves], ["" for _ in curves]
    for code, edge, limit in ((LOW, low, 0.5 * low), (HIGH, high, 2 * high)):
        ends = [(i, end) for i, (_, _, codes, _) in enumerate(curves) for end in (0, 1) if codes[end] == code]
        if len(ends) < 2:
            continue
        within = sorted((edge / equations.hertz, limit / equations.hertz))
        for i, end in ends:
            points, tangents, _, _ = curves[i]
            x, tangent = (points[0], -tangents[0]) if end == 0 else (points[-1], tangents[-1])
            outside, _, _, why = trace(*equations.system, x, tangent, *within, _LONGEST, _ROOM, -1)
            back = [
                j for j, other in ends if (j, other) != (i, end) and distance(outside[-1], curves[j][0][-other]) < _SAME
            ]
            joins[i].update(back)
            if not back and why not in (LOW, HIGH):
                where = outside[-1, -1] * equations.hertz
                remarks[i] += f"; beyond {edge:g} Hz followed only to {_end(why, where)}"
    return [tuple(sorted(join)) for join in joins], remarks
