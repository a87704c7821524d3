"""The overlay by tests made by hand, whose branches are known, and what a virtual experiment tries in which order."""

from dataclasses import fields, replace

import numpy as np
import pytest

from rigsim import RigParameters, SineTest, Status, Tap, frequency_response, overlay, sine_test, virtual_experiment

RIG, FORCE = RigParameters(), 3.18
# At 20 Hz there is one solution, at 50 Hz the middle one of three is unstable, at 80 Hz all three are stable.
SOLUTIONS = dict(zip((20.0, 50.0, 80.0), frequency_response(RIG, FORCE, [20.0, 50.0, 80.0]).relative, strict=True))
LOW, MIDDLE, HIGH = range(3)


def made(*points, force=FORCE, last=3.0):
    """A `SineTest` of points (frequency, z, status), which were never run; from rest, ended at ``last``."""
    frequency, relative, status = zip(*((f, z, *(rest or [Status.SETTLED])) for f, z, *rest in points), strict=True)
    n = len(points)
    known = {
        "parameters": (RIG,) * n, "force": np.full(n, force), "frequency": np.array(frequency), "tap": (None,) * n,
        "relative": np.array(relative), "status": np.array(status), "message": ("by hand",) * n,
        "time": np.linspace(last - 1, last, 11),
    }  # fmt: skip
    return SineTest(**{field.name: known.get(field.name) for field in fields(SineTest)})


def z(frequency, which=LOW, times=1.0):
    return times * SOLUTIONS[frequency][which]


@pytest.mark.parametrize("times", [1.0, 1.14, 0.86, np.exp(0.14j)])
def test_a_settled_test_is_named_after_the_solution_within_fifteen_per_cent(times):
    points = [(80.0, HIGH), (50.0, LOW), (80.0, MIDDLE), (50.0, HIGH), (80.0, LOW), (50.0, MIDDLE), (20.0, LOW)]
    laid = overlay(RIG, made(*((f, z(f, which, times)) for f, which in points)))
    assert list(laid.branch[0]) == ["high", "low", "middle", "high", "low", "middle", "only"]
    assert set(laid.status[0]) == {Status.SETTLED}


@pytest.mark.parametrize("times", [1.16, 0.84, np.exp(0.16j), -1.0])
def test_further_away_it_is_elsewhere(times):
    laid = overlay(RIG, made(*((f, z(f, which, times)) for f, which in [(80.0, HIGH), (50.0, LOW), (20.0, LOW)])))
    assert set(laid.status[0]) == {Status.ELSEWHERE} and set(laid.branch[0]) == {str(Status.ELSEWHERE)}
    assert not laid.reached().any()


@pytest.mark.parametrize(
    "status", [Status.SUBHARMONIC, Status.STILL_DRIFTING, Status.NOT_PERIODIC, Status.FLEW_APART], ids=str
)
def test_what_did_not_settle_is_on_no_branch_however_near(status):
    laid = overlay(RIG, made((50.0, z(50.0), status), (50.0, z(50.0, HIGH))))
    assert list(laid.branch[0]) == [str(status), "high"] and laid.status[0][0] == status
    assert laid.reached().tolist() == [[False, False, True]] and laid.missing() == [(50.0, "low")]


def test_reached_and_missing_count_every_campaign_at_every_frequency():
    first = made((80.0, z(80.0)), (20.0, z(20.0)), (50.0, z(50.0), Status.STILL_DRIFTING))
    second = made((50.0, z(50.0, HIGH)), last=6.0)
    laid = overlay(RIG, first, second)
    np.testing.assert_array_equal(laid.response.frequency, [20.0, 50.0, 80.0])
    assert laid.reached().tolist() == [[True, False, False], [False, False, True], [True, False, False]]
    # The middle solution at 50 Hz is unstable: no test can miss it.
    assert laid.missing() == [(50.0, "low"), (80.0, "middle"), (80.0, "high")]
    assert "4 tests at 3 frequencies, 3 settled on a branch" in laid.summary() and "; 3 branches" in laid.summary()
    assert overlay(RIG, made((80.0, z(80.0)))).missing() == [(80.0, "middle"), (80.0, "high")]
    assert overlay(RIG, made((20.0, z(20.0, times=2)))).missing() == [(20.0, "only")]


