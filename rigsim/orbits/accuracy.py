"""How good a converged orbit is: the lines it neglects, fed through the equations of many more harmonics.

An orbit of h harmonics solves its own equations to rounding, so its error does not show there. Padded to `_WIDER` times
as many lines it leaves a residual, the lines of the wires' force beyond h, and one Newton step of the wider equations,
the shortest one, says how far the orbit is from theirs. That is an estimate, good where it is small; no bound.
"""

import numpy as np

from .. import checks
from .continuation import sizes
from .harmonic_balance import residual

LADDER = (9, 13, 19, 27, 39, 55)  # numbers of harmonics that are tried in turn
NOTICED = 1e-3  # error of a given number of harmonics that is always told
_WIDER = 3
_THINNED = 16  # orbits of a curve, evenly along it, that tell its error


def neglected(equations, points):
    """Relative error (k,) of orbits, points (k, n) of a `Balance`, by the lines it neglects."""
    wider = equations.with_harmonics(_WIDER * equations.harmonics // equations.period)
    padded = np.zeros((len(points), wider.size + 1))
    padded[:, : equations.size], padded[:, -1] = points[:, :-1], points[:, -1]
    result = np.empty(len(points))
    for i, x in enumerate(padded):
        values, jacobian = residual(wider.system, x)
        jacobian = jacobian * sizes(x)
        result[i] = np.linalg.norm(jacobian.T @ np.linalg.solve(jacobian @ jacobian.T, values))
    return result


def worst(equations, points):
    """Largest error along a curve, from some of its orbits and their largest ones."""
    some = {*range(0, len(points), max(1, len(points) // _THINNED)), *np.abs(points[:, :-1]).argmax(axis=0).tolist()}
    return float(neglected(equations, points[sorted(some)]).max())


def climbed(attempt, harmonics, tolerance, first=LADDER[0]):
    """What ``attempt(count)`` gives, a result and its error, with a given number of harmonics, or with enough: "auto".

    Then the `LADDER` is climbed from ``first`` until the error meets the tolerance, at most two rungs at once: errors
    fall geometrically.
    """
    if not isinstance(harmonics, str):
        return attempt(harmonics)
    count = first
    while True:
        result, error = attempt(count)
        above = [rung for rung in LADDER if rung > count][:2]
        if error <= tolerance or not above:
            return result, error
        wanted = count * np.log(tolerance) / np.log(min(error, 0.5))
        count = next((rung for rung in above if rung >= wanted), above[-1])


def checked_harmonics(harmonics, high=200):
    """A number of harmonics, from 1 to ``high``, or "auto"; `ValueError` if it is neither."""
    if isinstance(harmonics, str):
        return checks.one_of("harmonics", harmonics, ("auto",))
    return checks.integer("harmonics", harmonics, low=1, high=high)


def doubt(error, harmonics, tolerance):
    """The remark, to a power of ten, that an error deserves: above the tolerance of "auto", else above `NOTICED`."""
    if error <= (tolerance if isinstance(harmonics, str) else max(tolerance, NOTICED)):
        return ""
    told = 10.0 ** np.floor(np.log10(min(error, 0.1)))  # above that the estimate is none
    return f"; some orbits are in error by more than {told:.0e}: more harmonics are needed"
