"""The figure of the response surface: what is drawn is what was computed."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Line3D

from rigsim.design.count import existence_forces
from rigsim.parameters import RigParameters
from rigsim.theory.detached import force_scenario

RIG = RigParameters()
SCENARIO = force_scenario(RIG)


def test_the_figure_shows_both_fold_lines_and_the_detached_curve():
    figure = SCENARIO.plot("surface", resolution=60)
    lower, sheet = figure.axes
    assert sheet.get_zlabel() == "amplitude [mm]" and lower.get_ylabel() == sheet.get_ylabel() == "force [N]"
    names = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    assert len(names) == len(set(names)) and "inner detached curve at 3.18 N" in names
    assert "inner detached curve from 20.5 to 53.7 hertz" in figure.alt
    assert sum(isinstance(line, Line3D) for line in sheet.lines) == len(sheet.lines) >= 4
    (solid,) = [line for line in lower.lines if "gamma_+" in line.get_label()]
    force = np.asarray(solid.get_ydata())
    _, died = existence_forces(RIG)[0]
    below = np.asarray(solid.get_xdata()) < 50
    assert np.nanmax(force[below]) == pytest.approx(died, rel=2e-3)  # the hump's top is the curve's death
    assert figure.svg().startswith("<svg role=")


def test_without_a_detached_curve_it_says_so():
    figure = SCENARIO.plot("surface", forces=(5.95, 8), band=(15, 60), force=6.5, quantity="mass", resolution=16)
    assert "no closed detached curve" in figure.alt


def test_it_draws_into_a_users_axes_if_the_first_has_depth():
    figure = Figure()
    axes = [figure.add_subplot(2, 1, 1, projection="3d"), figure.add_subplot(2, 1, 2)]
    assert SCENARIO.plot("surface", ax=axes, resolution=16) is figure and axes[0].collections and axes[1].get_legend()
    with pytest.raises(ValueError, match=r"ax\[0\] is flat"):
        SCENARIO.plot("surface", ax=[axes[1], axes[1]], resolution=16)
