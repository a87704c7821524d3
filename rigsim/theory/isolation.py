"""Positive roots of a polynomial with integer coefficients: none missed, none invented.

With X = t/(1 - t) the positive half-line is 0 < t < 1, and sum a_i X^i has the sign of the Bernstein polynomial
with coefficients b_i = a_i/binomial(n, i). By Descartes' rule in Bernstein form (Basu, Pollack and Roy, *Algorithms
in Real Algebraic Geometry*, 10.2) an interval whose coefficients do not change sign holds no root, and one whose
coefficients change sign once holds exactly one; all others are halved by de Casteljau's algorithm, and halving ends
because simple roots part. It runs in double-double arithmetic with a bound on its rounding; a sign that the bound
leaves open hands the polynomial to the same rule in integers.
"""

import math

import numpy as np
from numba import njit

_BITS = 120  # kept of an integer coefficient; more than double-double holds
_NODES = 4000  # intervals looked at before double-double gives up; usual are 20 to 100
_CLUSTER = 200  # halvings of a root's own size after which integers call it multiple


def positive_roots(coefficients):
    """All distinct positive roots of sum coefficients[i] X^i, ascending.

    Parameters
    ----------
    coefficients : sequence of int
        Exact; not all zero.

    Returns
    -------
    numpy.ndarray
        (k,) roots to about 1e-15 relative. A multiple root, or roots closer than 2^-200 relative, count once.
    """
    values = list(coefficients)
    while values[-1] == 0:
        values.pop()
    while values[0] == 0:
        values.pop(0)
    degree = len(values) - 1
    binomials = [math.comb(degree, i) for i in range(degree + 1)]
    common = math.lcm(*binomials)
    bernstein = [value * (common // binomial) for value, binomial in zip(values, binomials, strict=True)]
    rounded = _double_double(bernstein)
    small, certain = isolate(rounded, 0.0)
    if certain:
        large, certain = isolate(rounded[::-1].copy(), 0.0)
    if not certain:
        return _exact_roots(bernstein)
    # The second run is over 1 - t, so that both ends of the half-line are resolved to full relative precision.
    return np.concatenate([small / (1 - small), ((1 - large) / large)[::-1]])


def _double_double(values):
    """Integers as (n, 2) high and low parts, scaled alike so that the largest is near 2^_BITS."""
    shift = max(value.bit_length() for value in values) - _BITS
    parts = np.empty((len(values), 2))
    for i, value in enumerate(values):
        value = value >> shift if shift > 0 else value << -shift
        parts[i, 0] = value
        parts[i, 1] = value - int(parts[i, 0])
    return parts


@njit(cache=True)
def _halve(b, left, right):
    """De Casteljau's algorithm at the middle, in double-double: coefficients of both halves."""
    n = b.shape[0]
    for i in range(n):
        right[i, 0], right[i, 1] = b[i, 0], b[i, 1]
    for level in range(n):
        left[level, 0], left[level, 1] = right[0, 0], right[0, 1]
        for i in range(n - 1 - level):
            a, c = right[i, 0], right[i + 1, 0]
            total = a + c
            part = total - a
            error = (a - (total - part)) + (c - part)
            error += right[i, 1] + right[i + 1, 1]
            high = total + error
            right[i, 0] = 0.5 * high
            right[i, 1] = 0.5 * (error - (high - total))


@njit(cache=True)
def _signs(b, error):
    """(sign changes, whether every sign is certain)."""
    changes = 0
    for i in range(b.shape[0]):
        if not abs(b[i, 0]) > error:
            return 0, False
        if i > 0 and (b[i, 0] > 0.0) != (b[i - 1, 0] > 0.0):
            changes += 1
    return changes, True


@njit(cache=True)
def bernstein_root(b):
    """Where in (0, 1) the Bernstein polynomial b (n,), negative at one end and positive at the other, vanishes.

    Newton's method inside a bracket, which is halved where Newton would leave it or hardly moves its far end.
    """
    work = np.empty_like(b)
    low, high = 0.0, 1.0
    rising = b[-1] > b[0]
    place = b[0] / (b[0] - b[-1])
    for step in range(90):
        work[:] = b
        for level in range(b.size - 1, 1, -1):
            for i in range(level):
                work[i] += place * (work[i + 1] - work[i])
        slope = (b.size - 1) * (work[1] - work[0])
        value = work[0] + place * (work[1] - work[0])
        if value == 0.0:
            return place
        if (value > 0.0) == rising:
            high = place
        else:
            low = place
        new = place - value / slope if slope != 0.0 else low
        if not low < new < high or step % 8 == 7:
            new = 0.5 * (low + high)
        if abs(new - place) <= 2.0**-52 or not low < new < high:
            return new
        place = new
    return place


@njit(cache=True)
def isolate(bernstein, error):
    """Roots t in (0, 1/2], ascending, of a Bernstein polynomial known to within ``error``, and whether all is certain.

    The coefficients (n, 2) are high and low parts, on top of whose error comes their own rounding.
    """
    n = bernstein.shape[0]
    unit = n * 2.0**-103  # rounding of one halving, relative to the largest coefficient
    stack = np.empty((400, n, 2))
    errors, lefts, widths = np.empty(400), np.empty(400), np.empty(400)
    roots, found = np.empty(n), 0
    first, second = np.empty((n, 2)), np.empty((n, 2))
    _halve(bernstein, first, second)
    stack[0] = first
    errors[0] = error + 2.0 * unit * np.abs(bernstein).max()
    lefts[0], widths[0] = 0.0, 0.5
    top = 1
    for _ in range(_NODES):
        if top == 0:
            return roots[:found], True
        top -= 1
        b, error, left, width = stack[top], errors[top], lefts[top], widths[top]
        largest = np.abs(b[:, 0]).max()
        if not largest > error or width < 2.0**-50 * left or width < 1e-90:
            return roots[:0], False
        changes, certain = _signs(b, error)
        if certain and changes == 0:
            continue
        if certain and changes == 1 and width <= left * 2.0**-6:
            roots[found] = left + width * bernstein_root(b[:, 0] / largest)
            found += 1
            continue
        _halve(b, first, second)
        errors[top] = errors[top + 1] = error + unit * largest
        width *= 0.5
        stack[top], lefts[top], widths[top] = second, left + width, width
        stack[top + 1], lefts[top + 1], widths[top + 1] = first, left, width
        top += 2
    return roots[:0], False


def _exact_roots(bernstein):
    """The same rule in integers; intervals are [place, place + 1]/2^depth."""
    degree = len(bernstein) - 1
    roots = []
    stack = [(bernstein, 0, 0)]
    while stack:
        b, place, depth = stack.pop()
        whole = 1 << depth
        if b[0] == 0 and place % 2:  # at the left end, which left halves inherit
            roots.append(place / (whole - place))
        signs = [value > 0 for value in b if value]
        changes = sum(one != other for one, other in zip(signs, signs[1:], strict=False))
        if changes == 0:
            continue
        nearest_end = min(place, whole - place - 1)
        if nearest_end >> _CLUSTER:
            roots.append(place / (whole - place))
            continue
        if changes == 1 and nearest_end >> 6 and b[0] and b[-1]:
            shift = max(0, max(abs(value).bit_length() for value in b) - 1000)
            floats = np.array([float(value >> shift) for value in b])
            inside = place + bernstein_root(floats / abs(floats).max())
            rest = (whole - place) - (inside - place)
            roots.append(inside / rest)
            continue
        left, row = [], list(b)
        for level in range(degree + 1):
            left.append(row[0] << (degree - level))
            row = [one + other for one, other in zip(row, row[1:], strict=False)]
        row, right = list(b), []
        for level in range(degree + 1):
            right.append(row[-1] << (degree - level))
            row = [one + other for one, other in zip(row, row[1:], strict=False)]
        stack.append((right[::-1], 2 * place + 1, depth + 1))
        stack.append((left, 2 * place, depth + 1))
    return np.array(roots)
