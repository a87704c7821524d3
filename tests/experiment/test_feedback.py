"""Tests under feedback: the design against the equations themselves, and what is measured against harmonic balance."""

from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
import pytest
import scipy.linalg
from scipy.interpolate import CubicSpline

from rigsim import continue_orbit, feedback_test, frequency_response, periodic_orbits, response_sheet, sine_test
from rigsim.experiment.feedback.balance import largest_amplitude, refitted, stepped
from rigsim.experiment.feedback.gains import designed, loop_multipliers, multipliers, transitions
from rigsim.experiment.feedback.loop import Loop
from rigsim.experiment.feedback.sweep import held
from rigsim.model.planar import damping_matrix, mass_matrix, pack, static_equilibrium, tangent_stiffness
from rigsim.orbits.harmonic_balance import balance
from rigsim.orbits.sheet import from_rest
from rigsim.parameters import RigParameters
from rigsim.results import Status

RIG = RigParameters()
MODEL = RIG.oscillator
FORCE = 3.18
MIDDLE = np.array([0, 1.317e-3], dtype=complex)  # of z at 36 Hz and this force
DESIGN = {"sample_rate": 2000.0, "delay": 1, "feedback": "both"}


@pytest.fixture(scope="module")
def sweep():
    """One S-curve."""
    return feedback_test(RIG, 4.0, 36.0)


def lines_of(branch, i, count=11):
    """Mean and lines of xs and x (count, 2) of an orbit of a branch."""
    lines = np.zeros((count, 2), dtype=complex)
    known = min(count, branch.shaker.shape[1])
    lines[:known] = np.column_stack([branch.shaker[i], branch.mass[i]])[:known]
    return lines


# The design.


def simulated_monodromy(gains, relative, frequency, count, delay):
    """Multipliers of the sampled loop, differences of a map that steps Eqs. (3) over a period, and lines of z.

    The states are xs, x, xs', x', the last reading, and the commands under way; a target that is not quite a motion of
    the rig is followed until the loop repeats itself, and then each state is moved a little.
    """
    length, fine = 1 / (frequency * count), 8
    P, D = gains[::2], gains[1::2] / length
    z = lambda k: np.real(relative[1] * np.exp(2j * np.pi * k / count))  # noqa: E731
    s = 2j * np.pi * frequency
    X = (s * MODEL.c + MODEL.k1 + 0.75 * MODEL.k3 * abs(relative[1]) ** 2) * relative[1] / (MODEL.m * s**2)
    F = (MODEL.ms * s**2 + MODEL.cs * s + MODEL.ks) * (X + relative[1]) + MODEL.m * s**2 * X
    rotating = lambda line, k: np.real(line * np.exp(2j * np.pi * k / count))  # noqa: E731

    def rate(state, u):
        z, v = state[0] - state[1], state[2] - state[3]
        between = MODEL.c * v + MODEL.k1 * z + MODEL.k3 * z**3
        frame = (u - MODEL.ks * state[0] - MODEL.cs * state[2] - between) / MODEL.ms
        return np.stack([state[2], state[3], frame, between / MODEL.m])

    def period(states, kept=None):
        states, h = states.copy(), length / fine
        for k in range(count):
            if kept is not None:
                kept.append(states[0, 0] - states[1, 0])
            x = np.array([rotating(X, k) + z(k), rotating(X, k)])[:, None]
            last = np.array([rotating(X, k - 1) + z(k - 1), rotating(X, k - 1)])[:, None]
            error, before = x - states[:2], last - states[4:6]
            command = (P[:, None] * error + D[:, None] * (error - before)).sum(axis=0)
            u = rotating(F, k) + states[6]
            reading, motion = states[:2].copy(), states[:4]
            for _ in range(fine):
                one = rate(motion, u)
                two = rate(motion + h / 2 * one, u)
                three = rate(motion + h / 2 * two, u)
                four = rate(motion + h * three, u)
                motion = motion + h / 6 * (one + 2 * two + 2 * three + four)
            states = np.concatenate([motion, reading, states[7:], command[None]])
        return states

    n = 6 + delay
    steady = np.zeros((n, 1))
    steady[:4, 0] = rotating(X, 0) + z(0), rotating(X, 0), rotating(s * (X + relative[1]), 0), rotating(s * X, 0)
    steady[4:6, 0] = rotating(X, -1) + z(-1), rotating(X, -1)
    for _ in range(60):
        steady = period(steady)
    trace = []
    assert abs(period(steady, trace)[:4] - steady[:4]).max() < 1e-9 * abs(steady[:4]).max()
    moved = np.concatenate([[1e-7, 1e-7, 1e-5, 1e-5, 1e-7, 1e-7], np.full(delay, 1e-3)])
    after = period(steady + np.diag(moved)) - period(steady - np.diag(moved))
    lines = np.fft.rfft(trace)[:12] / count * np.where(np.arange(12) > 0, 2, 1)
    return np.linalg.eigvals(after / (2 * moved)), lines


