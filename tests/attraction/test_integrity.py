"""Integrity: everything inside the ball returns, and the state on its rim does not."""

from dataclasses import replace

import numpy as np
import pytest

from rigsim import RigParameters, Status, attractors, frequency_response, integrity

RIG = RigParameters()


def test_ball_lies_in_the_basin_and_touches_its_rim():
    found = integrity(RIG, 3.18, [30.0, 60.0], "high", samples=512)
    assert found.status == 2 * (Status.FOUND,) and found.attractors[0].names[found.neighbour[0]] == "low"
    for f, radius, offset, neighbour in zip(found.frequency, found.radius, found.offset, found.neighbour, strict=True):
        there = attractors(RIG, 3.18, f)
        motion = there.find("high").orbit[0]
        scale = np.array([1, 1, 2 * np.pi * f, 2 * np.pi * f])
        np.testing.assert_allclose(np.linalg.norm(offset / scale), radius, rtol=1e-12)
        assert there.settle((motion + offset)[None])[0][0] == neighbour
        normal = np.random.default_rng(2).normal(size=(2000, 4))
        inside = normal / np.linalg.norm(normal, axis=1)[:, None] * 0.97 * radius
        label, _ = there.settle(motion + inside * scale)
        assert (label == there.find("high").motion).mean() > 0.999


def test_missing_motion_is_said():
    found = integrity(RIG, 3.18, [30.0, 70.0], "high", samples=64, starts=64)
    assert np.isfinite(found.radius[0]) and np.isnan(found.radius[1])
    assert found.status == (Status.FOUND, Status.NOT_FOUND) and list(found.motion) == [1, -1]
    assert "no motion 'high'" in found.message[1] and "low" in found.message[1]
    assert "Integrity of 'high'" in repr(found) and len(found.table()) == 2
    with pytest.raises(ValueError, match="samples = 1"):
        integrity(RIG, 3.18, 30.0, samples=1)


def test_an_undecided_state_ends_the_ball(monkeypatch):
    """Beyond a tenth of a millimetre nothing is trapped: the radius is that, and no motion is named."""

    def far_is_lost(found, states):
        offset = (states - found[1].orbit[0]) / np.array([1, 1, 60 * np.pi, 60 * np.pi])
        return found, np.where(np.linalg.norm(offset, axis=1) > 1e-4, -1, 1)

    monkeypatch.setattr("rigsim.attraction.integrity.settle_and_learn", far_is_lost)
    found = integrity(RIG, 3.18, 30.0, "high", samples=64, starts=64)
    assert found.status == (Status.FOUND,) and found.message == ("",) and list(found.neighbour) == [-1]
    assert 1e-4 < found.radius[0] < 1.3e-4 and found.table()["beyond it"][0] == ""


def test_one_quiet_ball_does_not_end_the_search(monkeypatch):
    """Whether the states of a ball return is scripted: farther than so many metres from the motion they do not."""
    limits = iter([1e-4, np.inf, 5e-5, np.inf, np.inf])

    def scripted(found, states):
        offset = (states - found[1].orbit[0]) / np.array([1, 1, 60 * np.pi, 60 * np.pi])
        return found, np.where(np.linalg.norm(offset, axis=1) > next(limits), 0, 1)

    monkeypatch.setattr("rigsim.attraction.integrity.settle_and_learn", scripted)
    found = integrity(RIG, 3.18, 30.0, "high", samples=256, starts=64)
    assert 5e-5 < found.radius[0] < 7e-5 and list(found.neighbour) == [0]
    assert not list(limits), "two quiet balls running are enough"


@pytest.mark.parametrize(("name", "column"), [("high", 2), ("other", 0)])
@pytest.mark.parametrize("first", [0, 1])
def test_of_two_motions_of_one_name_the_one_nearest_to_theory_is_followed(monkeypatch, name, column, first):
    """To the solution of the name, or where no solution bears it to any, however far the others are."""
    theory = frequency_response(RIG, 3.18, [30.0]).relative[0]
    found = attractors(RIG, 3.18, 30.0, starts=64)
    lines = [found[1].relative * share * theory[column] / found[1].relative[1] for share in (1.01, 1.1)]
    order = [lines[first], lines[1 - first]]
    members = tuple(replace(one, name=name, relative=line) for one, line in zip(found, order, strict=True))
    monkeypatch.setattr("rigsim.attraction.integrity.attractors", lambda *_, **__: replace(found, members=members))
    monkeypatch.setattr("rigsim.attraction.integrity._ball", lambda found, *_: (found, 1.0, np.zeros(4), -1))
    followed = integrity(RIG, 3.18, 30.0, name)
    assert list(followed.motion) == [first]
