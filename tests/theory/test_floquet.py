"""Floquet multipliers about the single-term orbit against direct integration and Liouville's formula."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from rigsim.parameters import OscillatorParameters, RigParameters
from rigsim.theory.amplitude import frequency_response
from rigsim.theory.floquet import runs_of


def _monodromy(oscillator, frequency, relative):
    """Map of (xs, x, xs', x') over a forcing period, in SI, about z(t) = Re(relative exp(i omega t))."""
    o, w = oscillator, 2 * np.pi * frequency

    def variation(t, flat):
        xs, x, vs, v = flat.reshape(4, 4)
        z = (relative * np.exp(1j * w * t)).real
        spring = o.c * (vs - v) + (o.k1 + 3 * o.k3 * z**2) * (xs - x)
        return np.concatenate([vs, v, -(o.cs * vs + o.ks * xs + spring) / o.ms, spring / o.m])

    run = solve_ivp(variation, (0, 1 / frequency), np.eye(4).ravel(), method="DOP853", rtol=1e-12, atol=1e-12)
    return run.y[:, -1].reshape(4, 4)


def test_multipliers_are_those_of_the_integrated_variational_equation():
    rig = RigParameters()
    response = frequency_response(rig, 3.18, [12.0, 24.0, 45.0, 66.0, 80.0])
    for i, j in zip(*np.nonzero(np.isfinite(response.relative)), strict=True):
        scale = np.diag([1, 1, 300, 300])  # speeds in units comparable with displacements
        matrix = _monodromy(rig.oscillator, response.frequency[i], response.relative[i, j])
        expected = np.linalg.eigvals(np.linalg.inv(scale) @ matrix @ scale)
        for value in response.multipliers[i, j]:
            assert abs(expected - value).min() < 1e-8
        assert response.stable[i, j] == (abs(expected).max() < 1)


def test_the_middle_solution_of_the_paper_is_unstable_and_the_outer_two_are_stable_at_30_hz():
    response = frequency_response(RigParameters(), 3.18, [30.0])
    assert response.stable.tolist() == [[True, False, True]]


@settings(deadline=None, max_examples=150, derandomize=True)
@given(st.floats(-3, 0), st.floats(-3, -0.7), st.floats(-3, -0.7), st.floats(0, 2), st.floats(-4, 1), st.floats(0.3, 3))
def test_the_product_of_the_multipliers_is_liouvilles(mu, zeta_s, zeta, Omega0, gamma, Omega):
    parameters = OscillatorParameters.from_nondimensional(10**mu, 10**zeta_s, 10**zeta, Omega0, 10**gamma)
    response = frequency_response(parameters, 1.0, [Omega / (2 * np.pi)])
    trace = -(parameters.cs / parameters.ms + parameters.c / parameters.m * (1 + 10**mu))
    expected = np.exp(trace * 2 * np.pi / Omega)
    for values in response.multipliers[0, : response.count[0]]:
        # The smallest multipliers carry the rounding of the largest.
        tolerance = 1e-9 * max(1.0, abs(values[0])) * max(1.0, abs(values[:3]).prod())
        assert abs(values.prod() - expected) <= 1e-9 * expected + tolerance


def test_runs_of_equal_stability_meet_at_the_first_point_of_the_next():
    assert runs_of(np.array([True, True, False, True, True])) == (
        (slice(0, 3), True),
        (slice(2, 4), False),
        (slice(3, 6), True),
    )
    assert runs_of(np.array([False])) == ((slice(0, 2), False),)