@pytest.mark.parametrize("delay", [1, 2])
def test_the_loop_s_multipliers_are_those_of_the_equations_stepped_sample_by_sample(delay):
    count, frequency = 56, 2000 / 56
    gains, largest = designed(MODEL, MIDDLE, frequency, **DESIGN | {"delay": delay})
    found, lines = simulated_monodromy(gains, MIDDLE, frequency, count, delay)
    told = loop_multipliers(*transitions(MODEL, lines, frequency, count), gains[None], delay)[0]
    np.testing.assert_allclose(np.sort(abs(found)), np.sort(abs(told)), atol=2e-3)
    assert abs(found).max() < largest + 0.02 < 0.65
    assert abs(multipliers(transitions(MODEL, lines, frequency, count)[0])).max() > 2.5


def test_the_rig_s_undamped_modes_stay_as_they_are_under_feedback(sweep):
    """The planar rig linearised along a held motion, bounce and rocking with it: they neither grow nor are damped."""
    motion = sweep[14]
    assert not motion.stable and motion.status is Status.HELD
    count, about = round(2000 / motion.frequency), static_equilibrium(RIG).coordinates
    rigs, wires = pack([RIG])
    inverse, length = np.linalg.inv(mass_matrix(RIG)), 1 / (motion.frequency * count)
    steps = np.empty((count, 8, 9))
    stiffness, damping, rate = np.empty((4, 4)), np.empty((4, 4)), np.zeros((9, 9))
    for k in range(count):
        turn = np.exp(2j * np.pi * (k + 0.5) / count * np.arange(11))
        q = about + np.array([1, 0, 0, 0]) * (motion.shaker * turn).real.sum()
        q = q + np.array([0, 1, 0, 0]) * (motion.mass * turn).real.sum()
        tangent_stiffness(q, rigs[0], wires[0], stiffness)
        damping_matrix(q, rigs[0], wires[0], damping)
        rate[:4, 4:8] = np.eye(4)
        rate[4:8, :4], rate[4:8, 4:8], rate[4:8, 8] = -inverse @ stiffness, -inverse @ damping, inverse[:, 0]
        steps[k] = scipy.linalg.expm(rate * length)[:8]
    reading = np.zeros((2, 8))
    reading[0, 0] = reading[1, 1] = 1.0
    reading[1, 3] = RIG.LG * np.sin(about[3])  # x of P
    found = np.sort(abs(loop_multipliers(steps, length, motion.gains[None], 1, reading)[0]))
    model = loop_multipliers(*transitions(MODEL, motion.relative, motion.frequency, count), motion.gains[None], 1)[0]
    np.testing.assert_allclose(found[-4:], 1.0, atol=1e-5)
    np.testing.assert_allclose(found[-5], abs(model).max(), atol=5e-3)


def test_a_loop_that_cannot_hold_a_motion_says_so():
    """Ten samples late, nothing holds the middle branch at 50 Hz, and it is not tried."""
    _, largest = designed(MODEL, 1.3 * MIDDLE, 50.0, **DESIGN | {"delay": 20, "feedback": "relative"})
    assert largest > 1
    test = feedback_test(RIG, FORCE, 50.0, [1.7e-3], feedback="relative", delay=20)
    (motion,) = test
    assert motion.status is Status.UNTRIED and "multiplier" in motion.message and motion.segments == 0
    assert np.isnan(motion.invasive) and motion.trace is None and test.bench_time == 0
    with pytest.raises(ValueError, match="status = untried"):
        motion.to_record()


