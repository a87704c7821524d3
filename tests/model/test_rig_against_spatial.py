"""The planar rig against the three-dimensional one, its equations written separately, integrated at eighth order."""

import numpy as np
import pytest

from rigsim.experiment.random_test import simulate
from rigsim.experiment.sine_test import sine_test
from rigsim.model.excitation import Tap
from rigsim.model.planar import linear_modes, static_equilibrium
from rigsim.parameters import RigParameters
from rigsim.results import Status
from tests.model import refereed as referee

FORCE = 3.18
TWO_SETS = RigParameters()
ONE_SET = TWO_SETS.single_set()
RIGS = {"two sets": TWO_SETS, "one set": ONE_SET}
# settled from rest and after the tap alike, on different branches at all but 56 Hz
FREQUENCY = np.array([40.0, 46.0, 50.0, 56.0, 60.0])
TAPS = pytest.mark.parametrize("tap", [None, Tap()], ids=["from rest", "tapped"])
HOLDS = pytest.mark.parametrize("hold", ["zero", "linear"])


def referee_amplitudes(parameters, frequency, tap):
    """Complex xs, x, z (3, n) of the referee."""
    amplitudes = []
    for f in frequency:
        t, *displacements, _ = referee.simulate_sine(parameters, FORCE, f, tap=tap)
        amplitudes.append([referee.fourier(t, u, f) for u in displacements])
    return np.transpose(amplitudes)


def assert_fundamentals_agree(parameters, frequency, tap, tolerance=1e-3):
    test = sine_test(parameters, FORCE, frequency, tap=tap)
    assert list(test.status) == [Status.SETTLED] * len(frequency)
    expected = referee_amplitudes(parameters, frequency, tap)
    for name, wanted in zip(("shaker", "mass", "relative"), expected, strict=True):
        error = np.abs(getattr(test, name) - wanted) / np.abs(wanted)
        assert error.max() < tolerance, f"{name}: {error}"
    return expected


@TAPS
def test_fundamentals_agree_within_a_thousandth(tap):
    assert_fundamentals_agree(TWO_SETS, FREQUENCY, tap)


def test_motion_through_a_tap_converges_at_second_order():
    step, frequency, tap = 2.5e-5, 40.0, Tap()
    t, *_, z, _ = referee.simulate_sine(TWO_SETS, FORCE, frequency, tap.time + 0.5, tap, step=step)
    errors = []
    for rig_step in (5e-5, 2.5e-5, 1.25e-5):
        test = sine_test(TWO_SETS, FORCE, frequency, tap=tap, duration=tap.time + 0.5, step=rig_step)
        sample = np.rint((test.time - t[0]) / step).astype(int)
        np.testing.assert_allclose(t[sample], test.time, rtol=0, atol=1e-12)
        errors.append(np.abs(test.record(0).relative - z[sample]).max() / np.abs(z).max())
    assert errors[0] < 1e-3
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 4, rtol=0.02)


def test_the_frequencies_reach_both_branches():
    low, high = (np.abs(referee_amplitudes(TWO_SETS, FREQUENCY[[0, 2, 4]], tap)[2]) for tap in (None, Tap()))
    assert np.all(high > 2 * low)


@pytest.mark.full
@TAPS
def test_fundamentals_agree_wherever_both_settle(tap):
    frequency = [36.0, 43.0, 52.0, 54.0, 58.0]
    assert_fundamentals_agree(TWO_SETS, frequency, tap)


@pytest.mark.full
def test_fundamentals_of_one_set_agree():
    assert_fundamentals_agree(ONE_SET, [36.0, 40.0, 43.0, 46.0, 50.0], Tap())


ROCKING = ONE_SET.replace(rocking_damping=1e-5)


@pytest.mark.full
@pytest.mark.parametrize(
    ("parameters", "frequency", "tap"),
    [(TWO_SETS, FREQUENCY, None), (TWO_SETS, FREQUENCY, Tap()), (ROCKING, np.array([40.0, 50.0, 56.0, 60.0]), Tap())],
    ids=["two sets from rest", "two sets tapped", "one set tapped"],
)
def test_settled_fundamentals_converge_at_second_order(parameters, frequency, tap):
    """One set as it is rocks on after a tap: at 60 Hz its phase is lost after 3 s, and no step gets below 3e-4."""
    expected = referee_amplitudes(parameters, frequency, tap)[2]
    errors = []
    for step in (5e-5, 2.5e-5):
        found = sine_test(parameters, FORCE, frequency, tap=tap, step=step).relative
        errors.append(np.abs(found - expected) / np.abs(expected))
    assert errors[0].max() < 1e-3
    assert errors[1].max() < 3e-4
    np.testing.assert_allclose(errors[0] / errors[1], 4, rtol=0.1)


