"""Figures of tests on the bench: every point is drawn, jumps are marked, and pieces say whether they were found."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from rigsim import RigParameters, compare_tests, periodic_orbits, ramp_test, stepped_test, swept_test, tapped_test
from rigsim.results import Status

RIG = RigParameters()


@pytest.fixture(scope="module")
def stepped():
    """Up at 1 N, over the fold."""
    up = np.r_[12.0, 16.0, 20.0:50.0:5.0, 50.0, 51.0, 53.0]
    return stepped_test(RIG, 1.0, up)


def drawn(axes, marker):
    return np.concatenate([line.get_xydata() for line in axes.lines if line.get_marker() == marker])


def test_every_point_is_drawn_and_a_jump_is_marked(stepped):
    figure = stepped.plot()
    for axes, name in zip(figure.axes, ("relative", "mass"), strict=True):
        settled = stepped.status == Status.SETTLED
        expected = np.column_stack([stepped.frequency, 1e3 * abs(getattr(stepped, name))])[settled]
        np.testing.assert_allclose(drawn(axes, "o"), expected)
        (jump,) = stepped.jumps
        np.testing.assert_allclose(drawn(axes, ">")[0, 0], jump.frequency)
        assert axes.get_ylabel().endswith("[mm]") and axes.get_yscale() == "log"
    assert figure.axes[-1].get_xlabel() == "frequency [Hz]" and "(falls)" in figure.alt


def test_a_ramp_is_drawn_over_force_and_waits_over_what_was_moved(stepped):
    ramp = ramp_test(RIG, [1.0, 3.0], 30.0, 1.0)
    figure = ramp.plot()
    assert figure.axes[-1].get_xlabel() == "force [N]"
    np.testing.assert_allclose(figure.axes[0].lines[0].get_xdata(), ramp.force)
    waits = stepped.plot("waits")
    np.testing.assert_allclose(drawn(waits.axes[0], "."), np.column_stack([stepped.frequency, stepped.dwell]))


def test_comparison_has_a_panel_a_test_and_says_which_pieces_were_found():
    orbits = periodic_orbits(RIG, 3.18)
    swept = swept_test(RIG, 3.18, (57, 53), 0.5)
    tapped = tapped_test(RIG, 3.18, [40.0])
    up = stepped_test(RIG, 3.18, [63.0, 64.0], limit=3.0, dwell=1.0)
    comparison = compare_tests(orbits, swept, tapped, up)
    figure = comparison.plot()
    assert len(figure.axes) == 4 and not figure.axes[3].axison
    for i, (axes, name) in enumerate(zip(figure.axes[:3], comparison.names, strict=True)):
        assert axes.get_title("left").startswith(name)
        labels = [line.get_label() for line in axes.lines]
        assert labels.count("piece that was found") == comparison.found(i).sum()
        assert labels.count("piece that was walked past") == comparison.walked_past(i).sum()
        assert {text.get_text() for text in axes.texts} == {"A", "B", "C", "D"}
    np.testing.assert_allclose(
        drawn(figure.axes[1], "o"), np.column_stack([tapped.frequency, 1e3 * abs(tapped.relative)])
    )
    assert "A from 5.0 to 62.2 hertz" in figure.alt and "walked past" in figure.alt
    own = Figure().subplots(1, 3)
    assert comparison.plot(ax=own) is own[0].figure
    with pytest.raises(ValueError, match="ax has 2 elements; expected 3"):
        comparison.plot(ax=own[:2])
