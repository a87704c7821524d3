"""Sines of a made-up signal, recovered."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rigsim.experiment.lines import fit_sines, strongest_lines

TIME = 2.0 + np.arange(4000) / 4000


def signal(lines, time=TIME, mean=0.0):
    return mean + sum(np.real(U * np.exp(2j * np.pi * f * time)) for f, U in lines)


def test_sines_fitted_together_are_recovered_exactly():
    lines = [(20.0, 1 - 2j), (40.0, 1e-3j), (61.3, 0.5), (63.0, -1e-6)]
    values = np.column_stack([signal(lines, mean=5.0), signal(lines[:2], mean=-1.0)])
    amplitudes, residual = fit_sines(TIME, values, [f for f, _ in lines])
    np.testing.assert_allclose(amplitudes[:, 0], [U for _, U in lines], atol=1e-13)
    np.testing.assert_allclose(amplitudes[:, 1], [1 - 2j, 1e-3j, 0, 0], atol=1e-13)
    np.testing.assert_allclose(residual, 0, atol=1e-12)


@settings(max_examples=30)
@given(st.floats(2.0, 150.0), st.integers(0, 2**32 - 1))
def test_the_fit_is_that_of_a_least_squares_solver(f, seed):
    """NumPy's, by singular values: whole periods of a noisy signal, ten harmonics."""
    noisy = np.random.default_rng(seed).normal(size=(4000, 2)) + 100 * signal([(f, 1j)])[:, None]
    inside = TIME[-1] - np.floor((TIME[-1] - TIME[0]) * f) / f < TIME
    frequencies = f * np.arange(1, 11)
    amplitudes, residual = fit_sines(TIME[inside], noisy[inside], frequencies)
    phase = 2 * np.pi * np.outer(TIME[inside], frequencies)
    basis = np.hstack([np.ones((inside.sum(), 1)), np.cos(phase), np.sin(phase)])
    expected = np.linalg.lstsq(basis, noisy[inside], rcond=None)[0]
    np.testing.assert_allclose(amplitudes.real, expected[1:11], atol=1e-11)
    np.testing.assert_allclose(-amplitudes.imag, expected[11:], atol=1e-11)
    np.testing.assert_allclose(basis.T @ residual, 0, atol=1e-9)


def test_sines_that_the_time_cannot_tell_apart_share_what_is_there():
    amplitudes, residual = fit_sines(TIME, signal([(20.0, 2.0)])[:, None], [20.0, 20.0, 20.0 + 1e-9])
    assert amplitudes.sum() == pytest.approx(2.0, rel=1e-6)
    assert abs(amplitudes).max() < 3
    assert abs(residual).max() < 1e-6


def test_what_is_left_is_what_was_not_asked_for():
    _, residual = fit_sines(TIME, signal([(20.0, 3.0), (30.0, 0.1j)], mean=1.0)[:, None], [20.0])
    np.testing.assert_allclose(residual[:, 0], signal([(30.0, 0.1j)]), atol=1e-12)


@given(st.floats(6.0, 90.0), st.floats(0, 6.28))
def test_a_line_between_the_bins_is_found(f, phase):
    [(found, amplitude)] = strongest_lines(TIME, signal([(f, 0.3 * np.exp(1j * phase))], mean=2.0), (1.0, 100.0))
    assert found == pytest.approx(f, abs=2e-3)
    assert amplitude == pytest.approx(0.3, rel=5e-3)


def test_the_strongest_in_the_band_is_found_beside_a_stronger_one_outside():
    values = signal([(20.0, 0.01), (31.0, 0.02j), (80.0, 1.0)])
    (found, amplitude), (lower, _) = strongest_lines(TIME, values, (5.0, 60.0), (5.0, 26.0))
    assert found == pytest.approx(31.0, abs=0.01)
    assert amplitude == pytest.approx(0.02, rel=0.01)
    assert lower == pytest.approx(20.0, abs=0.02)


@pytest.mark.parametrize("band", [(20.9, 60.0), (5.0, 19.1)])
def test_the_skirt_of_a_line_outside_the_band_is_found_at_its_end(band):
    [(found, _)] = strongest_lines(TIME, signal([(20.0, 1.0)]), band)
    assert band[0] <= found <= band[1] and found == pytest.approx(20.0, abs=0.95)


def test_a_band_without_frequencies_holds_no_line():
    assert strongest_lines(TIME, signal([(20.0, 1.0)]), (5.0, 5.0)) == [(5.0, 0.0)]
