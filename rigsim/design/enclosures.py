"""Breakpoints of `rigsim.theory.levels` for sets by the thousand: compiled double-double, with bounds on its rounding.

A coefficient is (high, low, size): the exact one lies within ROUNDING times size of high + low, for ``size`` is what
the same steps give when nothing cancels. A sign which the bound leaves open is known to be open, and exact integers
decide there; that hardly ever happens. Kept for its speed, which charts and tolerance studies live on: 0.02 ms a set,
where the integers take half a millisecond (measured on the benchmark's ten thousand).
"""

import numpy as np

from ..compiled import compiled, inlinable
from ..theory.isolation import bernstein_root

# A sum or product in double-double is good to 2^-103 of the magnitudes that enter, and no coefficient of `polynomials`
# is more than 220 of them deep: 72 before the divisions, then 8 for each coefficient before it, twice.
ROUNDING = 2.0**-95
_SPLITTER = 2.0**27 + 1.0
_NODES = 4000  # intervals looked at before the search gives up; usual are 20 to 100


@inlinable
def _two_sum(a, b):
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


@inlinable
def _two_product(a, b):
    """Dekker's product: a b exactly, as two doubles."""
    product = a * b
    scaled = _SPLITTER * a
    a_high = scaled - (scaled - a)
    a_low = a - a_high
    scaled = _SPLITTER * b
    b_high = scaled - (scaled - b)
    b_low = b - b_high
    return product, a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low)


@inlinable
def _add(a_high, a_low, b_high, b_low):
    high, low = _two_sum(a_high, b_high)
    low += a_low + b_low
    total = high + low
    return total, low - (total - high)


@inlinable
def _multiply(a_high, a_low, b_high, b_low):
    high, low = _two_product(a_high, b_high)
    low += a_high * b_low + a_low * b_high
    total = high + low
    return total, low - (total - high)


@compiled
def _product(a, b):
    """Of two polynomials (n, 3), (k, 3)."""
    result = np.zeros((a.shape[0] + b.shape[0] - 1, 3))
    for i in range(a.shape[0]):
        for j in range(b.shape[0]):
            high, low = _multiply(a[i, 0], a[i, 1], b[j, 0], b[j, 1])
            result[i + j, 0], result[i + j, 1] = _add(result[i + j, 0], result[i + j, 1], high, low)
            result[i + j, 2] += a[i, 2] * b[j, 2]
    return result


@compiled
def _sum(f, a, g, b, places=0):
    """f a + g X^places b, for small whole numbers f and g and polynomials a, b."""
    result = np.zeros((max(a.shape[0], b.shape[0] + places), 3))
    for factor, terms, shift in ((f, a, 0), (g, b, places)):
        for i in range(terms.shape[0]):
            high, low = _multiply(terms[i, 0], terms[i, 1], factor, 0.0)
            k = i + shift
            result[k, 0], result[k, 1] = _add(result[k, 0], result[k, 1], high, low)
            result[k, 2] += abs(factor) * terms[i, 2]
    return result


@compiled
def _euler(a):
    """X d/dX; degrees are small whole numbers."""
    result = np.zeros_like(a)
    for i in range(a.shape[0]):
        result[i, 0], result[i, 1] = _multiply(a[i, 0], a[i, 1], float(i), 0.0)
        result[i, 2] = i * a[i, 2]
    return result


@compiled
def _quotient(a, divisor):
    """Exact quotient by a divisor whose constant term is 1."""
    result = a[: a.shape[0] - divisor.shape[0] + 1].copy()
    for i in range(result.shape[0]):
        for j in range(1, min(i, divisor.shape[0] - 1) + 1):
            high, low = _multiply(divisor[j, 0], divisor[j, 1], result[i - j, 0], result[i - j, 1])
            result[i, 0], result[i, 1] = _add(result[i, 0], result[i, 1], -high, -low)
            result[i, 2] += divisor[j, 2] * result[i - j, 2]
    return result


