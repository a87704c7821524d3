"""Detached curves of many sets at once, against certified roots in exact rational arithmetic."""

import numpy as np
import pytest

from rigsim.design import count as module
from rigsim.design.count import existence_forces, judge
from rigsim.parameters import Nondimensional, RigParameters
from rigsim.theory.detached import detached_curves, force_scenario

from ..theory.exact_folds import exact_folds


def random_sets(count, seed):
    """(n, 5): mu 1e-4..1, dampings 1e-4..0.5 and gamma 1e-6..100, all log-uniform, Omega0 uniform in 0..2."""
    rng = np.random.default_rng(seed)
    low, high = [-4, -4, -4, -6], [0, np.log10(0.5), np.log10(0.5), 2]
    mu, zeta_s, zeta, gamma = 10 ** rng.uniform(low, high, (count, 4)).T
    return np.column_stack([mu, zeta_s, zeta, rng.uniform(0, 2, count), gamma])


def certified(numbers):
    """(inner, outer) by the referee."""
    kinds = [kind for _, kind in exact_folds(Nondimensional(*numbers))]
    pairs = list(zip(kinds[::2], kinds[1::2], strict=True))
    return pairs.count(("lower", "lower")), pairs.count(("upper", "upper"))


def near_edges(sets, seed):
    """Two rows for each set that has a detached curve at some force: 1e-6 of the force on either side of an edge."""
    rng = np.random.default_rng(seed)
    kind = rng.integers(2, size=len(sets))
    distance = judge(sets)[1][np.arange(len(sets)), kind]
    sets, distance = sets[np.isfinite(distance)], distance[np.isfinite(distance)]
    rows = []
    for numbers, away in zip(sets, distance, strict=True):
        # The edge is towards more or towards less force; ln(gamma) changes twice as fast as ln(F).
        edges = [numbers[4] * np.exp(2 * move) for move in (away, -away)]
        pairs = [[[*numbers[:4], edge * (1 + sign * 2e-6)] for sign in (-1, 1)] for edge in edges]
        rows += next(pair for pair in pairs if np.abs(judge(pair)[1]).min(axis=1).max() < 1.1e-6)
    return np.array(rows)


def check(count, near_count, tell, seed=21):
    sets = random_sets(count, seed)
    many = random_sets(60 * near_count, seed + 1)
    counts = judge(many)[0]
    with_curves = many[counts.any(axis=1)][:near_count]
    near = near_edges(many[: 8 * near_count], seed + 2)
    wrong = {}
    for name, tried in {"random": sets, "with detached curves": with_curves, "near an edge": near}.items():
        found = judge(tried)[0].tolist()
        wrong[name] = sum(tuple(a) != certified(b) for a, b in zip(found, tried.tolist(), strict=True))
    tried = f"{len(sets)} random sets, {len(with_curves)} with detached curves and {len(near)} forces within 1e-6"
    tell(f"counts by exact roots, {tried} of where one comes or goes, none discarded: {wrong} wrong")
    assert len(with_curves) == near_count and len(near) > near_count
    assert not any(wrong.values())


def test_no_set_is_classified_wrongly(tell):
    check(200, 40, tell)


@pytest.mark.full
def test_no_set_is_classified_wrongly_by_the_thousand(tell):
    check(10_000, 1000, tell)


@pytest.mark.soak
def test_no_set_is_classified_wrongly_in_a_long_run(tell):
    check(30_000, 3000, tell, seed=2026)


def test_doubtful_sets_are_decided_by_integers(monkeypatch):
    rig = RigParameters().nondimensional(3.18)
    sets = np.vstack([random_sets(60, seed=24), [rig.mu, rig.zeta_s, rig.zeta, rig.Omega0, rig.gamma]])
    sets[0, 2] = 0.0  # no damping in the attachment
    sets[1, 3] = 0.0  # no linear stiffness
    usual = judge(sets)
    calls = []
    exact = module.levels
    monkeypatch.setattr(module, "_judge_all", lambda *arguments: arguments[-1].fill(True))
    monkeypatch.setattr(module, "levels", lambda group: calls.append(group) or exact(group))
    again = judge(sets)
    assert len(calls) == len(sets)
    np.testing.assert_array_equal(usual[0], again[0])
    np.testing.assert_allclose(usual[1], again[1], atol=1e-9)


def test_distance_is_positive_exactly_where_there_is_a_curve():
    counts, distances = judge(random_sets(3000, seed=25))
    np.testing.assert_array_equal(counts > 0, distances > 0)
    assert (counts > 0).any(axis=0).all()


def test_existence_forces_are_those_of_the_scenario():
    rig = RigParameters()
    events = {event.force for event in force_scenario(rig)}
    for kind, number in (("inner", 1), ("outer", 2)):
        spans = existence_forces(rig, kind)
        assert len(spans) == number
        for low, high in spans:
            assert all(min(abs(end / force - 1) for force in events) < 1e-12 for end in (low, high))
            for force in (low * (1 + 1e-9), np.sqrt(low * high), high * (1 - 1e-9)):
                assert kind in [curve.kind for curve in detached_curves(rig, force)]
            for force in (low * (1 - 1e-9), high * (1 + 1e-9)):
                assert kind not in [curve.kind for curve in detached_curves(rig, force)]
    assert existence_forces(rig.oscillator.replace(k3=0.0)) == ()


def test_nothing_is_found_without_cubic_stiffness():
    group = RigParameters().nondimensional(3.18)
    gammas = group.gamma * np.array([0.0, 0.5, 1.0, 5.0])
    counts, distances = judge([[group.mu, group.zeta_s, group.zeta, group.Omega0, gamma] for gamma in gammas])
    np.testing.assert_array_equal(counts, [[0, 0], [0, 0], [1, 0], [0, 0]])
    assert np.isneginf(distances[0]).all() and np.isfinite(distances[1:]).all()


def test_an_unknown_kind_is_named():
    with pytest.raises(ValueError, match="kind = 'both' is not allowed"):
        existence_forces(RigParameters(), "both")
