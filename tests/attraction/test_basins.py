"""Basins: shares with intervals, and a picture that says what its states do."""

import numpy as np
import pytest

from rigsim import RigParameters, basins
from rigsim.attraction.basins import wilson

RIG = RigParameters()


@pytest.fixture(scope="module")
def found():
    return basins(RIG, 3.18, 40.0, pixels=41, samples=1024)


def test_shares_add_up_and_agree_with_plain_random_states(found):
    np.testing.assert_allclose(found.share.sum(), 1)
    assert ((found.share_low < found.share) & (found.share < found.share_high)).all()
    states = np.random.default_rng(8).uniform(-1, 1, (2000, 4)) * found.landscape.box
    label, _ = found.landscape.settle(states)
    low, high = wilson(np.bincount(label, minlength=3), 2000)
    assert ((low < found.share_high) & (found.share_low < high)).all()


def test_picture_is_of_its_own_states(found):
    low = found.landscape.find("low").orbit[0]
    row, column = np.random.default_rng(1).integers(41, size=(2, 40))
    states = np.tile(low, (40, 1))
    states[:, 1], states[:, 3] = found.z[column], found.speed[row]
    assert np.array_equal(found.label[row, column], found.landscape.settle(states)[0])
    near = np.abs(found.z - low[1]).argmin(), np.abs(found.speed - low[3]).argmin()
    assert found.attractors[found.label[near[1], near[0]]].name == "low"


def test_window_and_motion_can_be_chosen():
    found = basins(RIG, 3.18, 30.0, "high", pixels=9, window=(1e-3, 0.1), samples=64, starts=64)
    assert found.around == "high" and found.z[-1] == 1e-3 and found.speed[0] == -0.1
    assert "Basins at 30 Hz" in repr(found) and list(found.table()["motion"]) == ["low", "high"]
    with pytest.raises(ValueError, match="attractor = 'middle'"):
        basins(RIG, 3.18, 30.0, "middle", starts=64)


def test_interval_is_wilsons():
    # Agresti and Coull (1998): 0 of 10 gives 0 to 0.278; and 10 of 100 by hand.
    low, high = wilson(np.array([0, 10]), np.array([10, 100]))
    np.testing.assert_allclose(low, [0, 0.0552], atol=1e-4)
    np.testing.assert_allclose(high, [0.2775, 0.1744], atol=1e-4)
