"""The rig over the theory: lines stand where theory is, points where the rig was, in the colours of the motions."""

import numpy as np
import pytest

from rigsim.experiment.sine_test import sine_test
from rigsim.paper.virtual_experiment import overlay
from rigsim.parameters import RigParameters
from rigsim.present.figures.style import MOTIONS
from rigsim.theory.amplitude import frequency_response

RIG = RigParameters()
AXES = ("shaker", "mass", "relative")


def test_branches_hold_theory_the_rig_and_what_was_missed(test):
    low = sine_test(RIG, 3.18, [30.0, 66.0])
    found = overlay(RIG, low)
    figure = found.plot(nominal=RIG.replace(cs=9.0))
    missing = found.missing()
    assert (30.0, "high") in missing, "no tap was tried"
    for axes, name in zip(figure.axes, AXES, strict=True):
        drawn = {line.get_label(): line.get_xydata() for line in axes.lines}
        rig = np.concatenate([xy for label, xy in drawn.items() if label.startswith("rig: ")])
        np.testing.assert_allclose(np.sort(rig[:, 1]), np.sort(1e3 * abs(getattr(low, name))))
        crosses = drawn["stable in theory, not reached"]
        theory = frequency_response(RIG, 3.18, [30.0])
        cross = crosses[[f == 30 and b == "high" for f, b in missing]]
        np.testing.assert_allclose(cross, [[30, 1e3 * abs(getattr(theory, name)[0, 2])]])
        assert axes.get_yscale() == "log" and axes.get_xlim()[0] < 10 < 80 < axes.get_xlim()[1]
        assert "nominal theory, stable" in drawn and "theory, unstable" in drawn
        assert axes.get_ylabel().endswith("[mm]")
    assert "low branch" in figure.alt and "not reached" in figure.alt


def test_a_motion_has_its_colour(test):
    figure = overlay(RIG, test).plot()
    colors = {line.get_label(): line.get_color() for line in figure.axes[0].lines}
    assert colors["rig: low branch"] == MOTIONS["low"] and colors["rig: subharmonic"] == MOTIONS["subharmonic"]


def test_bad_input_is_named(test):
    with pytest.raises(ValueError, match=r"band = \(50, 40\) Hz"):
        overlay(RIG, test).plot(band=(50, 40))
