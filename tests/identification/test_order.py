"""The order of a record is the number of its states, and is in doubt where the record does not tell it."""

from functools import cache

import numpy as np
import pytest
from numba import njit

from rigsim.experiment.record import Record
from rigsim.identification.identify import identify
from rigsim.identification.layout import ONE_MASS
from rigsim.identification.model import about_springs_zero
from rigsim.identification.order import model_order
from rigsim.identification.simulate import Run, simulate
from rigsim.identification.subspace import dynamics, truncated
from rigsim.model.oscillator import oscillator_modes
from rigsim.parameters import RigParameters
from rigsim.results import Status
from tests.identification.cubic import cubic_record
from tests.identification.test_records import ACCELERATION, DISPLACEMENT, VELOCITY
from tests.identification.test_records import record as record_of

OSCILLATOR = RigParameters().oscillator


@cache
def three_masses(noise=0.0, mass=0.02, seed=1, duration=30, sample_rate=2000):
    """The paper's rig with one more mass, on a spring of its own to the shaker: 30 Hz, damped by 2 %."""
    stiffness = (2 * np.pi * 30.0) ** 2 * mass
    p, rng = OSCILLATOR, np.random.default_rng(seed)
    force = rng.normal(scale=1.115, size=duration * sample_rate)
    rig = (p.ms, p.m, mass, p.ks, p.cs, p.c, p.k1, p.k3, stiffness, 0.04 * np.sqrt(stiffness * mass))
    outputs = _integrate(force, 0.25 / sample_rate, np.array(rig))
    outputs = outputs + noise * outputs.std(axis=0) * rng.normal(size=outputs.shape)
    return Record(force, *outputs.T, sample_rate)


@njit
def _integrate(force, step, rig):
    """Shaker and mass before each sample of a held force, by the classical Runge-Kutta rule, four steps a sample."""
    outputs, state = np.empty((force.size, 2)), np.zeros(6)
    for n in range(force.size):
        outputs[n] = state[:2]
        for _ in range(4):
            one = _rate(state, force[n], rig)
            two = _rate(state + step / 2 * one, force[n], rig)
            three = _rate(state + step / 2 * two, force[n], rig)
            four = _rate(state + step * three, force[n], rig)
            state = state + step / 6 * (one + 2 * two + 2 * three + four)
    return outputs


@njit
def _rate(state, f, rig):
    ms, m, mass, ks, cs, c, k1, k3, stiffness, damping = rig
    z, w = state[0] - state[1], state[3] - state[4]
    spring = c * w + k1 * z + k3 * z**3
    third = stiffness * (state[0] - state[2]) + damping * (state[3] - state[5])
    shaker = (f - ks * state[0] - cs * state[3] - spring - third) / ms
    return np.array([state[3], state[4], state[5], shaker, spring / m, third / mass])


def modes(found):
    return np.sort(found.frequency[found.order == found.chosen])


@pytest.mark.parametrize("noise", [0.0, 1e-3, 0.01, 0.05])
def test_the_rig_has_four_states_whatever_the_noise(noise):
    for seed in range(3):
        found = model_order(cubic_record(duration=20, noise=noise, seed=seed))
        assert (found.chosen, found.status, found.message) == (4, Status.FOUND, "")
        np.testing.assert_allclose(modes(found), oscillator_modes(OSCILLATOR).frequency, rtol=0.01)
        assert found.fall(4) == max(found.fall(order) for order in found.orders) > 50
        assert found.summary().startswith(f"Model order 4: singular values fall by {found.fall(4):.2g} after it")


