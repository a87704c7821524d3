"""Figures of design: what they show is what the results hold."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from rigsim import RigParameters, design_for_detached_curve, existence_chart, margins, tolerance_study

RIG = RigParameters()


def texts(figure):
    return " ".join(text.get_text() for ax in figure.axes for text in ax.texts)


def labels(figure):
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def test_a_chart_shows_boundaries_rig_and_box():
    chart = existence_chart(
        RIG, 3.18, ("d0", 33.985e-3, 34.001e-3), ("force", 0.3, 8.0), {"d0": 1e-6, "force": "2 %"}, points=(25, 31)
    )
    figure = chart.plot()
    (ax,) = figure.axes
    assert ax.get_yscale() == "log" and ax.get_xlabel() == "d0 [µm]"
    lines = [line for line in ax.lines if line.get_linestyle() == "-"]
    assert len(lines) == len(chart.boundaries)
    np.testing.assert_allclose(lines[0].get_xdata(), 1e6 * chart.boundaries[0].x)
    (box,) = [patch for patch in ax.patches if isinstance(patch, Rectangle)]
    assert (box.get_width(), box.get_height()) == (pytest.approx(2.0), pytest.approx(0.1272))
    assert box.get_x() + 1 == pytest.approx(33997)
    assert {"inner detached curve", "outer detached curve", "this rig", "its tolerances"} <= set(labels(figure))
    assert "no such rig (slack wires)" in labels(figure)
    assert "inner on" in figure.alt and "d0 = 33997" in figure.alt and figure.svg().startswith("<svg role=")


def test_a_chart_of_nothing_still_draws():
    figure = existence_chart(RIG, 3.18, ("mu", 0.01, 0.1), ("gamma", 1e-9, 1e-8), points=(4, 4)).plot()
    assert labels(figure) == [] and not figure.axes[0].lines  # the rig lies beyond the chart


def test_margins_name_the_move_in_the_builders_unit():
    found = margins(RIG, 3.18)
    figure = found.plot()
    (ax,) = figure.axes
    bars = [patch for patch in ax.patches if patch.get_height() < 0.5]
    assert len(bars) == 2 * len(found) and ax.get_xscale() == "log"
    first = found[0]
    assert f"+{1e6 * first.up:.3g} µm" in texts(figure) and texts(figure).count("never lost") == 2
    right = bars[1].get_x() + bars[1].get_width()
    assert right == pytest.approx(100 * first.up / first.value)
    assert "e+" not in texts(figure) and found.summary() in figure.alt


def test_a_study_shows_shares_and_distances():
    study = tolerance_study(RIG, 3.18, {"cs": "5 %", "d0": 1e-6}, samples=400)
    figure = study.plot()
    left, right = figure.axes
    assert [tick.get_text() for tick in left.get_yticklabels()] == ["cs ± 0.493 N s/m", "d0 ± 1 µm"]
    heights = np.array([[patch.get_height() for patch in group] for group in right.containers])
    assert heights.sum() == 400 and heights[1].sum() == study.share.kept  # stacked: the second is what is kept
    assert tolerance_study(RIG, 4.5, {"cs": "5 %"}, samples=50).plot().axes


def test_a_design_shows_its_profiles():
    best = design_for_detached_curve(RIG, 3.18, {"force": (2.5, 7.0)})
    figure = best.plot()
    (ax,) = figure.axes
    curve = ax.lines[0]
    np.testing.assert_array_equal(curve.get_ydata(), best.profiles["force"][1])
    assert ax.lines[2].get_xdata() == [pytest.approx(best.force)] and "force ± 100 %" in figure.get_suptitle()


def test_every_figure_draws_into_a_users_axes():
    study = tolerance_study(RIG, 3.18, {"cs": "5 %", "d0": 1e-6}, samples=50)
    best = design_for_detached_curve(RIG, 3.18, {"force": (2.5, 7.0)})
    chart = existence_chart(RIG, 3.18, "c", "cs", points=(9, 9))
    for result, panels in ((study, 2), (best, 1), (chart, 1), (margins(RIG, 3.18, names=["force", "cs"]), 1)):
        figure = Figure()
        axes = figure.subplots(1, panels)
        assert result.plot(ax=axes) is figure and len(figure.axes) == panels and not figure.legends
        assert all(axis.get_legend() for axis in figure.axes)
