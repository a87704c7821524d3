"""Best designs: the closed form of the force, and no better neighbour where there is none."""

import numpy as np
import pytest

from rigsim.design.best import design_for_detached_curve
from rigsim.design.count import existence_forces
from rigsim.design.margins import margins
from rigsim.parameters import RigParameters
from rigsim.results import Status

RIG = RigParameters()


def test_the_best_force_lies_half_way_between_birth_and_death():
    ((low, high),) = existence_forces(RIG)
    best = design_for_detached_curve(RIG, 3.18)
    assert best.force == pytest.approx(0.5 * (low + high), rel=2e-5)
    assert best.margin == pytest.approx((high - low) / (high + low), rel=1e-4)
    assert best.start_margin == pytest.approx(1 - low / 3.18, rel=1e-9)
    assert best.parameters == RIG and best.reach == {"force": best.margin}
    assert "force = 4.49" in best.summary()
    assert best.status is Status.CONVERGED and best.message.endswith("rigs were tried") and best.seed == 2014
    np.testing.assert_allclose(best.table().loc["force", ["before", "best"]].astype(float), [3.18, best.force])


def test_the_margin_is_the_smallest_reach_in_tolerances():
    tolerances = {"cs": "5 %", "force": "2 %"}
    best = design_for_detached_curve(RIG, 3.18, {"force": (2.0, 8.0)}, tolerances=tolerances)
    found = margins(RIG, best.force, names=["cs", "force"])
    for name in tolerances:
        width = found[name].value * float(tolerances[name].split()[0]) / 100
        # Moves in both directions; the damping may also fall to nothing, where it is never lost.
        assert best.reach[name] == pytest.approx(min(found[name].down, found[name].up) / width, rel=1e-6)
    for force in (best.force * 0.99, best.force * 1.01):
        nearby = design_for_detached_curve(RIG, force, {"force": (2.0, 8.0)}, tolerances=tolerances)
        assert nearby.start_margin < best.margin
    profile = best.profiles["force"]
    assert np.nanmax(profile[1]) == pytest.approx(best.margin, rel=1e-4) and np.isnan(profile[1]).any()


def test_a_curve_that_is_lost_at_a_hundred_thousandth_of_a_tolerance_and_found_again_is_lost():
    """The outer one exists at two ranges of the force; a thousandth of the tolerance reaches into the second."""
    (_, lost), (again, last) = existence_forces(RIG, "outer")
    tolerance = 1e3 * (0.5 * (again + last) - 0.47)
    best = design_for_detached_curve(RIG, 0.47, {"force": (0.46, 0.48)}, "outer", {"force": tolerance})
    assert best.start_margin == pytest.approx((lost - 0.47) / tolerance, rel=1e-6)


def test_two_free_numbers_do_better_than_one():
    tolerances = {"d0": 1e-6, "force": "5 %"}
    bounds = {"force": (2.0, 8.0), "d0": (33.985e-3, 34e-3)}
    both = design_for_detached_curve(RIG, 3.18, bounds, tolerances=tolerances)
    one = design_for_detached_curve(RIG, 3.18, {"force": bounds["force"]}, tolerances=tolerances)
    assert one.margin == pytest.approx(3.0, rel=1e-6)  # three micrometres of stretch, then the wires are slack
    assert both.margin > 1.3 * one.margin
    assert both.parameters.d0 == pytest.approx(both.free["d0"][2]) and set(both.profiles) == set(bounds)


def test_a_rig_without_the_curve_can_be_given_one():
    best = design_for_detached_curve(RIG, 1.0, {"force": (0.5, 8.0)})
    assert best.start_margin == 0 and best.force == pytest.approx(4.497, abs=1e-3)
    outer = design_for_detached_curve(RIG, 1.0, {"force": (1.0, 2.0)}, kind="outer")
    low, high = existence_forces(RIG, "outer")[1]
    assert outer.force == pytest.approx(0.5 * (low + high), rel=1e-4)


@pytest.mark.parametrize(
    "changes, message",
    [
        ({"free": "force"}, "free = 'force' is not allowed"),
        ({"free": ()}, "free is empty"),
        ({"free": ("mu",)}, "free quantity = 'mu' is not allowed"),
        ({"free": {"force": (5.0, 2.0)}}, "bounds of force = .* expected .low, high."),
        ({"free": {"force": (-1.0, 2.0)}}, r"bounds of force\[0\] = -1 N is not allowed"),
        ({"free": {"force": (0.01, 0.02)}}, "no inner detached curve was found for force from 0.01 to 0.02"),
        ({"tolerances": {}}, "expected a dict"),
        ({"force": -1.0}, "force = -1 N is not allowed"),
    ],
)
def test_what_is_not_allowed_is_named(changes, message):
    with pytest.raises(ValueError, match=message):
        design_for_detached_curve(**({"parameters": RIG, "force": 3.18} | changes))
