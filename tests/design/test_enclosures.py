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