# The steps between motions.


@pytest.fixture(scope="module")
def orbit():
    """The middle branch of the model near 36 Hz, by harmonic balance, five odd lines."""
    return continue_orbit(MODEL, FORCE, 36.0, [0, 1.317e-3 * np.exp(-0.17j)], band=(34, 38), harmonics=10)


def test_steps_by_the_balance_end_in_the_motion_of_the_model(orbit):
    """From 0.9 of the amplitude and no harmonics, feedback being what the equations lack, to harmonic balance."""
    i = int(np.argmin(abs(orbit.frequency - 36)))
    frequency, wanted = orbit.frequency[i], lines_of(orbit, i)
    z = wanted[:, 0] - wanted[:, 1]
    turn = (np.conj(z[1]) / abs(z[1])) ** np.arange(11)
    relative = np.zeros(11, dtype=complex)
    relative[1] = 0.9 * abs(z[1])
    for _ in range(8):
        lines, lacking = under_feedback(relative, frequency)
        feedback = np.where(np.arange(11) == 1, 0, lacking)
        new, added = stepped(MODEL, frequency, lines, feedback, abs(z[1]))
        relative = new[:, 0] - new[:, 1]
    np.testing.assert_allclose(relative, z * turn, atol=1e-6 * abs(z[1]))
    assert abs(lacking[1] + added) == pytest.approx(FORCE, rel=1e-5)
    assert abs(lacking[2:]).max() < 1e-5


def under_feedback(relative, frequency):
    """Lines of xs and x (11, 2) for those of z that one wants, by the mass's equation, and of the force that takes."""
    s = 2j * np.pi * frequency * np.arange(11)
    z = (np.exp(2j * np.pi / 128 * np.outer(np.arange(128), np.arange(11))) @ relative).real
    cubed = np.fft.rfft(z**3)[:11] / 128 * np.where(np.arange(11) > 0, 2, 1)
    between = (s * MODEL.c + MODEL.k1) * relative + MODEL.k3 * cubed
    mass = np.append(0, between[1:] / (MODEL.m * s[1:] ** 2))
    shaker = mass + relative
    return np.column_stack([shaker, mass]), (MODEL.ms * s**2 + MODEL.cs * s + MODEL.ks) * shaker + between


def test_a_suspension_is_fitted_to_motions(orbit):
    motions = [lines_of(orbit, i) for i in range(0, len(orbit.frequency), 3)]
    assert len(motions) > 3
    frequency = orbit.frequency[0]
    fitted = refitted(
        MODEL.replace(c=1.0, k1=1.0, k3=1e7),
        frequency,
        [under_feedback(np.diff(m)[:, 0] * -1, frequency)[0] for m in motions],
    )
    assert [fitted.c, fitted.k1, fitted.k3] == pytest.approx([MODEL.c, MODEL.k1, MODEL.k3], rel=1e-6)


def test_the_largest_amplitude_is_that_of_single_term_theory():
    for frequency in (15.0, 36.0, 53.0, 70.0):
        expected = np.nanmax(abs(frequency_response(MODEL, FORCE, [frequency]).relative))
        assert largest_amplitude(MODEL, frequency, FORCE) == pytest.approx(expected, rel=1e-9)


def test_a_held_line_acts_half_a_sample_late_and_a_little_less():
    rate, frequency = 2000.0, 53.0
    k = np.arange(2000)
    fine = np.repeat(np.cos(2 * np.pi * frequency * k / rate), 64)
    time = (np.arange(fine.size) + 0.5) / (64 * rate)
    line = 2 * np.mean(fine * np.exp(-2j * np.pi * frequency * time))
    assert line == pytest.approx(held(frequency / rate), rel=1e-4)


# What is measured.


def sheet_at(frequency, force=FORCE):
    """Amplitude of z (m) and force (N) of the slice of the response sheet from rest, by harmonic balance."""
    equations = balance(RIG, force, 9, "exact").at(frequency)
    (line,) = from_rest(equations, 3.0)
    x0 = force / RIG.ks
    return x0 * np.hypot(line.points[:, 1], line.points[:, 2]), force * line.points[:, -1]


