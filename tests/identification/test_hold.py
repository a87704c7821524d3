"""Inverses of the holds against the continuous system, and the closed forms of what is misread without them."""

import numpy as np
import pytest

from rigsim.identification.hold import continuous_response, sampled_response
from rigsim.parameters import RigParameters
from tests.identification.cubic import first_order, true_receptance

RATE = 2000.0
FREQUENCY = np.linspace(2, 900, 200)
THETA = np.pi * FREQUENCY / RATE


def exponential(matrix):
    """By squaring a Taylor sum: `scipy.linalg.expm` draws from numpy's global random numbers."""
    power, total = np.eye(len(matrix)), np.eye(len(matrix))
    for k in range(1, 20):
        power = power @ matrix / (2**20 * k)
        total = total + power
    for _ in range(20):
        total = total @ total
    return total


def sampled(A, B, hold):
    """Sampled matrices of x' = A x + B f, y = x[0]: from a chain of integrators, not from phi functions."""
    o, dt = len(A), 1 / RATE
    chain = np.zeros((o + 2, o + 2))  # state, f, slope of f per second
    chain[:o, :o], chain[:o, o : o + 1], chain[o, o + 1] = A, B, 1.0
    e = exponential(chain * dt)
    Ad, from_value, from_slope = e[:o, :o], e[:o, o : o + 1], e[:o, o + 1 :]
    C = np.eye(1, o)
    if hold == "zero":
        return Ad, from_value, C, np.zeros((1, 1))
    now, following = from_value - from_slope / dt, from_slope / dt  # x[r+1] = Ad x[r] + now f[r] + following f[r+1]
    return Ad, now + Ad @ following, C, C @ following


@pytest.mark.parametrize("hold", ["zero", "linear"])
def test_the_inverse_gives_the_continuous_receptance(hold):
    p = RigParameters().oscillator
    A, B, _ = first_order(p)
    found = continuous_response(*sampled(A, B, hold), RATE, FREQUENCY, hold)[:, 0, 0]
    np.testing.assert_allclose(found, true_receptance(p, FREQUENCY)[:, 0, 0], rtol=1e-8)


@pytest.mark.parametrize("hold", ["zero", "linear"])
def test_a_pole_at_rest_has_an_inverse_too(hold):
    A, B = np.diag([0.0, -1e-4, -50.0]), np.ones((3, 1))
    found = continuous_response(*sampled(A, B, hold), RATE, FREQUENCY, hold)[:, 0, 0]
    np.testing.assert_allclose(found, 1 / (2j * np.pi * FREQUENCY), rtol=1e-7)


def test_the_holds_leave_their_closed_forms_in_the_band():
    p = RigParameters().oscillator
    A, B, _ = first_order(p)
    low = FREQUENCY < 100
    true = true_receptance(p, FREQUENCY)[:, 0, 0]
    for hold, gain in (("zero", np.exp(-1j * THETA) * np.sin(THETA) / THETA), ("linear", (np.sin(THETA) / THETA) ** 2)):
        read = sampled_response(*sampled(A, B, hold), RATE, FREQUENCY)[:, 0, 0]
        # What lies beyond half the sample rate folds back, weakly, since a displacement falls off.
        np.testing.assert_allclose(read[low], (gain * true)[low], rtol=1e-3)


def test_a_band_limited_force_is_read_directly():
    A, B, _ = first_order(RigParameters().oscillator)
    matrices = sampled(A, B, "zero")
    direct = sampled_response(*matrices, RATE, FREQUENCY)
    np.testing.assert_array_equal(continuous_response(*matrices, RATE, FREQUENCY, "band-limited"), direct)
