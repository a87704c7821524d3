"""Rigs whose wires are longer than their places, d0 > d: slack where they let go, buckled where they push."""

import numpy as np
import pytest

from rigsim import (
    OscillatorParameters,
    Record,
    RigParameters,
    attractors,
    basins,
    cubic_law_error,
    detached_curves,
    existence_chart,
    force_scenario,
    frequency_response,
    linear_modes,
    margins,
    oscillator_modes,
    periodic_orbits,
    response_sheet,
    simulate,
    sine_test,
    static_equilibrium,
    tap_map,
    tolerance_study,
)
from rigsim.model import spatial
from rigsim.model.planar import conservative_forces, longest_step, pack
from rigsim.model.wires import suspension_force
from rigsim.results import Status
from tests.model import refereed as referee

RIG = RigParameters()
BUCKLED = RIG.replace(d0=RIG.d + 3e-6)
SLACK = BUCKLED.replace(tension_only=True)
BOTH = {"slack": SLACK, "buckled": BUCKLED}
KINDS = pytest.mark.parametrize("rig", BOTH.values(), ids=BOTH)
# Slack, its weight off and hung from its middle: a mass that moves along the axis only.
AXIAL = SLACK.replace(gravity=0, LG=0)


@KINDS
def test_force_along_the_axis_is_that_of_the_wires_in_space(rig):
    unequal = rig.replace(k=tuple(np.linspace(2e4, 6e4, 8)))
    for p in (rig, unequal, rig.single_set(), rig.replace(d0=0.04)):
        rigs, wires = referee.rig_and_wires(p)
        z = p.gap * np.array([-3.0, -1.1, -0.9, 0.0, 0.3, 0.999, 1.001, 2.0])
        # P moved back by z
        pulls = [spatial.pull_of_wires(spatial.planar_state([0, p.LG - one, 0, 0]), rigs, wires)[0] for one in z]
        scale = p.wire_stiffness.sum() * p.gap
        np.testing.assert_allclose(suspension_force(z, p), pulls, rtol=1e-9, atol=1e-13 * scale)


def test_slack_wires_have_no_force_in_the_gap_and_that_of_pushing_ones_beyond():
    inside, beyond = SLACK.gap * np.array([-0.99, 0.5]), SLACK.gap * np.array([-1.01, 3.0])
    assert SLACK.gap == pytest.approx(np.sqrt(2 * RIG.d * 3e-6), rel=1e-4)
    np.testing.assert_array_equal(suspension_force(inside, SLACK), 0)
    assert (suspension_force(inside, BUCKLED) * inside < 0).all()
    np.testing.assert_array_equal(suspension_force(beyond, SLACK), suspension_force(beyond, BUCKLED))
    # The cubic law has its own wells; they lie where the exact ones do to the order of its error.
    assert np.sqrt(-BUCKLED.k1 / BUCKLED.k3) == pytest.approx(BUCKLED.gap, rel=2e-4)


@KINDS
def test_forces_are_the_slope_of_the_energy_in_space(rig):
    rigs, wires = pack([rig])
    force = np.empty(4)
    for q in np.random.default_rng(3).normal(size=(40, 4)) * [2e-4, 6e-4, 4e-6, 3e-3]:
        q += [0, rig.LG, 0, 0]
        conservative_forces(q, rigs[0], wires[0], force)
        np.testing.assert_allclose(force, referee.residual(rig, q), rtol=1e-9, atol=1e-11)
        for i, h in enumerate([1e-7, 1e-7, 1e-7, 1e-6]):
            sides = [referee.energy(rig, spatial.planar_state(q + s * h * np.eye(4)[i])) for s in (1, -1)]
            # a kink within the difference moves it by the stiffness times the difference
            assert (sides[1] - sides[0]) / (2 * h) == pytest.approx(force[i], rel=1e-4, abs=5e-3 * h / 1e-7)