def test_an_s_curve_is_a_slice_of_the_response_sheet(sweep):
    amplitude, force = sheet_at(36.0)
    assert all(one.status is Status.HELD for one in sweep) and len(sweep) == 24
    assert sum(not one.stable for one in sweep) >= 6
    squared = CubicSpline(amplitude, force**2)
    for one in sweep:
        z, F = abs(one.relative[1]), abs(one.force[1])
        assert F == pytest.approx(np.sqrt(squared(z)), rel=5e-3), f"{1e3 * z:.3f} mm"
        assert one.invasive < 0.01 and one.loop < 1 and one.segments <= 3
    assert (np.diff([abs(one.relative[1]) for one in sweep]) > 0).all()


def test_the_contour_has_the_motions_and_multipliers_of_the_orbits(sweep):
    response = sweep.at(FORCE)
    assert [one.motion for one in response] == ["low", "middle", "high"]
    assert list(response.stable) == [True, False, True]
    for one in response:
        orbit = continue_orbit(RIG, FORCE, 36.0, [0, one.relative], band=(35, 37))
        i = int(np.argmin(abs(orbit.frequency - 36)))
        orbit_z = np.interp(36, orbit.frequency, abs(orbit.relative[:, 1]))
        assert abs(one.relative) == pytest.approx(orbit_z, rel=2e-3)
        assert np.angle(one.relative) == pytest.approx(np.angle(orbit.relative[i, 1]), abs=0.02)
        assert one.multiplier == pytest.approx(abs(orbit.multipliers[i]).max(), rel=0.01)
    assert response.table()["stable"].tolist() == [True, False, True]
    assert "38" not in response.summary() and "1 of them unstable" in response.summary()


def test_the_trace_of_a_motion_is_a_record_of_its_window(sweep):
    motion = sweep[12]
    record = motion.to_record()
    assert record.hold == "zero" and record.sample_rate == 2000 and record.parameters == RIG
    k = np.arange(record.force.size) + round(motion.begin * 2000)
    turn = np.exp(-2j * np.pi * 36 * k / 2000)
    whole = record.force.size // 500 * 500  # 9 whole periods
    line = 2 * np.mean((record.force * turn)[:whole]) * held(36 / 2000)
    assert line == pytest.approx(motion.force[1], rel=1e-3)
    assert 2 * np.mean((record.mass * turn)[:whole]) == pytest.approx(motion.mass[1], rel=1e-3)


def test_what_a_test_says_of_itself(sweep):
    assert sweep.bench_time == pytest.approx(1.8 * sum(one.segments for one in sweep))
    assert "24 held" in sweep.summary() and "min of a bench" in sweep.summary()
    assert len(sweep.to_dataframe()) == 24
    with pytest.raises(ValueError, match="frequency = 35"):
        sweep.held(35.0)


def test_results_do_not_depend_on_neighbours_executors_or_interruption(tmp_path):
    call = partial(feedback_test, RIG, FORCE, amplitude=[0.3e-3, 0.8e-3], noise=1e-3, average=0.5, settle=0.1)
    alone, both = call([36.0]), call([36.0, 44.0])
    with ThreadPoolExecutor(1) as executor:
        again = call([36.0, 44.0], executor=executor, checkpoint=tmp_path / "kept")
    kept = call([36.0, 44.0], checkpoint=tmp_path / "kept")
    for one, two in zip([*alone, *both, *both], [*both[:2], *again, *kept], strict=True):
        np.testing.assert_allclose(one.trace, two.trace, atol=1e-9)
        assert one.status is two.status


def test_a_model_that_is_off_loses_a_motion_and_ends_the_sweep():
    asked = [0.3e-3, 1.5e-3, 1.6e-3, 1.7e-3]
    test = feedback_test(RIG, FORCE, 36.0, asked, MODEL.replace(k3=4 * MODEL.k3), average=0.5)
    statuses = [one.status for one in test]
    assert statuses[0] is Status.HELD and Status.HELD not in statuses[1:]
    lost = next(i for i, status in enumerate(statuses) if status in (Status.LOST, Status.FLEW_APART))
    assert statuses[lost + 1 :] == [Status.UNTRIED] * (3 - lost) and statuses[-1] is Status.UNTRIED
    told = f"the loop had lost the motion of {1e3 * asked[lost]:g} mm"
    assert all(one.message == told and np.isnan(one.multipliers).all() for one in test[lost + 1 :])
    assert "1 held" in test.summary() and "untried" in test.summary()


