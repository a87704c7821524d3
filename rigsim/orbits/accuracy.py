"""How good a converged orbit is: the lines it neglects, fed through the equations of many more harmonics.

An orbit of h harmonics solves its own equations to rounding, so its error does not show there. Padded to `_WIDER` times
as many lines it leaves a residual, the lines of the wires' force beyond h, and one Newton step of the wider equations,
the shortest one, says how far the orbit is from theirs. That is an estimate, good where it is small; no bound.
"""

import numpy as np

from .harmonic_balance import residual

LADDER = (9, 13, 19, 27, 39, 55)  # numbers of harmonics that are tried in turn
_WIDER = 3
_THINNED = 16  # orbits of a curve, evenly along it, that tell its error


def neglected(equations, points):
    """Relative error (k,) of orbits, points (k, n) of a `Balance`, by the lines it neglects."""
    wider = equations.with_harmonics(_WIDER * equations.harmonics // equations.period)
    padded = np.zeros((len(points), wider.size + 1))
    padded[:, : equations.size], padded[:, -1] = points[:, :-1], points[:, -1]
    result = np.empty(len(points))
    for i, x in enumerate(padded):
        size = np.append(np.full(x.size - 1, np.linalg.norm(x[:-1])), x[-1])
        values, jacobian = residual(wider.system, x)
        jacobian = jacobian * size
        result[i] = np.linalg.norm(jacobian.T @ np.linalg.solve(jacobian @ jacobian.T, values))
    return result


def worst(equations, points):
    """Largest error along a curve, from some of its orbits and their largest ones."""
    some = {*range(0, len(points), max(1, len(points) // _THINNED)), *np.abs(points[:, :-1]).argmax(axis=0).tolist()}
    return float(neglected(equations, points[sorted(some)]).max())


def next_rung(harmonics, error, tolerance):
    """The rung of the `LADDER` that should meet the tolerance, as errors fall geometrically; two up at most."""
    wanted = harmonics * np.log(tolerance) / np.log(min(error, 0.5))
    above = [rung for rung in LADDER if rung > harmonics][:2]
    return next((rung for rung in above if rung >= wanted), above[-1])
