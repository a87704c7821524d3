"""Figures of the response room: what is drawn is what was computed, with units and a text alternative."""

import numpy as np
import pytest

from rigsim.parameters import RigParameters
from rigsim.present.figures.style import style, subplots
from rigsim.theory.amplitude import frequency_response
from rigsim.theory.detached import detached_curves, folds, force_scenario


@pytest.fixture(scope="module")
def response():
    return frequency_response(RigParameters(), 3.18, np.linspace(10, 80, 141))


def test_three_panels_with_units_and_every_point_of_every_piece(response):
    figure = response.plot()
    assert len(figure.axes) == 3 and "inner detached curve from 20.5 to 53.7 hertz" in figure.alt
    assert figure.axes[2].get_xlabel() == "frequency [Hz]"
    for ax, name in zip(figure.axes, ("shaker", "mass", "relative"), strict=True):
        assert ax.get_ylabel() == "amplitude [mm]" and ax.get_yscale() == "log"
        drawn = np.concatenate([line.get_xydata() for line in ax.lines if line.get_linestyle() in ("-", "--")])
        for piece in response.pieces:
            points = np.column_stack([piece.frequency, 1e3 * abs(getattr(piece, name))])
            assert {tuple(point) for point in points} <= {tuple(point) for point in drawn}
        assert {line.get_linestyle() for line in ax.lines} >= {"-", "--"}
    assert "single-term orbit" in figure.legends[0].get_title().get_text()


def test_other_responses_go_into_the_callers_axes(response):
    other = frequency_response(RigParameters().replace(cs=12.0), 3.18, response.frequency)
    with style():
        figure, axes = subplots(3, 1, alt="test")
    assert response.plot(beside=other, beside_label="other", ax=axes) is figure
    assert any((line.get_label() or "").startswith("other") for line in axes[0].lines) and not figure.legends
    assert axes[2].get_legend() and not axes[0].get_legend()
    with pytest.raises(ValueError, match="ax has 2 elements; expected 3"):
        response.plot(ax=axes[:2])


@pytest.mark.parametrize("found", [detached_curves(RigParameters(), 3.18), folds(RigParameters(), 3.18)])
def test_detached_curves_and_folds_show_the_response_around_them(found):
    figure = found.plot(label="theory")
    assert "inner detached curve from 20.5 to 53.7 hertz" in figure.alt
    low, high = figure.axes[0].get_xlim()
    assert low < 20.5 and high > 106.9
    (diamonds,) = [line for line in figure.axes[2].lines if line.get_label() == "theory, folds"]
    np.testing.assert_allclose(np.sort(diamonds.get_xdata()), [f.frequency for f in folds(RigParameters(), 3.18)])


def test_without_a_detached_curve_the_response_is_shown_all_the_same():
    found = detached_curves(RigParameters().oscillator.replace(k3=0.0), 3.18)
    assert "none in this band" in found.plot().alt


def test_the_ladder_names_every_event():
    scenario = force_scenario(RigParameters())
    figure = scenario.plot(force=3.18)
    for event in scenario:
        assert event.kind in figure.alt and event.kind in figure.axes[0].get_title(loc="left")
    with style():
        mine, axes = subplots(1, 1, alt="test")
    assert scenario.plot(ax=axes) is mine and axes.get_ylabel() == "force amplitude [N]" and axes.get_legend()
    with pytest.raises(ValueError, match="k3 = 0"):
        force_scenario(RigParameters().oscillator.replace(k3=0.0)).plot()
