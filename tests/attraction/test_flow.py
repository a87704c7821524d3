"""The flow map against SciPy, against itself at other steps, and against neighbours that must not matter."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rigsim import OscillatorParameters, RigParameters
from rigsim.attraction.flow import Flow, accurate_flow
from rigsim.model.excitation import Tap
from rigsim.model.oscillator import matrices
from rigsim.model.wires import suspension_force

RIG = RigParameters()
STATES = np.array([[1e-4, -2e-3, 0.05, 0.3], [-3e-4, 1e-3, 0.1, -0.5], [0.0, 0.0, 0.0, 0.0]])
SCALE = np.array([1e-3, 1e-3, 0.2, 0.2])


def referee(state, law, force, frequency, span, tap=None):
    """Eqs. (3a, b) over [xs, x] with the matrices and the force law of the model room, by SciPy."""
    mass, damping, stiffness = matrices(RIG)
    stiffness = stiffness - RIG.k1 * np.array([[1, -1], [-1, 1]])

    def rate(t, y):
        q, v = y[:2], y[2:]
        r = suspension_force(q[0] - q[1], RIG, law)
        push = np.array([force * np.cos(2 * np.pi * frequency * t) - r, r])
        if tap is not None:
            push[1] += tap.force(RIG.m, t)
        return np.concatenate([v, np.linalg.solve(mass, push - damping @ v - stiffness @ q)])

    xs, z, us, uz = state
    # Pieces that begin and end with the pulse, so that no step jumps over it.
    cuts = [span[0], *([] if tap is None else [tap.time, tap.time + tap.duration]), span[1]]
    y = np.array([xs, xs - z, us, us - uz])
    for low, high in zip(cuts, cuts[1:], strict=False):
        y = solve_ivp(rate, (low, high), y, method="DOP853", rtol=1e-11, atol=1e-15).y[:, -1]
    return np.array([y[0], y[0] - y[1], y[2], y[2] - y[3]])


@pytest.mark.parametrize("law", ["exact", "cubic"])
def test_flow_agrees_with_scipy(law):
    flow = Flow(RIG, law, 3.18, 30.0, 64)
    found = flow.advance(STATES, 3)
    wanted = [referee(state, law, 3.18, 30.0, (0, 0.1)) for state in STATES]
    np.testing.assert_allclose(found / SCALE, wanted / SCALE, atol=1e-8)


def test_order_is_eight():
    exact = Flow(RIG, "exact", 3.18, 30.0, 400).advance(STATES)
    errors = [
        np.abs((Flow(RIG, "exact", 3.18, 30.0, steps).advance(STATES) - exact) / SCALE).max() for steps in (20, 40)
    ]
    assert 2**7 < errors[0] / errors[1] < 2**10


def test_neighbours_do_not_matter():
    generator = np.random.default_rng(3)
    states = generator.uniform(-1, 1, (203, 4)) * SCALE
    flow = Flow(RIG, "exact", 3.18, 30.0, 30)
    together = flow.advance(states, 2)
    apart = np.concatenate([flow.advance(states[i : i + 1], 2) for i in range(0, 203, 7)])
    assert np.array_equal(together[::7], apart)


def test_parts_of_a_period_join():
    flow = Flow(RIG, "exact", 3.18, 30.0, 60)
    parts = flow.advance(flow.advance(STATES, 0.37), 0.63, start=0.37)
    np.testing.assert_allclose(parts / SCALE, flow.advance(STATES) / SCALE, atol=1e-8)
    trace = flow.trace(STATES, 2, 16)
    assert np.array_equal(trace[:, 0], STATES)
    np.testing.assert_allclose(trace[:, 24] / SCALE, flow.advance(STATES, 1.5) / SCALE, atol=1e-8)


@pytest.mark.parametrize(
    ("start", "duration", "expected"), [(0.1, 2e-3, 1), (0.97, 2e-3, 2), (0.1, 40e-3, 2), (0.97, 2e-5, 1)]
)
def test_tap_is_that_of_the_rig(start, duration, expected):
    """Short or longer than a period, and across the end of one."""
    flow = Flow(RIG, "exact", 3.18, 30.0, 60)
    found, periods = flow.tapped(STATES[0], start, [0.0, 0.5], duration)
    assert periods == expected
    for state, velocity in zip(found, (0.0, 0.5), strict=True):
        wanted = referee(STATES[0], "exact", 3.18, 30.0, (0, periods / 30), Tap(velocity, duration, start / 30))
        np.testing.assert_allclose(state / SCALE, wanted / SCALE, atol=1e-8)


def test_steps_are_as_few_as_accuracy_allows():
    states = STATES * 3
    flow = accurate_flow(RIG, "exact", 3.18, 30.0, states, SCALE, 1e-6)
    exact = flow.refined(8).advance(states)
    assert np.abs((flow.advance(states) - exact) / SCALE).max() < 1e-6
    assert np.abs((Flow(RIG, "exact", 3.18, 30.0, flow.steps // 2).advance(states) - exact) / SCALE).max() > 1e-6


def test_bad_input_is_named():
    with pytest.raises(ValueError, match="no wires"):
        Flow(OscillatorParameters(1, 1, 0.1, 0.1, 0.01, 1, 1), "exact", 1.0, 1.0, 20)
    with pytest.raises(ValueError, match="law = 'linear'"):
        Flow(RIG, "linear", 1.0, 1.0, 20)
    with pytest.raises(ValueError, match="force = 0 N"):
        Flow(RIG, "cubic", 0, 1.0, 20)
    with pytest.raises(ValueError, match="smaller box"):
        accurate_flow(RIG, "cubic", 3.18, 1.0, 1e3 * STATES, SCALE)
