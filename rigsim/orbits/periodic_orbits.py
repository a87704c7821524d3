"""Periodic orbits of Eqs. (3a, b) with any number of harmonics: every piece of the response, untold.

Algorithm:

1. seed: every solution of the single-term equation (5a), at frequencies across the band, at its ends, and inside
   every interval with three solutions (so inside every detached curve), is corrected to a converged orbit, by way of
   fewer harmonics if need be; and every fold of the response that the loci of the response sheet pass at this force
   (`rigsim.orbits.sheet`), and every motion of its slices, is a seed as it stands;
2. compare: a seed that lies on a curve already traced is dropped;
3. trace: arc-length continuation both ways to the ends of the band, or until the curve closes;
4. fold: every turning point is located and becomes an orbit of the curve, and starts a fold locus if it lies on none,
   until every fold of a curve lies on a locus and every locus that passes the force is a fold of a curve;
5. branch off: where orbits can lose their symmetry, the curve of asymmetric ones (even lines and a mean) is traced
   until it meets the symmetric curve again; its mirror image, half a period later, is not repeated. Where these can
   double their period, the curves of twice the period are traced likewise, if asked for;
6. join: where several curves end at one end of the band, they are followed beyond it to twice its upper frequency
   or half its lower one, to learn which of them are one curve;
7. judge: lines that were neglected are fed through more harmonics, and if they matter the search begins anew with more
   (`rigsim.orbits.accuracy`).
"""

from dataclasses import replace

import numpy as np

from .. import checks
from ..blas import one_blas_thread
from ..campaign.progress import reporting
from ..parameters import law_of, oscillator_of
from ..theory.amplitude import frequency_response
from ..theory.detached import folds
from .accuracy import NOTICED, checked_harmonics, climbed, doubt, worst
from .branches import PeriodicOrbits
from .continuation import correct_at, place_on
from .curves import add_curve, add_curve_at_fold, branch_of, branching_curves, corrected, curve_through, joined
from .harmonic_balance import balance
from .loci import FOLD, resized
from .sheet import SLICES, explored, sheets_of

_SEEDS = 24
_SHARES = (0.03, 0.2, 0.5, 0.8, 0.97)  # of an interval with three solutions
_EXPLORED = 27  # harmonics with which the sheet is explored, at most; its curves may have more
_ROUNDING = 1e-8  # even lines below this share of an orbit's largest are none


@one_blas_thread
def periodic_orbits(
    parameters,
    force,
    band=(5, 80),
    harmonics="auto",
    law=None,
    *,
    period=1,
    search="complete",
    tolerance=1e-6,
    progress=False,
):
    """Every curve of periodic orbits over a band of frequencies, by harmonic balance and continuation.

    Parameters
    ----------
    parameters : RigParameters or OscillatorParameters
    force : float
        Force amplitude F (N, above zero).
    band : (float, float)
        Forcing frequencies (Hz).
    harmonics : int or "auto"
        Multiples of the forcing frequency kept besides the mean, odd and even; 1 is single-term theory (and a mean).
        "auto": as many as the ``tolerance`` needs, from 9 to 55.
    law : {"exact", "cubic"}, optional
        Eq. (1) or Eq. (2); by default what the parameters carry, see `rigsim.parameters.law_of`.
    period : {1, 2}
        1: every curve above; 2: the curves of twice the period. Subharmonic motions that are connected to none of these
        need a first orbit, see `continue_orbit`.
    search : {"complete", "seeds"}
        "seeds": curves that pass a solution of single-term theory, or branch off such a curve inside the band.
        "complete": also every other that is connected with rest over frequency and force together; see
        `rigsim.orbits.sheet` for what that covers.
    tolerance : float
        Relative error of an orbit, by `rigsim.orbits.accuracy`, that "auto" aims at. A branch says in its message
        where it is not met, with a given number of harmonics where the error is above 1e-3.
    progress : bool or callable
        See `rigsim.campaign.progress.reporting`; counts slices of the sheet.

    Returns
    -------
    PeriodicOrbits

    Raises
    ------
    ValueError
        If an input is not allowed, the exact law is asked of a set without wires, or the shaker is undamped.
    """
    law, band = law_of(parameters, law), checks.pair("band", band, "Hz")
    force, progress = checks.positive("force", force, "N"), checks.progress(progress)
    harmonics, period = checked_harmonics(harmonics), checks.one_of("period", period, (1, 2))
    search = checks.one_of("search", search, ("complete", "seeds"))
    tolerance = checks.real("tolerance", tolerance, low=1e-12, high=1e-2)
    with reporting(progress, SLICES, "periodic orbits") as report:
        sheets, exploration = explored_with(
            parameters, force, band, law, harmonics, tolerance, period + 1, search == "complete", report=report
        )
    branches, count = judged(parameters, force, band, law, sheets, exploration, harmonics, tolerance, period)
    return PeriodicOrbits(branches, parameters, sheets[0].equations.force, law, band, count)