@KINDS
@pytest.mark.parametrize("sets", [1, 2])
def test_it_rests_where_the_energy_in_space_is_least(rig, sets):
    """No force there, and all about it higher; by a search of its own the slack rig has no lower place."""
    for p in (rig, rig.replace(LG=-0.005), rig.replace(LG=0.0005), rig.replace(d0=RIG.d + 5e-5)):
        p = p.single_set() if sets == 1 else p
        found = static_equilibrium(p)
        at = found.coordinates
        assert np.abs(referee.residual(p, at) / [1, 1, 1, 0.01]).max() < 1e-7 * p.m * p.gravity + 1e-10
        lowest = referee.energy(p, spatial.planar_state(at))
        around = at + np.random.default_rng(1).normal(size=(200, 4)) * [1e-6, 2e-5, 1e-6, 1e-3]
        assert min(referee.energy(p, spatial.planar_state(q)) for q in around) > lowest
        z = at[0] - (at[1] - p.LG * np.cos(found.tilt))
        if p.tension_only:
            assert abs(z) < p.gap
        else:
            assert sets == 1 or z == pytest.approx(p.gap, rel=0.1)
        linear_modes(p)


def test_one_set_may_be_unbuckled_by_its_own_tilt():
    """Tilted, the upright wires are longer by Rm (1 - cos tilt), here twice what they lack."""
    found = static_equilibrium(BUCKLED.single_set())
    tightened = RIG.Rm * (1 - np.cos(found.tilt))
    assert tightened > 2 * (BUCKLED.d0 - BUCKLED.d)
    at = found.coordinates
    z = at[0] - (at[1] - RIG.LG * np.cos(found.tilt))
    assert abs(z) < 0.2 * BUCKLED.gap
    mirrored = at + [0, 2 * z, 0, 0]  # where the other well would be; from there it comes back
    assert np.abs(referee.residual(BUCKLED.single_set(), mirrored)[1]) > 1e-5


def test_a_slack_rig_hangs_low_by_its_slack_and_swings_as_a_pendulum():
    """Two upper wires carry the weight, the mass hung from its middle: m g / (2 k) below where they are taut."""
    p = SLACK.replace(LG=0)
    stretch = p.m * p.gravity / (2 * p.k)
    assert static_equilibrium(p).sag == pytest.approx(3e-6 + stretch, rel=1e-6)
    modes = linear_modes(p.replace(c=0, cs=0, ms=1e3, ks=1e9))
    swing = np.sqrt(p.gravity / (p.d0 + stretch)) / (2 * np.pi)
    assert modes.frequency[modes.names.index("axial")] == pytest.approx(swing, rel=1e-4)


def test_a_buckled_rig_is_twice_as_stiff_in_its_well_as_it_is_unstable_between():
    """V'' = k1 (1 - 3) about z = sqrt(-k1/k3), the frame held; the weight adds little."""
    p = BUCKLED.replace(c=0, cs=0, ms=1e3, ks=1e9, gravity=0)
    modes = linear_modes(p)
    axial = modes.frequency[modes.names.index("axial")]
    assert axial == pytest.approx(np.sqrt(-2 * p.k1 / p.m) / (2 * np.pi), rel=1e-3)


def test_out_of_the_plane_a_buckled_rig_has_a_ring_of_places_of_rest():
    """A roll stretches wires as z does, by Rm (Rm + d)/(2 d) roll^2 and z^2/(2 d): no energy where both make 3 um."""
    weightless, c = BUCKLED.replace(gravity=0), RIG.Rm * (RIG.Rm + RIG.d) / RIG.d
    middle = referee.energy(weightless, spatial.planar_state([0, RIG.LG, 0, 0]))
    for angle in np.linspace(0, np.pi / 2, 7):
        z, roll = BUCKLED.gap * np.cos(angle), np.sqrt(2 * 3e-6 / c) * np.sin(angle)
        state = spatial.planar_state([0, RIG.LG - z, 0, 0])
        state[4:6] = np.cos(roll / 2), np.sin(roll / 2)
        assert referee.energy(weightless, state) < 2e-6 * middle