def test_the_table_has_every_test_and_its_distance():
    laid = overlay(RIG, made((80.0, z(80.0, HIGH, 1.1)), (20.0, z(20.0, times=2))), made((20.0, z(20.0)), last=6.0))
    table = laid.table()
    assert table["frequency [Hz]"].tolist() == [20.0, 20.0, 80.0] and table["duration [s]"].tolist() == [3.0, 6.0, 3.0]
    assert table["trial"].tolist() == ["from rest"] * 3
    np.testing.assert_allclose(table["distance [%]"], [np.nan, 0, 10], atol=1e-9)
    expected = 1e3 * abs(np.array([np.nan, z(20.0), z(80.0, HIGH)]))
    np.testing.assert_allclose(table["theory |z| [mm]"], expected, rtol=1e-12)
    np.testing.assert_allclose(
        table["rig |z| [mm]"], 1e3 * abs(np.array([z(20.0, times=2), z(20.0), z(80.0, HIGH, 1.1)]))
    )


def test_what_is_laid_over_must_be_sine_tests_at_one_force():
    with pytest.raises(ValueError, match="expected at least one SineTest"):
        overlay(RIG)
    with pytest.raises(ValueError, match="expected at least one SineTest"):
        overlay(RIG, made((50.0, z(50.0))), "x")
    with pytest.raises(ValueError, match="force = 3 to 3.18 N in the tests"):
        overlay(RIG, made((50.0, z(50.0))), made((50.0, z(50.0)), force=3.0))


def test_what_three_seconds_do_not_settle_is_given_six():
    laid = virtual_experiment(RIG, FORCE, [50.0, 20.0])
    first, again = laid.tests  # and no ladder, since every stable solution is reached
    np.testing.assert_array_equal(first.frequency, [50.0, 20.0, 50.0, 20.0])
    assert first.tap == (None, None, Tap(), Tap()) and first.time[-1] == pytest.approx(3)
    assert list(laid.branch[0]) == ["low", "still drifting", "high", "still drifting"]
    np.testing.assert_array_equal(again.frequency, [20.0, 20.0])
    assert again.tap == (None, Tap()) and again.time[-1] == pytest.approx(6)
    assert list(laid.branch[1]) == ["only", "only"] and laid.missing() == []
    assert len(virtual_experiment(RIG, FORCE, [20.0], duration=6).tests) == 1


def test_what_is_missed_is_tried_with_sixteen_taps():
    *_, ladder = virtual_experiment(RIG, FORCE, [80.0]).tests
    assert ladder.frequency.tolist() == [80.0] * 16 and ladder.time[-1] == pytest.approx(6)
    tried = {(tap.velocity, round((tap.time - 1) * 80.0, 9)) for tap in ladder.tap}
    assert tried == {(v, part) for v in (0.25, 0.5, 1.0, 2.0) for part in (0, 0.25, 0.5, 0.75)}


def test_the_theory_may_be_another_than_the_rig_s():
    theory = RIG.oscillator.replace(k3=2 * RIG.k3)
    laid = virtual_experiment(RIG, FORCE, [50.0], theory, duration=6)
    np.testing.assert_array_equal(laid.response.relative, frequency_response(theory, FORCE, [50.0]).relative)
    assert laid.branch[0][1] == "elsewhere"  # a rig with this k3 would have a smaller z there


def test_the_lowest_frequency_is_that_of_the_sine_test():
    wanted = r"frequency\[0\] = 1.5 Hz is not allowed; expected .* 2 "
    for run in (virtual_experiment, sine_test):
        with pytest.raises(ValueError, match=wanted):
            run(RigParameters(), 3.18, [1.5])


def test_what_settled_near_no_solution_is_elsewhere():
    rig = RigParameters()
    test = sine_test(rig, 3.18, [30.0, 30.0])
    found = overlay(rig, replace(test, relative=test.relative * [1.1, 1.3]))
    assert list(found.status[0]) == [Status.SETTLED, Status.ELSEWHERE]
    assert list(found.branch[0]) == ["low", "elsewhere"]
    assert [str(one) for one in found.table()["status"]] == ["settled", "elsewhere"]


def test_theory_runs_over_a_band_with_its_own_or_other_parameters():
    rig = RigParameters()
    found = overlay(rig, sine_test(rig, 3.18, [30.0], duration=2))
    assert found.theory((20, 40)).frequency[[0, -1]].tolist() == [20, 40]
    assert found.theory().parameters == rig.oscillator and found.theory().force == 3.18
    assert found.theory(parameters=rig.replace(c=0.1)).parameters.c == 0.1
    with pytest.raises(ValueError, match=r"band = \(50, 40\) Hz is not allowed"):
        found.theory((50, 40))
