"""Folds, detached curves and the force scenario against certified roots of the discriminant of Eq. (5a)."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import rigsim
from rigsim.parameters import OscillatorParameters, RigParameters
from rigsim.theory.amplitude import frequency_response
from rigsim.theory.detached import detached_curves, folds, force_scenario, jump_frequencies

from .exact_folds import exact_folds, fold_polynomial

ROOT = Path(rigsim.__file__).parents[1]


def random_sets(count, seed):
    """Log-uniform sets: mu 1e-4..1, dampings 1e-4..0.5, gamma over eight decades; Omega0 uniform in 0..2."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        mu, zeta_s, zeta = 10 ** rng.uniform([-4, -4, -4], [0, np.log10(0.5), np.log10(0.5)])
        yield OscillatorParameters.from_nondimensional(mu, zeta_s, zeta, rng.uniform(0, 2), 10 ** rng.uniform(-6, 2))


def compare(parameters, force):
    """Whether folds agree with the referee in number and kind; positions to 1e-6, or what a near-double root allows."""
    expected = exact_folds(parameters.nondimensional(force))
    found = folds(parameters, force)
    if [fold.kind for fold in found] != [kind for _, kind in expected]:
        return False
    return all(
        abs(2 * np.pi * fold.frequency / parameters.omega_s / Omega - 1) < 1e-6
        for fold, (Omega, _) in zip(found, expected, strict=True)
    )


def near_events(sets, seed):
    """Forces 1e-6 (relative) below and above one event of each set's scenario."""
    rng = np.random.default_rng(seed)
    for parameters in sets:
        events = force_scenario(parameters)
        if events:
            event = events[rng.integers(len(events))]
            yield parameters, event.force * (1 - 1e-6), event.force * (1 + 1e-6)


def check_random_sets(count, near_count, tell, seed=5):
    wrong = [p for p in random_sets(count, seed) if not compare(p, 1.0)]
    near = list(near_events(random_sets(near_count, seed + 1), seed + 2))
    wrong_near = [p for p, below, above in near if not (compare(p, below) and compare(p, above))]
    tried = f"{count} random sets and {2 * len(near)} forces within 1e-6 of an event"
    tell(f"folds by exact roots, {tried}, none discarded: {len(wrong)} and {len(wrong_near)} miscounts")
    assert not wrong and not wrong_near


def test_folds_are_the_certified_roots_of_the_discriminant(tell):
    check_random_sets(300, 60, tell)


@pytest.mark.full
def test_folds_are_the_certified_roots_of_the_discriminant_by_the_thousand(tell):
    check_random_sets(10_000, 600, tell)


@pytest.mark.soak
def test_folds_are_the_certified_roots_of_the_discriminant_in_a_long_run(tell):
    check_random_sets(60_000, 6000, tell, seed=2026)


def test_the_fold_polynomial_has_the_known_degrees():
    rig = RigParameters().oscillator
    degrees = [fold_polynomial(p.nondimensional(3.18)).degree() for p in (rig, rig.replace(k1=0.0), rig.replace(c=0.0))]
    assert degrees == [12, 10, 11]


@pytest.mark.parametrize("change", [{"k1": 0.0}, {"c": 0.0}, {"k1": 0.0, "c": 0.0}])
@pytest.mark.parametrize("force", [0.01, 0.3, 1.0, 3.18, 10.0, 100.0])
def test_limits_of_the_parameters_against_certified_roots(change, force):
    assert compare(RigParameters().oscillator.replace(**change), force)


def test_the_papers_rig_has_one_inner_detached_curve():
    (curve,) = detached_curves(RigParameters(), 3.18)
    assert curve.kind == "inner"
    np.testing.assert_allclose([curve.low, curve.high], [20.5, 53.7], atol=0.05)
    assert jump_frequencies(RigParameters(), 3.18)[:2] == (curve.low, curve.high)


def test_birth_and_death_of_the_inner_curve_are_told_apart_within_a_thousandth():
    rig = RigParameters()
    birth, death = [e for e in force_scenario(rig) if ("inner" in e.after) != ("inner" in e.before)]
    kinds = lambda force: [curve.kind for curve in detached_curves(rig, force)]  # noqa: E731
    assert kinds(birth.force * 0.999) == [] and kinds(birth.force * 1.001) == ["inner"]
    assert kinds(death.force * 0.999) == ["inner"] and kinds(death.force * 1.001) == []
    points = jump_frequencies(rig, birth.force * 1.001)
    assert 0.4 < points[2] - points[1] < 0.5  # the gap between inner curve and hysteresis, Hz
    (curve,) = detached_curves(rig, death.force * (1 - 1e-6))
    assert curve.low < death.frequency < curve.high and curve.high - curve.low < 0.4


