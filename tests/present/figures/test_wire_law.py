"""The wires' law drawn: both equations, their error, and what a test uses of it."""

import numpy as np
import pytest

from rigsim.model.wires import cubic_law_error, suspension_force
from rigsim.parameters import RigParameters

RIG = RigParameters()


def lines(axes):
    return {line.get_label(): line.get_xydata() for line in axes.lines}


def test_wire_law_holds_both_laws_their_error_and_the_range_reached():
    figure = RIG.plot("wire law", reached=(0.2e-3, 2.7e-3))
    force, error = figure.axes
    z, exact = lines(force)["Eq. (1), exact"].T
    np.testing.assert_allclose(exact, suspension_force(z / 1e3, RIG))
    np.testing.assert_allclose(lines(force)["Eq. (2), cubic"][:, 1], RIG.k1 * z / 1e3 + RIG.k3 * (z / 1e3) ** 3)
    z, percent = lines(error)["error of Eq. (2)"].T
    np.testing.assert_allclose(percent, 100 * cubic_law_error(z / 1e3, RIG))
    assert error.get_xscale() == error.get_yscale() == "log"
    assert "[mm]" in error.get_xlabel() and "[%]" in error.get_ylabel() and "[N]" in force.get_ylabel()
    band = next(patch for patch in error.patches if patch.get_label() == "amplitudes in the test")
    assert (band.get_x(), band.get_x() + band.get_width()) == pytest.approx((0.2, 2.7))
    assert f"at most {100 * cubic_law_error(2.7e-3, RIG):.2g} %" in figure.alt


@pytest.mark.parametrize(
    ("options", "message"), [({"reached": (2e-3, 1e-3)}, "reached"), ({"largest": -1}, "largest = -1")]
)
def test_bad_input_is_named(options, message):
    with pytest.raises(ValueError, match=message):
        RIG.plot("wire law", **options)


@pytest.mark.parametrize("slack", [True, False])
def test_wire_law_marks_the_gap_of_slack_wires_and_the_wells_of_those_that_push(slack):
    rig = RIG.replace(d0=RIG.d + 3e-6, tension_only=slack)
    figure = rig.plot("wire law", largest=1e-3, reached=(1e-4, 7e-4))
    force, error = figure.axes
    z, exact = lines(force)["Eq. (1), exact"].T
    np.testing.assert_allclose(exact, suspension_force(z / 1e3, rig))
    cubic = lines(force)["Eq. (2), cubic, if wires pushed" if slack else "Eq. (2), cubic"][:, 1]
    np.testing.assert_allclose(lines(error)["Eq. (2) less Eq. (1)"][:, 1], cubic - exact)
    assert "[N]" in error.get_ylabel() and f"{1e3 * rig.gap:.3g} mm" in figure.alt
    spans = {patch.get_label(): patch.get_x() for patch in force.patches}
    assert spans["z reached"] == pytest.approx(-0.7)
    if slack:
        assert spans["wires slack"] == pytest.approx(-1e3 * rig.gap)
    else:
        np.testing.assert_allclose(lines(force)["at rest, without weight"], [[-1e3 * rig.gap, 0], [1e3 * rig.gap, 0]])
