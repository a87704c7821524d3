"""The figure of the readings shows what the identifications hold."""

import numpy as np
import pytest

from rigsim import RigParameters, identify, random_test


@pytest.fixture(scope="module")
def readings():
    record = random_test(RigParameters(), duration=10)
    return [identify(record, conversion=name) for name in ("force", "all", "none")]


def test_lines_are_the_coefficients_and_the_closed_form_lies_under_them(readings):
    figure = readings[0].plot("readings", beside=readings[1:])
    real, imaginary = figure.axes
    assert [line.get_label() for line in real.lines] == ['"force"', '"all"', '"none"', "θ cot θ + iθ"]
    unit = readings[0].nonlinear_coefficient.real.mean()
    for line, each in zip(real.lines, readings, strict=False):
        np.testing.assert_allclose(line.get_ydata(), 100 * (each.nonlinear_coefficient.real / unit - 1), atol=1e-9)
    for axes in (real, imaginary):
        np.testing.assert_allclose(axes.lines[1].get_ydata(), axes.lines[3].get_ydata(), atol=0.1)
    assert '"all" lies between' in figure.alt and "Re" in real.get_ylabel()


def test_bad_input(readings):
    with pytest.raises(ValueError, match="identifications are by the readings all, none"):
        readings[1].plot("readings", beside=readings[2])
    with pytest.raises(ValueError, match="each once"):
        readings[0].plot("readings", beside=readings[0])