def test_a_shaker_at_its_limit_is_told():
    (motion,) = feedback_test(RIG, FORCE, 36.0, [0.8e-3], limit=4.0, average=0.5)  # of the 5.8 N that it takes
    assert motion.status is not Status.HELD and "the force is at its limit in" in motion.message
    assert np.abs(motion.to_record().force).max() == 4.0


def test_stability_is_told_by_the_motions_and_not_by_the_design():
    """A design whose suspension is far off still holds the high motion at 36 Hz, and its multipliers are the rig's."""
    test = feedback_test(RIG, FORCE, 36.0, [1.2e-3, 1.62e-3], MODEL.replace(k3=0.8 * MODEL.k3, c=2 * MODEL.c))
    assert [one.status for one in test] == [Status.HELD] * 2
    assert [one.stable for one in test] == [False, True]
    assert test[0].suspension == pytest.approx([MODEL.c, MODEL.k1, MODEL.k3], rel=0.02)
    assert test[0].misfit > 0.1


def test_motions_that_are_let_go_leave_or_stay_as_their_multipliers_say():
    """The loop is opened, with the force's own line alone left on: no model is in how fast what deviates then grows."""
    test = feedback_test(RIG, 4.0, 40.0, [0.6e-3, 1.0e-3, 1.35e-3, 1.48e-3, 1.7e-3, 1.85e-3])
    unstable, stable = test[3], test[5]
    assert not unstable.stable and stable.stable
    motions, count, held_for = (unstable, stable), 50, 100  # samples a period, periods
    loop = Loop([RIG] * 2, 2000.0, 1, 20.0, "equilibrium", 5e-5, [np.random.default_rng(0)] * 2)
    phase = 2 * np.pi / count * np.arange(count * held_for)
    share = np.minimum(phase / phase[-1] * 2, 1.0)
    target, force = np.empty((phase.size, 2, 2)), np.empty((phase.size, 2))
    for i, motion in enumerate(motions):
        turns = np.exp(1j * np.outer(phase, np.arange(11)))
        target[:, 0, i], target[:, 1, i] = (share * (turns @ line).real for line in (motion.shaker, motion.mass))
        line = motion.force[1] / held(40 / 2000)
        force[:, i] = share * (turns[:, 1] * line).real
    gains = np.stack([motion.gains for motion in motions], axis=1)
    settled = loop.run(target, force, gains, np.zeros((2, 2)))[0].reshape(held_for, count, 2, 2)[-1]
    free = loop.run(target[-count * 20 :], force[-count * 20 :], 0 * gains, np.zeros((2, 2)))[0]
    away = np.linalg.norm(free.reshape(20, count, 2, 2) - settled, axis=(1, 2)) / np.linalg.norm(settled, axis=(0, 1))
    small = np.flatnonzero((away[:, 0] > 2e-4) & (away[:, 0] < 0.03))
    growth = (away[small[-1], 0] / away[small[0], 0]) ** (1 / (small[-1] - small[0]))
    assert growth == pytest.approx(abs(unstable.multipliers[0]), rel=0.1)
    assert away[-1, 0] > 0.1 and away[:, 1].max() < 0.02


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"frequency": 120.0}, "frequency"),
        ({"frequency": 4.0}, "from 5 to 100 Hz"),
        ({"delay": 0}, "delay = 0"),
        ({"amplitude": [0.0]}, "amplitude"),
        ({"feedback": "shaker"}, "feedback"),
        ({"noise": 0.2}, "noise = 0.2"),
        ({"step": 1e-3}, "step"),
        ({"design": 3}, "design = 3"),
        ({"points": 10**6}, "points"),
    ],
)
def test_arguments_that_are_not_allowed(change, words):
    with pytest.raises(ValueError, match=words):
        feedback_test(**{"parameters": RIG, "force": FORCE, "frequency": 30.0} | change)


