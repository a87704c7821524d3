"""Polynomials in double-double: the bounds hold against exact integers, and the roots are the integers' roots."""

import math
from fractions import Fraction

import numpy as np
import pytest

from rigsim.design import enclosures
from rigsim.theory import levels
from rigsim.theory.isolation import positive_roots

from ..theory.test_levels import sets

# The corners of the parameters' ranges, the limits of no stiffness and no damping, and far beyond.
HARD = [
    (1e-4, 1e-4, 1e-4, 0.0),
    (1e-4, 1e-4, 1e-4, 2.0),
    (1.0, 0.5, 0.5, 1e-9),
    (1.0, 1e-4, 0.5, 1.0),
    (0.03, 0.1, 0.0, 0.2),
    (0.03, 0.1, 0.0, 0.0),
    (1e-12, 1e-7, 1e-9, 1.0),
    (50.5, 3.0, 2.0, 30.0),
]
NUMBERS = [(group.mu, group.zeta_s, group.zeta, group.Omega0) for group in sets(60, seed=11)] + HARD


@pytest.mark.parametrize("which", [0, 1], ids=["cusp", "extremum"])
def test_every_coefficient_lies_within_its_bound(which):
    for numbers in NUMBERS:
        enclosed, exact = enclosures.polynomials(*numbers)[which], levels.polynomials(*numbers)[which]
        # The integers carry a power of 1/one: the one that brings the leading coefficients together.
        bits = max(Fraction(value).denominator.bit_length() - 1 for value in numbers)
        last = len(exact) - 1
        ratio = abs(Fraction(exact[last]) / Fraction(enclosed[last, 0]))
        scale = Fraction(2) ** (bits * round(math.log2(ratio) / bits))
        for value, (high, low, size) in zip(exact, enclosed, strict=True):
            assert abs(Fraction(value) / scale - Fraction(high) - Fraction(low)) <= Fraction(enclosures.ROUNDING * size)
        if numbers not in HARD:  # a bound, not a surrender
            assert enclosures.ROUNDING * enclosed[:, 2].max() < 1e-21 * abs(enclosed[:, 0]).max()


def product(a, b):
    result = [Fraction(0)] * (len(a) + len(b) - 1)
    for i, one in enumerate(a):
        for j, other in enumerate(b):
            result[i + j] += one * other
    return result


def total(*terms):
    """Sum of factor times polynomial."""
    result = [Fraction(0)] * max(len(a) for _, a in terms)
    for factor, a in terms:
        for i, value in enumerate(a):
            result[i] += factor * value
    return result


def without_cancelling(mu, zeta_s, zeta, Omega0):
    """The steps from the equations to both polynomials in exact numbers, every minus a plus."""
    mu, zeta_s, zeta, square = map(Fraction, (mu, zeta_s, zeta, Fraction(Omega0) ** 2))
    shift = lambda a, places: [Fraction(0)] * places + a  # noqa: E731
    euler = lambda a: [i * value for i, value in enumerate(a)]  # noqa: E731
    shaker = [Fraction(1), 1 + mu]
    e = total((1, product(shaker, shaker)), (4, [0, zeta_s**2]))
    P = total((1, product([square, Fraction(1)], e)), (1, shift([mu * value for value in shaker], 2)))
    v = total((1, [zeta * value for value in e]), (1, [0, 0, mu * zeta_s]))
    cusp = total((1, product(P, P)), (12, shift(product(v, v), 1)))
    first = total((6, product(e, euler(v))), (1, product(e, v)), (4, product(euler(e), v)))
    second = total((3, product(e, euler(P))), (2, product(e, P)), (2, product(euler(e), P)))
    mixed = total((2, product(P, euler(v))), (1, product(v, euler(P))), (1, product(P, v)))
    third = total((1, product(e, mixed)), (2, product(euler(e), product(P, v))))
    both = total((1, shift(product(v, product(first, first)), 1)), (1, product(second, third)))
    for _ in range(2):  # times 1/e, whose terms beyond the first are added, too
        quotient = []
        for i, value in enumerate(both[: len(both) - len(e) + 1]):
            quotient.append(value + sum(e[j] * quotient[i - j] for j in range(1, min(i, len(e) - 1) + 1)))
        both = quotient
    return cusp, both


def test_the_size_of_a_coefficient_is_what_its_steps_give_without_cancelling():
    """Its bound is so large and no larger: the rounding of every step is in it."""
    for numbers in NUMBERS:
        for enclosed, size in zip(enclosures.polynomials(*numbers), without_cancelling(*numbers), strict=True):
            np.testing.assert_allclose(enclosed[:, 2], np.array(size, dtype=float), rtol=1e-12)


def test_a_sign_that_the_bound_leaves_open_is_not_called_certain():
    """(X - 1)^2 - a^2 has two roots, 1 - a and 1 + a: seen where the bound is below a^2, and not where it is above."""
    for a in (1e-3, 1e-6, 1e-9):
        coefficients = np.zeros((3, 3))
        coefficients[:, 0], coefficients[0, 1] = [1.0, -2.0, 1.0], -(a**2)
        for share, expected in ((0.02, True), (50.0, False)):
            coefficients[:, 2] = share * a**2 / enclosures.ROUNDING
            roots, certain = enclosures.positive_roots(coefficients)
            assert certain == expected
            if certain:
                np.testing.assert_allclose(roots, [1 - a, 1 + a], rtol=1e-12)


def test_roots_are_those_of_the_integers_or_owned_up_to():
    certain_ones = 0
    for numbers in NUMBERS:
        for enclosed, exact in zip(enclosures.polynomials(*numbers), levels.polynomials(*numbers), strict=True):
            roots, certain = enclosures.positive_roots(enclosed)
            if certain:
                certain_ones += 1
                np.testing.assert_allclose(roots, positive_roots(exact), rtol=1e-12)
    assert certain_ones > 120  # all of the random sets, and some of the hard ones


@pytest.mark.parametrize("values", [[1.0, np.nan, 1.0], [1.0, np.inf, 1.0], [0.0, 0.0, 0.0], [1e-300, -1e-300, 1e-300]])
def test_what_has_no_sign_is_not_certain(values):
    coefficients = np.zeros((3, 3))
    coefficients[:, 0] = values
    assert not enclosures.positive_roots(coefficients)[1]


def test_a_double_root_is_not_certain():
    coefficients = np.zeros((3, 3))
    coefficients[:, 0], coefficients[:, 2] = [1.0, -2.0, 1.0], 1.0
    assert not enclosures.positive_roots(coefficients)[1]
