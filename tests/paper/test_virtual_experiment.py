"""The rig over the theory: frequencies that a sine test can read, names of motions, and the theory between them."""

import dataclasses

import pytest

from rigsim import RigParameters, Status, overlay, sine_test, virtual_experiment


def test_the_lowest_frequency_is_that_of_the_sine_test():
    wanted = r"frequency\[0\] = 1.5 Hz is not allowed; expected .* 2 "
    for run in (virtual_experiment, sine_test):
        with pytest.raises(ValueError, match=wanted):
            run(RigParameters(), 3.18, [1.5])


def test_what_settled_near_no_solution_is_elsewhere():
    rig = RigParameters()
    test = sine_test(rig, 3.18, [30.0, 30.0])
    found = overlay(rig, dataclasses.replace(test, relative=test.relative * [1.1, 1.3]))
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