def test_its_planar_tests_say_so_and_do_not_last():
    test = sine_test([RIG, BUCKLED], 3.18, 40.0, start="equilibrium")
    assert "in the plane only: without tension a mass may roll" in test.summary()
    space = test.out_of_plane()
    assert list(space.status) == [Status.STAYS_IN_PLANE, Status.OPTIMISTIC] and space.growth[1] > 50


def test_nothing_holds_a_slack_mass_without_weight():
    with pytest.raises(ValueError, match=r"gravity = 0 m/s\^2 leaves the mass on slack wires, d0 - d = 3e-06 m"):
        static_equilibrium(AXIAL)
    assert simulate(AXIAL, np.ones(10), 2000.0).slack == (1.0, 0.0)
    assert static_equilibrium(AXIAL.replace(tension_only=False)).sag == 0


def test_the_longest_step_is_stable_and_no_shorter_for_wires_that_push():
    for p in (BUCKLED, SLACK, BUCKLED.single_set(), BUCKLED.single_set().replace(d0=0.05)):
        step = longest_step(p)
        assert 0.9 * longest_step(p.replace(d0=p.d)) < step <= longest_step(p.replace(d0=p.d))
        if p.gap < 1e-3:
            test = sine_test(p.replace(wire_damping=0.1), 0.5, 30.0, duration=1, step=0.9 * step)
            assert test.status[0] != Status.FLEW_APART


def errors(parameters, rms, steps, start="rest", duration=0.3, sample_rate=2000.0):
    """Largest difference of z from the referee's over its rms, at each of the steps, and the last record's slack."""
    force = np.random.default_rng(2014).normal(0, rms, round(duration * sample_rate))
    *_, expected, _ = referee.simulate_held(parameters, force, sample_rate, "linear", start, step=1e-6)
    records = [simulate(parameters, force, sample_rate, "linear", start, step) for step in steps]
    found = [np.abs(record.relative - expected).max() for record in records]
    return np.array(found) / np.sqrt(np.mean(expected**2)), records[-1].slack


def test_a_buckled_rig_moves_as_in_three_dimensions_to_second_order():
    for p in (BUCKLED.replace(wire_damping=2.0), BUCKLED.single_set().replace(wire_damping=2.0)):
        found, slack = errors(p, 1.115, (5e-5, 2.5e-5, 1.25e-5))
        assert found[0] < 2e-3 and slack is None
        np.testing.assert_allclose(found[:-1] / found[1:], 4, rtol=0.01)


def test_a_slack_rig_moves_to_second_order_within_the_gap():
    found, slack = errors(AXIAL, 5.0, (2e-5, 1e-5, 5e-6))
    assert found[0] < 1e-4 and slack == (1.0, 0.0)
    np.testing.assert_allclose(found[:-1] / found[1:], 4, rtol=1e-3)


def test_through_the_kink_order_two_holds_on_the_whole_and_not_from_step_to_step():
    """Where a step meets the edge of the gap its error depends on how; over four halvings that evens out."""
    found, (share, times) = errors(AXIAL, 10.0, (2e-5, 1e-5, 5e-6, 2.5e-6, 1.25e-6))
    assert 0.3 < share < 0.7 and times > 50
    assert (found[0] / found[-1]) ** (1 / 4) == pytest.approx(4, rel=0.1)
    assert np.abs(found[:-1] / found[1:] - 4).max() > 0.1
    assert found[-1] < 1e-4


@pytest.mark.parametrize(
    "rig, frequency, start",
    [(SLACK, 50.0, "rest"), (SLACK, 30.0, "rest"), (BUCKLED, 50.0, "rest"), (BUCKLED, 70.0, "rest")],
)
def test_sine_tests_agree_with_three_dimensions(rig, frequency, start):
    damped = rig.replace(wire_damping=2.0)
    test = sine_test(damped, 3.18, frequency, start=start)
    t, *found, _ = referee.simulate_sine(damped, 3.18, frequency, start=start, step=1e-5)
    for name, u in zip(("shaker", "mass", "relative"), found, strict=True):
        expected = referee.fourier(t, u, frequency)
        assert abs(getattr(test, name)[0] - expected) < 2e-3 * abs(referee.fourier(t, found[2], frequency)), name


