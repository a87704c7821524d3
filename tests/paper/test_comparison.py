"""Tests over the orbits: what is found, what is walked past, and that a subharmonic is not taken for an orbit."""

import numpy as np
import pytest

from rigsim import RigParameters, Tap, compare_tests, periodic_orbits, sine_test, stepped_test, swept_test, tapped_test
from rigsim.results import Status

RIG = RigParameters()
FORCE = 3.18


@pytest.fixture(scope="module")
def comparison():
    """Up and down, swept up, tapped, and the paper's sine tests, over the orbits at 3.18 N."""
    up = np.r_[np.arange(10.0, 61.0, 5.0), 62.0, 63.0, 64.0, 66.0, 70.0]
    stepped = stepped_test(RIG, FORCE, [up, up[::-1]], limit=5.0)
    swept = swept_test(RIG, FORCE, (40, 80), 1.0)
    tapped = tapped_test(RIG, FORCE, [[40.0], [60.0]])
    paper = sine_test(RIG, FORCE, [30.0, 30.0], [None, Tap()], 4.0)
    return compare_tests(periodic_orbits(RIG, FORCE), *stepped.runs, swept, tapped, paper)


def test_pieces_are_the_stable_stretches_between_special_points(comparison):
    special = sorted(p.frequency for branch in comparison.orbits for p in branch.special_points)
    assert [piece.name for piece in comparison.pieces] == ["A", "B", "C", "D"]
    ends = [f for piece in comparison.pieces for f in piece.frequency[[0, -1]] if 5.1 < f < 79.9]
    # The curve from the fold at 53.56 Hz to where the detached one loses its stability is no piece.
    assert set(np.round(ends, 9)) == {round(f, 9) for f in special if not 53.5 < f < 53.6}
    assert [piece.kind for piece in comparison.pieces].count("a detached curve") == 1
    for piece in comparison.pieces:
        assert (np.diff(piece.frequency) >= 0).all()


def test_neither_way_finds_the_detached_curve_and_a_tap_from_rest_does(comparison):
    names = [str(name) for name in comparison.names]
    assert names == ["stepped_test, up", "stepped_test, down", "swept_test, up", "tapped_test", "sine_test, tapped"]
    found = {name: "".join(np.array(list("ABCD"))[comparison.found(i)]) for i, name in enumerate(names)}
    past = {name: "".join(np.array(list("ABCD"))[comparison.walked_past(i)]) for i, name in enumerate(names)}
    assert found["stepped_test, up"] == "A" and past["stepped_test, up"] == "BC"
    assert found["stepped_test, down"] == "AC" and past["stepped_test, down"] == "B"
    assert found["tapped_test"] == "ABC" and found["sine_test, tapped"] == "AB"
    # From rest at 40 Hz a sweep begins on the low branch, leaves it where it ends, and ends on a motion below f.
    assert found["swept_test, up"].startswith("AB") and "D" in past["swept_test, up"]


def test_a_subharmonic_near_a_piece_is_not_on_it(comparison):
    """At 70 Hz z has on the motion of three periods a line at f that is 11 % from the low orbit's."""
    test, on = comparison.tests[0], comparison.on[0]
    three = test.status == Status.SUBHARMONIC
    assert three.any() and (on[three] == -1).all() and (on[test.status == Status.SETTLED] >= 0).all()


def test_table_says_what_it_took(comparison):
    table = comparison.table()
    np.testing.assert_allclose(table["bench [min]"], [test.bench_time / 60 for test in comparison.tests])
    assert table["jumps [Hz]"][1].startswith("57") and table["found"][3] == "A B C"
    pieces = comparison.pieces_table()
    assert list(pieces["piece"]) == list("ABCD") and "tapped_test" in pieces["found by"][1]
    assert "missed: D" in comparison.summary()


def test_what_does_not_fit_is_refused(comparison):
    other = sine_test(RIG, 1.0, 30.0, duration=1)
    for tests, named in (
        ((), "tests is empty"),
        ((other,), "tests at 1 to 1 N are not allowed; expected 3.18 N"),
        ((RIG,), "tests = .* expected a BenchTest or a SineTest"),
    ):
        with pytest.raises(ValueError, match=named):
            compare_tests(comparison.orbits, *tests)
    with pytest.raises(ValueError, match="names has 1 elements; expected 5"):
        compare_tests(comparison.orbits, *comparison.tests, names=["one"])
    with pytest.raises(ValueError, match="orbits = "):
        compare_tests(RIG, *comparison.tests)
    with pytest.raises(ValueError, match="i = 5"):
        comparison.found(5)


def test_tests_of_another_rig_are_refused():
    orbits = periodic_orbits(RIG, 1.0, band=(20, 30))
    with pytest.raises(ValueError, match="tests of another rig than that of the orbits are not allowed"):
        compare_tests(orbits, stepped_test(RIG.replace(m=0.006), 1.0, [20.0], dwell=1.0))
