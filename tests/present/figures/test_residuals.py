"""Residuals and predictions: white where the rig explains all, out of the bands where it does not."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure

from rigsim.identification.identify import identify
from rigsim.present.figures.residuals import left_over
from tests.identification.cubic import cubic_record


@pytest.fixture(scope="module")
def noisy():
    return identify(cubic_record(duration=20, noise=0.01))


def outside(axis):
    """Share of a correlation that is outside its band, which is the first patch."""
    band = axis.patches[0].get_height() / 2
    return np.mean(np.abs(axis.lines[0].get_ydata()) > band)


def test_what_white_noise_leaves_stays_in_the_bands_and_on_the_floor(noisy):
    figure = noisy.plot("residuals")
    spectra, correlations = figure.axes[:2], figure.axes[2:]
    assert "1 % of shaker are left" in figure.alt
    for axis in correlations:
        assert outside(axis) < 0.03
    for axis in spectra:
        _, left, floor = axis.lines
        np.testing.assert_allclose(np.median(left.get_ydata()), floor.get_ydata()[0], rtol=0.2)


def test_what_the_rig_does_not_explain_is_seen(noisy):
    wrong = replace(noisy, modelled=1.02 * noisy.modelled)
    figure = wrong.plot("residuals")
    assert all(outside(axis) > 0.1 for axis in figure.axes[2:])
    np.testing.assert_allclose(left_over(wrong).std(axis=0) / left_over(noisy).std(axis=0), np.sqrt(5), rtol=0.1)


def test_prediction_lays_the_simulated_rig_over_the_record(noisy):
    figure = noisy.plot("prediction", interval=(2.0, 2.5))
    recorded, simulated = figure.axes[2].lines
    np.testing.assert_array_equal(recorded.get_ydata(), 1e3 * noisy.record.mass[4000:5001])
    np.testing.assert_allclose(simulated.get_ydata(), recorded.get_ydata(), atol=0.06 * np.ptp(recorded.get_ydata()))
    assert figure.axes[3].get_xlim()[1] == noisy.record.time[-1]
    with pytest.raises(ValueError, match="interval = 30 to 31 s"):
        noisy.plot("prediction", interval=(30, 31))


def test_the_papers_readings_have_no_simulated_rig():
    paper = identify(cubic_record(duration=10), conversion="all")
    for what in ("residuals", "prediction", "parameters"):
        with pytest.raises(ValueError, match="has no simulated rig"):
            paper.plot(what)


def test_outputs_have_the_units_of_their_kinds(noisy):
    record = noisy.record.replace(kinds={"shaker": "displacement", "mass": "acceleration"})
    other = replace(noisy, record=record)
    assert [axis.get_ylabel() for axis in other.plot("prediction").axes][::2] == ["shaker [mm]", "mass [m/s^2]"]
    recorded = other.plot("residuals", ax=Figure().subplots(3, 2))
    assert [axis.get_ylabel() for axis in recorded.axes[:2]] == ["density [µm/√Hz]", "density [m/s^2/√Hz]"]