def largest_errors(parameters, hold, start, channel="relative", duration=0.5, sample_rate=2000.0):
    """Largest difference of a channel over its rms, for steps halved twice."""
    force = np.random.default_rng(2014).normal(0, 1.115, round(duration * sample_rate))
    traces = referee.simulate_held(parameters, force, sample_rate, hold, start, step=2.5e-5)
    expected = dict(zip(("shaker", "mass", "relative", "tilt"), traces, strict=True))[channel]
    records = (simulate(parameters, force, sample_rate, hold, start, step) for step in (5e-5, 2.5e-5, 1.25e-5))
    errors = [np.abs(getattr(record, channel) - expected).max() for record in records]
    return np.array(errors) / np.sqrt(np.mean(expected**2))


@pytest.mark.full
def test_a_random_record_is_right_to_a_few_parts_in_ten_thousand():
    force = np.random.default_rng(2014).normal(0, 1.115, 20_000)
    record = simulate(TWO_SETS, force, 2000.0)
    traces = referee.simulate_held(TWO_SETS, force, 2000.0, "zero", "equilibrium", step=2.5e-5)
    for name, expected in zip(("shaker", "mass", "relative"), traces, strict=False):
        assert np.std(getattr(record, name) - expected) < 2e-4 * np.std(expected)


@HOLDS
def test_held_random_force_converges_at_second_order(hold):
    errors = largest_errors(TWO_SETS, hold, "equilibrium")
    assert errors[0] < 5e-4
    np.testing.assert_allclose(errors[:-1] / errors[1:], 4, rtol=0.01)


@pytest.mark.parametrize("channel", ["shaker", "mass", "relative", "tilt"])
@pytest.mark.parametrize("sets", [1, 2])
def test_every_parameter_acts_as_in_three_dimensions(sets, channel):
    """Unequal wires, an offset the other way, close sets, gravity on the Moon, damped wires and rocking."""
    parameters = RigParameters(
        k=tuple(np.linspace(3e4, 5e4, 4 * sets)),
        LG=-0.002,
        wire_sets=sets,
        set_half_spacing=0.002 if sets == 2 else None,
        gravity=1.62,
        wire_damping=3.0,
        rocking_damping=1e-5,
    )
    errors = largest_errors(parameters, "linear", "equilibrium", channel)
    assert errors[0] < 1e-3
    np.testing.assert_allclose(errors[:-1] / errors[1:], 4, rtol=0.02)


@pytest.mark.parametrize("channel", ["relative", "tilt"])
@pytest.mark.parametrize("sets", [1, 2])
def test_sets_off_P_act_as_in_three_dimensions(sets, channel):
    """Their middle on the cylinder's own, so that two sets hold its ends, or on the far side of P, loosely guided."""
    for centre in (TWO_SETS.LG, -0.004):
        parameters = RigParameters(wire_sets=sets, set_centre=centre, wire_damping=3.0, rocking_damping=1e-5)
        errors = largest_errors(parameters, "linear", "equilibrium", channel)
        assert errors[0] < 1e-3
        np.testing.assert_allclose(errors[:-1] / errors[1:], 4, rtol=0.02)


def test_slack_wires_let_go_as_in_three_dimensions():
    # Without pretension the sag alone leaves the lower wires slack, and z changes by half.
    slack = TWO_SETS.replace(d0=TWO_SETS.d, wire_damping=2.0, tension_only=True)
    assert largest_errors(slack, "zero", "rest")[0] < 5e-4


OFF_P = {f"{name}, middle at {centre} m": rig.replace(set_centre=centre) for name, rig in RIGS.items()
         for centre in (0.002, -0.001)}  # fmt: skip


@pytest.mark.parametrize("parameters", (RIGS | OFF_P).values(), ids=RIGS | OFF_P)
def test_statics_and_modes_agree(parameters):
    undamped = parameters.replace(c=0, cs=0)
    expected = referee.static_equilibrium(undamped)
    found = static_equilibrium(undamped)
    np.testing.assert_allclose(found.coordinates, expected, rtol=1e-9, atol=1e-15)
    assert found.sag == pytest.approx(parameters.LG * np.sin(expected[3]) - expected[2], rel=1e-9)
    np.testing.assert_allclose(np.sort(linear_modes(undamped).frequency), referee.linear_modes(undamped)[0], rtol=1e-7)


@pytest.mark.full
@HOLDS
@pytest.mark.parametrize("parameters", RIGS.values(), ids=RIGS)
@pytest.mark.parametrize("start", ["rest", "equilibrium"])
def test_either_rig_converges_at_second_order(parameters, start, hold):
    # From rest the bounce mode (about 1 kHz) rings for ever unless damped, and its phase is lost at these steps.
    damping = 2.0 if start == "rest" else 0.0
    errors = largest_errors(parameters.replace(wire_damping=damping), hold, start)
    np.testing.assert_allclose(errors[:-1] / errors[1:], 4, rtol=0.02)
    assert largest_errors(parameters, hold, start)[0] < 1e-3
