"""Figures of basins, taps and integrity: colours that stay with their motion, and words for what is seen."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from rigsim import RigParameters, basins, integrity, smallest_tap, tap_map
from rigsim.present.figures.basins import motion_colors

RIG = RigParameters()


@pytest.fixture(scope="module")
def taps():
    return tap_map(RIG, 3.18, 40.0, velocity=np.linspace(-0.5, 0.5, 11), instants=12, starts=64)


def test_basins_figure_shows_its_labels():
    found = basins(RIG, 3.18, 30.0, pixels=21, samples=64, starts=64)
    figure = found.plot()
    (ax,) = figure.axes
    image = ax.images[0]
    assert np.array_equal(image.get_array(), found.label)
    colors = image.cmap(image.norm(found.label))[..., :3]
    wanted = np.array([to_rgb(color) for color in motion_colors(found.attractors)])
    np.testing.assert_allclose(colors, wanted[found.label])
    assert "low" in figure.alt and "per cent" in figure.alt and "30 hertz" in figure.alt
    assert "[mm]" in ax.get_xlabel() and "[m/s]" in ax.get_ylabel()
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == [
        f"{one.name}: {share:.1%} of the box" for one, share in zip(found.attractors, found.share, strict=True)
    ]


def test_tap_map_marks_the_smallest(taps):
    marked = smallest_tap(taps, "high", rounds=2)
    figure = taps.plot(smallest=marked)
    (ax,) = figure.axes
    (point,) = ax.lines
    assert point.get_xdata() == [marked.instant] and point.get_ydata() == [marked.velocity]
    assert f"{marked.velocity:.3g} m/s" in figure.alt
    ax = Figure().subplots()
    assert taps.plot(ax=ax) is ax.figure and not ax.lines and len(ax.images) == 1
    assert [text.get_text() for text in ax.get_legend().get_texts()] == taps.attractors.names


def test_motions_keep_their_colours(taps):
    colors = motion_colors(taps.attractors)
    assert len(set(colors)) == len(colors)
    by_name = dict(zip(taps.attractors.names, colors, strict=True))
    other = basins(RIG, 3.18, 30.0, pixels=3, samples=16, starts=64)
    for one, color in zip(other.attractors, motion_colors(other.attractors), strict=True):
        assert by_name[one.name] == color


def test_integrity_figure_has_both_motions():
    high, low = (integrity(RIG, 3.18, [30.0, 45.0], name, samples=64, starts=64) for name in ("high", "low"))
    figure = high.plot(beside=low)
    lines = figure.axes[0].lines
    np.testing.assert_allclose(lines[0].get_ydata(), 1e3 * high.radius)
    np.testing.assert_allclose(lines[2].get_ydata(), 1e3 * low.radius)
    assert "high from" in figure.alt and "low from" in figure.alt
