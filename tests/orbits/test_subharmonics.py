"""Subharmonic motions: met by the search, followed to folds, found again by shooting, and seen on the rig."""

import numpy as np
import pytest

from rigsim import RigParameters, sine_test, subharmonic_motions, tap_map
from rigsim.attraction.attractors import default_box
from rigsim.attraction.flow import Flow
from rigsim.attraction.traps import closed_orbit
from rigsim.results import Status

RIG = RigParameters()


@pytest.fixture(scope="module")
def found():
    return subharmonic_motions(RIG, 3.18, [70.0, 74.0], starts=64)


def test_both_families_are_met_and_closed(found):
    assert [family.period for family in found.families] == [2, 3]
    for family, reach in zip(found.families, ((59.358, 76.312), (62.301, 120.981)), strict=True):
        assert family.branch.closed and len(family.folds) == 2
        np.testing.assert_allclose(sorted(family.folds), reach, atol=2e-3)
        assert list(family.met) == [70.0, 74.0]


def test_folds_are_where_the_motion_ends(found):
    """Newton on the stroboscopic map, which shares no code with harmonic balance, closes inside the fold only."""
    branch = found.families[0].branch
    at = branch.folds[int(np.argmax(branch.frequency[list(branch.folds)]))]
    fold = branch.frequency[at]
    lines = np.array([branch.shaker[at], branch.relative[at]])
    rate = 2j * np.pi * fold / 2 * np.arange(lines.shape[1])
    state = np.concatenate([lines.real.sum(axis=1), (rate * lines).real.sum(axis=1)])
    box = default_box(RIG, 3.18, fold)
    closed = [closed_orbit(Flow(RIG, "exact", 3.18, fold + shift, 80), state, 2, box) for shift in (-1e-2, 1e-2)]
    assert closed[0] is not None and closed[0][0] == 2
    assert abs(closed[0][2] - 1).min() < 0.3  # on their way to +1, as the root of the distance
    assert closed[1] is None or closed[1][0] == 1


def test_motions_lie_on_their_curves_and_shooting_agrees(found):
    for one in found.motions:
        family = next(family for family in found.families if family.period == one.period)
        branch = family.branch
        at = int(np.abs(branch.frequency - one.frequency + 10 * ~branch.stable).argmin())
        shot = branch.shoot(at)
        assert shot.converged and shot.stable == branch.stable[at]
        assert one.giveaway[0] == pytest.approx(one.frequency / one.period)
        assert one.giveaway[1] > 2 * abs(one.relative[one.period])
        assert one.share > 0.05


def test_table_and_summary_tell(found):
    table = found.table()
    assert list(table["period"]) == [2, 3, 2, 3] and list(table["frequency [Hz]"]) == [70, 70, 74, 74]
    assert "period 2 from 59.36" in found.summary() and "closed" in found.families[0].summary()
    figure = found.plot()
    assert "period 3 from 62.3 to 121.0 hertz" in figure.alt and len(figure.axes) == 2


def test_band_without_any_has_none():
    none = subharmonic_motions(RIG, 3.18, [28.0], starts=32)
    assert none.families == () and none.motions == () and "families: none" in repr(none)
    assert "none" in none.plot().alt
    with pytest.raises(ValueError, match="frequency"):
        subharmonic_motions(RIG, 3.18, [-1.0])


def _on_the_rig(frequency, period):
    """Tap the rig a dozen times as the map says: those that stay, and the motion of the theory.

    Basins are so finely mixed here that the rig, a little different, leaves for another motion after some of the taps.
    """
    taps = tap_map(RIG, 3.18, frequency, velocity=np.linspace(-1, 1, 41), instants=24)
    name = f"subharmonic 1/{period}"
    places = np.argwhere(taps.reached(name))
    chosen = places[np.linspace(0, len(places) - 1, 12).astype(int)]
    test = sine_test(RIG, 3.18, frequency, [taps.tap(*place, after=4.0) for place in chosen], duration=9)
    line = frequency / test.subharmonic[:, 1]
    there = (test.status == Status.SUBHARMONIC) & (abs(line - frequency / period) < 0.01 * frequency)
    return np.abs(test.relative[there]), test.subharmonic[there, 0], taps.attractors.find(name)


@pytest.mark.parametrize(("frequency", "period"), [(70.0, 2), (74.0, 3)])
def test_rig_has_them_too(frequency, period):
    z, ratio, motion = _on_the_rig(frequency, period)
    assert len(z) >= 2
    np.testing.assert_allclose(z, abs(motion.relative[period]), rtol=0.02)
    np.testing.assert_allclose(ratio * z, motion.giveaway[1], rtol=0.02)


@pytest.mark.full
@pytest.mark.parametrize(
    ("frequency", "period"), [(40.0, 2), (65.0, 3), (66.0, 3), (73.0, 3), (73.0, 2), (78.0, 3), (90.0, 3), (105.0, 3)]
)
def test_rig_has_them_all_over_the_band(frequency, period):
    z, ratio, motion = _on_the_rig(frequency, period)
    assert len(z) >= 1
    np.testing.assert_allclose(ratio * z, motion.giveaway[1], rtol=0.03)


@pytest.mark.full
def test_whole_band():
    """At least 200 starts every 2 Hz from 40 to 110 Hz: every motion of two or three periods lies on a closed curve."""
    found = subharmonic_motions(RIG, 3.18)
    assert found.starts >= 200 and found.frequency.size == 36
    assert all(len(family.folds) >= 2 and family.branch.closed for family in found.families)
    assert {family.period for family in found.families} == {2, 3}
    followed = [one for one in found.motions if one.period in (2, 3)]
    assert sum(family.met.size for family in found.families) == len(followed) >= 30
