"""Fold levels of the single-term response over frequency, their cusps and all their extrema; non-dimensional.

At X = Omega^2 the cubic of `rigsim.theory.cubic` has three solutions where gamma_-(X) < gamma < gamma_+(X), with
gamma_-+ = (4/3) (e/X^2) rho_-+. Both levels exist where r < -sqrt(3) s, on *windows* that end at cusps, where the
levels meet. Between neighbouring *breakpoints* (cusps and extrema of either level) both levels are monotonic.

Why no breakpoint is missed. Write P = e r, v = e s/(2 Omega) = zeta e + mu zeta_s X^2, polynomials in X as e is.

- Cusps lie where P^2 = 12 X v^2 with P < 0: a polynomial of degree 6.
- A fold level is Gamma(U, X) = (4/3) (e/X^2) U [(U + r)^2 + s^2] at a U where dGamma/dU = 0. So along the level
  dgamma/dX is the partial derivative dGamma/dX, and an extremum is a common root U of two quadratics. With
  V = U + r and L = d ln(e/X^2)/dX they are 3 V^2 - 2 r V + s^2 and L V^2 + 2 r' V + L s^2 + 2 s s', and their
  resultant vanishes: 4 s {s (L s + 3 s')^2 + (3 r' + L r) [r (L s + 2 s') + s r']} = 0. Cleared of denominators,
  of s > 0 and of a factor e^2 that divides it, the bracket is a polynomial of degree 8 in X.

Neither polynomial knows gamma. Their coefficients are computed exactly, as integers, from the doubles of the
parameters, and `rigsim.theory.isolation` finds all their positive roots. A root that belongs to no extremum (its
common U is the other level's, or lies outside the windows) does no harm: a breakpoint too many leaves the levels
monotonic in between. All of it is plain Python, half a millisecond a set; `rigsim.design.count` does the same for
sets by the thousand, compiled.
"""

import functools
import math
from dataclasses import dataclass
from itertools import zip_longest

import numpy as np

from ..compiled import inlinable
from .cubic import dynamic_stiffness, fold_levels
from .isolation import positive_roots

UNDAMPED = 1e-100  # a zeta_s below it is as good as none, and its square is zero
LOWER, UPPER = 1, -1  # a fold on gamma_+ joins the low and middle solutions, one on gamma_- the middle and high ones


@dataclass(frozen=True)
class Levels:
    """Breakpoints of the fold levels of one set (mu, zeta_s, zeta, Omega0).

    Attributes
    ----------
    numbers : tuple of float
        mu, zeta_s, zeta, Omega0.
    X : (k,) tuple of float
        Breakpoints, ascending; 0 or infinity where a window is open there.
    minus, plus : (k,) tuple of float
        gamma_- and gamma_+ there, equal at the ends of a window; 0 at X = 0, infinite at infinity.
    windows : tuple of (int, int)
        First and last breakpoint of each window.
    """

    numbers: tuple
    X: tuple
    minus: tuple
    plus: tuple
    windows: tuple


def _product(*factors):
    return functools.reduce(np.convolve, [np.array(factor, dtype=object) for factor in factors]).tolist()


def _combine(*terms):
    """Sum of (integer, polynomial) pairs."""
    scaled = ([factor * value for value in polynomial] for factor, polynomial in terms)
    return [sum(column) for column in zip_longest(*scaled, fillvalue=0)]


def _euler(polynomial):
    """X d/dX."""
    return [i * value for i, value in enumerate(polynomial)]


def _quotient(polynomial, divisor, bits):
    """Exact quotient by a divisor whose constant term is 2^bits."""
    quotient = []
    for i in range(len(polynomial) - len(divisor) + 1):
        rest = polynomial[i] - sum(divisor[j] * quotient[i - j] for j in range(1, min(i + 1, len(divisor))))
        quotient.append(rest >> bits)
    return quotient


