"""Motions that last: against theory, against brute force, and the same whoever runs them."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from rigsim import OscillatorParameters, RigParameters, attractors, frequency_response, integrity
from rigsim.attraction.attractors import quasi_random, settle_and_learn
from rigsim.attraction.settle import until_trapped
from rigsim.attraction.taps import TapMap
from rigsim.attraction.traps import closed_orbit
from rigsim.present.figures.basins import motion_colors

RIG = RigParameters()


@pytest.fixture(scope="module")
def at_30():
    return attractors(RIG, 3.18, 30.0)


@pytest.fixture(scope="module")
def at_40():
    return attractors(RIG, 3.18, 40.0)


def test_branches_are_those_of_the_theory(at_30):
    assert at_30.names == ["low", "high"]
    theory = frequency_response(RIG, 3.18, [30.0])
    for one, column in zip(at_30, (0, 2), strict=True):
        assert one.period == 1 and one.symmetric
        # The single term leaves out the third harmonic, which takes 2.5 % off the high branch.
        np.testing.assert_allclose(one.relative[1], theory.relative[0, column], rtol=0.03)
        np.testing.assert_allclose(one.shaker[1], theory.shaker[0, column], rtol=0.02)
        np.testing.assert_allclose(one.mass, one.shaker - one.relative, atol=1e-15)


def test_orbits_repeat_and_keep_liouville(at_40):
    """The product of the multipliers is the exponential of the trace of the damping, whatever the motion."""
    assert {one.period for one in at_40} == {1, 2}
    for one in at_40:
        again = at_40.flow.refined().advance(one.orbit, one.period)
        np.testing.assert_allclose(again / at_40.box, one.orbit / at_40.box, atol=1e-6)
        shrinking = np.exp(-(RIG.cs / RIG.ms + RIG.c / RIG.ms + RIG.c / RIG.m) * one.period / 40)
        np.testing.assert_allclose(np.prod(one.multipliers), shrinking, rtol=1e-5)
        assert (abs(one.multipliers) < 1).all()


def test_lines_add_up_to_the_motion(at_40):
    one = at_40.find("subharmonic 1/2")
    trace = at_40.flow.trace(one.orbit[:1], 2, 16)[0]
    time = np.arange(32) / 16 / 40
    sum_of_lines = (one.relative * np.exp(2j * np.pi * one.frequency * time[:, None])).sum(axis=1).real
    np.testing.assert_allclose(sum_of_lines, trace[:, 1], atol=1e-4 * one.amplitude)
    assert one.giveaway[0] == 20.0 and one.giveaway[1] > 0.9 * abs(one.relative[2])


def test_twins_count_as_one(at_40):
    one = at_40.find("subharmonic 1/2")
    assert not one.symmetric
    twin = -at_40.flow.advance(one.orbit, 0.5)
    assert np.abs((twin[:, None] - one.orbit) / at_40.box).max(axis=2).min() > 1e-3  # another orbit
    label, periods = at_40.settle(twin)
    assert (label == one.motion).all() and (periods == 0).all()


@pytest.mark.parametrize("frequency", [40.0, 70.0])
def test_traps_tell_the_truth(frequency):
    """What is said of a state after few periods is where it is after many."""
    found = attractors(RIG, 3.18, frequency)
    states = quasi_random(256, found.box, 11)
    label, periods = found.settle(states)
    assert 5 < np.median(periods) < 200
    ends = found.flow.advance(states, 900)
    nearest = np.abs((ends[:, None] - found.points) / found.box).max(axis=2)
    assert nearest.min(axis=1).max() < 1e-3
    assert np.array_equal(found.owner[nearest.argmin(axis=1)], label)


def test_threads_do_not_matter(at_40):
    states = quasi_random(1500, at_40.box, 5)
    with ThreadPoolExecutor(1) as one, ThreadPoolExecutor(4) as four:
        results = [until_trapped(at_40, states, 300, executor=executor) for executor in (one, four, None)]
    for other in results[1:]:
        assert all(np.array_equal(results[0][name], other[name]) for name in ("label", "periods", "states"))


def test_a_pool_that_is_given_does_the_work_and_else_one_of_its_own(at_30, monkeypatch):
    begun = []

    class Counting(ThreadPoolExecutor):
        def submit(self, *arguments, **options):
            begun.append(self)
            return super().submit(*arguments, **options)

    monkeypatch.setattr("rigsim.campaign.run.ThreadPoolExecutor", Counting)
    states = quasi_random(300, at_30.box, 5)
    with Counting(1) as given:
        at_30.settle(states, executor=given)
        assert begun and set(begun) == {given}
        begun.clear()
        at_30.settle(states)
        assert begun and given not in begun


def test_checkpoint_spares_what_is_done(at_30, tmp_path):
    states = quasi_random(700, at_30.box, 5)
    seen = []
    first = at_30.settle(states, checkpoint=tmp_path / "c")
    again = at_30.settle(states, checkpoint=tmp_path / "c", progress=lambda done, total: seen.append((done, total)))
    assert np.array_equal(first, again) and seen[0] == (6, 6)  # every chunk was there from the start


def test_rare_motions_are_learnt_from_the_states_that_lead_there(at_30):
    low = at_30.find("low").orbit[0]
    poor = attractors(RIG, 3.18, 30.0, starts=2, seed=1)
    assert poor.names == ["high"]
    states = np.concatenate([quasi_random(8, poor.box, 3), low + 0.01 * quasi_random(4, poor.box, 4)])
    found, label = settle_and_learn(poor, states)
    assert found.names == ["high", "low"] and found[0] is poor[0]
    assert np.array_equal(1 - label, at_30.settle(states)[0])


def test_a_second_high_renames_nothing(at_30, monkeypatch):
    """A small motion that passes for "high", and a second, larger "high" that is learnt from states later."""
    low, high = at_30
    own = at_30.owner == low.motion
    few = replace(
        at_30,
        members=(replace(low, name="high"),),
        points=at_30.points[own],
        metrics=at_30.metrics[own],
        owner=at_30.owner[own],
    )
    states = np.concatenate([low.orbit, high.orbit])
    found, label = settle_and_learn(few, states)
    assert found[0] is few[0] and few.find("high").motion == 0 and list(label) == [0, 1]
    assert [one.name for one in found] == ["high", "high"] and [one.motion for one in found] == [0, 1]
    assert found.names == ["high #0", "high #1"] and found[1].amplitude > found[0].amplitude
    assert found.find(np.int64(1)) is found[1]
    with pytest.raises(ValueError, match=r"motion = 'high' .* one of 0 \(high\), 1 \(high\), by its number"):
        found.find("high")
    with pytest.raises(ValueError, match="motion = 2"):
        found.find(2)
    taps = TapMap(found, 0, np.array([0.1]), np.array([0.0]), 2e-3, np.array([[1]]))
    assert taps.reached(1).all() and not taps.reached(0).any() and "from 'high #0': high #0 0.0%" in repr(taps)
    assert motion_colors(found)[0] == motion_colors(few)[0] != motion_colors(found)[1]
    # Along a branch goes the one that is nearer to the single-term solution of the name.
    monkeypatch.setattr("rigsim.attraction.integrity.attractors", lambda *_, **__: found)
    followed = integrity(RIG, 3.18, 30.0, "high", samples=64)
    assert list(followed.motion) == [1] and list(followed.neighbour) == [0]


def test_sequence_prints_and_draws(at_40):
    assert repr(at_40).startswith("Attractors at 40 Hz and 3.18 N, from 256 starts: low, high, subharmonic 1/2\n")
    assert list(at_40.table()["motion"]) == [0, 1, 2] and at_40.flow.law == "exact"
    figure = at_40.plot()
    for one, line in zip(at_40, figure.axes[0].lines[::2], strict=True):
        np.testing.assert_allclose(np.abs(line.get_xdata()).max(), 1e3 * one.amplitude, rtol=2e-3)
        np.testing.assert_allclose(one.path[:, 0], one.orbit[0, [1, 3]], rtol=5e-3, atol=1e-3 * one.amplitude)
        np.testing.assert_allclose(one.path[:, -1], one.path[:, 0], atol=1e-12)
    assert figure.axes[0].get_xlabel() == "relative displacement z [mm]" and "subharmonic 1/2 up to" in figure.alt


def test_newton_finds_the_least_period(at_30):
    low = at_30.find("low")
    period, orbit, _ = closed_orbit(at_30.flow, low.orbit[0] + 1e-3 * at_30.box, 4, at_30.box)
    assert period == 1
    np.testing.assert_allclose(orbit / at_30.box, low.orbit / at_30.box, atol=1e-8)


def test_quasi_periodic_motion_has_no_period():
    found = attractors(RIG, 3.18, 63.0, starts=64)
    one = found[-1]
    assert one.name == "not periodic" and one.period == 0 and one.amplitude > 2e-3
    assert "no period" in one.summary() and one.frequency.size == 0


def test_box_is_wide_enough_where_the_high_branch_has_ended():
    assert attractors(RIG, 3.18, 110.0, starts=64).names == ["only", "subharmonic 1/3"]


def test_cubic_law_of_an_identified_rig():
    found = attractors(RIG.oscillator, 3.18, 30.0, starts=64)
    exact = attractors(RIG, 3.18, 30.0, starts=64)
    assert found.names == exact.names == ["low", "high"]
    assert 1e-5 < abs(found[1].amplitude / exact[1].amplitude - 1) < 0.01


def test_bad_input_is_named():
    with pytest.raises(ValueError, match="no wires"):
        attractors(RIG.oscillator, 3.18, 30.0, law="exact")
    with pytest.raises(ValueError, match="box has 3 elements|box has 3"):
        attractors(RIG, 3.18, 30.0, box=[1, 1, 1])
    with pytest.raises(ValueError, match="force = -1 N"):
        attractors(RIG, -1, 30.0)
    with pytest.raises(ValueError, match="undamped"):
        attractors(OscillatorParameters(1, 1, 0, 0.1, 0, 1, 1), 1.0, 0.01)
