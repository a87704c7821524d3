"""Every solution of Eq. (5a) at 1501 frequencies, 5 to 80 Hz, at 3.18 N.

Unit: one call of numpy.linalg.eigvals on the 1501 companion matrices of the cubic (5a).
"""

import numpy as np
from run import fastest

from rigsim import RigParameters, detached_curves, force_scenario, frequency_response

FORCE = 3.18


def companions(parameters, force, frequency):
    """Companion matrices (n, 3, 3) of Eq. (5a) in W^2 from the coefficients of Eqs. (6a-g)."""
    group = parameters.nondimensional(force)
    mu, zeta_s, zeta, gamma = group.mu, group.zeta_s, group.zeta, group.gamma
    X = (2 * np.pi * frequency / parameters.oscillator.omega_s) ** 2
    shaker, detuning = 1 - X * (1 + mu), group.Omega0**2 - X
    e = shaker**2 + 4 * zeta_s**2 * X
    g = 1.5 * mu * gamma * shaker
    h = 2 * mu * shaker * detuning - mu**2 * X**2 - 8 * mu * zeta_s * zeta * X
    a = np.full_like(X, 9 * gamma**2 / 16)
    b = 1.5 * gamma * detuning - g * X**2 / e
    c = detuning**2 + 4 * zeta**2 * X - h * X**2 / e
    matrices = np.zeros((X.size, 3, 3))
    matrices[:, 0] = -np.stack([b, c, -(X**2) / e], axis=1) / a[:, None]
    matrices[:, 1, 0] = matrices[:, 2, 1] = 1
    return matrices


def measure():
    """Rows (name, value, unit, ratio)."""
    rig, frequency = RigParameters(), np.linspace(5, 80, 1501)
    matrices = companions(rig, FORCE, frequency)
    roots = np.sqrt(np.linalg.eigvals(matrices).astype(complex)) * FORCE / rig.ks
    theory = frequency_response(rig, FORCE, frequency)
    largest = np.where(np.abs(roots.imag) < 1e-9 * np.abs(roots), roots.real, 0).max(axis=1)
    np.testing.assert_allclose(np.nanmax(np.abs(theory.relative), axis=1), largest, rtol=1e-6)  # the same task

    unit = fastest(lambda: np.linalg.eigvals(matrices))
    timed = {
        "unit: eigvals of companion matrices": unit,
        "frequency_response, every solution": fastest(lambda: frequency_response(rig, FORCE, frequency)),
        "frequency_response, with Floquet multipliers": fastest(
            lambda: frequency_response(rig, FORCE, frequency).stable
        ),
        "detached_curves": fastest(lambda: detached_curves(rig, FORCE)),
        "force_scenario": fastest(lambda: force_scenario(rig), 2),
    }
    return [(name, 1e3 * seconds, "ms", seconds / unit) for name, seconds in timed.items()]
