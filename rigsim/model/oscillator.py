"""The two-degree-of-freedom model, Eqs. (3a, b): matrices, equations of motion and linear modes."""

import numpy as np

from ..parameters import oscillator_of
from .modes import modes_of


def matrices(parameters):
    """Mass, damping and stiffness (2, 2) of Eqs. (3a, b) over [xs, x], without the cubic term; kg, N s/m, N/m."""
    p = oscillator_of(parameters)
    between = np.array([[1.0, -1.0], [-1.0, 1.0]])
    shaker = np.array([[1.0, 0.0], [0.0, 0.0]])
    return np.diag([p.ms, p.m]), p.cs * shaker + p.c * between, p.ks * shaker + p.k1 * between


def oscillator_modes(parameters):
    """`Modes` of the underlying linear system, "mass" and "shaker" by what moves most: the paper's Table 3.

    Parameters
    ----------
    parameters : OscillatorParameters or RigParameters

    Raises
    ------
    ValueError
        If a mode is overdamped or has no stiffness.
    """
    return modes_of(*matrices(parameters), names=("shaker", "mass"))