@pytest.mark.parametrize("noise", [0.0, 0.01, 0.05])
def test_a_third_mass_makes_it_six_and_its_mode_is_named(noise):
    found = model_order(three_masses(noise))
    assert (found.chosen, found.status) == (6, Status.FOUND)
    p, mass = OSCILLATOR, 0.02
    k4 = (2 * np.pi * 30.0) ** 2 * mass
    stiffness = [[p.ks + p.k1 + k4, -p.k1, -k4], [-p.k1, p.k1, 0], [-k4, 0, k4]]
    squares = np.linalg.eigvals(np.array(stiffness) / np.array([[p.ms], [p.m], [mass]]))
    np.testing.assert_allclose(modes(found), np.sqrt(np.sort(squares)) / (2 * np.pi), rtol=0.01)
    assert f"{modes(found)[1]:.4g}" in found.summary() and abs(modes(found)[1] - 29.25) < 0.2


def test_a_third_mass_that_noise_all_but_drowns_is_a_doubt():
    found = model_order(three_masses(0.05, 0.003))
    assert (found.chosen, found.status) == (4, Status.DOUBTFUL)
    assert "keeps frequency and shape at higher orders, and this one lacks it" in found.message
    assert "doubtful: a mode at 29." in found.summary()


def test_channels_that_have_nothing_to_do_with_each_other_have_no_clear_order():
    found = model_order(Record(*np.random.default_rng(1).standard_normal((3, 4000)), 1000.0))
    assert (found.chosen, found.status) == (4, Status.DOUBTFUL)
    assert found.message.startswith("the order is not clear: singular values fall by 1")


def test_an_offset_of_a_sensor_is_no_mode():
    record = cubic_record(duration=20)
    found = model_order(record.replace(shaker=record.shaker + 5e-4))
    assert (found.chosen, found.status) == (4, Status.FOUND) and found.fall(4) > 1e4


def test_what_folds_in_a_slow_record_is_no_mode():
    """Sampled at 500 Hz, z^3 is not what its samples say, and high orders find poles in the rest."""
    for seed in range(4):
        found = model_order(cubic_record(duration=20, seed=seed, sample_rate=500))
        assert (found.chosen, found.status) == (4, Status.FOUND)
        assert found.singular_values[4] > 1e-5 * found.singular_values[0]


def test_one_decomposition_gives_what_one_for_each_order_does():
    record = cubic_record(duration=5, noise=0.01)
    found = model_order(record, orders=range(4, 15, 2), block_rows=20)
    _, gram, scale = about_springs_zero(record, 4, 20, (2, 80))
    for order in found.orders:
        A, _, singular_values = dynamics(gram, scale, 2, order)
        poles = np.log(np.linalg.eigvals(A).astype(complex)) * record.sample_rate
        own = np.sort(found.frequency[found.order == order])
        alone = np.sort(np.abs(poles[poles.imag > 0])) / (2 * np.pi)
        assert all(np.isclose(alone, one, rtol=1e-6).any() for one in own)
        np.testing.assert_allclose(found.singular_values, singular_values)


def test_a_smaller_order_is_the_first_columns():
    rng = np.random.default_rng(3)
    A = np.linalg.qr(rng.normal(size=(4, 4)))[0] * 0.9
    C = rng.normal(size=(2, 4))
    observability = np.concatenate([C @ np.linalg.matrix_power(A, power) for power in range(8)])
    found, outputs = truncated(np.hstack([observability, rng.normal(size=(16, 3))]), np.array([2.0, 3.0]), 4)
    np.testing.assert_allclose(found, A, atol=1e-10)
    np.testing.assert_allclose(outputs, C * [[2.0], [3.0]])


def test_criteria_compare_with_the_order_before():
    found = model_order(cubic_record(duration=20, noise=0.01))
    assert not found.meets[found.order == 4].any()  # order 2 has no poles of its own
    assert found.stable[found.order == 6][np.argsort(found.frequency[found.order == 6])][:2].all()
    table = found.table()
    assert (table.loc[6:, "stable in band"] == 2).all() and list(table.index) == list(range(2, 21, 2))
    np.testing.assert_allclose(table["fall after it"], [found.fall(order) for order in found.orders])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"orders": (4, 6, 7, 8)}, "orders = 7 is not allowed; expected even numbers"),
        ({"orders": (4, 6, 8)}, "orders = 4, 6, 8 do not tell; expected 4 and at least 3 beyond it"),
        ({"orders": (6, 8, 10, 12)}, "do not tell; expected 4"),
        ({"orders": (4, 6, 8, 60)}, "orders = 60 is not allowed; expected .* 2 to 40"),
        ({"block_rows": 8}, "block_rows = 8 is not allowed; expected .* 10"),
        ({"band": (2, 5000)}, "band"),
    ],
)
def test_mistakes_are_named(options, message):
    with pytest.raises(ValueError, match=message):
        model_order(cubic_record(duration=2), **options)


