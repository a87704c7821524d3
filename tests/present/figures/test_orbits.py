"""Figures of periodic orbits show every piece, point and word they promise."""

import numpy as np
import pytest

from rigsim import RigParameters, frequency_response, harmonics_worth, periodic_orbits
from rigsim.present.figures.orbits import orbits_figure


@pytest.fixture(scope="module")
def branches():
    return periodic_orbits(RigParameters(), 3.18, (5, 120), harmonics=7)


def test_every_piece_and_special_point_is_drawn_and_told(branches):
    theory = frequency_response(RigParameters(), 3.18, np.linspace(5, 120, 50))
    circles = [30.0], [1e-4], [1e-3], [1e-3]
    figure = orbits_figure(branches, beside=theory, circles=circles)
    assert "Neimark-Sacker at 62.2" in figure.alt and "closed curve" in figure.alt
    words = {text.get_text() for text in figure.legends[0].get_texts()}
    assert {
        "single-term theory",
        "multi-body rig",
        "open, stable",
        "closed, unstable",
        "fold",
        "detached curve",
    } <= words
    ax = figure.axes[2]
    for branch in branches:
        drawn = np.concatenate([line.get_xydata() for line in ax.lines if line.get_linestyle() in ("-", "--")])
        for f, z in zip(branch.frequency, 1e3 * abs(branch.relative[:, 1]), strict=True):
            assert abs(drawn - [f, z]).sum(axis=1).min() < 1e-9
    texts = sorted(float(text.get_text()) for text in ax.texts)
    places = sorted(point.frequency for branch in branches for point in branch.special_points)
    np.testing.assert_allclose(texts, places, atol=0.051)


def test_stable_runs_are_solid_and_unstable_ones_dashed(branches):
    figure = branches[0].plot()
    stable = branches[0].stable
    for key, verdict in (("-", True), ("--", False)):
        drawn = [line.get_xdata() for line in figure.axes[0].lines if line.get_linestyle() == key]
        shown = np.concatenate([run[:-1] for run in drawn])  # the last point belongs to the next run
        assert set(shown) <= set(branches[0].frequency[stable == verdict])


def test_harmonics_are_worth_what_the_figure_shows():
    worth = harmonics_worth(RigParameters(), 3.18, (40, 80), harmonics=(1, 3, 5))
    assert (np.diff(worth.error, axis=0) < 0).all() and (np.diff(worth.shift) < 0).all()
    assert worth.error[-1].max() < 1e-3 < worth.error[0].min()
    assert list(worth.table().index) == [1, 3, 5]
    np.testing.assert_array_equal(worth.plot().axes[1].lines[0].get_ydata(), worth.shift)


def test_no_branches_are_refused():
    with pytest.raises(ValueError, match="at least one"):
        orbits_figure(())
