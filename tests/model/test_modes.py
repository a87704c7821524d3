"""Quadratic eigenvalue problems with known answers."""

import numpy as np
import pytest

from rigsim.model.modes import modes_of


def test_uncoupled_oscillators_keep_their_own_frequency_damping_and_name():
    frequency, damping = np.array([30.0, 3.0, 300.0]), np.array([0.01, 0.5, 0.0])
    mass, omega = np.array([2.0, 1e-3, 1e-7]), 2 * np.pi * frequency
    modes = modes_of(np.diag(mass), np.diag(2 * damping * omega * mass), np.diag(mass * omega**2), ["a", "b", "c"])
    assert modes.names == ("b", "a", "c")
    np.testing.assert_allclose(modes.frequency, [3.0, 30.0, 300.0], rtol=1e-12)
    np.testing.assert_allclose(modes.damping, [0.5, 0.01, 0.0], atol=1e-12)
    np.testing.assert_allclose(abs(modes.shape), np.eye(3)[[1, 0, 2]], atol=1e-12)
    assert list(modes.table().index) == ["b", "a", "c"]
    assert "b 3.0000 Hz (50.00%)" in modes.summary()


@pytest.mark.parametrize("speed", [1.0, 1e-3])
def test_shapes_solve_the_coupled_problem(speed):
    """However slow."""
    random = np.random.default_rng(1)
    factors = random.normal(size=(2, 3, 3))
    stiffness, damping = factors[0] @ factors[0].T + np.eye(3), 0.02 * factors[1] @ factors[1].T
    stiffness, damping, mass = speed**2 * stiffness, speed * damping, np.diag([1.0, 0.2, 5.0])
    modes = modes_of(mass, damping, stiffness, "xyz")
    omega = 2 * np.pi * modes.frequency
    values = omega * (-modes.damping + 1j * np.sqrt(1 - modes.damping**2))
    for value, shape in zip(values, modes.shape, strict=True):
        np.testing.assert_allclose((value**2 * mass + value * damping + stiffness) @ shape, 0, atol=1e-12 * speed**2)
        assert abs(shape).max() == pytest.approx(1)


@pytest.mark.parametrize(("damping", "stiffness"), [(0.0, -1.0), (3.0, 1.0), (0.0, 0.0)])
def test_what_does_not_oscillate_is_refused(damping, stiffness):
    with pytest.raises(ValueError, match="1 of 2 modes do not oscillate"):
        modes_of(np.eye(2), np.diag([damping, 0.0]), np.diag([stiffness, 2.0]), "xy")
