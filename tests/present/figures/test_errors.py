"""Intervals as bars, and other readings of the parameters in half-widths."""

from dataclasses import replace

import numpy as np
import pytest

from rigsim.identification.identify import identify
from tests.identification.cubic import cubic_record


@pytest.fixture(scope="module")
def found():
    return identify(cubic_record(duration=20, noise=0.01))


def test_bars_are_half_widths_and_marks_are_as_far_off_as_they_are(found):
    left, right = found.plot("parameters").axes
    errors = found.errors
    widths = [bar.get_width() for bar in left.patches]
    np.testing.assert_allclose(widths, 100 * errors.half_width / errors.value)
    np.testing.assert_allclose(left.lines[0].get_xdata(), 196 * errors.bound / errors.value)
    read, nominal = (line for line in right.lines if line.get_label() in ("read from H_E alone", "nominal"))
    for line, parameters in ((read, found.read), (nominal, found.nominal)):
        off = [(getattr(parameters, name) - value) for name, value in zip(errors.names, errors.value, strict=True)]
        np.testing.assert_allclose(line.get_xdata(), np.clip(off / errors.half_width, -30, 30))
    assert [label.get_text() for label in left.get_yticklabels()] == list(errors.names)


def test_a_value_of_zero_has_no_bar_and_what_is_far_off_stands_on_the_edge(found):
    value = found.errors.value * (np.array(found.errors.names) != "c")
    errors = replace(found.errors, value=value, half_width=found.errors.half_width / 10)
    figure = replace(found, errors=errors).plot("parameters")
    assert np.isnan(figure.axes[0].patches[4].get_width())
    assert max(figure.axes[1].lines[1].get_xdata()) == 30
