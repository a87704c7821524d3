"""Probability of a detached curve: a sure rig has it or not, an unsure one in the share of rigs that have it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from rigsim.design.count import existence_forces, having, judge
from rigsim.design.probability import curve_probability, sampled
from rigsim.design.variation import varied_sets
from rigsim.identification.identify import identify
from rigsim.parameters import RigParameters
from tests.identification.cubic import cubic_record

RIG = RigParameters().oscillator


@pytest.fixture(scope="module")
def sure():
    return identify(cubic_record(duration=10))


def widened(found, shares):
    """The identification, its half-widths by name as told (shares of the values), each for itself."""
    width = np.array([shares.get(name, 0.0) for name in found.errors.names]) * found.errors.value
    return replace(found, errors=replace(found.errors, half_width=width, covariance=np.diag(width**2)))


def test_a_tally_counts_what_judging_each_set_at_each_force_does():
    names, generator = ("m", "c", "k1", "k3", "ks", "cs"), np.random.default_rng(1)
    changes = {name: getattr(RIG, name) * (1 + 0.1 * generator.standard_normal(100)) for name in names}
    forces = np.geomspace(0.3, 8, 17)
    tally = having(varied_sets(RIG, 1.0, changes), forces)
    judged = [(judge(varied_sets(RIG, force, changes))[0] > 0).sum(axis=0) for force in forces]
    np.testing.assert_array_equal(tally.T, judged)
    assert (0 < tally).any(axis=1).all() and (tally < 100).all(axis=0).any()


def test_of_a_sure_rig_the_curves_exist_where_theory_has_them(sure):
    found = curve_probability(sure)
    for kind in ("inner", "outer"):
        spans = existence_forces(sure.parameters, kind)
        there = np.any([(low * 1.01 < found.force) & (found.force < high / 1.01) for low, high in spans], axis=0)
        gone = np.all([(found.force < low / 1.01) | (high * 1.01 < found.force) for low, high in spans], axis=0)
        share = getattr(found, kind)
        assert there.sum() > 5 and (share[there] == 1).all() and (share[gone] == 0).all()
    low, high = existence_forces(sure.parameters)[0]
    assert f"inner detached curve: more likely than not from {low:.2f}" in found.summary() and found.at(4.0) == (1, 0)
    assert 3.456 in curve_probability(sure, 3.456).force and len(found.table()) == found.force.size


def test_at_the_edge_half_of_the_rigs_have_it_and_the_wider_the_slower_it_comes(sure):
    (edge, _), *_ = existence_forces(sure.parameters)
    for width in (0.02, 0.1):
        further = np.array([1 - width / 4, 1, 1 + width / 4, 1 + width / 2])
        found = curve_probability(widened(sure, {"k3": width}), edge * further, samples=4000)
        expected = norm.cdf(1.96 / width * (1 - further**-2))  # the edge goes as 1 / sqrt(k3)
        np.testing.assert_allclose([found.at(force)[0] for force in edge * further], expected, atol=0.025)


def test_rigs_are_drawn_correlated_and_as_wide_as_the_intervals(sure):
    errors = sure.errors
    correlation = errors.covariance / np.sqrt(np.outer(np.diag(errors.covariance), np.diag(errors.covariance)))
    drawn = sampled(errors, 20_000, np.random.default_rng(0))
    np.testing.assert_allclose(drawn.std(axis=0), errors.half_width / 1.96, rtol=0.03)
    np.testing.assert_allclose(np.corrcoef(drawn.T), correlation, atol=0.03)
    same = curve_probability(sure, seed=3), curve_probability(sure, seed=3)
    np.testing.assert_array_equal(same[0].inner, same[1].inner)


def test_what_cannot_be_is_no_rig_with_a_curve(sure):
    found = curve_probability(widened(sure, {"k1": 4.0, "k3": 4.0}))
    assert 0 < found.inner.max() < 0.9
    with pytest.raises(ValueError, match="errors is None"):
        curve_probability(identify(cubic_record(duration=10), conversion="all"))
    with pytest.raises(ValueError, match="force"):
        curve_probability(sure, -1.0)
