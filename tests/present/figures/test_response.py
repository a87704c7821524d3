"""Figures of the response room: what is drawn is what was computed, with units and a text alternative."""

import numpy as np
import pytest

from rigsim.parameters import RigParameters
from rigsim.present.figures.response import force_scenario_figure, frequency_response_figure
from rigsim.present.figures.style import style, subplots
from rigsim.theory.amplitude import frequency_response
from rigsim.theory.detached import force_scenario


@pytest.fixture(scope="module")
def response():
    return frequency_response(RigParameters(), 3.18, np.linspace(10, 80, 141))


def test_three_panels_with_units_and_every_point_of_every_piece(response):
    figure = response.plot()
    assert len(figure.axes) == 3 and "inner detached curve from 20.5 to 53.7 hertz" in figure.alt
    assert figure.axes[2].get_xlabel() == "frequency (Hz)"
    for ax, name in zip(figure.axes, ("shaker", "mass", "relative"), strict=True):
        assert ax.get_ylabel() == "amplitude (mm)" and ax.get_yscale() == "log"
        drawn = np.concatenate([line.get_xydata() for line in ax.lines if line.get_linestyle() in ("-", "--")])
        for piece in response.pieces:
            points = np.column_stack([piece.frequency, 1e3 * abs(getattr(piece, name))])
            assert {tuple(point) for point in points} <= {tuple(point) for point in drawn}
        assert {line.get_linestyle() for line in ax.lines} >= {"-", "--"}
    assert "single-term orbit" in figure.legends[0].get_title().get_text()


def test_a_second_response_and_circles_go_into_the_callers_axes(response):
    other = frequency_response(RigParameters().replace(cs=12.0), 3.18, response.frequency)
    circles = (response.frequency, *(values[:, 0] for values in (response.shaker, response.mass, response.relative)))
    with style():
        figure, axes = subplots(3, 1, alt="test")
    assert frequency_response_figure(response, beside=other, beside_label="other", circles=circles, axes=axes) is figure
    (rig,) = [line for line in axes[1].lines if line.get_label() == "multi-body rig"]
    np.testing.assert_allclose(rig.get_ydata(), 1e3 * abs(response.mass[:, 0]))
    assert any((line.get_label() or "").startswith("other") for line in axes[0].lines) and not figure.legends


def test_the_ladder_names_every_event():
    figure = force_scenario_figure(RigParameters(), force=3.18)
    for event in force_scenario(RigParameters()):
        assert event.kind in figure.alt and event.kind in figure.axes[0].get_title(loc="left")
    with pytest.raises(ValueError, match="k3 = 0"):
        force_scenario_figure(RigParameters().oscillator.replace(k3=0.0))
