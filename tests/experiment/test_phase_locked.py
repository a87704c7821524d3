"""Phase-locked tests: resonance of the linear modes, and the backbone of the rig against harmonic balance."""

import numpy as np
import pytest

from rigsim import continue_orbit, oscillator_modes, phase_locked_test
from rigsim.experiment.feedback.balance import phase_slope, single_term
from rigsim.parameters import RigParameters
from rigsim.results import Status

RIG = RigParameters()
MODEL = RIG.oscillator


def test_a_weak_force_finds_the_frequency_of_the_phase_of_the_linear_model():
    test = phase_locked_test(RIG, 0.02, [90.0, 60.0])
    assert [one.status for one in test] == [Status.HELD] * 2
    near = np.linspace(11, 13, 4001)
    phases = -np.degrees([np.angle(single_term(MODEL, f)[0]) for f in near])
    for one in test:
        expected = np.interp(-one.phase, -phases, near)  # it falls with frequency
        assert one.frequency == pytest.approx(expected, abs=0.02)
        assert np.degrees(np.angle(one.relative)) == pytest.approx(one.phase, abs=1)
        assert one.relative == pytest.approx(one.shaker - one.mass)
    assert test[0].frequency == pytest.approx(oscillator_modes(MODEL).frequency[0], abs=0.05)
    assert test.bench_time >= 3 and "2 held" in test.summary() and len(test.table()) == 2


def test_the_slope_of_the_phase_is_that_of_a_damped_mass():
    """At resonance the phase of a mass on a spring falls by 2 m/c a radian a second; the shaker changes it a little."""
    frequency = oscillator_modes(MODEL).frequency[0]
    expected = -2 * np.pi * 2 * MODEL.m / MODEL.c
    assert phase_slope(MODEL, frequency, 0.0) == pytest.approx(expected, rel=0.1)


def test_a_motion_that_a_phase_has_is_that_of_harmonic_balance():
    """At -40 degrees from rest, step by step to 3.18 N: the low motion of the detached curve."""
    test = phase_locked_test(RIG, [1.0, 2.0, 3.18], -40.0, 49.0)
    assert [one.status for one in test] == [Status.HELD] * 3
    one = test[-1]
    orbit = continue_orbit(RIG, 3.18, one.frequency, [0, one.relative], band=(49, 51.5))
    i = int(np.argmin(abs(orbit.frequency - one.frequency)))
    f, z = orbit.frequency[i - 1 : i + 2], orbit.relative[i - 1 : i + 2, 1]
    order = np.argsort(f)
    assert abs(one.relative) == pytest.approx(np.interp(one.frequency, f[order], abs(z)[order]), rel=0.01)
    assert orbit.stable[i] and abs(one.error) < 1


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"phase": [1.0, 2.0, 3.0]}, "phase has 3 elements; expected 1 or 2"),
        ({"frequency": 300.0}, "frequency = 300 Hz"),
        ({"signal": "force"}, "signal"),
        ({"patience": 0.1}, "patience"),
        ({"force": [1.0, 0.0]}, r"force\[1\] = 0 N"),
    ],
)
def test_arguments_that_are_not_allowed(change, words):
    with pytest.raises(ValueError, match=words):
        phase_locked_test(**{"parameters": RIG, "force": [1.0, 2.0]} | change)


@pytest.mark.full
def test_phase_resonance_from_rest_climbs_the_main_curve_and_passes_the_detached_one(tell):
    test = phase_locked_test(RIG, [0.05, 0.1, 0.3, 0.5, 0.7, 1.0, 1.8, 3.18])
    assert all(one.status is Status.HELD for one in test)
    assert (np.diff(test.frequency) > 0).all()
    last = test[-1]
    orbit = continue_orbit(RIG, 3.18, last.frequency, [0, last.relative], band=(50, 54))
    phase = np.degrees(np.angle(orbit.relative[:, 1]))
    order = np.argsort(-phase)
    expected = np.interp(-90, -phase[order], orbit.frequency[order])
    assert last.frequency == pytest.approx(expected, abs=0.1)
    detached = continue_orbit(RIG, 3.18, 36.0, [0, 1.317e-3 * np.exp(-0.08j)])
    assert detached.closed
    least, most = (f(np.degrees(np.angle(detached.relative[:, 1]))) for f in (np.min, np.max))
    assert -70 < least < most < 10
    tell(
        f"phase resonance from rest: {last.frequency:.2f} Hz at 3.18 N, on the main curve ({expected:.2f} Hz); the "
        f"detached curve has phases of z from {least:.0f} to {most:.0f} degrees, and none at 90"
    )
