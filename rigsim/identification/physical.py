"""Physical parameters from the extended receptance: a start from the fraction polynomial, then one bounded fit."""

import numpy as np
from scipy.optimize import least_squares

NAMES = ("ms", "ks", "cs", "m", "c", "k1", "k3")


def oscillator_receptance(values, frequency):
    """Receptance of Eqs. (3a, b) without the cubic term (m/N) at each frequency (n,) in Hz: complex, shape (n, 2, 2).

    ``values`` are ms, ks, cs, m, c, k1 (and k3, which is not used).
    """
    ms, ks, cs, m, c, k1 = values[:6]
    s = 2j * np.pi * frequency
    coupling = k1 + s * c
    shaker, mass = ks + s * cs + s**2 * ms + coupling, coupling + s**2 * m
    determinant = shaker * mass - coupling**2
    return np.stack([mass, coupling, coupling, shaker], axis=-1).reshape(-1, 2, 2) / determinant[:, None, None]


def mass_receptance(values, frequency):
    """Receptance of one mass on a spring (m/N) at each frequency (n,) in Hz: complex, shape (n, 1, 1).

    ``values`` are m, c, k1 (and k3, which is not used).
    """
    m, c, k1 = values[:3]
    s = 2j * np.pi * frequency
    return (1 / (k1 + s * c + s**2 * m))[:, None, None]


def mass_of_fraction(fraction):
    """m, c, k1 that the polynomials of H11 name, shape (3,), of any sign."""
    above = fraction.numerators[0][0]
    return fraction.denominator[::-1] / above


def parameters_of_fraction(fraction):
    """ms, ks, cs, m, c, k1 that the polynomials of (H11, H21, H22) name, shape (6,), of any sign."""
    (a0, a1, a2), (b0, b1), (e0, e1, e2) = fraction.numerators
    ms, m = 1 / a2, 1 / e2
    k1, c = ms * m * (a0 + b0) / 2, ms * m * (a1 + b1) / 2
    return np.array([ms, ms * m * e0 - k1, ms * m * e1 - c, m, c, k1])


def fit_parameters(model, measured, weight, start, lower):
    """Fit parameters to complex functions of frequency, from a ``start`` (p,) of any sign.

    ``model`` leads from the values to what is ``measured``, and ``weight``, shaped alike, is what a unit of misfit
    counts for. Returns the values, kept from falling below ``lower`` (p,) times the size of the start, and the rms
    misfit over the rms of what is measured, both weighted.
    """
    unit = np.where(start == 0, 1.0, np.abs(start))
    size = np.linalg.norm(weight * measured)

    def misfit(scaled):
        difference = (weight * (model(scaled * unit) - measured)).ravel() / size
        return np.concatenate([difference.real, difference.imag])

    # A start of the wrong sign still tells the size.
    guess = np.where(lower > -np.inf, 1.0, np.sign(start))
    options = {"bounds": (lower, np.inf), "x_scale": "jac", "jac": "3-point", "max_nfev": 200}
    found = least_squares(misfit, guess, **options, xtol=1e-14, ftol=1e-14, gtol=1e-14)
    return found.x * unit, float(np.sqrt(2 * found.cost))