def explored_with(
    parameters, force, band, law, harmonics, tolerance, levels, complete=True, branchings=False, report=None
):
    """The first ``levels`` `Sheet` with as many harmonics as ``harmonics`` says, and their `Exploration`, if wanted."""
    coarse = []  # the first that will do for the sheet's shape

    def attempt(count):
        sheets = sheets_of(parameters, force, count, law, levels)
        if not isinstance(harmonics, str):
            return sheets, 0.0
        error = _largest(_errors(sheets, force, curves_at(sheets, force, band)[0]))  # along what is quickly found
        if error <= NOTICED or count >= _EXPLORED:
            coarse.append(sheets)
        return sheets, error

    sheets, _ = climbed(attempt, harmonics, tolerance)
    return sheets, explored((coarse or [sheets])[0], band, branchings, report) if complete else None


def judged(parameters, force, band, law, sheets, exploration, harmonics, tolerance, period):
    """Tuple of `OrbitBranch` at a force (N), and their harmonics: those of the ``sheets``, if "auto" more as needed."""
    known = sheets[0].equations
    exploration = exploration and exploration.copied()  # whatever is added to it, it stays what it was

    def attempt(count):
        these = sheets
        if count != known.harmonics:
            these = sheets_of(parameters, known.force, count, law, len(sheets))
        found, lost = curves_at(these, force, band, exploration)
        errors = _errors(these, force, found)
        return (these, found, lost, errors), _largest(errors)

    (these, found, lost, errors), _ = climbed(attempt, harmonics, tolerance, known.harmonics)
    remarks = [[doubt(error, harmonics, tolerance) for error in some] for some in errors]
    branches = _branches(_systems(these, force), found, remarks, lost, parameters, law, band, period)
    return branches, these[0].equations.harmonics


def _errors(sheets, force, found):
    """The largest error by lines neglected of each curve, a list for each sheet."""
    pairs = zip(_systems(sheets, force), found, strict=True)
    return [[worst(system, curve.points) for curve in curves] for system, curves in pairs]


def _largest(errors):
    return max(error for some in errors for error in some)


def _systems(sheets, force):
    return [sheet.equations.at_force(force / sheet.equations.force) for sheet in sheets]


def curves_at(sheets, force, band, exploration=None):
    """Every `Curve` at a force (N) over a band (Hz): a list for each of the ``sheets``; and single-term seeds in vain.

    Without an `Exploration` those of single-term theory, and what branches off them.
    """
    first = sheets[0].equations
    share = force / first.force
    systems = _systems(sheets, force)
    # Seeds that do not lead to an orbit at once are led there by way of fewer harmonics.
    fewer = [systems[0].with_harmonics(h) for h in range(1, first.harmonics, 2)]
    found, lost = [[]], []
    for frequency, relative in _seeds(first.parameters, force, *band):
        good, x, tangent = _seed_orbit(systems[0], fewer, frequency, [0, relative])
        if not good:
            lost.append((frequency, relative))
        elif not any(place_on(*systems[0].system, *curve[:2], x) >= 0 for curve in found[0]):
            found[0].append(curve_through(systems[0], x, tangent, *band))
    for level, system in enumerate(systems):
        if level > 0:
            found.append(branching_curves(systems[level - 1], system, found[-1], *band))
        if exploration:
            _complete(sheets[level], system, level, found[level], share, band, exploration)
    if not found[0]:
        raise RuntimeError(f"no single-term solution from {band[0]:g} to {band[1]:g} Hz led to a converged orbit")
    return found, lost


