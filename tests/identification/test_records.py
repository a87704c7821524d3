"""Records of every kind: velocities and accelerations, one sensor, a base that moves, several tests end to end."""

from dataclasses import replace

import numpy as np
import pytest

from rigsim.experiment.random_test import random_test
from rigsim.experiment.record import Record
from rigsim.identification.identify import identify
from rigsim.identification.layout import ONE_MASS, TWO_MASSES
from rigsim.identification.simulate import SENSED, Run, simulate
from rigsim.identification.terms import Friction, Power, Term
from rigsim.model.wires import suspension_force
from rigsim.parameters import MassParameters, RigParameters
from rigsim.results import Status

P = RigParameters().oscillator
TWO = np.array([P.ms, P.ks, P.cs, P.m, P.c, P.k1, P.k3])
ONE = np.array([0.154, 9.86, 1.88e4, 3e9])
RATE = 2000.0
DISPLACEMENT, VELOCITY, ACCELERATION = SENSED


def record(kinds=(DISPLACEMENT,) * 2, rms=1.115, n=60_000, noise=0.0, base=False, hold="zero", seed=1, **more):
    """A test of the paper's rig, or with one sensor of a single mass, from rest."""
    rng = np.random.default_rng(seed)
    force = rms * rng.normal(size=n)
    layout, values = (TWO_MASSES, TWO) if len(kinds) == 2 else (ONE_MASS, ONE)
    outputs = dict.fromkeys(("shaker", "mass")[: len(kinds)])
    empty = Record(force, **{"mass": None} | dict.fromkeys(outputs, force), sample_rate=RATE, hold=hold, base=base,
                   kinds=dict(zip(outputs, kinds, strict=True)))  # fmt: skip
    terms = tuple(more)
    structure = layout.structure(empty, terms)
    every = np.append(layout.ordered(values, structure)[: len(values)], list(more.values()))
    reach = np.full(len(structure.terms), 1e-3 if len(kinds) == 2 else 1e-2)
    start = np.zeros((1, 2 * len(kinds)))
    found = simulate(structure, every, Run(force, RATE, hold), start, reach, finer=6)[0]
    found = found + noise * found.std(axis=0) * rng.normal(size=found.shape)
    return empty.replace(**dict(zip(outputs, found.T, strict=True)))


def off(found, true=TWO, base=False):
    """Errors of the parameters, relative, and their half-widths."""
    true = true / true[0] if base else true
    errors = found.errors
    return errors.value[: true.size] / true - 1, errors.half_width[: true.size] / true


@pytest.mark.parametrize("kinds", [(VELOCITY, VELOCITY), (ACCELERATION, ACCELERATION), (DISPLACEMENT, ACCELERATION)])
def test_velocities_and_accelerations_are_read_as_they_are(kinds):
    found = identify(record(kinds))
    assert found.status == Status.IDENTIFIED
    error, _ = off(found)
    assert np.abs(error).max() < 1e-4
    second = np.array([getattr(found.read, name) for name in TWO_MASSES.names]) / TWO - 1
    assert np.abs(second).max() < 1e-2  # H_E, with a z that was simulated
    assert found.receptance.shape == (found.frequency.size, 2, 2)
    still = found.receptance[np.searchsorted(found.frequency, 10.0), 0, 0]
    assert abs(still) == pytest.approx(1 / P.ks, rel=0.1)  # m/N, whatever was measured


@pytest.mark.parametrize("hold", ["linear", "band-limited"])
def test_accelerations_under_other_holds(hold):
    smooth = record((ACCELERATION,) * 2, hold=hold)
    error, _ = off(identify(smooth))
    assert np.abs(error).max() < 1e-3


def test_what_noisy_accelerations_do_not_tell_is_said():
    found = identify(record((ACCELERATION,) * 2, noise=0.03))
    error, wide = off(found)
    assert (np.abs(error) < 1.5 * wide).all()
    assert found.status == Status.DOUBTFUL and "not determined" in found.message


