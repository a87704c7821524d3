"""Margins: verified by the fold theory just inside and just outside, and by a dense scan on the way."""

import math

import numpy as np
import pytest

from rigsim.design.count import existence_forces
from rigsim.design.margins import margins
from rigsim.design.variation import judge_varied, replaced
from rigsim.parameters import RigParameters
from rigsim.theory.detached import detached_curves

RIG = RigParameters()


def has(parameters, force, kind, name, value):
    changed, level = replaced(parameters, force, {name: value})
    return kind in [curve.kind for curve in detached_curves(changed, level)]


@pytest.mark.parametrize(
    "parameters, force, kind",
    [(RIG, 3.18, "inner"), (RIG, 4.5, "inner"), (RIG, 1.5, "outer"), (RIG.oscillator, 0.47, "outer")],
)
def test_each_margin_is_the_edge_and_nothing_is_lost_before(parameters, force, kind):
    found = margins(parameters, force, kind)
    assert len(found) == (9 if parameters is RIG else 8)
    for entry in found:
        for end, lost in ((entry.low, entry.low_lost), (entry.high, entry.high_lost)):
            # Stretch and force are differences or squares: as close as doubles of the value itself allow.
            inside = end + 1e-9 * (entry.value - end)
            assert has(parameters, force, kind, entry.name, inside)
            if lost is not None:
                assert abs(lost - end) <= 2e-12 * abs(entry.value - end) + 2 * math.ulp(end)
                assert not has(parameters, force, kind, entry.name, lost + 1e-9 * (lost - entry.value))
            steps = entry.value + np.linspace(0, 1, 400)[1:-1] * (inside - entry.value)
            counts, _ = judge_varied(parameters, force, {entry.name: steps})
            assert counts[:, int(kind == "outer")].all()


def test_the_forces_margin_is_the_closed_form():
    ((low, high),) = existence_forces(RIG)
    force = margins(RIG, 3.18)["force"]
    np.testing.assert_allclose([force.low, force.high], [low, high], rtol=1e-10)


@pytest.mark.parametrize(
    ("cs", "c", "m", "stretch"),
    [
        (1.301188477050256, 0.00644556248001295, 0.0037345387105644496, 3.48963895e-07),
        (5.3622190601041995, 0.06878447571732488, 0.004708145343444889, 6.345833291e-06),
        (1.9051330289620962, 0.07439340702590583, 0.0036488876897050335, 9.35383783e-06),
    ],
)
def test_a_narrow_gap_is_not_stepped_over(cs, c, m, stretch):
    """The curve is lost for a per mille of the force and found again: less than the scan's steps, but seen as a dip."""
    rig = RIG.replace(cs=cs, c=c, m=m, d0=RIG.d - stretch)
    (first, lost), (again, last) = existence_forces(rig, "outer")
    for distance in (again - lost) * np.array([10, 14, 20, 28, 40, 56]):
        if lost - distance > first:
            found = margins(rig, lost - distance, "outer", ["force"])["force"]
            assert found.high == pytest.approx(lost, rel=1e-9)
        if again + distance < last:
            found = margins(rig, again + distance, "outer", ["force"])["force"]
            assert found.low == pytest.approx(again, rel=1e-9)


def test_the_papers_rig_hangs_on_micrometres():
    found = margins(RIG, 3.18)
    first = found[0]
    assert first.name == "d0" and 1.2e-6 < first.up < 1.4e-6  # rounded to 1 um it is uncertain by half of one
    assert 0.028 < found["force"].down / 3.18 < 0.030
    assert found["cs"].down == math.inf and 0.02 < found["cs"].up / RIG.cs < 0.04
    assert "d0" in found.summary() and "µm" in found.summary()
    table = found.table()
    assert table.loc["d0", "up"] == pytest.approx(1e6 * first.up) and table.loc["d0", "unit"] == "µm"
    assert [entry.name for entry in found] == list(table.index)


def test_non_dimensional_names_move_alone():
    found = margins(RIG, 3.18, names=["gamma", "k3", "mu"])
    # gamma and k3 are proportional, and gamma goes with the square of the force.
    assert found["gamma"].down / found["gamma"].value == pytest.approx(found["k3"].down / RIG.k3, rel=1e-9)
    edge = existence_forces(RIG)[0][0]
    assert found["gamma"].low / found["gamma"].value == pytest.approx((edge / 3.18) ** 2, rel=1e-9)


def test_a_quantity_that_is_zero_moves_up_only():
    found = margins(RIG.oscillator.replace(k1=0.0, c=0.0), 3.5, names=["k1", "c"])
    assert all(entry.down == math.inf and 0 < entry.up < math.inf for entry in found)


def test_what_never_loses_the_curve_is_followed_a_thousand_times_up_and_a_millionth_down():
    found = margins(RIG.replace(c=1e-5), 3.18, names=["c", "cs"])
    c, cs = found["c"], found["cs"]
    assert (c.low, c.high, c.low_lost, c.high_lost) == (0.0, pytest.approx(1e-2, rel=1e-12), None, None)
    assert c.down == c.up == c.smallest == math.inf
    assert cs.low == pytest.approx(1e-6 * RIG.cs, rel=1e-9) and cs.low_lost is None and cs.high_lost is not None


def test_without_the_curve_there_is_nothing_to_lose():
    with pytest.raises(
        ValueError, match=r"force = 3 N gives no inner detached curve; expected one between 3\.0879 and"
    ):
        margins(RIG, 3.0)
    with pytest.raises(ValueError, match="there is none at any force"):
        margins(RIG.replace(cs=90.0, c=1.0), 3.0)
    with pytest.raises(ValueError, match="quantity = 'Rm' is not allowed"):
        margins(RIG, 3.18, names=["Rm"])
    with pytest.raises(KeyError):
        margins(RIG, 3.18, names=["m"])["k"]
