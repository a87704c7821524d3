"""The polynomials of `rigsim.theory.levels` in compiled double-double arithmetic, with bounds on what it rounds.

A coefficient is (high, low, error): the exact one lies within ``error`` of high + low. Sums and products carry their
bounds along, so that a sign which the bound leaves open is known to be open, and exact integers decide there. It is
an order of magnitude faster than integers, and it hardly ever leaves a sign open.
"""

import numpy as np
from numba import njit

from .isolation import isolate

# A sum or product in double-double is good to about 2^-103 of the magnitudes that enter; the rest is for the bounds'
# own rounding. Each coefficient of a product is at most 8 such terms, each added in turn.
_UNIT = 2.0**-98
_SPLITTER = 2.0**27 + 1.0


@njit(cache=True, inline="always")
def _two_sum(a, b):
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


@njit(cache=True, inline="always")
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


@njit(cache=True, inline="always")
def _add(a_high, a_low, b_high, b_low):
    high, low = _two_sum(a_high, b_high)
    low += a_low + b_low
    total = high + low
    return total, low - (total - high)


@njit(cache=True, inline="always")
def _multiply(a_high, a_low, b_high, b_low):
    high, low = _two_product(a_high, b_high)
    low += a_high * b_low + a_low * b_high
    total = high + low
    return total, low - (total - high)


@njit(cache=True)
def _product(a, b):
    """Of two polynomials (n, 3), (k, 3)."""
    result = np.zeros((a.shape[0] + b.shape[0] - 1, 3))
    for i in range(a.shape[0]):
        for j in range(b.shape[0]):
            high, low = _multiply(a[i, 0], a[i, 1], b[j, 0], b[j, 1])
            k = i + j
            result[k, 0], result[k, 1] = _add(result[k, 0], result[k, 1], high, low)
            one, other = abs(a[i, 0]), abs(b[j, 0])
            # Twice the term's magnitude, and what it was added to, bound the rounding of both steps.
            result[k, 2] += (
                one * b[j, 2] + a[i, 2] * other + a[i, 2] * b[j, 2] + _UNIT * (one * other + abs(result[k, 0]))
            ) * (1.0 + 1e-15)
    return result


@njit(cache=True)
def _sum(f, a, g, b):
    """f a + g b, for small whole numbers f and g and polynomials a, b."""
    result = np.zeros((max(a.shape[0], b.shape[0]), 3))
    for i in range(a.shape[0]):
        result[i, 0], result[i, 1] = _multiply(a[i, 0], a[i, 1], f, 0.0)
        result[i, 2] = abs(f) * a[i, 2] + _UNIT * abs(result[i, 0])
    for i in range(b.shape[0]):
        high, low = _multiply(b[i, 0], b[i, 1], g, 0.0)
        result[i, 0], result[i, 1] = _add(result[i, 0], result[i, 1], high, low)
        result[i, 2] += abs(g) * b[i, 2] + _UNIT * (2.0 * abs(high) + abs(result[i, 0]))
    return result


@njit(cache=True)
def _shifted(a, places):
    """X^places a."""
    result = np.zeros((a.shape[0] + places, 3))
    result[places:] = a
    return result


@njit(cache=True)
def _euler(a):
    """X d/dX; degrees are small whole numbers."""
    result = np.zeros_like(a)
    for i in range(a.shape[0]):
        result[i, 0], result[i, 1] = _multiply(a[i, 0], a[i, 1], float(i), 0.0)
        result[i, 2] = i * a[i, 2] + _UNIT * abs(result[i, 0])
    return result