def test_slack_is_counted_as_the_motion_tells():
    """The axial motion beyond the gap on either side makes every wire taut, and slack again as it comes back."""
    force = np.random.default_rng(2014).normal(0, 10.0, 600)
    fine = simulate(AXIAL, force, 2000.0, "linear", step=1e-5)
    dense = simulate(AXIAL, np.interp(np.arange(30000) / 50, np.arange(600), force), 1e5, "linear", step=1e-5)
    taut = np.abs(dense.relative) > AXIAL.gap
    assert fine.slack[1] == 8 * np.count_nonzero(np.diff(taut.astype(int)) == -1) > 50
    assert fine.slack[0] == pytest.approx(1 - taut.mean(), abs=2e-3)


def test_slack_is_told_where_one_looks(tmp_path):
    test = sine_test([SLACK, RIG.replace(tension_only=True)], 3.18, 50.0, duration=1)
    assert "; wires go slack in 1, for up to " in test.summary()
    assert test.table()["goes slack [times]"].tolist() == test.slack[:, 1].tolist() and test.slack[1].tolist() == [0, 0]
    usual = sine_test(RIG, 3.18, 50.0, duration=1)
    assert "slack" not in usual.summary() and not any("slack" in name for name in usual.table())
    record = simulate(SLACK, np.ones(20), 2000.0, start="equilibrium")
    assert record.summary().endswith("; a wire is slack 100% of the time and goes so 0 times")
    for name in ("record.csv", "record.nc"):
        record.save(tmp_path / name)
        assert Record.load(tmp_path / name).slack == record.slack
        assert Record.load(tmp_path / name).parameters == SLACK
    assert Record.joined([record, record]).slack is None


THEORY = {
    "the oscillator": lambda p: p.oscillator,
    "non-dimensional numbers": lambda p: p.nondimensional(3.18),
    "oscillator_modes": oscillator_modes,
    "frequency_response": lambda p: frequency_response(p, 3.18, [30.0]),
    "detached_curves": lambda p: detached_curves(p, 3.18),
    "force_scenario": force_scenario,
    "periodic_orbits": lambda p: periodic_orbits(p, 3.18),
    "response_sheet": lambda p: response_sheet(p, (20, 30), (3.0, 3.3)),
    "attractors": lambda p: attractors(p, 3.18, 30.0),
    "basins": lambda p: basins(p, 3.18, 30.0),
    "tap_map": lambda p: tap_map(p, 3.18, 30.0),
    "margins": lambda p: margins(p, 3.18),
    "tolerance_study": lambda p: tolerance_study(p, 3.18, {"d0": 1e-6}),
    "existence_chart": lambda p: existence_chart(p, 3.18, "c", "cs"),
    "cubic_law_error": lambda p: cubic_law_error(1e-3, p),
    "events over d0": lambda p: force_scenario(RIG, 3, band=(20, 30), force=(3.0, 3.3)).over("d0", [RIG.d0, p.d0]),
}


@KINDS
@pytest.mark.parametrize("name", THEORY)
def test_theory_refuses_in_one_line(name, rig):
    told = "k1 = -28.2353 N/m of d0 = 0.034003 m is not allowed; theory expects d0 of at most d = 0.034 m"
    with pytest.raises(ValueError) as caught:
        THEORY[name](rig)
    assert told in str(caught.value) and "sine_test" in str(caught.value) and "\n" not in str(caught.value)


def test_wires_just_as_long_as_their_places_are_still_theorys():
    limp = RIG.replace(d0=RIG.d)
    assert limp.gap == 0 and isinstance(limp.oscillator, OscillatorParameters)
    assert frequency_response(limp, 3.18, [30.0]).count[0] >= 1