def polynomials(mu, zeta_s, zeta, Omega0):
    """Integer coefficients, ascending in X, of the cusp polynomial (7,) and the extremum polynomial (9,).

    The parameters are integers over one = 2^bits; every polynomial carries the power of 1/one that its total degree
    in the parameters asks for.
    """
    ratios = [value.as_integer_ratio() for value in (mu, zeta_s, zeta, Omega0)]
    bits = max(denominator.bit_length() - 1 for _, denominator in ratios)
    one = 1 << bits
    mu, zeta_s, zeta, Omega0 = (numerator * (one // denominator) for numerator, denominator in ratios)
    shaker = [one, -(one + mu)]
    e = _combine((1, _product(shaker, shaker)), (4, [0, zeta_s**2]))
    P = _combine((1, _product([Omega0**2, -(one**2)], e)), (-mu * one**2, [0, 0, *shaker]))
    v = _combine((zeta, e), (mu * zeta_s * one, [0, 0, 1]))
    cusp = _combine((1, _product(P, P)), (-12 * one**2, [0, *_product(v, v)]))
    De, DP, Dv = _euler(e), _euler(P), _euler(v)
    first = _combine((6, _product(e, Dv)), (-1, _product(e, v)), (-4, _product(De, v)))
    second = _combine((3, _product(e, DP)), (-2, _product(e, P)), (-2, _product(De, P)))
    mixed = _combine((2, _product(P, Dv)), (1, _product(v, DP)), (-1, _product(P, v)))
    third = _combine((1, _product(e, mixed)), (-2, _product(De, P, v)))
    both = _combine((one**2, [0, *_product(v, first, first)]), (1, _product(second, third)))
    return cusp, _quotient(_quotient(both, e, 2 * bits), e, 2 * bits)


@inlinable
def level(mu, zeta_s, zeta, Omega0, X, kind):
    """gamma_+ (kind LOWER) or gamma_- (kind UPPER) at X inside a window, or on its edge up to rounding."""
    r, s, e = dynamic_stiffness(mu, zeta_s, zeta, Omega0, X)
    rho_minus, rho_plus, _, _ = fold_levels(min(r, -math.sqrt(3.0) * s), s)
    return 4.0 / 3.0 * e / (X * X) * (rho_plus if kind == LOWER else rho_minus)


@inlinable
def _level_or_limit(mu, zeta_s, zeta, Omega0, X, kind):
    return X if X == 0.0 or math.inf == X else level(mu, zeta_s, zeta, Omega0, X, kind)


@inlinable
def arrange(mu, zeta_s, zeta, Omega0, cusps, extrema):
    """X, gamma_-, gamma_+ at the breakpoints (k,), and first and last breakpoint of each window (w, 2)."""
    room = 2 * len(cusps) + 2 + len(extrema)
    X, minus, plus = np.empty(room), np.empty(room), np.empty(room)
    windows = np.empty((len(cusps) + 1, 2), dtype=np.int64)
    used, number, place = 0, 0, 0
    for i in range(len(cusps) + 1):
        left = cusps[i - 1] if i > 0 else 0.0
        right = cusps[i] if i < len(cusps) else math.inf
        r, s, _ = dynamic_stiffness(
            mu, zeta_s, zeta, Omega0, 0.5 * (left + right) if right < math.inf else 1 + 2 * left
        )
        if not r < -math.sqrt(3.0) * s:
            continue
        while place < len(extrema) and extrema[place] <= left:
            place += 1
        windows[number, 0] = used
        X[used] = left
        minus[used] = plus[used] = _level_or_limit(mu, zeta_s, zeta, Omega0, left, LOWER)  # they meet at a cusp
        used += 1
        while place < len(extrema) and extrema[place] < right:
            X[used] = extrema[place]
            minus[used] = level(mu, zeta_s, zeta, Omega0, extrema[place], UPPER)
            plus[used] = level(mu, zeta_s, zeta, Omega0, extrema[place], LOWER)
            used += 1
            place += 1
        X[used] = right
        minus[used] = plus[used] = _level_or_limit(mu, zeta_s, zeta, Omega0, right, LOWER)
        windows[number, 1] = used
        used += 1
        number += 1
    return X[:used], minus[:used], plus[:used], windows[:number]


def levels(group):
    """The `Levels` of a set of non-dimensional parameters (whose gamma plays no part).

    `ValueError` if the shaker is undamped: solutions are then without bound near 1/sqrt(1 + mu), folds not isolated.
    """
    if group.zeta_s < UNDAMPED:
        told = "cs = 0 N s/m, or next to nothing, is not allowed here"
        raise ValueError(f"{told}; expected a damped shaker, for else solutions have no bound")
    return _levels(group.mu, group.zeta_s, group.zeta, group.Omega0)


@functools.lru_cache(maxsize=256)  # a rig is asked at one force after another
def _levels(*numbers):
    cusps, extrema = map(positive_roots, polynomials(*numbers))
    X, minus, plus, windows = arrange(*numbers, cusps, extrema)
    return Levels(numbers, *map(tuple, (X.tolist(), minus.tolist(), plus.tolist(), map(tuple, windows.tolist()))))


@inlinable
def passed(minus, plus, windows, gamma):
    """Folds at gamma, ascending in frequency: (n, 2) segments and kinds, two of them to an interval of three solutions.

    Segment k lies between breakpoints k and k + 1. At a breakpoint gamma is below both levels, between them, or
    above both; in between each monotonic level is passed at most once. So comparing with the breakpoints decides
    every fold, and no root has to be found.
    """
    found = np.empty((2 * len(minus), 2), dtype=np.int64)
    count = 0
    for window in range(len(windows)):
        start, stop = windows[window]
        before = int(gamma > minus[start]) + int(gamma >= plus[start])
        for k in range(start, stop):
            after = int(gamma > minus[k + 1]) + int(gamma >= plus[k + 1])
            for step in range(before, after):
                found[count, 0], found[count, 1] = k, UPPER if step == 0 else LOWER
                count += 1
            for step in range(before, after, -1):
                found[count, 0], found[count, 1] = k, LOWER if step == 2 else UPPER
                count += 1
            before = after
    return found[:count]


def crossings(levels, gamma):
    """The folds `passed` at gamma, as a list of (segment, kind)."""
    return list(map(tuple, passed(levels.minus, levels.plus, levels.windows, gamma).tolist()))


def crossing(levels, gamma, segment, kind):
    """X of one of the `crossings`, where a monotonic level passes gamma: Chandrupatla's method, to 4e-16."""
    values = levels.plus if kind == LOWER else levels.minus
    rising = values[segment] <= gamma

    def height(X):
        """ln(level/gamma), turned so that it rises."""
        value = math.log(level(*levels.numbers, X, kind) / gamma)
        return value if rising else -value

    left, right = levels.X[segment], levels.X[segment + 1]
    if right == math.inf:
        right = 2.0 * max(left, 1.0)
        while height(right) <= 0:
            left, right = right, 2.0 * right
    if left == 0.0:
        left = 0.5 * right
        while height(left) > 0:
            left, right = 0.5 * left, left
    # The level passes gamma between them, also where rounding at a breakpoint would say otherwise.
    near, far, at_near, at_far = left, right, min(height(left), -1e-300), max(height(right), 1e-300)
    share = 0.5
    while True:
        X = near + share * (far - near)
        value = height(X)
        if (value > 0) == (at_near > 0):
            last, at_last = near, at_near
        else:
            last, at_last, far, at_far = far, at_far, near, at_near
        near, at_near = X, value
        least = 4e-16 * X / abs(far - near) if far != near else 1.0
        if value == 0 or least > 0.5:
            return X
        # Through the last three places, if the inverse is single-valued there; else halve.
        x, y = (near - far) / (last - far), (at_near - at_far) / (at_last - at_far)
        share = 0.5
        if 1 - math.sqrt(1 - x) < y < math.sqrt(x):
            share = at_near / (at_far - at_near) * at_last / (at_far - at_last) + (last - near) / (
                far - near
            ) * at_near / (at_last - at_near) * at_far / (at_last - at_far)
        share = min(max(share, least), 1 - least)
