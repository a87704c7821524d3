"""The simulated rig against the tests' own integrator, and its derivatives against differences."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from rigsim.identification.simulate import Run, Structure, simulate
from rigsim.identification.terms import CUBIC, LINEAR, Friction, Gap, Power, Term
from rigsim.parameters import RigParameters
from tests.identification.cubic import band_limited_record, cubic_record

P = RigParameters().oscillator
RIG = Structure(("ms", "m"), (*LINEAR, CUBIC), ((0, "displacement"), (1, "displacement")), (1.0, 0.0))
VALUES = np.array([P.ms, P.m, P.ks, P.cs, P.c, P.k1, P.k3])
REST = np.zeros((1, 4))


def reach_of(record, extra=()):
    return np.array([1.0, 1.0, 1.0, 1.0, np.abs(record.relative).max(), *extra])


@pytest.mark.parametrize("hold", ["zero", "linear"])
def test_the_motion_is_that_of_another_integrator(hold):
    record = cubic_record(duration=5, hold=hold)
    outputs, columns = simulate(RIG, VALUES, Run(record.force, 2000.0, hold), REST, reach_of(record), finer=8)
    np.testing.assert_allclose(outputs.T, [record.shaker, record.mass], atol=2e-8 * record.mass.std())
    assert columns.shape == (10000, 2, 0)


def test_a_band_limited_force_is_a_smooth_one():
    record = band_limited_record(duration=5)
    run = Run(record.force, 2000.0, "band-limited")
    outputs, _ = simulate(RIG, VALUES, run, REST, reach_of(record), finer=4)
    late = slice(2000, -200)  # the ends of a spline know of one side only
    for output, channel in zip(outputs.T, (record.shaker, record.mass), strict=True):
        np.testing.assert_allclose(output[late], channel[late], atol=2e-6 * channel.std())


def test_what_long_steps_lose_falls_with_their_fourth_power():
    record = cubic_record(duration=3)
    run = Run(record.force, 2000.0, "zero")
    off = [
        np.abs(simulate(RIG, VALUES, run, REST, reach_of(record), finer=finer)[0][:, 0] - record.shaker).max()
        for finer in (1, 2)
    ]
    assert 12 < off[0] / off[1] < 20


def test_derivatives_are_those_of_the_motion():
    record = cubic_record(duration=3, rms=2)
    terms = (*RIG.terms, Term("mu", (0,), Friction(0.02), "velocity"), Term("g", (1,), Gap(2e-5)))
    rig = Structure(RIG.masses, terms, ((0, "displacement"), (1, "velocity")), (1.0, 0.0))
    values, reach = np.append(VALUES, [0.05, 20.0]), reach_of(record, [0.1, 1e-3])
    run, start = Run(record.force, 2000.0, "zero"), np.array([[1e-5, -1e-5, 1e-3, 2e-3]])
    _, columns = simulate(rig, values, run, start, reach, wanted=range(9))
    for place in range(13):
        step = 1e-6 * (values[place] if place < 9 else 1e-3)
        moved = []
        for sign in (1, -1):
            changed, begun = values.copy(), start.copy()
            if place < 9:
                changed[place] += sign * step
            else:
                begun[0, place - 9] += sign * step
            moved.append(simulate(rig, changed, run, begun, reach)[0])
        slope = (moved[0] - moved[1]) / (2 * step)
        np.testing.assert_allclose(columns[..., place], slope, atol=2e-5 * np.abs(slope).max(axis=0).max())


def test_small_forces_beside_the_recorded_one_add_what_they_move():
    record = cubic_record(duration=2)
    more = np.random.default_rng(1).normal(size=(4000, 2))
    reach = reach_of(record)
    _, columns = simulate(RIG, VALUES, Run(record.force, 2000.0, "zero"), REST, reach, [0], more)
    plain, _ = simulate(RIG, VALUES, Run(record.force, 2000.0, "zero"), REST, reach)
    for place in range(2):
        run = Run(record.force + 1e-6 * more[:, place], 2000.0, "zero")
        slope = (simulate(RIG, VALUES, run, REST, reach)[0] - plain) / 1e-6
        np.testing.assert_allclose(columns[..., 1 + 4 + place], slope, atol=1e-4 * np.abs(slope).max())


def test_parts_begin_anew_from_their_own_states():
    record = cubic_record(duration=2)
    reach, force = reach_of(record), record.force
    states = np.array([[0, 0, 0, 0], [1e-5, 0, 0, 1e-3]])
    both, _ = simulate(RIG, VALUES, Run(force, 2000.0, "zero", (0, 1500)), states, reach)
    later, _ = simulate(RIG, VALUES, Run(force[1500:], 2000.0, "zero"), states[1:], reach)
    np.testing.assert_array_equal(both[1500:], later)


def test_a_table_holds_a_cubic_and_beyond_its_reach_a_straight_line():
    """A mass alone on a cubic spring, far outside: its force grows straight from three times the reach."""
    one = Structure(("m",), (Term("k", (0,), Power(3)),), ((0, "acceleration"),), (1.0,))
    run = Run(np.zeros(1), 1e4, "zero")
    for place, force in ((2.9, 2.9**3), (5.0, 27 + 27 * 2), (-5.0, -27 - 27 * 2)):
        (found,), _ = simulate(one, np.array([2.0, 1.0]), run, np.array([[place, 0.0]]), np.array([1.0]))
        assert found == pytest.approx(-force / 2, rel=1e-6)


def test_a_rig_far_too_fast_for_its_samples_is_no_motion():
    values = VALUES * [1, 1, 1e9, 1, 1, 1, 1]
    outputs, _ = simulate(RIG, values, Run(np.ones(10), 2000.0, "zero"), REST, np.ones(5))
    assert np.isnan(outputs).all()


def test_a_base_moves_the_masses_as_forces_in_proportion_to_them():
    record = cubic_record(duration=2)
    run, reach = Run(record.force, 2000.0, "linear"), reach_of(record)
    shaken = replace(RIG, driven=(-P.ms, -P.m))
    based = replace(RIG, driven=(0.0, 0.0), base=True)
    expected, _ = simulate(shaken, VALUES, run, REST, reach)
    found, columns = simulate(based, VALUES, run, REST, reach, range(7))
    np.testing.assert_allclose(found, expected, atol=1e-12 * np.abs(expected).max())
    # All parameters times one factor are the same rig.
    np.testing.assert_allclose(columns[..., :7] @ VALUES, 0.0, atol=1e-9 * np.abs(columns[..., 2] * P.ks).max())
    absolute = replace(based, sensors=((0, "acceleration"), (1, "acceleration")))
    relative = replace(shaken, sensors=absolute.sensors)
    felt = simulate(absolute, VALUES, run, REST, reach)[0] - record.force[:, None]
    np.testing.assert_allclose(felt, simulate(relative, VALUES, run, REST, reach)[0], atol=1e-10 * np.abs(felt).max())


def test_the_force_of_one_test_knows_nothing_of_the_next():
    force = np.random.default_rng(1).normal(size=400)
    both = Run(force, 2000.0, "band-limited", (0, 150, 200), (0, 200)).pieces()
    alone = [Run(part, 2000.0, "band-limited").pieces() for part in np.split(force, 2)]
    np.testing.assert_array_equal(both, np.concatenate(alone))


@pytest.mark.parametrize("size", [12, 150, 400])
def test_a_band_limited_force_is_one_spline(size):
    force = np.random.default_rng(1).normal(size=size)
    pieces, samples = Run(force, 50.0, "band-limited").pieces(), np.arange(size)
    spline = make_interp_spline(samples, force, k=5)
    for power in range(6):
        expected = spline(samples, power) * 50.0**power / math.factorial(power)
        np.testing.assert_allclose(pieces[:, power], expected, atol=1e-12 * np.abs(expected).max())


def test_columns_by_the_first_state_end_where_they_have_died_away_and_may_be_left_out():
    record = cubic_record(duration=20)
    run, reach = Run(record.force, 2000.0, "zero"), reach_of(record)
    extra = np.random.default_rng(2).normal(size=(40_000, 1))
    _, columns = simulate(RIG, VALUES, run, REST, reach, [0, 6], extra)
    _, without = simulate(RIG, VALUES, run, REST, reach, [0, 6], extra, states=False)
    np.testing.assert_array_equal(without, columns[..., [0, 1, 6]])
    begun = np.abs(columns[..., 2:6]).max(axis=1)
    (last,) = {np.flatnonzero(column).max() for column in begun.T}
    assert 4000 < last < 36_000 and (begun[last] < 1e-10 * begun.max(axis=0)).all()


def test_a_term_of_no_size_moves_what_a_little_of_it_does():
    record = cubic_record(duration=3, rms=2)
    rig = replace(RIG, terms=(*RIG.terms, Term("mu", (0, 1), Friction(0.02), "velocity"), Term("k5", (1,), Power(5))))
    run, reach = Run(record.force, 2000.0, "zero"), reach_of(record, [0.1, 1e-3])
    little = np.array([1e-12, 1e-6])
    absent, present = (
        simulate(rig, np.append(VALUES, sizes), run, REST, reach, [7, 8], states=False)[1]
        for sizes in (0 * little, little)
    )
    for place in (0, 1):
        off = np.abs(absent - present)[..., place].max()
        assert 0 < off < 1e-4 * np.abs(present[..., place]).max()