def test_it_takes_what_identify_takes():
    with pytest.raises(ValueError, match="record = 1.0 is not allowed; expected a Record"):
        model_order([1.0, 2.0])
    flat = np.ones(4000)
    with pytest.raises(ValueError, match="mass = 1 throughout is not allowed"):
        model_order(Record(*np.random.default_rng(1).standard_normal((2, 4000)), flat, 1000.0))


def test_identify_takes_the_order_that_is_found():
    found = identify(three_masses(noise=1e-3), order="auto")
    assert len(found.state_space.A) == 6 and found.status == Status.DOUBTFUL  # a third mode is no part of the rig
    assert len(identify(cubic_record(duration=20, noise=0.01), order="auto").state_space.A) == 4
    with pytest.raises(ValueError, match="order = 'most' is not allowed; expected an even"):
        identify(cubic_record(duration=20), order="most")


def test_one_sensor_has_two_states():
    record = cubic_record(duration=20)
    p, run = [0.154, 9.86, 1.88e4, 1e9], Run(record.force, 2000.0, "zero")
    shaker, _ = simulate(
        ONE_MASS.structure(record.replace(mass=None)), np.array(p), run, np.zeros((1, 2)), np.full(3, 5e-3)
    )
    noise = 0.01 * shaker.std() * np.random.default_rng(1).normal(size=shaker.shape)
    found = model_order(record.replace(shaker=(shaker + noise)[:, 0], mass=None))
    assert (found.chosen, found.status) == (2, Status.FOUND)


@pytest.mark.parametrize("noise", [1e-3, 0.02])
@pytest.mark.parametrize("base", [False, True])
@pytest.mark.parametrize("kinds", [(ACCELERATION,), (VELOCITY,), (VELOCITY, VELOCITY), (DISPLACEMENT, ACCELERATION)])
def test_whatever_was_measured_the_order_is_the_rigs(kinds, base, noise):
    level = 20.0 if base and len(kinds) == 1 else 1.115
    found = model_order(record_of(kinds, rms=level, n=30_000, noise=noise, base=base))
    assert found.chosen == 2 * len(kinds)
    assert base or found.status is Status.FOUND, found.message


def test_an_order_beyond_the_rigs_is_doubtful_where_z_was_not_measured():
    """Two accelerations of a base that shakes hard: what z lacks below the band makes poles that stay."""
    found = model_order(record_of((ACCELERATION,) * 2, rms=2.0, n=30_000, noise=1e-3, base=True))
    assert found.chosen > 4 and found.status is Status.DOUBTFUL and "z was not measured" in found.message


def test_few_block_rows_of_one_sensor_have_a_singular_value_after_every_order():
    short = record_of((DISPLACEMENT,), n=20_000, noise=1e-3)
    found = model_order(short, block_rows=10)
    assert found.chosen == 2 and found.orders[-1] == 8 and found.fall(8) >= 1
    with pytest.raises(ValueError, match="orders = 10"):
        model_order(short, (2, 4, 6, 8, 10), block_rows=10)
    with pytest.raises(ValueError, match="block_rows = 9"):
        model_order(short, block_rows=9)


def test_an_identification_has_the_order_of_its_record():
    record = record_of((ACCELERATION,), n=20_000, noise=1e-3)
    own, asked = identify(record, block_rows=20).model_order(), model_order(record, block_rows=20)
    np.testing.assert_array_equal(own.frequency, asked.frequency)
    assert own.orders == asked.orders and own.chosen == 2
