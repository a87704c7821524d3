"""Whoever sees a planar result of one wire set is told so, unless three dimensions are shown beside it."""

import pytest

import rigsim
from rigsim import RigParameters, Tap

RIG = RigParameters()
ONE_SET = RIG.single_set()


@pytest.fixture(scope="module")
def tests():
    run = (3.18, [44.0, 70.0], [Tap(), None], 1.5)
    return {1: rigsim.sine_test(ONE_SET, *run), 2: rigsim.sine_test(RIG, *run)}


@pytest.mark.parametrize("what", ["lines", "spectrum", "distortion"])
def test_figures_of_one_set_say_that_they_are_planar(tests, what):
    titles = {
        sets: [axes.get_title(side) for axes in test.plot(what).axes for side in ("left", "center", "right")]
        for sets, test in tests.items()
    }
    assert any("in the plane only" in title for title in titles[1])
    assert not any("plane" in title for title in titles[2])


def test_overlay_and_animation_of_one_set_say_so_too(tests):
    one, two = (rigsim.overlay(RIG, tests[sets]) for sets in (1, 2))
    assert "in the plane only" in one.summary() and "plane" not in two.summary()
    assert "in the plane only" in one.plot().alt and "in the plane only" in one.plot().axes[0].get_title("right")
    freed = one.plot(space=tests[1].out_of_plane())
    assert "plane only" not in freed.alt and "z changes by more than 1 % in" in freed.alt
    moved = {sets: rigsim.rig_animation(p, tests[sets].record(0), frames=3) for sets, p in ((1, ONE_SET), (2, RIG))}
    assert "in the plane only" in moved[1].caption and "plane" not in moved[2].caption