@njit(cache=True)
def _quotient(a, divisor):
    """Exact quotient by a divisor whose constant term is 1."""
    result = np.zeros((a.shape[0] - divisor.shape[0] + 1, 3))
    for i in range(result.shape[0]):
        result[i] = a[i]
        for j in range(1, min(i + 1, divisor.shape[0] - 1) + 1):
            if i - j < 0:
                continue
            d, q = divisor[j], result[i - j]
            high, low = _multiply(d[0], d[1], q[0], q[1])
            result[i, 0], result[i, 1] = _add(result[i, 0], result[i, 1], -high, -low)
            one, other = abs(d[0]), abs(q[0])
            result[i, 2] += (one * q[2] + d[2] * other + d[2] * q[2] + _UNIT * (one * other + abs(result[i, 0]))) * (
                1.0 + 1e-15
            )
    return result


@njit(cache=True)
def polynomials(mu, zeta_s, zeta, Omega0):
    """Coefficients, ascending in X, of the cusp polynomial (7, 3) and the extremum polynomial (9, 3).

    Up to positive factors these are `rigsim.theory.levels.polynomials`; the steps are the same.
    """
    shaker = np.zeros((2, 3))
    shaker[0, 0] = 1.0
    shaker[1, 0], shaker[1, 1] = _two_sum(-1.0, -mu)
    damping = np.zeros((2, 3))
    damping[1, 0], damping[1, 1] = _two_product(zeta_s, zeta_s)
    oscillator = np.zeros((2, 3))
    oscillator[0, 0], oscillator[0, 1] = _two_product(Omega0, Omega0)
    oscillator[1, 0] = -1.0
    mass, single = np.zeros((1, 3)), np.zeros((1, 3))
    mass[0, 0], single[0, 0] = mu, zeta
    drag = np.zeros((3, 3))
    drag[2, 0], drag[2, 1] = _two_product(mu, zeta_s)
    e = _sum(1.0, _product(shaker, shaker), 4.0, damping)
    P = _sum(1.0, _product(oscillator, e), -1.0, _shifted(_product(mass, shaker), 2))
    v = _sum(1.0, _product(single, e), 1.0, drag)
    cusp = _sum(1.0, _product(P, P), -12.0, _shifted(_product(v, v), 1))
    De, DP, Dv = _euler(e), _euler(P), _euler(v)
    first = _sum(1.0, _sum(6.0, _product(e, Dv), -1.0, _product(e, v)), -4.0, _product(De, v))
    second = _sum(1.0, _sum(3.0, _product(e, DP), -2.0, _product(e, P)), -2.0, _product(De, P))
    mixed = _sum(1.0, _sum(2.0, _product(P, Dv), 1.0, _product(v, DP)), -1.0, _product(P, v))
    third = _sum(1.0, _product(e, mixed), -2.0, _product(De, _product(P, v)))
    both = _sum(1.0, _shifted(_product(v, _product(first, first)), 1), 1.0, _product(second, third))
    return cusp, _quotient(_quotient(both, e), e)


@njit(cache=True)
def positive_roots(coefficients):
    """Positive roots, ascending, of an enclosed polynomial (n, 3), and whether they are certain."""
    degree = coefficients.shape[0] - 1
    bernstein = np.empty((degree + 1, 2))
    largest, error, binomial = 0.0, 1e-250, 1.0  # far above what underflow could lose
    for i in range(degree + 1):
        high, low = coefficients[i, 0] / binomial, 0.0
        back_high, back_low = _two_product(high, binomial)
        low = ((coefficients[i, 0] - back_high) - back_low + coefficients[i, 1]) / binomial
        bernstein[i, 0] = high + low
        bernstein[i, 1] = low - (bernstein[i, 0] - high)
        largest = max(largest, abs(high))
        error = max(error, coefficients[i, 2] / binomial + _UNIT * abs(high))
        binomial = binomial * (degree - i) / (i + 1)
    if not 1e-200 < largest < 1e200:
        return np.empty(0), False
    small, certain = isolate(bernstein, error)
    if not certain:
        return small, False
    large, certain = isolate(bernstein[::-1].copy(), error)
    return np.concatenate((small / (1.0 - small), ((1.0 - large) / large)[::-1])), certain
