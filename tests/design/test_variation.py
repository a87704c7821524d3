"""Numbers changed one by one or by the thousand give the sets that the parameter classes give."""

import numpy as np
import pytest

from rigsim.design.variation import half_widths, judge_varied, names_of, quantity, replaced, varied_sets
from rigsim.parameters import RigParameters

RIG = RigParameters()


def five(parameters, force):
    group = parameters.nondimensional(force)
    return [group.mu, group.zeta_s, group.zeta, group.Omega0, group.gamma]


@pytest.mark.parametrize(
    "parameters", [RIG, RIG.replace(k=(3e4, 5e4) * 4), RIG.oscillator], ids=["rig", "wires", "two"]
)
def test_every_field_moves_as_the_classes_say(parameters):
    for name in set(names_of(parameters)) & {"ms", "ks", "cs", "m", "c", "k", "d", "d0", "k1", "k3", "force"}:
        if name in ("k1", "k3") and parameters is not RIG.oscillator:
            continue
        value = quantity(parameters, 3.18, name).value * (1 - 2e-5)
        new, force = replaced(parameters, 3.18, {name: max(value, parameters.d0) if name == "d" else value})
        (row,) = varied_sets(parameters, 3.18, {name: [quantity(new, force, name).value]})
        # Not to the last bit: the stretch d - d0 loses four digits, and the mean of the wires one more.
        np.testing.assert_allclose(row, five(new, force), rtol=1e-11)


def test_names_further_along_override_what_comes_before():
    (plain,) = varied_sets(RIG, 3.18, {"k": [4.2e4], "k1": [10.0]})
    np.testing.assert_allclose(plain, five(RIG.oscillator.replace(k1=10.0, k3=RIG.k3 * 1.05), 3.18), rtol=1e-12)
    (group,) = varied_sets(RIG, 3.18, {"gamma": [0.5], "force": [7.0]})
    assert group[4] == 0.5 and group[0] == five(RIG, 3.18)[0]
    kept, changed = varied_sets(RIG, 3.18, {"mu": [np.nan, 0.2]})
    assert kept[0] == five(RIG, 3.18)[0] and changed[0] == 0.2


def test_rigs_that_cannot_be_have_no_curve_and_dampings_stop_at_zero():
    changes = {"d0": [RIG.d * (1 + 1e-9), RIG.d0, RIG.d0, RIG.d0], "m": [RIG.m, 0.0, -1.0, RIG.m]}
    sets = varied_sets(RIG, 3.18, changes)
    np.testing.assert_array_equal(np.isnan(sets).any(axis=1), [True, True, True, False])
    counts, distances = judge_varied(RIG, 3.18, changes)
    np.testing.assert_array_equal(counts, [[0, 0], [0, 0], [0, 0], [1, 0]])
    assert np.isneginf(distances[:3]).all() and 0.0285 < distances[3, 0] < 0.0295
    (row,) = varied_sets(RIG, 3.18, {"c": [-1.0], "cs": [-1.0]})
    assert row[2] == 0 and 0 < row[1] < 1e-9


def test_tolerances_are_numbers_or_per_cent():
    assert half_widths(RIG, 3.18, {"d0": 1e-6, "force": "2 %"}) == {"d0": 1e-6, "force": pytest.approx(0.0636)}


@pytest.mark.parametrize(
    "tolerances, message",
    [
        ({}, "expected a dict"),
        ({"LG": 1e-3}, "quantity = 'LG' is not allowed"),
        ({"d0": -1e-6}, "tolerance of d0 = -1e-06 m is not allowed"),
        ({"d0": "two"}, "tolerance of d0 = 'two' is not allowed"),
        ({"d0": "x %"}, "tolerance of d0 = 'x ' is not a number"),
    ],
)
def test_tolerances_that_are_not_allowed(tolerances, message):
    with pytest.raises(ValueError, match=message):
        half_widths(RIG, 3.18, tolerances)
    with pytest.raises(ValueError, match="c is zero"):
        half_widths(RIG.replace(c=0.0), 3.18, {"c": "5 %"})
