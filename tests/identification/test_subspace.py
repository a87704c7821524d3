"""The Gram recursion against the Hankel matrix itself, and known systems found again."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rigsim.identification.subspace import (
    StateSpace,
    _stable,
    extended_gram,
    fit_input_matrices,
)
from tests.identification.whole import identify_state_space


@settings(max_examples=30, deadline=None)
@given(st.integers(12, 40), st.integers(1, 3), st.integers(1, 6), st.floats(-5, 5))
def test_gram_recursion_is_the_hankel_product_about_row_means(samples, c, rows, offset):
    channels = np.random.default_rng(samples).normal(size=(samples, c)) + offset
    hankel = np.vstack([channels[a : samples - rows + 1 + a].T for a in range(rows)])
    hankel = hankel - hankel.mean(axis=1, keepdims=True)
    gram = extended_gram(channels, rows)
    np.testing.assert_allclose(gram, hankel @ hankel.T, atol=1e-10 * max(1, offset**2) * samples)


def known_system(start=(0.0, 0.0, 0.0, 0.0), offset=(0.0, 0.0)):
    angle, size = np.array([0.3, 1.1]), np.array([0.99, 0.95])
    A = np.zeros((4, 4))
    for mode in range(2):
        turn = [[np.cos(angle[mode]), np.sin(angle[mode])], [-np.sin(angle[mode]), np.cos(angle[mode])]]
        A[2 * mode : 2 * mode + 2, 2 * mode : 2 * mode + 2] = size[mode] * np.array(turn)
    rng = np.random.default_rng(5)
    B, C, D = rng.normal(size=(4, 2)), rng.normal(size=(2, 4)), rng.normal(size=(2, 2))
    return StateSpace(A, B, C, D, np.array(start), np.array(offset), 100.0)


def response(model, frequency):
    z = np.exp(2j * np.pi * frequency / model.sample_rate)
    return np.array(
        [model.D + model.C @ np.linalg.solve(point * np.eye(len(model.A)) - model.A, model.B) for point in z]
    )


def test_simulation_is_the_recursion():
    model = known_system((1.0, -2.0, 0.5, 3.0), (4.0, -1.0))
    inputs = np.random.default_rng(0).normal(size=(20, 2))
    state, expected = model.start, []
    for u in inputs:
        expected.append(model.C @ state + model.D @ u + model.offset)
        state = model.A @ state + model.B @ u
    np.testing.assert_allclose(model.simulate(inputs), expected, rtol=1e-12)


@pytest.mark.parametrize("block_rows", [5, 20])
def test_a_known_system_is_found_with_its_start_and_offset(block_rows):
    true = known_system((5.0, -3.0, 2.0, 1.0), (7.0, -2.0))
    inputs = np.random.default_rng(1).normal(size=(3000, 2)) + [3.0, 0.0]
    outputs = true.simulate(inputs)
    model, singular_values = identify_state_space(inputs, outputs, 100.0, 4, block_rows)
    poles = np.sort_complex(np.linalg.eigvals(model.A))
    np.testing.assert_allclose(poles, np.sort_complex(np.linalg.eigvals(true.A)), rtol=1e-7)
    frequency = np.linspace(0.1, 49.9, 50)
    np.testing.assert_allclose(response(model, frequency), response(true, frequency), rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(model.offset, true.offset, rtol=1e-6)
    np.testing.assert_allclose(model.simulate(inputs), outputs, atol=1e-6 * outputs.std())
    assert singular_values.size == 2 * block_rows
    assert singular_values[3] > 1e6 * singular_values[4]


@settings(max_examples=15, deadline=None)
@given(st.lists(st.floats(1e-12, 1e12), min_size=4, max_size=4))
def test_units_of_the_channels_do_not_matter(scales):
    rng = np.random.default_rng(2)
    true = known_system()
    inputs = rng.normal(size=(1000, 2))
    outputs = true.simulate(inputs) + 0.01 * rng.normal(size=(1000, 2))
    to_inputs, to_outputs = np.split(np.array(scales), 2)
    plain, values = identify_state_space(inputs, outputs, 100.0, 4, 8)
    scaled, scaled_values = identify_state_space(inputs * to_inputs, outputs * to_outputs, 100.0, 4, 8)
    np.testing.assert_allclose(scaled_values, values, rtol=1e-8)
    frequency = np.linspace(0.5, 49.5, 9)
    back = response(scaled, frequency) * to_inputs / to_outputs[:, None]
    np.testing.assert_allclose(back, response(plain, frequency), rtol=1e-5, atol=1e-7)


@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_the_hankel_matrix_itself_says_the_same(noise):
    """The Gram matrix loses half the digits of what is small, and what is small is not in the model."""
    rng = np.random.default_rng(6)
    true = known_system((5.0, -3.0, 2.0, 1.0), (7.0, -2.0))
    inputs = rng.normal(size=(3000, 2))
    outputs = true.simulate(inputs)
    outputs = outputs + noise * outputs.std(axis=0) * rng.normal(size=outputs.shape)
    frequency = np.linspace(0.1, 49.9, 50)
    (gram, values), (exact, exact_values) = (
        identify_state_space(inputs, outputs, 100.0, 4, 10, method) for method in ("gram", "qr")
    )
    np.testing.assert_allclose(values, exact_values, rtol=1e-9, atol=1e-5 * values[0])
    np.testing.assert_allclose(response(gram, frequency), response(exact, frequency), rtol=1e-6, atol=1e-7)


def test_given_a_and_c_the_rest_is_plain_least_squares():
    true = known_system((1.0, 2.0, 3.0, 4.0), (0.5, 0.25))
    rng = np.random.default_rng(3)
    inputs = rng.normal(size=(60, 2))
    outputs = true.simulate(inputs) + 0.1 * rng.normal(size=(60, 2))
    found = fit_input_matrices(true.A, true.C, inputs, outputs, 100.0)
    # Linear in what is sought: the columns are simulations with one unknown at 1.
    names = ("B", "D", "start", "offset")
    zero = {name: np.zeros_like(getattr(true, name)) for name in names}
    columns = []
    for name in names:
        for index in np.ndindex(zero[name].shape):
            one = zero[name].copy()
            one[index] = 1.0
            model = StateSpace(**{"A": true.A, "C": true.C, "sample_rate": 100.0, **zero, name: one})
            columns.append((model.simulate(inputs) / outputs.std(axis=0)).ravel())
    expected = np.linalg.lstsq(np.array(columns).T, (outputs / outputs.std(axis=0)).ravel(), rcond=None)[0]
    np.testing.assert_allclose(np.concatenate([getattr(found, name).ravel() for name in names]), expected, rtol=1e-8)


def test_poles_outside_the_circle_are_mirrored():
    A = np.diag([0.5, 1.25]) + np.array([[0.0, 1.0], [0.0, 0.0]])
    np.testing.assert_allclose(np.sort(np.linalg.eigvals(_stable(A))), [0.5, 0.8], rtol=1e-7)
    inside = np.diag([0.5, 0.99])
    assert _stable(inside) is inside
