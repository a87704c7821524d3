"""Figures of records and identifications: what is drawn is what was found."""

import numpy as np
import pytest

from rigsim.identification.identify import identify
from tests.identification.cubic import cubic_record


@pytest.fixture(scope="module")
def record():
    return cubic_record(duration=10)


@pytest.fixture(scope="module")
def identification(record):
    return identify(record)


def lines(axis):
    return [line.get_ydata() for line in axis.get_lines()]


def test_record_shows_every_channel(record):
    figure = record.plot()
    assert [axis.get_ylabel() for axis in figure.axes] == ["force [N]", "shaker [mm]", "mass [mm]", "relative [mm]"]
    part = record.plot(interval=(1.0, 1.5))
    np.testing.assert_array_equal(lines(part.axes[1])[0], 1e3 * record.shaker[2000:3001])
    assert "from 1 to 1.5 s" in part.alt
    with pytest.raises(ValueError, match="interval = 20 to 30 s"):
        record.plot(interval=(20, 30))


def test_coefficient_receptances_and_singular_values(identification):
    real, imaginary = identification.plot("nonlinear coefficient").axes
    np.testing.assert_array_equal(lines(real)[0], identification.nonlinear_coefficient.real)
    np.testing.assert_array_equal(lines(imaginary)[0], identification.nonlinear_coefficient.imag)
    nominal = lines(real)[2]
    np.testing.assert_array_equal(nominal, identification.nominal.k3)
    axes = identification.plot("receptances").axes
    for axis, (row, column) in zip(axes[:3], ((0, 0), (1, 0), (1, 1)), strict=True):
        estimate, fit = axis.get_lines()
        np.testing.assert_array_equal(estimate.get_ydata(), np.abs(identification.receptance[:, row, column]))
        np.testing.assert_array_equal(fit.get_ydata(), np.abs(identification.fitted_receptance[:, row, column]))
        assert estimate.get_linestyle() == "-" and fit.get_linestyle() == "--"
    kept, left = lines(identification.plot("singular values").axes[0])
    np.testing.assert_array_equal(np.concatenate([kept, left]), identification.singular_values)
    assert kept.size == 4


def test_plot_puts_all_on_one_page_with_a_text_alternative(identification):
    figure = identification.plot()
    assert "11.72 and 55.65 Hz" in figure.alt
    assert 'aria-label="Identification of a record' in figure.svg()
