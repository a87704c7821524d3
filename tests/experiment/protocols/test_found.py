"""What tests on the bench find, against sine tests, converged orbits, and the folds of the exact law."""

import numpy as np
import pytest

from rigsim import (
    RigParameters,
    Tap,
    jump_frequencies,
    periodic_orbits,
    ramp_test,
    response_sheet,
    sine_test,
    stepped_test,
    swept_test,
    tapped_test,
)
from rigsim.orbits.shooting import shoot_orbit
from rigsim.results import Status

RIG = RigParameters()
FORCE = 3.18


def converged(point):
    """Line of z (m) of the converged orbit, exact law, that shooting leads to from a point's own state."""
    lines = np.array([point.shaker, point.mass])
    state = np.concatenate([lines.real, (2j * np.pi * point.frequency * lines).real])
    orbit = shoot_orbit(RIG, point.force, point.frequency, state, "exact")
    assert orbit.converged
    return orbit.relative[1]


def test_the_first_point_is_the_sine_test_to_the_last_bits():
    """A sine test of 3 s holds its two ends: a step more than a dwell of 3 s."""
    for sets in (RIG, RIG.single_set()):
        alone = sine_test(sets, FORCE, 30.0, start="equilibrium")
        point = stepped_test(sets, FORCE, [30.0, 31.0], dwell=3.0 + 5e-5, start="equilibrium")[0]
        for name in ("shaker", "mass", "relative", "tilt", "drift"):
            np.testing.assert_allclose(getattr(point, name), getattr(alone, name)[0], rtol=1e-9, err_msg=name)
        np.testing.assert_allclose(point.distortion, alone.distortion[0], rtol=1e-6)
        assert point.status == alone.status[0]


def test_a_settled_point_does_not_remember_how_it_was_come_to():
    """From rest, shaken for 12 s, or from the point before: the same line, its phase against the force included."""
    stepped = stepped_test(RIG, FORCE, [25.3, 26.7, 29.9])
    alone = sine_test(RIG, FORCE, stepped.frequency, duration=12)
    np.testing.assert_allclose(stepped.relative, alone.relative, rtol=1e-3)
    np.testing.assert_allclose(stepped.shaker, alone.shaker, rtol=1e-3)


def test_settled_points_are_converged_orbits():
    """Two sets, step 5e-5 s: within 0.1 % of shooting, and `left` says how near, but for the step's own error."""
    up = np.arange(12.0, 60.0, 4.0)
    for force in (1.0, FORCE):
        stepped = stepped_test(RIG, force, [up, up[::-1]])
        tapped = tapped_test(RIG, force, np.array([25.0, 35.0, 45.0])[:, None])
        settled = [point for point in (*stepped, *tapped) if point.status == Status.SETTLED]
        # At 1 N, from 48 to 52 Hz at once, the rig falls into a motion of two periods and keeps it to 56 Hz.
        assert len(settled) == (28 if force == 1.0 else 30)
        for point in settled:
            z = converged(point)
            assert abs(point.relative - z) < min(1e-3, point.left + 4e-4) * abs(z)


def test_jumps_of_stepped_tests_are_the_folds():
    """At 1 N the one curve has two folds; single-term theory puts them a few tenths of a hertz away."""
    exact = sorted(p.frequency for branch in periodic_orbits(RIG, 1.0) for p in branch.special_points)
    assert len(exact) == 2
    up, down = np.arange(49.0, 52.0, 0.1), np.arange(16.0, 13.9, -0.1)
    rises = stepped_test(RIG, 1.0, [np.r_[np.linspace(12, 48, 13), up]]).jumps
    falls = stepped_test(RIG, 1.0, [np.r_[np.linspace(60, 17, 12), down]]).jumps
    assert [(jump.amplitude, jump.sweep) for jump in (*rises, *falls)] == [("falls", "up"), ("rises", "down")]
    for jump, fold in zip((*falls, *rises), exact, strict=True):
        assert jump.half_width == pytest.approx(0.05)
        assert abs(jump.frequency - fold) < jump.half_width + 0.02
    one_term = jump_frequencies(RIG, 1.0)
    assert len(one_term) == 2 and 0.05 < max(abs(np.array(one_term) - exact)) < 0.8


def test_a_sweep_s_jump_comes_late_and_the_later_the_faster():
    """Downwards on the low branch at 1 N, past its fold."""
    fold = min(p.frequency for branch in periodic_orbits(RIG, 1.0) for p in branch.special_points)
    late = []
    for run in swept_test(RIG, 1.0, (18, 11), [0.04, 0.16, 0.64]).runs:
        (jump,) = run.jumps
        assert (jump.amplitude, jump.sweep) == ("rises", "down")
        late.append(fold - jump.frequency)
    assert 0 < late[0] < late[1] < late[2] < 1.5
    stepped = stepped_test(RIG, 1.0, np.r_[18.0, 16.0, np.arange(15.2, 14.2, -0.1)])
    assert abs(stepped.jumps[0].frequency - fold) < min(0.06, late[0])


