"""The response over frequency and force at once: its events, its contours, and what single-term theory is of it."""

import numpy as np
import pytest

from rigsim import OscillatorParameters, RigParameters, force_scenario, periodic_orbits, response_sheet
from rigsim.orbits.response_sheet import ResponseSheet
from rigsim.theory import detached

RIG = RigParameters()


@pytest.fixture(scope="module")
def sheet():
    return response_sheet(RIG, (10, 90), (0.3, 8.0), 9)


@pytest.fixture(scope="module")
def scenario():
    return force_scenario(RIG, 9)


def test_with_one_harmonic_the_events_are_those_of_exact_roots():
    """Two ways to them: stationary points along traced fold lines, and roots of polynomials."""
    single = detached.force_scenario(RIG)
    found = [e for e in response_sheet(RIG, (8, 110), (0.1, 8.0), 1, "cubic").events if "Neimark" not in e.kind]
    assert [e.force for e in found] == pytest.approx([e.force for e in single], rel=1e-9)
    assert [e.frequency for e in found] == pytest.approx([e.frequency for e in single], rel=1e-6)
    assert [e.kind.split()[-1] for e in found if "birth" in e.kind or "death" in e.kind] == [
        e.kind.split()[-1] for e in single if "birth" in e.kind or "death" in e.kind
    ]


@pytest.mark.parametrize(("law", "birth"), [("exact", 1.3523), ("cubic", 1.3495)])
def test_converged_events_of_the_paper_s_rig(law, birth):
    found = force_scenario(RIG, 9, law)
    kinds = ["hysteresis birth", "outer birth", "merger: open + outer -> open"]
    kinds += ["outer birth", "merger: open + outer -> open", "split: open -> inner + open", "inner death"]
    assert [event.kind for event in found] == kinds
    assert found[3].force == pytest.approx(birth, abs=2e-4) and abs(found[3].frequency - 64.6) < 0.05
    more = force_scenario(RIG, 15, law)
    assert [e.force for e in more] == pytest.approx([e.force for e in found], abs=1e-6)
    assert len(found.single_term) == 7 and found.table()["single-term force [N]"].notna().all()


def test_the_paper_s_force_is_further_above_the_converged_split(scenario):
    (split,) = [event for event in scenario if event.kind.startswith("split")]
    assert 3.18 / split.force - 1 == pytest.approx(0.0365, abs=1e-4)


def test_curves_appear_and_vanish_where_the_events_say(scenario):
    for event in scenario:
        change = {"birth": 1, "death": -1, "merger": -1, "split": 1}
        step = next(value for word, value in change.items() if word in event.kind)
        if "hysteresis" in event.kind:
            continue
        band = event.frequency * 0.8, event.frequency * 1.25
        count = [
            sum(b.closed for b in periodic_orbits(RIG, event.force * (1 + side * 2e-4), (12, 90), 9))
            for side in (-1, 1)
        ]
        assert count[1] - count[0] == step, (event, band)


@pytest.mark.parametrize("force", [0.4, 1.36, 3.18, 5.0])
def test_a_contour_of_the_sheet_is_what_periodic_orbits_finds(sheet, force):
    one, other = sheet.at(force), periodic_orbits(RIG, force, (10, 90), 9)
    reach = [sorted((b.frequency.min(), b.frequency.max(), len(b.folds)) for b in found) for found in (one, other)]
    assert len(one) == len(other)
    np.testing.assert_allclose(*reach, rtol=1e-6)
    assert one.force == force and one[0].shoot(3).converged


def test_its_lines_pass_the_special_points_of_its_contours(sheet):
    """Folds and Neimark-Sacker points of a curve traced at one force lie on lines traced over the force."""
    for branch in sheet.at(3.18):
        for point in branch.special_points:
            gaps = [
                abs(y[-2] * locus.sheet.equations.hertz - point.frequency)
                for name, locus in sheet.lines
                if name == point.kind
                for y in locus.passing(-1, 3.18 / locus.sheet.equations.force)
            ]
            assert min(gaps) < 1e-5, point


def test_a_sheet_tells_what_it_is(sheet):
    assert isinstance(sheet, ResponseSheet) and "24 slices" in sheet.summary() and "fold" in sheet.summary()
    assert list(sheet.table().columns) == ["force [N]", "frequency [Hz]", "event"]
    with pytest.raises(ValueError, match=r"force = 9 N"):
        sheet.at(9.0)
    with pytest.raises(ValueError, match="ascending"):
        response_sheet(RIG, (10, 90), (3, 1))


def test_without_single_term_events_the_range_must_be_told():
    linear = OscillatorParameters(1, 1e3, 1.0, 0.1, 0.1, 10.0, 0.0)
    with pytest.raises(ValueError, match="band and force are needed"):
        force_scenario(linear, 9)
    assert len(force_scenario(linear, 5, band=(1, 20), force=(0.1, 1.0))) == 0


def test_events_are_followed_as_the_rig_changes(scenario):
    """Followed from rig to rig, and found on the other rig's own sheet."""
    curves = scenario.over("cs", [9.3, 9.86, 10.5])
    assert "hysteresis" not in " ".join(event.kind for event in curves.events)
    for value, forces in zip(curves.values, curves.force, strict=True):
        own = [e.force for e in force_scenario(RIG.replace(cs=value), 9) if "hysteresis" not in e.kind]
        assert forces == pytest.approx(own, rel=1e-7)
    assert curves.table().shape == (3, 6) and "over cs from 9.3 to 10.5" in curves.summary()
    with pytest.raises(ValueError, match="name = 'nope'"):
        scenario.over("nope", [1.0])
    far = scenario.over("d0", np.linspace(33.985e-3, 33.9995e-3, 8))
    assert np.isnan(far.force).any() and "were not reached" in far.summary()


def test_a_contour_leaves_the_sheet_as_it_was(sheet):
    before = [[len(known.points) for known in loci] for loci in sheet.exploration.loci]
    for force in (0.35, 1.36, 7.9):
        sheet.at(force)
    assert [[len(known.points) for known in loci] for loci in sheet.exploration.loci] == before
