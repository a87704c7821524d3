"""Drives compared at the same points: their margins, how far the rig is from the theory, and mistakes."""

import numpy as np
import pytest

from rigsim import RigParameters, Tap, compare_drives, margins, periodic_orbits, sine_test
from rigsim.model.shaker import MODES, ShakerDrive

RIG = RigParameters()


@pytest.fixture(scope="module")
def compared():
    return compare_drives(RIG, 3.18, [40.0, 56.0])


def test_each_drive_has_the_points_of_a_sine_test(compared):
    assert [drive.mode for drive in compared.drives] == list(MODES)
    for i, drive in enumerate(compared.drives):
        alone = sine_test(RIG, 3.18, [40.0, 56.0] * 2, [None] * 2 + [Tap()] * 2, duration=6, drive=drive)
        np.testing.assert_array_equal(compared.test.relative[compared.points(i)], alone.relative)
        np.testing.assert_array_equal(compared.test.driven.force[compared.points(i)], alone.driven.force)


def test_only_a_held_force_leaves_the_detached_curve(compared):
    table = compared.table()
    assert list(table["detached"] == "none") == [False, True, False, True]
    found = margins(RIG, 3.18, names=["cs", "force"])
    np.testing.assert_allclose(table["cs may rise by [N s/m]"], [found["cs"].up, np.nan] * 2)
    np.testing.assert_allclose(table["force may fall by [%]"], [100 * found["force"].down / 3.18, np.nan] * 2)
    assert table.loc["current", "inner curves at [N]"] == "3.09 to 5.91"
    assert table.loc["voltage", "at [Hz]"] == 56 and table.loc["voltage", "least |f| [N]"] < 0.25 * 3.18
    assert (table["z off theory [%]"] < 3.5).all() and (table["at the limit"] == 0).all()
    assert "constant current, force" in repr(compared)


def test_the_distance_from_the_theory_counts_only_settled_points(compared):
    apart = compared.apart(1)
    assert apart.shape == (4, 2) and (apart[:2] < 5e-4).all()
    short = compare_drives(RIG, 3.18, [20.0], [ShakerDrive()], tap=None, duration=1)
    assert np.isnan(short.apart(0)).all() and np.isnan(short.table()["voltage [V]"]).all()


def test_with_constant_voltage_the_rig_is_on_converged_orbits_of_the_rig_it_is_equivalent_to():
    """Nine harmonics and the wires' own law leave a thousandth of the 2.5 % between rig and single-term theory."""
    drive = ShakerDrive()
    equivalent, force = drive.equivalent(RIG, 3.18)
    assert isinstance(equivalent, RigParameters)
    orbits = periodic_orbits(equivalent, abs(force), band=(30, 57))
    assert len(orbits) == 3 and [branch.stable.all() for branch in orbits].count(True) == 2  # none of them closed
    frequency = np.array([32.0, 40.0, 52.0, 56.0])
    test = sine_test(RIG, 3.18, np.tile(frequency, 2), [None] * 4 + [Tap()] * 4, duration=8, drive=drive)
    stable = [branch for branch in orbits if branch.stable.all()]
    for f, z in zip(test.frequency, abs(test.relative), strict=True):
        found = []
        for branch in stable:
            order = np.argsort(branch.frequency)
            found.append(np.interp(f, branch.frequency[order], abs(branch.relative[order, 1])))
        assert min(abs(np.array(found) / z - 1)) < 1.5e-3


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"drives": []}, "drives has 0 elements; expected at least 1"),
        ({"drives": [None]}, "drives = None is not allowed; expected a ShakerDrive or several"),
        ({"tap": 0.5}, "tap = 0.5 is not allowed; expected a Tap or None"),
        ({"frequency": [1.0]}, r"frequency\[0\] = 1 Hz"),
    ],
)
def test_bad_input_is_named(changes, named):
    with pytest.raises(ValueError, match=named):
        compare_drives(**{"parameters": RIG, "force": 3.18, "frequency": [30.0]} | changes)