def test_a_ramp_s_hysteresis_lies_between_the_folds_of_the_sheet():
    sheet = response_sheet(RIG, (20, 40), (0.1, 8.0))
    folds = []
    for line in (line for name, line in sheet.lines if name == "fold"):
        for i in np.flatnonzero(np.diff(np.sign(line.frequency - 30.0))):
            one, other = line.frequency[i : i + 2]
            folds.append(np.interp((30.0 - one) / (other - one), (0, 1), line.force[i : i + 2]))
    low, high = sorted(folds)
    up, down = np.arange(5.3, 5.5, 0.02), np.arange(0.56, 0.4, -0.02)
    levels = np.r_[0.4, np.linspace(1, 5, 5), up, np.linspace(5, 0.7, 6), down]
    stepped = ramp_test(RIG, levels, 30.0)
    ramped = ramp_test(RIG, [0.4, 6.0, 0.3], 30.0, 0.05)
    for test, early, late in ((stepped, 0.0, 0.03), (ramped, 0.0, 0.15)):
        up, down = test.jumps
        assert (up.amplitude, up.sweep, down.amplitude, down.sweep) == ("rises", "up", "falls", "down")
        assert -early - 0.03 < up.force - high < late + 0.03
        assert -late - 0.03 < down.force - low < early + 0.03


def test_a_tap_is_tried_at_four_phases_and_then_harder():
    test = tapped_test(RIG, FORCE, [[20.0], [40.0]], velocity=(0.02, 0.5))
    before, after = test.runs[0]
    assert before.tries == 0 and after.tries == 8 and after.message.startswith("the same motion after tap 8")
    assert abs(after.relative) == pytest.approx(abs(before.relative), rel=1e-3)  # the only motion there is
    taps = [drive for drive in test.drives[0] if drive.velocity]
    assert [drive.velocity for drive in taps] == [0.02] * 4 + [0.5] * 4
    phases = [float(drive.turned(drive.tapped) % 1) for drive in taps]
    np.testing.assert_allclose(np.exp(2j * np.pi * np.array(phases)), np.tile(1j ** np.arange(4), 2), atol=1e-9)
    before, after = test.runs[1]
    assert 4 < after.tries < 9 and abs(after.relative) > 3 * abs(before.relative) and after.velocity == 0.5


def test_a_point_that_never_settles_says_so_and_the_test_goes_on():
    """At 63 Hz the motion that came up from below is quasi-periodic."""
    test = stepped_test(RIG, FORCE, [56.0, 60.0, 62.0, 63.0, 64.0], limit=5.0)
    assert len(test) == 5
    assert test[3].status == Status.NOT_PERIODIC and test[3].dwell == 5.0 and test[2].status == Status.SETTLED
    slow = stepped_test(RIG, FORCE, [12.0, 13.0], limit=3.0, tolerance=1e-5)
    assert {Status.STILL_DRIFTING} == set(slow.status) and (slow.dwell == 3.0).all()
    assert "left to go after 3 s" in slow[1].message or "drifts" in slow[1].message


def test_a_linear_rig_swept_slowly_has_its_receptance_within_the_error_it_states():
    from rigsim.model.oscillator import matrices

    linear = RIG.replace(k=RIG.k1 / 4, d0=RIG.d / 2, gravity=0, c=0.1)
    test = swept_test(linear, 0.05, (40, 70), 0.5, window=1.0)
    mass, damping, stiffness = matrices(linear)
    for point in test[8:-8:10]:
        omega = 2 * np.pi * point.frequency
        found = np.linalg.solve(stiffness + 1j * omega * damping - omega**2 * mass, [0.05, 0])
        z = found[0] - found[1]
        # What is left is the lag of the motion itself, of its rate over the square of its decay.
        assert abs(point.relative - z) < (point.error + 4e-3) * abs(z)
    wide, narrow = (swept_test(linear, 0.05, (40, 70), 10.0, window=window) for window in (0.6, 0.15))
    true = np.interp(wide.frequency, narrow.frequency, narrow.relative.real) + 1j * np.interp(
        wide.frequency, narrow.frequency, narrow.relative.imag
    )
    smoothed, error = (abs(wide.relative - true) / abs(true))[2:-2], wide.column("error")[2:-2]
    assert smoothed.max() > 5e-3 and (smoothed < 2 * error + 2e-3).all()


@pytest.mark.parametrize("highest", [20, pytest.param(80, marks=pytest.mark.full)])
def test_three_seconds_with_a_tap_at_one_leave_what_sine_test_says(highest):
    """The paper's protocol against the same shaken on for 15 s."""
    frequency = np.arange(10.0, highest + 1)
    count = frequency.size
    taps = [None] * count + [Tap()] * count
    short, long = (sine_test(RIG, FORCE, np.tile(frequency, 2), taps, duration) for duration in (3, 15))
    left = abs(short.relative / long.relative - 1)
    quiet, tapped = left[:count], left[count:]
    assert quiet.max() < 7e-4 and (short.status[:count] == Status.SETTLED).sum() == count - 1  # but 20 Hz
    low = frequency <= 32
    assert (short.status[count:][low] == Status.STILL_DRIFTING).all() and 1e-3 < tapped[0] < 0.085 and low[0]
    assert tapped[low].max() == tapped[0]
    if highest == 80:
        unsettled = np.isin(short.status[count:], (Status.STILL_DRIFTING, Status.NOT_PERIODIC))
        assert unsettled.sum() == 40
        rest = tapped[~low & (frequency != 64)]
        assert rest.max() < 0.03 and tapped[frequency == 64] > 0.5
