"""Fold levels: the exact polynomials against a resultant, and monotonic between breakpoints."""

from fractions import Fraction

import numpy as np
import pytest
from flint import fmpq, fmpq_poly

from rigsim.parameters import Nondimensional, OscillatorParameters
from rigsim.theory.cubic import cubic_roots, dynamic_stiffness
from rigsim.theory.detached import folds
from rigsim.theory.levels import LOWER, UPPER, Levels, crossings, level, levels, polynomials

from .exact_folds import exact_folds


def sets(count, seed):
    rng = np.random.default_rng(seed)
    for _ in range(count):
        mu, zeta_s, zeta = 10 ** rng.uniform([-4, -4, -4], [0, np.log10(0.5), np.log10(0.5)])
        yield Nondimensional(mu, zeta_s, zeta, rng.uniform(0, 2), 1.0)


def test_the_extremum_polynomial_is_the_resultant_of_the_two_conditions():
    X = fmpq_poly([0, 1])
    for group in sets(20, seed=1):
        numbers = group.mu, group.zeta_s, group.zeta, group.Omega0
        mu, zeta_s, zeta, Omega0 = (fmpq(*Fraction(value).as_integer_ratio()) for value in numbers)
        shaker, oscillator = 1 - (1 + mu) * X, Omega0**2 - X
        e = shaker**2 + 4 * zeta_s**2 * X
        P = oscillator * e - mu * X**2 * shaker
        Q = (shaker * oscillator - 4 * zeta_s * zeta * X - mu * X**2) ** 2
        Q += 4 * X * (zeta_s * oscillator + zeta * shaker) ** 2
        # gamma(U, X) = (4/3) U (e U^2 + 2 P U + Q)/X^2 is stationary in U and in X.
        in_U = [Q, 4 * P, 3 * e]
        in_X = [X * Q.derivative() - 2 * Q, 2 * (X * P.derivative() - 2 * P), X * e.derivative() - 2 * e]
        minor = lambda i, j: in_U[i] * in_X[j] - in_U[j] * in_X[i]  # noqa: B023, E731
        resultant = minor(2, 0) ** 2 - minor(2, 1) * minor(1, 0)
        v = zeta * e + mu * zeta_s * X**2
        cusp, extremum = (fmpq_poly(values) for values in polynomials(*numbers))
        quotient, rest = divmod(resultant, X * v)
        assert rest == 0 and quotient.degree() == 8
        assert quotient * extremum.coeffs()[-1] == extremum * quotient.coeffs()[-1]
        wanted = P**2 - 12 * X * v**2
        assert wanted * cusp.coeffs()[-1] == cusp * wanted.coeffs()[-1]


@pytest.mark.parametrize("kind", [LOWER, UPPER])
def test_levels_are_monotonic_between_breakpoints(kind):
    for group in sets(60, seed=2):
        found = levels(group)
        for start, stop in found.windows:
            for left, right in zip(found.X[start:stop], found.X[start + 1 : stop + 1], strict=True):
                right = min(right, 4 * max(left, 1.0))
                inside = left + (right - left) * np.sin(np.linspace(0.02, np.pi / 2 - 0.02, 80)) ** 2
                values = np.array([level(*found.numbers, X, kind) for X in inside])
                steps = np.diff(values) / values[1:]
                assert (steps > -1e-9).all() or (steps < 1e-9).all()


def test_the_number_of_solutions_changes_at_the_levels():
    for group in sets(60, seed=3):
        found = levels(group)
        for start, stop in found.windows:
            for X in found.X[start + 1 : stop]:
                r, s, e = dynamic_stiffness(*found.numbers, X)
                gammas = level(*found.numbers, X, UPPER), level(*found.numbers, X, LOWER)
                assert 0 < gammas[0] < gammas[1]
                forces = gammas[0] * (1 - 1e-8), np.sqrt(gammas[0] * gammas[1]), gammas[1] * (1 + 1e-8)
                assert [cubic_roots(r, s, 0.75 * gamma * X**2 / e)[0] for gamma in forces] == [1, 3, 1]


def test_crossings_follow_from_the_levels_at_the_breakpoints():
    inf = np.inf
    made = Levels((), (0.0, 1.0, 2.0, inf), (0.0, 2.0, 1.0, inf), (0.0, 4.0, 3.0, inf), ((0, 3),))
    for gamma, expected in (
        (0.5, [(0, LOWER), (0, UPPER)]),
        (1.5, [(0, LOWER), (0, UPPER), (1, UPPER), (2, UPPER)]),
        (2.5, [(0, LOWER), (2, UPPER)]),
        (3.5, [(0, LOWER), (1, LOWER), (2, LOWER), (2, UPPER)]),
        (4.5, [(2, LOWER), (2, UPPER)]),
    ):
        found = crossings(made, gamma)
        assert (found, gamma) == (expected, gamma)


@pytest.mark.parametrize("gamma", [1e-3, 0.1, 10.0])
def test_levels_without_any_breakpoint_are_passed_where_the_exact_roots_are(gamma):
    """Without stiffness and damping of the suspension both rise from nothing to infinity."""
    parameters = OscillatorParameters.from_nondimensional(0.05, 0.5, 0.0, 0.0, gamma)
    assert levels(parameters.nondimensional(1.0)).X == (0.0, np.inf)
    expected = exact_folds(parameters.nondimensional(1.0))
    found = [(2 * np.pi * fold.frequency / parameters.omega_s, fold.kind) for fold in folds(parameters, 1.0)]
    assert [kind for _, kind in found] == [kind for _, kind in expected]
    np.testing.assert_allclose([Omega for Omega, _ in found], [Omega for Omega, _ in expected], rtol=1e-12)
