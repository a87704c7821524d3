"""The response surface: every point of the sheet solves Eq. (5a), and its edges are the folds."""

import numpy as np
import pytest

from rigsim.parameters import OscillatorParameters, RigParameters
from rigsim.theory.amplitude import frequency_response
from rigsim.theory.detached import folds, force_scenario

RIG = RigParameters()


@pytest.mark.parametrize("quantity", ["shaker", "mass", "relative"])
def test_points_of_the_sheet_are_solutions_of_their_layer(quantity):
    surface = force_scenario(RIG).surface(band=(9.0, 65.0), quantity=quantity, resolution=12)
    frequency = surface.frequency  # the first has no folds
    tried = 0
    for number, (force, amplitude) in enumerate(surface.layers):
        for i, j in np.argwhere(np.isfinite(force)):
            if j in (0, 11):
                continue  # on a fold or at an end, where rounding may tell either way
            response = frequency_response(RIG, force[i, j], [frequency[i]])
            solutions = 1e3 * abs(getattr(response, quantity)[0])
            wanted = number if response.count[0] == 3 else 0
            assert amplitude[i, j] == pytest.approx(solutions[wanted], rel=1e-7)
            assert number != 1 or response.count[0] == 3
            assert 0.3 <= force[i, j] <= 7.0
            tried += 1
    assert tried > 150


def test_every_layer_reaches_the_forces_at_which_there_are_three():
    surface = force_scenario(RIG).surface(forces=(1.0, 3.18), band=(15.0, 110.0), force=2.0, resolution=20)
    tried = 0
    for i, frequency in enumerate(surface.frequency):
        for end, wanted in ((np.nanmin, 1.0), (np.nanmax, 3.18)):
            if frequency_response(RIG, wanted, [frequency]).count[0] == 3:
                for force, _ in surface.layers:
                    assert end(force[i]) == pytest.approx(wanted, rel=1e-9)
                tried += 1
    assert tried > 12


def test_fold_lines_pass_through_the_folds():
    for fold in folds(RIG, 3.18):
        # The first of the columns is where the fold is.
        surface = force_scenario(RIG).surface(band=(fold.frequency, 150.0), resolution=8)
        force, amplitude = surface.lines[0 if fold.kind == "lower" else 1]
        assert force[0] == pytest.approx(3.18, rel=1e-6)
        assert amplitude[0] == pytest.approx(1e3 * abs(fold.relative), rel=1e-5)


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"forces": (3, 2)}, "forces"),
        ({"forces": (1, 2, 3)}, "forces"),
        ({"band": (0, 5)}, "band"),
        ({"force": 9}, "force"),
        ({"quantity": "speed"}, "quantity"),
        ({"resolution": 2}, "resolution"),
    ],
)
def test_bad_input_is_named(options, named):
    with pytest.raises(ValueError, match=f"^{named}") as caught:
        force_scenario(RIG).surface(**options)
    assert "\n" not in str(caught.value)


def test_a_linear_spring_has_no_sheet():
    linear = OscillatorParameters(ms=0.15, ks=19e3, cs=9.9, m=0.005, c=0.03, k1=28, k3=0)
    with pytest.raises(ValueError, match="^k3"):
        force_scenario(linear).surface()
