"""Kicks: the impulse that a held, harmonic or tapping force gives in each half step around a kick."""

import numpy as np
import pytest
from scipy.integrate import quad

from rigsim.model.excitation import CosineForce, HeldForce, Tap, TapForce

SAMPLES = np.array([1.0, -2.0, 4.0, 3.0])
SUBSTEPS = 5


def held(hold, t):
    """The force at time t in sample intervals, last value kept."""
    k = min(int(np.floor(t + 1e-12)), 3)
    ahead = SAMPLES[min(k + 1, 3)]
    return SAMPLES[k] if hold == "zero" else SAMPLES[k] + (ahead - SAMPLES[k]) * (t - k)


@pytest.mark.parametrize("hold", ["zero", "linear"])
def test_held_kicks_are_the_mean_of_left_and_right_values(hold):
    kicks = HeldForce(SAMPLES, SUBSTEPS, hold).kicks(0, 20)[:, 0]
    for k, kick in enumerate(kicks):
        sides = [held(hold, max(k / SUBSTEPS - 1e-9, 0)), held(hold, k / SUBSTEPS + 1e-9)]
        assert kick == pytest.approx(np.mean(sides), abs=1e-7)


@pytest.mark.parametrize("hold", ["zero", "linear"])
def test_held_impulse_of_the_trapezoid_is_exact(hold):
    kicks = HeldForce(SAMPLES, SUBSTEPS, hold).kicks(0, 16)[:, 0]
    kicks[0] /= 2
    kicks[-1] /= 2
    # up to the instant of the last sample; a jump there counts by its left half only
    jump = (SAMPLES[3] - SAMPLES[2]) / 4 if hold == "zero" else 0
    expected = sum(quad(lambda t: held(hold, t), k, k + 1 - 1e-9)[0] for k in range(3))
    assert kicks.sum() / SUBSTEPS - jump / SUBSTEPS == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("hold", ["zero", "linear"])
def test_kicks_do_not_depend_on_where_blocks_are_cut(hold):
    force = HeldForce(np.random.default_rng(1).normal(size=30), 7, hold)
    pieces = [force.kicks(first, 35) for first in range(0, 210, 35)]
    np.testing.assert_array_equal(np.concatenate(pieces), force.kicks(0, 210))


def test_cosine_kicks():
    force = CosineForce(np.array([2.0, 3.0]), np.array([10.0, 0.5]), 1e-3)
    t = 1e-3 * np.arange(40, 50)[:, None]
    expected = np.hstack([2 * np.cos(20 * np.pi * t), 3 * np.cos(np.pi * t)])
    np.testing.assert_allclose(force.kicks(40, 10), expected, atol=1e-13)


@pytest.mark.parametrize("velocity", [0.5, -0.3])
def test_impulse_of_a_tap_is_mass_times_velocity(velocity):
    tap = Tap(velocity, duration=3e-3, time=0.2)
    impulse, _ = quad(lambda t: float(tap.force(0.7, t)), 0.2, 0.203)
    assert impulse == pytest.approx(0.7 * velocity, rel=1e-12)
    assert not tap.force(0.7, np.array([0.0, 0.1999, 0.2031, 1.0])).any()
    assert tap.force(0.7, 0.2015) == pytest.approx(0.7 * velocity * np.pi / 6e-3)


def test_impulse_of_a_taps_kicks_converges_at_second_order():
    errors = []
    for step in (1e-4, 5e-5, 2.5e-5):
        taps = TapForce((None, Tap(0.5, 2e-3, 0.1)), np.array([1.0, 0.3]), step)
        kicks = np.concatenate([taps.kicks(first, 100) for first in range(0, 5000, 100)])
        assert not kicks[:, 0].any()
        errors.append(kicks[:, 1].sum() * step / (0.3 * 0.5) - 1)
    assert abs(errors[1]) < 6e-4
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 4, rtol=0.01)


@pytest.mark.parametrize("begin", [0.0093, 0.00999, 0.01, 0.0112, 0.0081])
def test_a_tap_s_kicks_do_not_depend_on_where_blocks_are_cut(begin):
    """Taps that begin before a border and end behind it, and one as long as two blocks."""
    taps = TapForce((Tap(0.5, 2e-3, begin), Tap(-0.2, 0.02, begin)), np.array([1.0, 0.3]), 1e-4)
    pieces = np.concatenate([taps.kicks(first, 100) for first in range(0, 400, 100)])
    np.testing.assert_array_equal(pieces, taps.kicks(0, 400))
    impulses = pieces.sum(axis=0) * 1e-4 / (taps.mass * [0.5, -0.2])
    np.testing.assert_allclose(impulses, 1, rtol=3e-3)


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ({"velocity": np.nan}, "tap velocity = nan m/s"),
        ({"duration": 0}, "tap duration = 0 s"),
        ({"time": -1}, "tap time = -1 s"),
        ({"velocity": "fast"}, "tap velocity = 'fast'"),
    ],
)
def test_bad_taps_are_named(values, named):
    with pytest.raises(ValueError, match=named):
        Tap(**values)