def _complete(sheet, system, level, curves, share, band, exploration):
    """Add the curves of a level that the sheet knows, and loci to the sheet that only the curves know."""
    for x in exploration.passages(level, share):
        add_curve(system, curves, resized(x, system.size + 1, 1), *band)
    checked, count = 0, -1
    while count != len(exploration.loci[level]):
        count = len(exploration.loci[level])
        for y in exploration.folds(level, share):
            y = sheet.fitted(FOLD, y)
            if y is not None:
                add_curve_at_fold(system, curves, y[:-1], *band)
        for curve in curves[checked:]:
            for i in curve.folds:
                y = exploration.sheets[level].fitted(FOLD, np.append(curve.points[i], share))
                if y is not None:
                    exploration.add_locus(level, FOLD, y)
        checked = len(curves)


def _branches(systems, found, doubts, lost, parameters, law, band, period):
    """Tuple of `OrbitBranch` of what `curves_at` found, of one period, with what they leave open in their messages."""
    branches = []
    for system, curves, told in zip(systems, found, doubts, strict=True):
        if system.period != period:
            continue
        joins, remarks = joined(system, curves, *band)
        first = len(branches)
        for curve, join, *more in zip(curves, joins, remarks, told, strict=True):
            branches.append(branch_of(system, parameters, law, curve, [first + i for i in join], "".join(more)))
    for frequency, relative in lost if period == 1 else ():
        gaps = [np.hypot(b.frequency / frequency - 1, abs(b.relative[:, 1] / relative - 1)).min() for b in branches]
        near = int(np.argmin(gaps))
        remark = (
            f"; no orbit was found from the single-term solution {abs(relative):.4g} m at {frequency:.6g} Hz nearby"
        )
        branches[near] = replace(branches[near], message=branches[near].message + remark)
    return tuple(branches)


@one_blas_thread
def continue_orbit(
    parameters, force, frequency, relative, band=(5, 80), harmonics="auto", law=None, *, period=1, tolerance=1e-6
):
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
    harmonics : int or "auto"
        Multiples of the forcing frequency kept; so ``period`` times as many lines.
    law : {"exact", "cubic"}, optional
    tolerance : float
        Relative error that "auto" aims at; see `periodic_orbits`.
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
    law, (low, high) = law_of(parameters, law), checks.pair("band", band, "Hz")
    force, harmonics = checks.positive("force", force, "N"), checked_harmonics(harmonics)
    frequency = checks.real("frequency", frequency, "Hz", low=low, high=high)
    tolerance = checks.real("tolerance", tolerance, low=1e-12, high=1e-2)
    period = checks.one_of("period", period, (1, 2, 3))
    relative = checks.lines("relative", relative, "m")
    if not relative.any():
        raise ValueError(f"relative has shape {relative.shape}; expected one row of finite lines (m), not all zero")

    def attempt(count):
        nonlocal frequency, relative  # with more harmonics it begins from what was found with fewer
        equations, x, tangent = _known_orbit(balance(parameters, force, count, law, period), frequency, relative)
        curve = curve_through(equations, x, tangent, low, high)
        (frequency,), (relative,) = equations.lines(x[None])[::3]
        return (equations, curve), worst(equations, curve.points)

    (equations, curve), error = climbed(attempt, harmonics, tolerance)
    return branch_of(equations, parameters, law, curve, remark=doubt(error, harmonics, tolerance))


def _known_orbit(equations, frequency, relative):
    """Equations, with odd lines only if the orbit has no others, the orbit near given lines (m), and its tangent."""
    x = equations.unknowns(frequency, relative)
    good, steps, tangent = correct_at(*equations.system, x, x[-1], 60, 0.3)
    if not good:  # at a fold the frequency does not tell the orbit: corrected across the curve instead
        found = corrected(equations, equations.unknowns(frequency, relative))
        if not found:
            raise ValueError(
                f"relative at frequency = {frequency:g} Hz is not allowed; expected lines close enough to an orbit, "
                f"but Newton's method found none in {steps} steps"
            )
        x, tangent = found
    lines = equations.lines(x[None])[3][0]
    if equations.period != 2 and abs(lines[::2]).max() < _ROUNDING * abs(lines).max():
        symmetric = equations.symmetric()
        mirrored = symmetric.unknowns(frequency, lines)
        again, _, tangent_there = correct_at(*symmetric.system, mirrored, mirrored[-1], 10, 0.3)
        if again:
            return symmetric, mirrored, tangent_there
    return equations, x, tangent


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
