"""Figures of drives: every point is drawn where the test found it, and their words say what the force does."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from rigsim import RigParameters, compare_drives
from rigsim.results import Status


@pytest.fixture(scope="module")
def compared():
    return compare_drives(RigParameters(), 3.18, [40.0, 56.0, 64.0], duration=3)


def test_every_point_is_drawn_in_every_panel(compared):
    figure, test = compared.plot(), compared.test
    settled = test.status == Status.SETTLED
    assert settled.any() and not settled.all()
    heights = abs(test.driven.force), 100 * test.driven.distortion, 1e3 * abs(test.relative)
    for axes, height in zip(figure.axes, heights, strict=True):
        drawn = [line.get_xydata() for line in axes.lines if line.get_marker() in "o^x" and len(line.get_xdata())]
        found = np.concatenate(drawn)
        wanted = np.column_stack([test.frequency, height])
        for one in (found, wanted):
            one[:] = one[np.lexsort(one.T)]
        np.testing.assert_allclose(found, wanted)
        assert axes.get_yscale() == "log" and "[" in axes.get_ylabel()
    np.testing.assert_allclose(figure.axes[0].lines[0].get_ydata(), abs(compared.theory[0].force[:, 0]))
    assert figure.axes[-1].get_xlabel() == "frequency [Hz]"
    assert "constant voltage: least force 0.729 newtons at 56 hertz" in figure.alt
    own = Figure().subplots(3, 1)
    assert compared.plot(ax=own) is own[0].figure


def test_waveforms_are_two_periods_of_the_record(compared):
    figure = compared.plot("waveforms")
    for axes in figure.axes:
        assert len(axes.lines) == 4 and axes.get_xlabel() == "periods of what is asked for"
        for line in axes.lines:
            assert 1.9 < np.ptp(line.get_xdata()) <= 3
    labels = [line.get_label() for line in figure.axes[0].lines]
    assert labels[1].startswith("constant voltage, ") and labels[1].endswith(" Hz")
    largest = [abs(line.get_ydata()).max() for line in figure.axes[0].lines]
    assert largest[0] == pytest.approx(3.18, rel=1e-2) and largest[1] < 3.18