@compiled
def polynomials(mu, zeta_s, zeta, Omega0):
    """Coefficients, ascending in X, of the cusp polynomial (7, 3) and the extremum polynomial (9, 3).

    Up to positive factors these are `rigsim.theory.levels.polynomials`; the steps are the same.
    """
    shaker, damping, oscillator, drag = np.zeros((2, 3)), np.zeros((2, 3)), np.zeros((2, 3)), np.zeros((3, 3))
    mass, single = np.array([[mu, 0.0, mu]]), np.array([[zeta, 0.0, zeta]])
    shaker[0, 0], oscillator[1, 0] = 1.0, -1.0
    shaker[1, 0], shaker[1, 1] = _two_sum(-1.0, -mu)
    damping[1, 0], damping[1, 1] = _two_product(zeta_s, zeta_s)
    oscillator[0, 0], oscillator[0, 1] = _two_product(Omega0, Omega0)
    drag[2, 0], drag[2, 1] = _two_product(mu, zeta_s)
    for given in (shaker, damping, oscillator, drag):
        given[:, 2] = np.abs(given[:, 0])
    e = _sum(1.0, _product(shaker, shaker), 4.0, damping)
    P = _sum(1.0, _product(oscillator, e), -1.0, _product(mass, shaker), 2)
    v = _sum(1.0, _product(single, e), 1.0, drag)
    cusp = _sum(1.0, _product(P, P), -12.0, _product(v, v), 1)
    De, DP, Dv = _euler(e), _euler(P), _euler(v)
    first = _sum(1.0, _sum(6.0, _product(e, Dv), -1.0, _product(e, v)), -4.0, _product(De, v))
    second = _sum(1.0, _sum(3.0, _product(e, DP), -2.0, _product(e, P)), -2.0, _product(De, P))
    mixed = _sum(1.0, _sum(2.0, _product(P, Dv), 1.0, _product(v, DP)), -1.0, _product(P, v))
    third = _sum(1.0, _product(e, mixed), -2.0, _product(De, _product(P, v)))
    both = _sum(1.0, _product(second, third), 1.0, _product(v, _product(first, first)), 1)
    return cusp, _quotient(_quotient(both, e), e)


@compiled
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


@compiled
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
        changes, certain = 0, True
        for i in range(n):
            certain = certain and abs(b[i, 0]) > error
            changes += i > 0 and (b[i, 0] > 0.0) != (b[i - 1, 0] > 0.0)
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


@compiled
def positive_roots(coefficients):
    """Positive roots, ascending, of an enclosed polynomial (n, 3), and whether they are certain."""
    degree = coefficients.shape[0] - 1
    bernstein = np.empty((degree + 1, 2))
    largest, error, binomial = 0.0, 1e-250, 1.0  # far above what underflow could lose
    for i in range(degree + 1):
        high = coefficients[i, 0] / binomial
        back_high, back_low = _two_product(high, binomial)
        low = ((coefficients[i, 0] - back_high) - back_low + coefficients[i, 1]) / binomial
        bernstein[i, 0] = high + low
        bernstein[i, 1] = low - (bernstein[i, 0] - high)
        largest = max(largest, abs(high))
        error = max(error, 2.0 * ROUNDING * coefficients[i, 2] / binomial)
        binomial = binomial * (degree - i) / (i + 1)
    if not 1e-200 < largest < 1e200:
        return np.empty(0), False
    small, certain = isolate(bernstein, error)
    if not certain:
        return small, False
    large, certain = isolate(bernstein[::-1].copy(), error)
    return np.concatenate((small / (1.0 - small), ((1.0 - large) / large)[::-1])), certain


@compiled
def breakpoints(mu, zeta_s, zeta, Omega0):
    """(cusps, extrema, whether they are certain), ascending in X."""
    cusp, extremum = polynomials(mu, zeta_s, zeta, Omega0)
    cusps, certain = positive_roots(cusp)
    if not certain:
        return cusps, cusps, False
    extrema, certain = positive_roots(extremum)
    return cusps, extrema, certain