def test_a_mass_that_nobody_felt_is_never_surely_small():
    """A direction that the record hardly tells is as unsure as that, even where a fit went far along it."""
    tests = [record((ACCELERATION,) * 2, n=20_000, noise=0.05, rms=0.3, seed=seed) for seed in (1, 2)]
    found = identify(tests)
    assert found.status == Status.DOUBTFUL
    if found.errors is not None:
        error, wide = off(found)
        assert (np.abs(error) < 2 * wide).all()


@pytest.mark.parametrize("kind", SENSED)
def test_one_mass_on_a_spring(kind):
    found = identify(record((kind,)))
    assert found.status == Status.IDENTIFIED and isinstance(found.parameters, MassParameters)
    error, _ = off(found, ONE)
    assert np.abs(error).max() < 1e-5
    assert found.modes.frequency == pytest.approx(np.sqrt(ONE[2] / ONE[0]) / (2 * np.pi), rel=1e-3)
    assert "k3" in found.summary() and list(found.table().index) == list(ONE_MASS.names)


def test_one_mass_with_friction_is_not_said_to_be_without():
    rubbing = Term("mu", (0,), Friction(0.005), "velocity", "N")
    test = record((DISPLACEMENT,), noise=1e-3)
    force = test.force
    structure = ONE_MASS.structure(test, (rubbing,))
    run = Run(force, RATE, "zero")
    moved, _ = simulate(structure, np.append(ONE, 0.05), run, np.zeros((1, 2)), np.array([1e-2] * 3 + [1.0]), finer=6)
    noisy = moved[:, 0] + 1e-4 * moved.std() * np.random.default_rng(2).normal(size=force.size)
    silent = identify(test.replace(shaker=noisy))
    assert "dry friction" in silent.message
    found = identify(test.replace(shaker=noisy), terms=[rubbing])
    assert found.status == Status.IDENTIFIED
    assert found.errors.value[-1] == pytest.approx(0.05, rel=0.02)


@pytest.mark.parametrize("kind", [DISPLACEMENT, ACCELERATION])
def test_on_a_base_the_ratios_are_found(kind):
    shaken = record((kind,) * 2, rms=1.0, base=True, noise=1e-3)
    found = identify(shaken)
    error, wide = off(found, base=True)
    assert found.status == Status.IDENTIFIED and found.errors.value[0] == 1.0
    assert (np.abs(error) < 1.5 * wide + 1e-6).all()
    assert found.receptance[:, 0, 1] == pytest.approx(found.receptance[:, 1, 0])
    assert found.table().loc["ks", "unit"] == "N/m/kg" and "per kg of the first mass" in found.summary()
    single = identify(record((kind,), rms=20.0, base=True))
    error, _ = off(single, ONE, base=True)
    assert np.abs(error).max() < 1e-4


def test_several_tests_of_any_level_are_one_record():
    levels = [record(n=20_000, rms=rms, seed=seed, noise=2e-3) for seed, rms in enumerate((0.3, 1.115, 2.0))]
    found = identify(levels)
    error, wide = off(found)
    assert found.status == Status.IDENTIFIED and not found.mended
    assert (np.abs(error) < 1.5 * wide).all()
    alone = [off(identify(level))[1][-1] for level in levels]
    assert wide[-1] < min(alone)  # more is known of k3 than from any of them


def test_weights_that_were_made_of_a_misfit_are_made_anew():
    """Of these the first step left a misfit at a resonance, whose weight stayed low, and the next steps kept it."""
    levels = [
        record((ACCELERATION,) * 2, n=n, rms=rms, seed=seed, noise=0.01)
        for n, rms, seed in ((20_000, 1.115, 21), (30_000, 0.3, 22))
    ]
    found = identify(levels)
    assert (found.errors.disagreement == 1).all()


