"""Taps: what the map says, the smallest one, and the multi-body rig tapped alike."""

import numpy as np
import pytest

from rigsim import RigParameters, sine_test, smallest_tap, tap_map
from rigsim.results import Status

RIG = RigParameters()


@pytest.fixture(scope="module")
def taps():
    return tap_map(RIG, 3.18, 40.0, velocity=np.linspace(-1, 1, 41), instants=24)


def test_no_tap_changes_nothing(taps):
    assert taps.motion == 0 and taps.velocity[20] == 0
    assert taps.reached("low")[20].all()
    assert {"low", "high", "subharmonic 1/2"} == set(taps.attractors.names)
    # A tap half a period later along -x is the mirror image of the first.
    mirrored = np.roll(taps.label[::-1], 12, axis=1)
    assert (mirrored == taps.label).mean() > 0.99


def test_surest_tap_is_surrounded_by_its_like(taps):
    row, column = taps.surest("high")
    there = np.roll(taps.reached("high"), 12 - column, axis=1)
    assert 1 < row < 39 and there[row - 2 : row + 3, 10:15].all()
    with pytest.raises(ValueError, match="motion = 'middle'"):
        taps.surest("middle")


@pytest.mark.parametrize("name", ["high", "subharmonic 1/2"])
def test_smallest_tap_is_verified_and_smaller_ones_fail(taps, name):
    found = smallest_tap(taps, name)
    assert found.verified and found.spared == 1
    assert found.velocity > 0  # of a tap and its mirror image, half a period later, the one along +x
    assert abs(found.velocity) <= np.abs(taps.velocity[taps.reached(name).any(axis=1)]).min()
    # By another path: the flow itself, tap by tap.
    state = taps.attractors.find("low").orbit[0]
    states, _ = taps.attractors.flow.tapped(state, found.instant, found.velocity * np.array([1, 0.97, 0.9]), 2e-3)
    reached = [taps.attractors.names[i] for i in taps.attractors.settle(states)[0]]
    assert reached[0] == name and name not in reached[1:]
    # Nor do taps one per cent smaller a little earlier or later.
    instants, velocity = found.instant + np.linspace(-1, 1, 65) / 32, found.velocity * np.array([0.99, 0.985])
    states = np.concatenate([taps.attractors.flow.tapped(state, at % 1.0, velocity, 2e-3)[0] for at in instants])
    assert (taps.attractors.settle(states)[0] != taps.attractors.find(name).motion).all()
    tap = found.tap(after=2.99)
    assert tap.time >= 2.99 and tap.velocity == found.velocity
    np.testing.assert_allclose((tap.time * 40 - found.instant) % 1, 0, atol=1e-9)


def _agreement(frequency, count, seed):
    """Share of taps, drawn evenly over the motions of the map, after which the rig moves as the map says."""
    taps = tap_map(RIG, 3.18, frequency, velocity=np.linspace(-1, 1, 41), instants=24)
    generator = np.random.default_rng(seed)
    chosen, wanted = [], []
    for k in range(count):
        one = taps.attractors[k % len(taps.attractors)]
        # Inside its region, not on the rim: all neighbours lead there, too.
        inside = taps.reached(one.name)
        for axis, shift in ((0, 1), (0, -1), (1, 1), (1, -1)):
            inside = inside & np.roll(taps.reached(one.name), shift, axis)
        places = np.argwhere(inside)
        if len(places):
            row, column = places[generator.integers(len(places))]
            chosen.append(taps.tap(row, column, after=4.0))
            wanted.append(one)
    test = sine_test(RIG, 3.18, frequency, chosen, duration=8)
    same = [
        abs(z / one.relative[one.period] - 1) < 0.03 and (status == Status.SUBHARMONIC) == (one.period > 1)
        for z, status, one in zip(test.relative, test.status, wanted, strict=True)
    ]
    assert {one.name for one in wanted} >= {"low", "high"}
    return np.mean(same)


def test_rig_goes_where_the_map_says():
    assert _agreement(40.0, 9, 0) == 1


@pytest.mark.full
@pytest.mark.parametrize("frequency", [30.0, 35.0, 45.0, 50.0])
def test_rig_goes_where_the_map_says_along_the_detached_curve(frequency):
    assert _agreement(frequency, 30, 1) >= 0.9


def test_bad_input_is_named(taps):
    with pytest.raises(ValueError, match="duration = 0 s"):
        tap_map(RIG, 3.18, 30.0, duration=0)
    with pytest.raises(ValueError, match="motion = 'none'"):
        taps.reached("none")
    short = tap_map(RIG, 3.18, 30.0, velocity=[0.0, 1e-3], instants=2, starts=64)
    with pytest.raises(ValueError, match="no tap of the map leads to 'high'"):
        smallest_tap(short, "high")