# The whole response.

FREQUENCIES = [20, 21, 22, 25, 28, 31, 34, 37, 40, 43, 46, 49, 51, 52, 53, 54]


@pytest.fixture(scope="module")
def orbits():
    return periodic_orbits(RIG, FORCE)


@pytest.mark.full
@pytest.mark.parametrize("noise", [0.0, 0.005])
def test_the_detached_curve_with_its_middle_branch_is_measured(orbits, noise, tell):
    test = feedback_test(RIG, 4.0, FREQUENCIES, noise=noise)
    response, worst = test.at(FORCE), 0.0
    detached = next(branch for branch in orbits if branch.closed)
    middle = [one for one in response if one.motion == "middle" and 22 <= one.frequency <= 53]
    assert len(middle) >= 10 and not any(one.stable for one in middle)
    for one in middle:
        crossing = np.flatnonzero(np.diff(np.sign(detached.frequency - one.frequency)))
        near = [np.interp(one.frequency, *by_frequency(detached, i)) for i in crossing]
        worst = max(worst, min(abs(abs(one.relative) / z - 1) for z in near))
    assert worst < 0.01
    expected = [point.frequency for point in detached.special_points if point.kind == "fold"]
    found = [fold.frequency for fold in response.folds]
    np.testing.assert_allclose(np.sort(found), np.sort(expected), atol=0.2)
    kept = [one for one in test if one.status is Status.HELD]
    assert len(kept) > 0.95 * len(test) and max(one.invasive for one in kept) < 0.01
    tell(
        f"feedback test, noise {noise:.1%}: {test.summary()}; {len(middle)} motions of the middle branch within "
        f"{worst:.2%}, folds within {abs(np.sort(found) - np.sort(expected)).max():.3f} Hz, feedback off the "
        f"fundamental at most {max(one.invasive for one in kept):.2%} of F"
    )


def by_frequency(branch, i):
    """Frequencies, ascending, and amplitudes of z of the neighbours i and i + 1 on a branch."""
    order = [i, i + 1] if branch.frequency[i] < branch.frequency[i + 1] else [i + 1, i]
    return branch.frequency[order], abs(branch.relative[order, branch.period])


@pytest.mark.full
def test_measured_contours_are_those_of_the_response_sheet():
    """At other forces, by the sheet as it is explored: what exists beside a measured motion, and how many there are."""
    sheet = response_sheet(RIG, (24, 52), (1.0, 4.0))
    test = feedback_test(RIG, 4.0, [26.0, 34.0, 42.0, 50.0])
    for force in (1.5, 2.5, 3.8):
        computed = sheet.at(force)
        for frequency in test.frequency:
            z = [abs(one.relative) for one in test.at(force) if one.frequency == frequency]
            expected = sorted(
                np.interp(frequency, *by_frequency(branch, i))
                for branch in computed
                for i in np.flatnonzero(np.diff(np.sign(branch.frequency - frequency)))
            )
            assert z == pytest.approx(expected, rel=0.01), f"{frequency} Hz, {force} N"


def test_a_curve_begins_where_no_force_is_and_says_where_it_may_have_more():
    """A stiff rig, whose first motion asked for takes more force than that of the response."""
    rig = RigParameters(ms=0.3, ks=2.5e4, cs=6, m=0.02, c=0.1, k=2e4, d=0.05, d0=0.04999, Lm=0.03, LG=0.002)
    test = feedback_test(rig, 3.18, [30.0], design=rig.oscillator, limit=60)
    whole = test.at(3.18)
    assert [one.motion for one in whole] == ["low", "middle", "high"] and not whole.unfinished
    alone = sine_test(rig, 3.18, 30.0)
    np.testing.assert_allclose(abs(whole[0].relative), abs(alone.relative[0]), rtol=1e-3)
    part = feedback_test(rig, 3.18, [30.0], design=rig.oscillator).at(3.18)
    assert part.unfinished == (30.0,) and "at 30 Hz there may be more" in part.summary()
    with pytest.raises(ValueError, match=r"force = 5000 N is not allowed; expected at most"):
        test.at(5000.0)
