"""Basins: shares with intervals, and a picture that says what its states do."""

import numpy as np
import pytest
from scipy.stats import binomtest

from rigsim import RigParameters, basins

RIG = RigParameters()


@pytest.fixture(scope="module")
def found():
    return basins(RIG, 3.18, 40.0, pixels=41, samples=1024)


def test_shares_add_up_and_agree_with_plain_random_states(found):
    np.testing.assert_allclose(found.share.sum(), 1)
    assert ((found.share_low < found.share) & (found.share < found.share_high)).all()
    states = np.random.default_rng(8).uniform(-1, 1, (2000, 4)) * found.attractors.box
    label, _ = found.attractors.settle(states)
    counts = np.bincount(label, minlength=3)
    low, high = np.transpose([binomtest(int(k), 2000).proportion_ci(method="wilson") for k in counts])
    assert ((low < found.share_high) & (found.share_low < high)).all()


def test_picture_is_of_its_own_states(found):
    low = found.attractors.find("low").orbit[0]
    row, column = np.random.default_rng(1).integers(41, size=(2, 40))
    states = np.tile(low, (40, 1))
    states[:, 1], states[:, 3] = found.z[column], found.speed[row]
    assert np.array_equal(found.label[row, column], found.attractors.settle(states)[0])
    near = np.abs(found.z - low[1]).argmin(), np.abs(found.speed - low[3]).argmin()
    assert found.attractors[found.label[near[1], near[0]]].name == "low"


def test_window_and_motion_can_be_chosen():
    found = basins(RIG, 3.18, 30.0, "high", pixels=9, window=(1e-3, 0.1), samples=64, starts=64)
    assert found.motion == 1 and found.z[-1] == 1e-3 and found.speed[0] == -0.1
    assert "Basins at 30 Hz" in repr(found) and list(found.table()["name"]) == ["low", "high"]
    with pytest.raises(ValueError, match=r"motion = 'middle' .* expected one of 0 \(low\), 1 \(high\)"):
        basins(RIG, 3.18, 30.0, "middle", starts=64)


def test_interval_is_wilsons(found):
    """Agresti and Coull (1998), Eq. (2), by hand."""
    n, share, normal = found.samples, found.share, 1.959963984540054
    middle = (share + normal**2 / (2 * n)) / (1 + normal**2 / n)
    half = normal / (1 + normal**2 / n) * np.sqrt((share * (1 - share) + normal**2 / (4 * n)) / n)
    np.testing.assert_allclose(found.share_low, middle - half, rtol=1e-12)
    np.testing.assert_allclose(found.share_high, middle + half, rtol=1e-12)
