"""Figures of sine tests: points are the tests' own, symbols say status and tap."""

import numpy as np

from rigsim.results import Status

AXES = ("shaker", "mass", "relative")


def points(axes):
    """Frequencies and heights drawn in data coordinates, over all markers, ascending."""
    data = [line.get_xydata() for line in axes.lines if line.get_transform() == axes.transData]
    data = np.concatenate(data)
    return data[np.lexsort(data.T[::-1])]


def sorted_pairs(frequency, amplitude):
    known = np.isfinite(amplitude)
    data = np.column_stack([frequency, amplitude])[known]
    return data[np.lexsort(data.T[::-1])]


def test_every_amplitude_is_drawn_once_and_a_lost_one_on_the_edge(test):
    figure = test.plot()
    for axes, name in zip(figure.axes, AXES, strict=True):
        expected = sorted_pairs(test.frequency, 1e3 * abs(getattr(test, name)))
        np.testing.assert_allclose(points(axes), expected)
        (edge,) = [line for line in axes.lines if line.get_transform() != axes.transData]
        assert edge.get_xdata() == [66.0] and edge.get_label() == "flew apart, after a tap"
        assert axes.get_ylabel().endswith("[mm]") and axes.get_yscale() == "log"
    assert figure.axes[-1].get_xlabel() == "frequency [Hz]"
    assert "3 of them tapped" in figure.alt and "1 subharmonic" in figure.alt and "1 flew apart" in figure.alt


def test_symbols_tell_status_and_tap(test):
    figure = test.plot()
    markers = {line.get_label(): (line.get_marker(), line.get_markerfacecolor()) for line in figure.axes[0].lines}
    for status in set(test.status):
        rest, tap = (markers.get(f"{status}, {how}") for how in ("from rest", "after a tap"))
        assert rest is None or rest[1] == "none"
        assert tap is None or tap[1] != "none"
    assert len({markers[label][0] for label in markers if "tap" in label}) == len(set(test.status[3:]))


def test_distortion_is_in_per_cent_against_five(test):
    figure = test.plot("distortion")
    for column, axes in enumerate(figure.axes):
        expected = sorted_pairs(test.frequency, 100 * test.distortion[:, column])
        np.testing.assert_allclose(points(axes), expected)
        assert any(np.all(np.equal(line.get_ydata(), 5)) for line in axes.lines)
    settled = test.status == Status.SETTLED
    assert f"relative z {100 * test.distortion[settled, 2].max():.2g} %" in figure.alt
    assert "[%]" in figure.axes[0].get_ylabel()
