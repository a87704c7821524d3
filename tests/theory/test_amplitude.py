"""The single-term response against Eqs. (5a, b) as printed and against the equations of motion in time."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from rigsim.parameters import OscillatorParameters, RigParameters
from rigsim.theory.amplitude import frequency_response

FORCE = 3.18


def printed_coefficients(group, Omega):
    """a, b, c, d, e, g, h of Eqs. (6a-g)."""
    mu, zeta_s, zeta, Omega0, gamma = group.mu, group.zeta_s, group.zeta, group.Omega0, group.gamma
    X = Omega**2
    shaker, oscillator = 1 - X * (1 + mu), Omega0**2 - X
    e = shaker**2 + 4 * zeta_s**2 * X
    g = 1.5 * mu * gamma * shaker
    h = 2 * mu * shaker * oscillator - mu**2 * X**2 - 8 * mu * zeta_s * zeta * X
    a = np.full_like(X, 9 * gamma**2 / 16)
    b = 1.5 * gamma * oscillator - g * X**2 / e
    c = oscillator**2 + 4 * zeta**2 * X - h * X**2 / e
    return a, b, c, -(X**2) / e, e, g, h


def nondimensional_amplitudes(response):
    unit = response.force / response.parameters.ks
    return abs(response.relative) / unit, abs(response.shaker) / unit


def test_solutions_are_the_positive_roots_of_equation_5a():
    response = frequency_response(RigParameters(), FORCE, np.linspace(10, 80, 701))
    group = RigParameters().nondimensional(FORCE)
    Omega = 2 * np.pi * response.frequency / response.parameters.omega_s
    coefficients = np.array(printed_coefficients(group, Omega)[:4]).T
    W, _ = nondimensional_amplitudes(response)
    for row, count, amplitudes in zip(coefficients, response.count, W, strict=True):
        roots = np.roots(row)
        squares = np.sort(roots.real[(abs(roots.imag) < 1e-9 * abs(roots)) & (roots.real > 0)])
        np.testing.assert_allclose(amplitudes[:count] ** 2, squares, rtol=1e-9)
        assert np.isnan(amplitudes[count:]).all()


@settings(deadline=None, max_examples=200, derandomize=True)
@given(
    st.floats(-4, 0), st.floats(-4, -0.3), st.floats(-4, -0.3), st.floats(0, 2), st.floats(-6, 2), st.floats(0.05, 3)
)
def test_any_solution_satisfies_equations_5a_and_5b(mu, zeta_s, zeta, Omega0, gamma, Omega):
    parameters = OscillatorParameters.from_nondimensional(10**mu, 10**zeta_s, 10**zeta, Omega0, 10**gamma)
    response = frequency_response(parameters, 1.0, [Omega / (2 * np.pi)])
    a, b, c, d, e, g, h = (float(v[0]) for v in printed_coefficients(parameters.nondimensional(1.0), np.array([Omega])))
    W, Ys = (values[0, : response.count[0]] for values in nondimensional_amplitudes(response))
    # The printed coefficients cancel, so the residual is judged against the terms before cancellation.
    size = a * W**6 + 1.5 * 10**gamma * (Omega0**2 + Omega**2) * W**4 + abs(g) * Omega**4 / e * W**4
    size += (Omega0**2 + Omega**2) ** 2 * W**2 + abs(h) * Omega**4 / e * W**2 + abs(c) * W**2 + abs(d)
    assert (abs(a * W**6 + b * W**4 + c * W**2 + d) <= 1e-12 * size).all()
    size = 1 + abs(g) * W**4 + 4 * 10**mu * (1 + Omega**2) * (Omega0**2 + Omega**2) * (1 + 10**mu) * W**2
    size += 10 ** (2 * mu) * Omega**4 * W**2 + abs(h) * W**2
    assert (abs(Ys**2 * e - (1 + g * W**4 + h * W**2)) <= 1e-11 * size).all()


def test_a_slow_force_bends_the_shaker_s_spring_alone():
    rig = RigParameters()
    response = frequency_response(rig, FORCE, [1e-3])
    assert response.shaker[0, 0] == pytest.approx(FORCE / rig.ks, rel=1e-4) and abs(response.relative[0, 0]) < 1e-9


def test_phases_and_amplitudes_satisfy_the_harmonic_balance_of_equations_3():
    rig = RigParameters()
    response = frequency_response(rig, FORCE, [15.0, 30.0, 50.0])
    w = 2 * np.pi * response.frequency[:, None]
    z, xs, x = response.relative, response.shaker, response.mass
    spring = (rig.k1 + 1j * w * rig.c + 0.75 * rig.k3 * abs(z) ** 2) * z
    here = np.isfinite(z)
    np.testing.assert_allclose((z - xs + x)[here], 0, atol=1e-18)
    np.testing.assert_allclose(((rig.ks - w**2 * rig.ms + 1j * w * rig.cs) * xs + spring)[here], FORCE, rtol=1e-12)
    np.testing.assert_allclose((-(w**2) * rig.m * x)[here], spring[here], rtol=1e-11)


def _steady_motion(rig, frequency, xs, x, periods=200):
    """First-harmonic amplitudes of Eqs. (3a, b) integrated from a state of the orbit (xs, x complex)."""
    w = 2 * np.pi * frequency

    def motion(t, state):
        xs, x, vs, v = state
        z, vz = xs - x, vs - v
        spring = rig.c * vz + rig.k1 * z + rig.k3 * z**3
        return [vs, v, (FORCE * np.cos(w * t) - rig.cs * vs - rig.ks * xs - spring) / rig.ms, spring / rig.m]

    start = [xs.real, x.real, (1j * w * xs).real, (1j * w * x).real]
    period = 1 / frequency
    time = (periods - 10) * period + np.arange(10 * 64) * period / 64
    run = solve_ivp(motion, (0, periods * period), start, method="DOP853", rtol=1e-9, atol=1e-12, t_eval=time)
    return 2 * (run.y[:2] * np.exp(-1j * w * time)).mean(axis=1)


@pytest.mark.parametrize(("frequency", "which", "error"), [(30.0, 0, 0.005), (45.0, 2, 0.03), (70.0, 0, 0.005)])
def test_single_term_theory_is_near_the_motion_in_time(frequency, which, error):
    rig = RigParameters()
    response = frequency_response(rig, FORCE, [frequency])
    assert response.stable[0, which]
    predicted = response.shaker[0, which], response.mass[0, which]
    found = _steady_motion(rig, frequency, *predicted)
    np.testing.assert_allclose(abs(found), np.abs(predicted), rtol=error)


def test_without_nonlinearity_it_is_the_receptance():
    oscillator = RigParameters().oscillator.replace(k3=0.0)
    response = frequency_response(oscillator, 2.0, [8.0, 11.7, 55.0])
    w = 2 * np.pi * response.frequency
    for i, value in enumerate(w):
        coupling = oscillator.k1 + 1j * value * oscillator.c
        shaker = oscillator.ks + 1j * value * oscillator.cs - value**2 * oscillator.ms
        matrix = [[shaker + coupling, -coupling], [-coupling, coupling - value**2 * oscillator.m]]
        xs, x = np.linalg.solve(matrix, [2.0, 0.0])
        np.testing.assert_allclose([response.shaker[i, 0], response.mass[i, 0]], [xs, x], rtol=1e-12)
    assert (response.count == 1).all() and response.stable[:, 0].all()


@pytest.mark.parametrize("change", [{"k1": 0.0}, {"c": 0.0}, {"cs": 0.0}, {"c": 0.0, "cs": 0.0}])
def test_limits_of_the_parameters_work(change):
    oscillator = RigParameters().oscillator.replace(**change)
    response = frequency_response(oscillator, FORCE, np.linspace(1, 120, 500))
    assert np.isfinite(response.relative[:, 0]).all() and (response.count >= 1).all()
    assert np.isfinite(response.multipliers[:, 0]).all()


def test_low_solution_keeps_its_relative_accuracy_under_a_tiny_force():
    linear = frequency_response(RigParameters().oscillator.replace(k3=0.0), 1e-7, [20.0])
    response = frequency_response(RigParameters(), 1e-7, [20.0])
    np.testing.assert_allclose(response.relative[0, 0], linear.relative[0, 0], rtol=1e-11)


@pytest.mark.parametrize(
    ("force", "frequency", "message"),
    [(0.0, [10.0], "force = 0 N"), (np.nan, [10.0], "force = nan"), (1.0, [10.0, 0.0], r"frequency\[1\] = 0 Hz")],
)
def test_bad_input_is_named(force, frequency, message):
    with pytest.raises(ValueError, match=message):
        frequency_response(RigParameters(), force, frequency)
    with pytest.raises(ValueError, match="parameters"):
        frequency_response(None, 1.0, [10.0])


def test_an_undamped_linear_resonance_is_refused():
    oscillator = OscillatorParameters(ms=1.0, ks=1.0, cs=0.0, m=1.0, c=0.0, k1=0.0, k3=0.0)
    with pytest.raises(ValueError, match="undamped linear system resonates"):
        frequency_response(oscillator, 1.0, [1 / (2 * np.pi)])


def test_it_shows_itself():
    response = frequency_response(RigParameters(), FORCE, np.linspace(10, 120, 111))
    assert repr(response).startswith(
        "FrequencyResponse: 111 frequencies from 10 to 120 Hz at 3.18 N, three solutions at"
    )
    assert response.table()["piece"].tolist() == ["main", "inner"] and "inner" in response._repr_html_()
    undamped = frequency_response(RigParameters().oscillator.replace(cs=0.0), FORCE, [20.0])
    assert undamped.table() is None
    with pytest.raises(ValueError, match="cs = 0 N s/m"):
        undamped.pieces  # noqa: B018
