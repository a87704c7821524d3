"""The response surface: every point of the sheet solves Eq. (5a), and its edges are the folds."""

import numpy as np
import pytest
from mpl_toolkits.mplot3d.art3d import Line3D

from rigsim import OscillatorParameters, RigParameters, folds, frequency_response
from rigsim.design.count import existence_forces
from rigsim.present.figures.surface import _sheet, response_surface_figure

RIG = RigParameters()


@pytest.mark.parametrize("quantity", ["shaker", "mass", "relative"])
def test_points_of_the_sheet_are_solutions_of_their_layer(quantity):
    frequency = np.linspace(9.0, 65.0, 12)  # the first has no folds
    layers, _ = _sheet(RIG.oscillator, frequency, (0.3, 7.0), quantity, 9)
    tried = 0
    for number, (force, amplitude) in enumerate(layers):
        for i, j in np.argwhere(np.isfinite(force)):
            if j in (0, 8):
                continue  # on a fold or at an end, where rounding may tell either way
            response = frequency_response(RIG, force[i, j], [frequency[i]])
            solutions = 1e3 * abs(getattr(response, quantity)[0])
            wanted = number if response.count[0] == 3 else 0
            assert amplitude[i, j] == pytest.approx(solutions[wanted], rel=1e-7)
            assert number != 1 or response.count[0] == 3
            assert 0.3 <= force[i, j] <= 7.0
            tried += 1
    assert tried > 150


def test_fold_lines_pass_through_the_folds():
    found = [fold for fold in folds(RIG, 3.18) if fold.frequency < 120]
    frequency = np.array([fold.frequency for fold in found])
    _, lines = _sheet(RIG.oscillator, frequency, (0.3, 7.0), "relative", 5)
    for i, fold in enumerate(found):
        force, amplitude = lines[0 if fold.kind == "lower" else 1]
        assert force[i] == pytest.approx(3.18, rel=1e-6)
        assert amplitude[i] == pytest.approx(1e3 * abs(fold.relative), rel=1e-5)


def test_the_figure_shows_both_fold_lines_and_the_detached_curve():
    figure = response_surface_figure(RIG, resolution=60)
    lower, sheet = figure.axes
    assert sheet.get_zlabel() == "amplitude (mm)" and lower.get_ylabel() == sheet.get_ylabel() == "force (N)"
    names = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    assert len(names) == len(set(names)) and "inner detached curve at 3.18 N" in names
    assert "inner detached curve from 20.5 to 53.7 hertz" in figure.alt
    assert sum(isinstance(line, Line3D) for line in sheet.lines) == len(sheet.lines) >= 4
    (solid,) = [line for line in lower.lines if "gamma_+" in line.get_label()]
    force = np.asarray(solid.get_ydata())
    born, died = existence_forces(RIG)[0]
    below = np.asarray(solid.get_xdata()) < 50
    assert np.nanmax(force[below]) == pytest.approx(died, rel=2e-3)  # the hump's top is the curve's death
    assert figure.svg().startswith("<svg role=")


def test_without_a_detached_curve_it_says_so():
    figure = response_surface_figure(RIG, (5.95, 8), (15, 60), force=6.5, quantity="mass", resolution=16)
    assert "no closed detached curve" in figure.alt


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"forces": (3, 2)}, "forces"),
        ({"forces": (1, 2, 3)}, "forces"),
        ({"frequencies": (0, 5)}, "frequencies"),
        ({"force": 9}, "force"),
        ({"quantity": "speed"}, "quantity"),
        ({"resolution": 2}, "resolution"),
    ],
)
def test_bad_input_is_named(options, named):
    with pytest.raises(ValueError, match=f"^{named}") as caught:
        response_surface_figure(RIG, **options)
    assert "\n" not in str(caught.value)


def test_a_linear_spring_has_no_sheet():
    linear = OscillatorParameters(ms=0.15, ks=19e3, cs=9.9, m=0.005, c=0.03, k1=28, k3=0)
    with pytest.raises(ValueError, match="^k3"):
        response_surface_figure(linear)
