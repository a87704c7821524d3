"""Margins and tolerances of converged curves, against the curves themselves."""

import pytest

from rigsim import RigParameters, force_scenario, margins, periodic_orbits, tolerance_study

RIG = RigParameters()


def inner(parameters, force):
    return sum(branch.closed for branch in periodic_orbits(parameters, force, (12, 90), 7))


@pytest.fixture(scope="module")
def found():
    return margins(RIG, 3.18, names=("d0", "cs", "force"), harmonics=7)


def test_inside_a_margin_the_curve_is_there_and_outside_it_is_not(found):
    for name, lowest, highest in (("d0", 11.7e-6, 1.611e-6), ("cs", 7.9, 0.3786)):
        margin = found[name]
        assert (margin.down, margin.up) == pytest.approx((lowest, highest), rel=5e-3)
        for value, count in ((margin.high, 1), (margin.high_lost, 0)):
            moved = RIG.replace(**{name: margin.value + (value - margin.value) * (1 - 1e-4 if count else 1 + 1e-4)})
            assert inner(moved, 3.18) == count


def test_the_margin_in_force_is_the_distance_to_the_events(found):
    edges = [e.force for e in force_scenario(RIG, 7) if e.kind.startswith("split") or e.kind == "inner death"]
    assert [found["force"].low, found["force"].high] == pytest.approx(edges, rel=1e-8)
    assert found["force"].down / 3.18 == pytest.approx(0.0352, abs=1e-4)  # the paper's 2.9 % is the single term's


def test_of_rigs_within_tolerances_each_is_judged_as_its_own_curve_would_be():
    study = tolerance_study(RIG, 3.18, {"d0": 2e-6, "force": "3 %"}, samples=12, harmonics=7)
    for i, kept in enumerate(study.kept):
        if abs(study.distance[i]) > 1e-3:
            assert inner(RIG.replace(d0=study.values["d0"][i]), study.values["force"][i]) == kept
    assert 0 < study.kept.sum() < 12


def test_what_cannot_be_followed_is_refused():
    with pytest.raises(ValueError, match=r"force = 2.5 N gives no converged inner detached curve; .* split"):
        margins(RIG, 2.5, harmonics=7)
    with pytest.raises(ValueError, match="quantity = 'gamma'"):
        margins(RIG, 3.18, names=("gamma",), harmonics=7)
    with pytest.raises(ValueError, match="quantity = 'k1'"):
        tolerance_study(RIG, 3.18, {"k1": "1 %"}, samples=3, harmonics=7)
