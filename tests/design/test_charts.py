"""Existence charts: labels against the folds, boundaries against the force scenario and against classification."""

import numpy as np
import pytest
from matplotlib.path import Path

from rigsim.design.charts import _outlines, existence_chart
from rigsim.design.count import existence_forces
from rigsim.design.variation import judge_varied, replaced
from rigsim.parameters import RigParameters
from rigsim.theory.detached import detached_curves

RIG = RigParameters()
TOLERANCES = {"d0": 1e-6, "force": "2 %", "cs": "5 %"}


@pytest.fixture(scope="module")
def chart():
    return existence_chart(RIG, 3.18, ("d0", 33.985e-3, 34.0005e-3), ("force", 0.3, 8.0), TOLERANCES, points=(32, 61))


def test_labels_are_those_of_the_folds(chart):
    assert chart.inner.shape == chart.outer.shape == chart.labels.shape == (61, 32)
    assert chart.distance.shape == (2, 61, 32)
    rng = np.random.default_rng(4)
    for row, column in zip(rng.integers(61, size=60), rng.integers(32, size=60), strict=True):
        if not chart.possible[row, column]:
            assert chart.labels[row, column] == "none" and chart.x[column] > RIG.d
            continue
        rig, force = replaced(RIG, 3.18, {"d0": float(chart.x[column]), "force": float(chart.y[row])})
        kinds = {curve.kind for curve in detached_curves(rig, force)}
        assert chart.labels[row, column] == ("both" if len(kinds) == 2 else next(iter(kinds), "none"))
    assert {"inner", "outer", "none"} <= set(np.unique(chart.labels))


def test_boundaries_are_the_ends_of_existence(chart):
    checked = 0
    for boundary in chart.boundaries:
        for x, y in zip(boundary.x, boundary.y, strict=True):
            if x < RIG.d - 1e-9:
                forces = np.ravel(existence_forces(RIG.replace(d0=float(x)), boundary.kind))
                # To 1e-7 of a cell, 5 % of the force high; along d0 the edge is as steep as the region's tip is.
                checked += abs(forces / y - 1).min() < 1e-7
    assert checked > 0.95 * sum((b.x < RIG.d - 1e-9).sum() for b in chart.boundaries) > 50


def test_boundaries_part_where_it_exists_from_where_it_does_not():
    chart = existence_chart(RIG, 3.18, ("cs", 4.0, 16.0), ("d0", 33.985e-3, 34e-3), TOLERANCES, points=(25, 21))
    (boundary, *_) = [b for b in chart.boundaries if b.kind == "inner"]
    step = 1e-5 * 12.0
    for sign, expected in ((-1, True), (1, False)):
        rising = boundary.x > 9.0  # the steep right edge
        changes = {"cs": boundary.x[rising] + sign * step, "d0": boundary.y[rising] - sign * 1e-5 * 15e-6}
        counts, _ = judge_varied(RIG, 3.18, changes)
        assert np.mean((counts[:, 0] > 0) == expected) > 0.9
    assert chart.point == (RIG.cs, RIG.d0) and chart.box == (pytest.approx(0.493), 1e-6)


def test_axes_without_ends_are_about_the_rig():
    chart = existence_chart(RIG, 3.18, "d0", "force", points=(9, 9))
    assert chart.x[-1] == RIG.d and chart.x[0] == pytest.approx(RIG.d - 4 * (RIG.d - RIG.d0)) and chart.possible.all()
    assert (chart.y[0], chart.y[-1]) == (pytest.approx(1.59), pytest.approx(6.36)) and chart.box == (0.0, 0.0)
    groups = existence_chart(RIG, 3.18, ("gamma", 1e-4, 1.0), ("mu", 0.01, 0.1), points=(9, 9))
    assert groups.x[4] == pytest.approx(1e-2) and groups.y[4] == pytest.approx(0.055)  # four decades, and one
    assert "gamma" in groups.summary()


def test_a_chart_without_any_curve_has_no_boundary():
    chart = existence_chart(RIG, 3.18, ("force", 0.01, 0.1), ("cs", 5.0, 15.0), points=(5, 5))
    assert chart.boundaries == () and (chart.labels == "none").all()


def test_outlines_close_holes_are_kept_and_what_holds_no_cell_is_left_out():
    distance = np.full((9, 12), -0.1)
    distance[1:7, 1:7] = 0.1
    distance[3:5, 3:5] = -0.1  # a hole
    distance[4, 9:11] = distance[1, 9] = 0.1  # specks
    distance[6, 7:12] = 0.1  # a strip that hangs on the square
    edge = lambda values: np.where(values % 1 < 0.3, np.floor(values), np.ceil(values)).astype(int)  # noqa: E731
    exists = lambda x, y: distance[edge(y), edge(x)] > 0  # noqa: E731
    paths = _outlines(distance, exists)
    curves = [path for path, codes in paths if codes is None]
    ((area, codes),) = [(path, codes) for path, codes in paths if codes is not None]
    outer, hole = sorted(curves, key=len, reverse=True)
    assert (codes == 1).sum() == (codes == 79).sum() == 2
    assert (hole[0] == hole[-1]).all() and not (outer[0] == outer[-1]).all()  # the strip leaves the chart
    fractions = np.concatenate(curves) % 1
    np.testing.assert_allclose(fractions[fractions > 0], 0.3, atol=1e-6)
    assert {tuple(point) for point in np.concatenate(curves)} <= {tuple(point) for point in area}


def test_regions_are_what_the_boundaries_enclose(chart):
    inner = [Path(np.column_stack([r.x, np.log(r.y)]), r.codes) for r in chart.regions if r.kind == "inner"]
    x, y = (values.ravel() for values in np.meshgrid(chart.x, np.log(chart.y)))
    within = np.any([path.contains_points(np.column_stack([x, y])) for path in inner], axis=0).reshape(
        chart.inner.shape
    )
    edge = np.zeros(within.shape, dtype=bool)
    edge[:, [0, -1]] = edge[[0, -1]] = True
    np.testing.assert_array_equal(within[~edge], (chart.inner > 0)[~edge])
    assert chart.tolerances is TOLERANCES


def test_a_region_that_thins_out_has_no_specks():
    chart = existence_chart(RIG, 3.18, ("d0", 33.985e-3, 34e-3), ("force", 0.3, 1.0), points=(40, 60))
    outer = [region for region in chart.regions if region.kind == "outer"]
    (band,) = outer
    assert (chart.outer > 0)[:, chart.x < band.x.min()].any()  # single points hit it further on


@pytest.mark.parametrize(
    "axes, message",
    [
        (("force", "force"), "x and y are both force"),
        (("force", "Rm"), "quantity = 'Rm' is not allowed"),
        (("force", ("m", 2.0, 1.0)), "expected the lower one first"),
        (("force", ("m", 2.0)), "expected a name, or"),
        (("force", ("m", 0.0, 1.0)), r"ends of the axis m\[0\] = 0 kg is not allowed"),
    ],
)
def test_what_is_not_allowed_is_named(axes, message):
    with pytest.raises(ValueError, match=message):
        existence_chart(RIG, 3.18, *axes)
