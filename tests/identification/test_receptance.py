"""Fraction polynomials: exact receptances come back, and the basis is orthogonal."""

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rigsim.identification import physical
from rigsim.identification.receptance import _orthogonal, fit_rational_fraction
from rigsim.parameters import OscillatorParameters, RigParameters
from tests.identification.cubic import first_order, true_receptance

FREQUENCY = np.linspace(2, 80, 400)
LETTERS = ("ms", "ks", "cs", "m", "c", "k1")


def fit(p, weights=None):
    receptance = true_receptance(p, FREQUENCY)
    entries = receptance[:, [0, 1, 1], [0, 0, 1]]
    weights = 1 / np.abs(entries) if weights is None else weights
    return entries, fit_rational_fraction(FREQUENCY, entries, weights, (2, 1, 2), 4)


def test_the_paper_s_rig_comes_back():
    p = RigParameters().oscillator
    entries, fraction = fit(p)
    np.testing.assert_allclose(fraction(FREQUENCY), entries, rtol=1e-9)
    expected = np.sort_complex(np.linalg.eigvals(first_order(p)[0]))
    np.testing.assert_allclose(np.sort_complex(fraction.poles), expected, rtol=1e-8)
    assert fraction.denominator[-1] == 1
    found = physical.parameters_of_fraction(fraction)
    np.testing.assert_allclose(found, [getattr(p, name) for name in LETTERS], rtol=1e-7)


@settings(max_examples=40, deadline=None)
@given(st.tuples(*[st.floats(0.3, 3.0)] * 6))
def test_any_oscillator_comes_back(factors):
    p = RigParameters().oscillator
    values = np.array([getattr(p, name) for name in LETTERS]) * factors
    other = OscillatorParameters(*values, p.k3)
    poles = np.linalg.eigvals(first_order(other)[0])
    assume((np.abs(poles) < 2 * np.pi * 80).all())
    _, fraction = fit(other)
    np.testing.assert_allclose(physical.parameters_of_fraction(fraction), values, rtol=1e-5)


def test_weights_do_not_move_an_exact_fit():
    entries, fraction = fit(RigParameters().oscillator, np.random.default_rng(0).uniform(0.1, 10, (400, 3)))
    np.testing.assert_allclose(fraction(FREQUENCY) / entries, 1, atol=1e-2)


def test_the_basis_is_orthogonal_and_knows_its_powers():
    omega, weight = np.linspace(0.02, 1, 300), np.random.default_rng(1).uniform(0.5, 2, 300)
    values, powers = _orthogonal(omega, weight, 5)
    products = np.real(values.conj().T @ (weight[:, None] * values))
    size = np.sqrt(np.diag(products))
    np.testing.assert_allclose(products / np.outer(size, size), np.eye(6), atol=1e-12)
    monomials = (1j * omega)[:, None] ** np.arange(6)
    np.testing.assert_allclose(monomials @ powers, values, atol=1e-12)