def test_where_tests_meet_nothing_is_wrong_and_clocks_count_from_each_start():
    one, two = record(n=20_000, seed=3), record(n=24_000, seed=4)
    late = Record.joined([test.realigned(clock={"shaker": 50.0, "mass": 50.0}) for test in (one, two)])
    found = identify(late)
    assert any("clock" in trouble.message for trouble in found.mended)
    error, _ = off(found)
    assert np.abs(error).max() < 2e-2


def test_the_band_of_the_coefficient_is_as_wide_as_it_scatters():
    found = [identify(record(n=40_000, noise=0.005, seed=seed)) for seed in range(10)]
    places = np.searchsorted(found[0].frequency, [8.0, 15.0, 30.0, 50.0, 70.0])
    scatter = np.std([one.nonlinear_coefficient.real[places] for one in found], axis=0, ddof=1)
    apart = np.array([abs(one.read.k3 - one.k3) for one in found])[:, None]
    told = np.array([one.nonlinear_half_width[places] for one in found]) - apart
    np.testing.assert_allclose(np.median(told, axis=0), 1.96 * scatter, rtol=0.6)
    inside = [abs(one.nonlinear_coefficient.real - P.k3) < one.nonlinear_half_width for one in found]
    assert np.mean(inside) > 0.9


def test_what_is_foretold_of_another_test():
    found = identify(record(n=40_000, noise=1e-3))
    other = record(n=8000, rms=1.5, seed=9)
    foretold = found.predicted(other)
    rest = foretold - np.column_stack([other.shaker, other.mass])
    assert (rest.std(axis=0) < 0.02 * foretold.std(axis=0)).all()
    for wrong, told in (
        (record((ACCELERATION,) * 2, n=100), "'acceleration'} and a force"),
        (record(n=100, base=True), "a base"),
    ):
        with pytest.raises(ValueError, match=f"record measures .*{told}; expected .* and a force"):
            found.predicted(wrong)


def test_what_such_a_record_cannot_be_read_as():
    with pytest.raises(ValueError, match="conversion"):
        identify(record((VELOCITY,) * 2, n=20_000), conversion="all")
    with pytest.raises(ValueError, match=r"term k is between \(0, 1\)"):
        identify(record((DISPLACEMENT,), n=20_000), terms=[Term("k", (0, 1))])
    with pytest.raises(ValueError, match="sample_rate of the records = 2000.0 and 1000.0"):
        identify([record(n=20_000), replace(record(n=20_000), sample_rate=1000.0)])


@pytest.mark.full
def test_from_which_force_on_the_wires_show_their_quintic(tell):
    """Its coefficient is that of the wires' exact law; with 0.1 % noise on both sensors of the multi-body rig."""
    rig, quintic, rng = RigParameters(wire_sets=2), Term("k5", (0, 1), Power(5), unit="N/m^5"), np.random.default_rng(3)
    z = np.linspace(-5e-4, 5e-4, 2001)
    powers = np.stack([z, z**3, z**5, z**7], axis=1) / 5e-4 ** np.array([1, 3, 5, 7])
    true = (np.linalg.lstsq(powers, suspension_force(z, rig), rcond=None)[0] / 5e-4 ** np.array([1, 3, 5, 7]))[2]
    seen = {}
    for rms in (1.115, 2.0, 3.0, 5.0):
        test = random_test(rig, rms)
        noisy = {
            name: channel + 1e-3 * channel.std() * rng.normal(size=channel.size)
            for name, channel in (("shaker", test.shaker), ("mass", test.mass))
        }
        errors = identify(test.replace(**noisy), terms=[quintic]).errors
        value, wide = errors.value[-1], errors.half_width[-1]
        seen[rms] = abs(value) > wide
        assert abs(value - true) < 2 * wide + 0.03 * abs(true)  # the next term of the law is some per cent of it
        tell(f"quintic of the wires at {rms:g} N rms: {value:.3g} +- {wide:.2g} N/m^5, true {true:.3g}")
    assert list(seen.values()) == [False, True, True, True]
