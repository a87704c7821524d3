"""H_E and the receptance are each other's inverse."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rigsim.identification import nsi
from rigsim.parameters import RigParameters
from tests.identification.cubic import true_receptance

FREQUENCY = np.linspace(2, 80, 40)


@given(st.floats(1e-3, 1e12), st.booleans())
def test_coefficient_and_receptance_come_back(size, softening):
    k3 = -size if softening else size
    receptance = true_receptance(RigParameters().oscillator, FREQUENCY)
    extended = nsi.extended_from(receptance, k3)
    # Eq. (9): the second column is the receptance times [1, -1], times k3.
    np.testing.assert_allclose(extended[..., 1], k3 * (receptance @ [1, -1]), rtol=1e-9)
    np.testing.assert_allclose(nsi.nonlinear_coefficient(extended), k3, rtol=1e-9)
    np.testing.assert_allclose(nsi.underlying_receptance(extended), receptance, rtol=1e-7)


def test_inputs_are_force_and_minus_the_cube():
    inputs = nsi.extended_inputs(np.array([1.0, 2.0]), np.array([-2.0, 3.0]))
    np.testing.assert_array_equal(inputs, [[1.0, 8.0], [2.0, -27.0]])


def test_what_a_cube_folds_back_is_measured():
    t = np.arange(20000) / 1000
    slow, fast = np.cos(2 * np.pi * 20 * t), np.cos(2 * np.pi * 320 * t)
    # (a + b)^3 has 9/4 at 20 Hz, 1/4 at 60 Hz, and 1/4 at 960 Hz, which is sampled as 40 Hz.
    assert np.isclose(nsi.folded_share(slow + fast, 1000, (2, 80)), 0.25 / np.hypot(2.25, 0.25), rtol=1e-3)
    assert nsi.folded_share(slow, 1000, (2, 80)) < 1e-6
