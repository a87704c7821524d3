"""Which detached curves exist, for many parameter sets at once, and how far the force is from the edge.

The argument and the steps are those of `rigsim.theory.levels` and `rigsim.theory.detached`, compiled: breakpoints
of the fold levels, then comparisons with gamma. A set whose breakpoints double-double cannot make certain is done
again in exact integers.
"""

import math

import numpy as np

from .. import checks
from ..campaign.run import join, run_chunks, split
from ..compiled import compiled, inlinable
from ..parameters import Nondimensional, oscillator_of
from ..theory.levels import LOWER, arrange, levels, passed
from .enclosures import breakpoints

KINDS = ("inner", "outer")
_SAME = 1.0 + 1e-13  # levels nearer than that are one
_CHUNK = 4096  # sets that are judged at a time, in some 0.1 s


@inlinable
def _count(minus, plus, windows, gamma, kind):
    """Number of intervals whose two folds are both lower (kind 0, inner) or both upper (kind 1, outer)."""
    folds = passed(minus, plus, windows, gamma)
    count = 0
    for i in range(0, folds.shape[0], 2):
        if folds[i, 1] == folds[i + 1, 1] and (folds[i, 1] == LOWER) == (kind == 0):
            count += 1
    return count


@inlinable
def _spans(minus, plus, windows, kind):
    """Ranges of gamma (n, 2), ascending, where a curve of a kind exists.

    The list of intervals with three solutions is constant between neighbouring levels of breakpoints.
    """
    values = np.concatenate((minus, plus))
    values = np.sort(values[(values > 0.0) & (values < math.inf)])
    spans = np.empty((values.size + 1, 2))
    count, inside, low = 0, False, 0.0
    for i in range(values.size + 1):
        high = values[i] if i < values.size else math.inf
        if i > 0 and high <= low * _SAME:
            continue
        if values.size == 0:
            gamma = 1.0
        elif low == 0.0:
            gamma = 0.5 * high
        else:
            gamma = 2.0 * low if high == math.inf else math.sqrt(low * high)
        exists = _count(minus, plus, windows, gamma, kind) > 0
        if exists and not inside:
            spans[count, 0] = low
            count += 1
        if exists:
            spans[count - 1, 1] = high
        inside, low = exists, high
    return spans[:count]


@inlinable
def _distance(spans, gamma):
    """Signed distance of ln(force) from the nearest end of the spans: positive inside, -infinity without spans."""
    outside = math.inf
    for i in range(spans.shape[0]):
        low, high = spans[i]
        if low < gamma < high:
            return 0.5 * min(math.log(gamma / low) if low > 0.0 else math.inf, math.log(high / gamma))
        outside = min(outside, abs(math.log(low / gamma)) if low > 0.0 else math.inf, abs(math.log(high / gamma)))
    return -0.5 * outside


@inlinable
def _judge(minus, plus, windows, gamma, squares, counts, distances, tally):
    """Of one set: numbers and distances at its force, and whether there is a curve at others, squared, in tally."""
    for kind in range(2):
        spans = _spans(minus, plus, windows, kind)
        counts[kind] = _count(minus, plus, windows, gamma, kind)
        distances[kind] = _distance(spans, gamma)
        for i in range(squares.size):
            for j in range(spans.shape[0]):
                tally[kind, i] += spans[j, 0] < gamma * squares[i] < spans[j, 1]


@compiled(nogil=True)
def _judge_all(sets, squares, counts, distances, tally, doubtful):
    for i in range(sets.shape[0]):
        mu, zeta_s, zeta, Omega0, gamma = sets[i]
        if gamma == 0.0:
            continue
        cusps, extrema, certain = breakpoints(mu, zeta_s, zeta, Omega0)
        doubtful[i] = not certain
        if certain:
            _, minus, plus, windows = arrange(mu, zeta_s, zeta, Omega0, cusps, extrema)
            _judge(minus, plus, windows, gamma, squares, counts[i], distances[i], tally)


def judge(sets, **options):
    """Numbers of inner and outer detached curves (n, 2), int, and distances of the force from the edges of existence.

    ``sets`` (n, 5) are mu, zeta_s, zeta, Omega0, gamma, already checked. Distances (n, 2) are ln(F/F_edge) of the
    nearest force at which the last curve of a kind vanishes, positive where there is one and negative where there is
    none; -infinity where there is none at any force. The options are those of `rigsim.campaign.run.run_chunks`.
    """
    if not len(sets):
        return np.zeros((0, 2), dtype=np.int64), np.empty((0, 2))
    sets = np.ascontiguousarray(sets, dtype=float)
    chunks = [sets[part] for part in split(len(sets), _CHUNK)]
    found = join(run_chunks(_judge_chunk, chunks, label="sets", threads=len(chunks) > 1, **options))
    return found["counts"], found["distances"]


def _judge_chunk(sets):
    counts, distances, _ = _judged(sets, np.empty(0))
    return {"counts": counts, "distances": distances}


def _judged(sets, squares):
    """Numbers and distances of each set, and how many of them have curves at forces, squared, in units of their own."""
    counts, distances = np.zeros((len(sets), 2), dtype=np.int64), np.full((len(sets), 2), -math.inf)
    tally, doubtful = np.zeros((2, len(squares)), dtype=np.int64), np.zeros(len(sets), dtype=np.bool_)
    _judge_all(sets, squares, counts, distances, tally, doubtful)
    for i in np.flatnonzero(doubtful):
        group = Nondimensional(*sets[i].tolist())
        found = levels(group)
        _judge(found.minus, found.plus, found.windows, group.gamma, squares, counts[i], distances[i], tally)
    return counts, distances, tally


def having(sets, forces):
    """How many of some sets have an inner, and how many an outer detached curve at each force: int (2, forces).

    ``sets`` (n, 5) are mu, zeta_s, zeta, Omega0 and gamma at 1 N, already checked; ``forces`` are in N.
    """
    squares = np.square(np.ascontiguousarray(forces, dtype=float))
    return _judged(np.ascontiguousarray(sets, dtype=float), squares)[2]


def existence_forces(parameters, kind="inner"):
    """Every range of forces over which a detached curve of a kind, "inner" or "outer", exists.

    A tuple of (lowest, highest) force (N), ascending; empty if there is none. `ValueError` if the shaker is undamped.
    """
    oscillator = oscillator_of(parameters)
    number = KINDS.index(checks.one_of("kind", kind, KINDS))
    if oscillator.k3 == 0:
        return ()
    group = oscillator.nondimensional(1.0)
    found = levels(group)
    forces = np.sqrt(_spans(found.minus, found.plus, found.windows, number) / group.gamma)
    return tuple((low, high) for low, high in forces.tolist())
