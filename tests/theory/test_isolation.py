"""Root isolation against polynomials of known roots, and its two arithmetics against each other."""

from fractions import Fraction

import numpy as np
import pytest
from flint import fmpz_poly
from hypothesis import given, settings
from hypothesis import strategies as st

from rigsim.theory import isolation
from rigsim.theory.isolation import positive_roots


def polynomial(roots, extra=(1,)):
    """Integer polynomial with rational ``roots`` ((numerator, denominator) pairs) times ``extra``."""
    product = fmpz_poly(list(extra))
    for numerator, denominator in roots:
        product *= fmpz_poly([-numerator, denominator])
    return [int(c) for c in product.coeffs()]


@settings(deadline=None, max_examples=150, derandomize=True)
@given(
    st.lists(st.tuples(st.integers(-(10**9), 10**9), st.integers(1, 10**9)), min_size=1, max_size=6),
    st.sampled_from([(1,), (1, 0, 1), (5, -4, 1), (0, 0, 3)]),
)
def test_exactly_the_distinct_positive_roots_are_found(roots, extra):
    expected = sorted(float(root) for root in {Fraction(*pair) for pair in roots} if root > 0)
    np.testing.assert_allclose(positive_roots(polynomial(roots, extra)), expected, rtol=1e-12)


@pytest.mark.parametrize(
    "roots",
    [
        [(1, 1)],
        [(1, 1), (1, 3), (3, 1)],
        [(10**12, 10**12 + 1), (10**12 + 1, 10**12 + 2)],
        [(1, 10**20), (10**20, 1)],
        [(2, 7), (2, 7), (5, 3)],
        [(1, 1), (1, 1), (1, 1)],
        [(1, 1), (2047, 2049)],  # t = 1/2 ends the interval that holds the other
        [(1, 3), (255, 769), (257, 767)],  # t = 1/4, and a 1024th to either side
    ],
)
def test_hard_roots(roots):
    expected = sorted(float(root) for root in {Fraction(*pair) for pair in roots})
    np.testing.assert_allclose(positive_roots(polynomial(roots)), expected, rtol=1e-11)


def test_cut_integers_and_whole_ones_agree(monkeypatch):
    rng = np.random.default_rng(3)
    cases = [[int(v) ** 15 for v in rng.integers(-(10**15), 10**15, 9)] for _ in range(100)]
    usual = [positive_roots(case) for case in cases]
    monkeypatch.setattr(isolation, "_BITS", 10**6)
    for case, roots in zip(cases, usual, strict=True):
        np.testing.assert_allclose(positive_roots(case), roots, rtol=1e-13)