def test_a_scenario_explains_every_change_of_the_list_of_detached_curves():
    for parameters in [RigParameters().oscillator, *random_sets(25, seed=8)]:
        events = force_scenario(parameters)
        forces = [event.force for event in events]
        assert forces == sorted(forces)
        edges = [0.5 * forces[0], *forces, 2 * forces[-1]] if forces else []
        hysteresis_and_detached = []
        for low, high in zip(edges, edges[1:], strict=False):
            inside = [(low * (high / low) ** share) for share in (0.01, 0.5, 0.99)] if high > low * (1 + 1e-9) else []
            lists = [[fold.kind for fold in folds(parameters, force)] for force in inside]
            assert all(one == lists[0] for one in lists)  # nothing happens between events
            hysteresis_and_detached.append(lists[0] if lists else None)
        for event, before, after in zip(events, hysteresis_and_detached, hysteresis_and_detached[1:], strict=False):
            if before is not None and after is not None:
                assert len(after) - len(before) == 2 * (len(event.after) - len(event.before))
                assert abs(len(after) - len(before)) == 2


def test_folds_are_double_solutions_of_the_response():
    rig = RigParameters()
    for fold in folds(rig, 3.18):
        step = 1e-7 * fold.frequency
        near = frequency_response(rig, 3.18, [fold.frequency - step, fold.frequency + step])
        (row,) = np.flatnonzero(near.count == 3)
        low, middle, high = abs(near.relative[row])
        merging = (low, middle) if fold.kind == "lower" else (middle, high)
        np.testing.assert_allclose(merging, abs(fold.relative), rtol=2e-3)
        assert abs(merging[0] - merging[1]) < 0.1 * (high - low)


def test_without_cubic_stiffness_there_is_nothing():
    linear = RigParameters().oscillator.replace(k3=0.0)
    assert len(folds(linear, 1.0)) == len(detached_curves(linear, 1.0)) == len(force_scenario(linear)) == 0
    assert jump_frequencies(linear, 1.0) == force_scenario(linear).regions == ()
    assert repr(detached_curves(linear, 1.0)) == "Detached curves at 1 N: none"


def test_an_undamped_shaker_is_refused_by_name():
    with pytest.raises(ValueError, match="cs = 0 N s/m"):
        detached_curves(RigParameters().oscillator.replace(cs=0.0), 1.0)
    with pytest.raises(ValueError, match="force = -1 N"):
        folds(RigParameters(), -1.0)


def test_results_are_sequences_that_print_as_tables_and_know_their_settings():
    rig = RigParameters()
    curves, points, scenario = detached_curves(rig, 3.18), folds(rig, 3.18), force_scenario(rig)
    assert curves.parameters is rig and points.force == 3.18 and scenario.parameters is rig
    assert [len(found) for found in (curves, points, scenario)] == [1, 4, 7]
    assert "from [Hz]" in repr(curves) and "20.47" in repr(curves) and "20.47" in curves._repr_html_()
    assert points.table()["frequency [Hz]"].tolist() == list(jump_frequencies(rig, 3.18))
    np.testing.assert_allclose(points.table()["|z| [mm]"], [1e3 * abs(fold.relative) for fold in points])
    assert scenario.table()["event"].tolist() == [event.kind for event in scenario]
    assert points.summary() == "Folds at 3.18 N: 3 lower, 1 upper" and scenario[0].kind == "hysteresis birth"


def test_regions_of_a_scenario_are_bounded_by_folds():
    scenario = force_scenario(RigParameters())
    forces = [event.force for event in scenario]
    for kind, levels, low, high in scenario.regions:
        between = [sum(event < force for event in forces) for force in levels]
        assert len(set(between)) == 1 and kind in ("inner", "outer", "hysteresis")
        middle = levels.size // 2
        places = jump_frequencies(RigParameters(), levels[middle])
        assert (low[middle], high[middle]) in list(zip(places[::2], places[1::2], strict=True))


def test_one_set_needs_no_compiled_code():
    """Nor tables, nor SciPy: a first answer takes little longer than loading NumPy."""
    code = """import sys, rigsim
rig = rigsim.RigParameters()
rigsim.detached_curves(rig, 3.18), rigsim.folds(rig, 3.18), rigsim.force_scenario(rig), rigsim.jump_frequencies(rig, 3)
print(*{"numba", "scipy", "pandas", "tqdm"} & set(sys.modules))"""
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert not done.stdout.split()
