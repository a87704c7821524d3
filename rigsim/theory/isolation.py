"""Positive roots of a polynomial with integer coefficients: none missed, none invented.

With X = t/(1 - t) the positive half-line is 0 < t < 1, and sum a_i X^i has the sign of the Bernstein polynomial
with coefficients b_i = a_i/binomial(n, i). By Descartes' rule in Bernstein form (Basu, Pollack and Roy, *Algorithms
in Real Algebraic Geometry*, 10.2) an interval whose coefficients do not change sign holds no root, and one whose
coefficients change sign once holds exactly one; all others are halved by de Casteljau's algorithm, and halving ends
because simple roots part. The coefficients are cut to so many bits first, with a bound on what that and each halving
round off; where the bound leaves a sign open, the same is done with every bit.
"""

import math

from ..compiled import inlinable

_BITS = 160  # kept of the coefficients at first
_CLOSE = 50  # halvings of a root's own size after which signs that are still open need every bit
_CLUSTER = 200  # and with every bit, after which roots are called one


def positive_roots(coefficients):
    """All distinct positive roots of sum coefficients[i] X^i, exact integers and not all zero: a list, ascending.

    They are good to about 1e-15 relative. A multiple root, or roots closer than 2^-200 relative, count once.
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
    excess = max(value.bit_length() for value in bernstein) - _BITS
    roots = _roots([value >> excess for value in bernstein], 1) if excess > 0 else None
    return _roots(bernstein, 0) if roots is None else roots


def _roots(bernstein, error):
    """Roots from coefficients known to within ``error``, or None if that is not enough; 0 means exactly."""
    degree = len(bernstein) - 1
    roots = []
    stack = [(bernstein, error, 0, 0)]  # over [place, place + 1]/2^depth
    while stack:
        b, error, place, depth = stack.pop()
        whole = 1 << depth
        nearest_end = min(place, whole - place - 1)
        if error == 0 and b[0] == 0 and place % 2:  # at the left end, which left halves inherit
            roots.append(place / (whole - place))
        signs = [value > 0 for value in b if abs(value) > error]
        changes = sum(one != other for one, other in zip(signs, signs[1:], strict=False))
        certain = error == 0 or len(signs) > degree
        if certain and changes == 0:
            continue
        if not certain and (not signs or nearest_end >> _CLOSE):
            return None
        if nearest_end >> _CLUSTER:
            roots.append(place / (whole - place))
            continue
        if certain and changes == 1 and nearest_end >> 6 and b[0] and b[-1]:
            largest = max(map(abs, b))
            inside = bernstein_root([value / largest for value in b])
            roots.append((place + inside) / ((whole - place) - inside))
            continue
        if error:
            error += degree
        else:
            b = [value << degree for value in b]  # so that halving is exact
        left, right = [], []
        while b:
            left.append(b[0])
            right.append(b[-1])
            b = [(one + other) >> 1 for one, other in zip(b, b[1:], strict=False)]
        stack.append((right[::-1], error, 2 * place + 1, depth + 1))
        stack.append((left, error, 2 * place, depth + 1))
    return roots


@inlinable
def bernstein_root(b):
    """Where in (0, 1) the Bernstein polynomial b (n,), negative at one end and positive at the other, vanishes.

    Newton's method inside a bracket, which is halved where Newton would leave it or hardly moves its far end.
    """
    degree = len(b) - 1
    low, high = 0.0, 1.0
    rising = b[-1] > b[0]
    place = b[0] / (b[0] - b[-1])
    for step in range(90):
        work = b.copy()
        for level in range(degree, 1, -1):
            for i in range(level):
                work[i] += place * (work[i + 1] - work[i])
        slope = degree * (work[1] - work[0])
        value = work[0] + place * (work[1] - work[0])
        if value == 0.0:
            return place
        if (value > 0.0) == rising:
            high = place
        else:
            low = place
        new = place - value / slope if slope != 0.0 else low
        if slope != 0.0 and abs(new - place) <= 2.0**-52:
            return place
        if not low < new < high or step % 8 == 7:
            new = 0.5 * (low + high)
            if not low < new < high:
                return new
        place = new
    return place
