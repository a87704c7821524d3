"""Gauss-Newton on the lines of a band: derivatives, leakage, and what it gains on noise."""

from dataclasses import replace

import numpy as np

from rigsim.identification.refine import _lines, refine_state_space, response_deviations
from tests.identification.test_subspace import known_system, response
from tests.identification.whole import identify_state_space


def test_derivatives_are_those_of_the_modelled_lines():
    model = known_system()
    rng = np.random.default_rng(0)
    z = np.exp(2j * np.pi * np.array([0.01, 0.1, 0.3]))
    U = rng.normal(size=(3, 2)) + 1j * rng.normal(size=(3, 2))
    matrices = (model.A, model.B, model.C, model.D, rng.normal(size=(4, 2)))
    ends = z[:, None] * np.array([[1, 0], [1, 0], [0, 1]])
    _, columns = _lines(matrices, U, z, ends)
    column = 0
    for number, matrix in enumerate(matrices):
        for index in np.ndindex(matrix.shape):
            sides = []
            for step in (1e-6, -1e-6):
                moved = [m.copy() for m in matrices]
                moved[number][index] += step
                sides.append(_lines(moved, U, z, ends)[0])
            np.testing.assert_allclose(columns[..., column], (sides[0] - sides[1]) / 2e-6, rtol=1e-6, atol=1e-6)
            column += 1
    assert column == columns.shape[-1]


def test_lines_of_a_finite_record_are_exact():
    model = known_system((3.0, -1.0, 2.0, 5.0))
    inputs = np.random.default_rng(1).normal(size=(301, 2))
    states = [model.start]
    for u in inputs:
        states.append(model.A @ states[-1] + model.B @ u)
    lines = np.arange(3, 120)
    matrices = (model.A, model.B, model.C, model.D, (states[0] - states[-1])[:, None])
    z = np.exp(2j * np.pi * lines / 301)
    modelled, _ = _lines(matrices, np.fft.rfft(inputs, axis=0)[lines], z, z[:, None])
    np.testing.assert_allclose(modelled, np.fft.rfft(model.simulate(inputs), axis=0)[lines], rtol=1e-9, atol=1e-9)


def test_a_noisy_estimate_comes_nearer_and_an_exact_one_stays():
    true = known_system()
    rng = np.random.default_rng(2)
    inputs = rng.normal(size=(4000, 2))
    clean = true.simulate(inputs)
    frequency = np.linspace(1, 25, 60)
    exact, _, left = refine_state_space(true, inputs, clean, (1, 25))
    assert (left < 1e-11).all()
    np.testing.assert_allclose(response(exact, frequency), response(true, frequency), rtol=1e-8)
    before, after = [], []
    for _ in range(6):
        outputs = clean + 0.3 * clean.std(axis=0) * rng.normal(size=clean.shape)
        estimate, _ = identify_state_space(inputs, outputs, 100.0, 4, 10)
        refined, _, unexplained = refine_state_space(estimate, inputs, outputs, (1, 25))
        before.append(np.linalg.norm(response(estimate, frequency) - response(true, frequency)))
        after.append(np.linalg.norm(response(refined, frequency) - response(true, frequency)))
        assert (unexplained > 0.05).all() and (unexplained < 0.3).all()  # noise outside the band does not count
    assert np.mean(after) < 0.9 * np.mean(before)


def test_no_refinement_leaves_more_than_it_was_given_or_a_model_that_grows():
    """Newton's steps from far away end anywhere: what does not lower the misfit, or is unstable, is not taken."""
    true = known_system()
    inputs = np.random.default_rng(4).normal(size=(2000, 2))
    outputs = true.simulate(inputs)
    gains = []
    for seed in range(24):
        rng = np.random.default_rng(seed)
        size = (0.02, 0.05, 0.1, 0.3)[seed % 4]
        A = true.A + size * rng.normal(size=true.A.shape)
        radius = abs(np.linalg.eigvals(A)).max()
        A *= 0.97 / radius if radius >= 1 else 1
        start = replace(true, A=A, B=true.B + 3 * size * rng.normal(size=true.B.shape))
        refined, given, _ = refine_state_space(start, inputs, outputs, (1, 25))
        _, left, _ = refine_state_space(refined, inputs, outputs, (1, 25))
        gains.append(np.mean((left / given) ** 2))
        assert gains[-1] < 1 + 1e-9 and abs(np.linalg.eigvals(refined.A)).max() < 1
        if gains[-1] > 1 - 1e-9:
            np.testing.assert_array_equal(refined.A, start.A)
    assert min(gains) < 1e-9 and max(gains) > 1 - 1e-9  # from near it finds the system; from far it stays


def test_deviations_of_the_response_are_those_of_models_of_many_noises():
    truth = known_system()
    rng = np.random.default_rng(5)
    inputs, frequency, band = rng.normal(size=(4000, 2)), np.array([3.0, 8.0, 20.0]), (1.0, 30.0)
    clean, noise = truth.simulate(inputs), np.array([0.02, 0.05])
    points = np.exp(2j * np.pi * frequency / truth.sample_rate)[:, None, None]
    found = []
    for _ in range(60):
        model, *_ = refine_state_space(truth, inputs, clean + noise * rng.normal(size=clean.shape), band)
        found.append(model.D + model.C @ np.linalg.solve(points * np.eye(4) - model.A, np.tile(model.B, (3, 1, 1))))
    columns = response_deviations(truth, inputs, clean, noise * np.sqrt(len(inputs)), band, (0,), frequency)
    expected = np.sqrt(np.sum(np.abs(columns) ** 2, axis=-1))
    np.testing.assert_allclose(np.std(found, axis=0), expected, rtol=0.35)
