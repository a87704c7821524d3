"""The bounded fit: from any start of the right size, and against its bounds."""

import numpy as np
import pytest

from rigsim.identification import nsi, physical
from rigsim.identification.layout import TWO_MASSES
from rigsim.parameters import RigParameters
from tests.identification.cubic import true_receptance

FREQUENCY = np.linspace(2, 80, 200)
P = RigParameters().oscillator
TRUE = np.array([getattr(P, name) for name in physical.NAMES])


def extended_of(values):
    return nsi.extended_from(physical.oscillator_receptance(values, FREQUENCY), values[6])


def test_receptance_is_the_inverse_of_the_dynamic_stiffness():
    np.testing.assert_allclose(
        physical.oscillator_receptance(TRUE, FREQUENCY), true_receptance(P, FREQUENCY), rtol=1e-10
    )


@pytest.mark.parametrize("factors", [np.ones(7), [1.3, 0.8, 1.5, 0.7, 2.0, 1.2, -1.0], [1, 1, -1, 1, -1, 1, 2]])
def test_the_fit_finds_all_seven_from_starts_of_any_sign(factors):
    measured = extended_of(TRUE)
    values, misfit = physical.fit_parameters(
        extended_of, measured, 1 / np.abs(measured), TRUE * factors, TWO_MASSES.least
    )
    np.testing.assert_allclose(values, TRUE, rtol=1e-7)
    assert misfit < 1e-8


def test_a_softening_coefficient_keeps_its_sign_and_damping_stays_above_zero():
    softening = TRUE * [1, 1, 1, 1, -0.1, 1, -1]
    measured = extended_of(softening)
    values, misfit = physical.fit_parameters(extended_of, measured, 1 / np.abs(measured), TRUE, TWO_MASSES.least)
    assert values[6] < 0 and 0 <= values[4] < 1e-3 * TRUE[4]
    assert misfit > 1e-3
