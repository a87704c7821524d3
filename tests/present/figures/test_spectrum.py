"""Spectra of single sine tests show z at the force's frequency."""

import numpy as np
import pytest


def test_spectra_of_tests_show_z_at_f(test):
    figure = test.plot("spectrum", indices=[0, 3])
    grid = np.reshape(figure.axes, (2, 2))
    for (axes, tilt), i in zip(grid, (0, 3), strict=True):
        frequency, amplitude = axes.lines[0].get_data()
        assert amplitude[abs(frequency - 30).argmin()] == pytest.approx(1e3 * abs(test.relative[i]), rel=0.02)
        marks = {line.get_label(): line.get_xdata()[0] for line in axes.lines[1:]}
        assert marks == pytest.approx({"f": 30, "f/2": 15, "f/3": 10})
        assert axes.get_ylabel() == "z [mm]" and tilt.get_ylabel() == "tilt [°]"
        assert axes.get_xlim() == (0, 120) and "two wire sets" in axes.get_title("left")
    assert "tapped at 0.5 m/s" in figure.alt
    two = test.plot("spectrum", indices=3, beside=[test, test])
    assert len(two.axes) == 6 and [axes.get_title("left") for axes in two.axes[::2]] == 3 * [
        grid[1, 0].get_title("left")
    ]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"indices": [9]}, "i = 9"),
        ({"indices": []}, "indices is empty"),
        ({"highest": 0}, "highest = 0"),
    ],
)
def test_bad_input_is_named(test, options, message):
    with pytest.raises(ValueError, match=message):
        test.plot("spectrum", **options)
