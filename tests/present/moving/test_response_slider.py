"""The response slider says what theory says."""

import re

import numpy as np
import pytest

from rigsim import RigParameters, detached_curves, frequency_response
from rigsim.present.moving.response_slider import response_slider

PARAMETERS = RigParameters().oscillator
FREQUENCY = np.linspace(10, 80, 141)


@pytest.fixture(scope="module")
def slider():
    forces = (1.0, 3.18)
    responses = [frequency_response(PARAMETERS, force, FREQUENCY) for force in forces]
    circles = ([20.0], [1e-4], [np.nan], [1e-3j])
    return response_slider("Force", forces, "N", responses, beside=responses[1], circles=circles, start=1)


def test_notes_name_the_detached_curves(slider):
    (curve,) = detached_curves(PARAMETERS, 3.18)
    low, high = (float(number) for number in re.findall(r"[\d.]+\d", slider.notes[1]))
    assert (low, high) == pytest.approx((curve.low, curve.high), abs=0.05)
    assert not detached_curves(PARAMETERS, 1.0) and "no detached curve" in slider.notes[0]


def test_every_solution_is_drawn_with_its_stability(slider):
    response = frequency_response(PARAMETERS, 3.18, FREQUENCY)
    for panel, channel in zip(slider.panels, (response.shaker, response.mass, response.relative), strict=True):
        for kind, stable in (("stable", True), ("unstable", False)):
            at = [
                (x, y) for curve in panel.curves[1] if curve.kind == kind for x, y in zip(curve.x, curve.y, strict=True)
            ]
            drawn = np.array(at)
            rows, columns = np.nonzero((response.stable == stable) & np.isfinite(channel))
            for row, column in list(zip(rows, columns, strict=True))[::7]:
                distance = np.hypot(*(drawn - [FREQUENCY[row], 1e3 * abs(channel[row, column])]).T)
                assert distance.min() < 1e-6


def test_circles_and_comparison_stay(slider):
    html = slider._repr_html_()
    assert [len([c for c in panel.fixed if c.kind == "point"]) for panel in slider.panels] == [1, 1, 1]
    assert html.count("a30 30 0 1 0 60 0") == 2, "NaN leaves a circle out"
    assert 'aria-label="Three plots' in html and "from 10 to 80 hertz" in html


def test_one_response_for_each_value():
    with pytest.raises(ValueError, match="1 lists of curves; expected 2"):
        response_slider("Force", [1, 2], "N", [frequency_response(PARAMETERS, 1.0, FREQUENCY)])
