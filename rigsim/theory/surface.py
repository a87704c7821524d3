"""The single-term response over frequency and force: one folded sheet, with its fold lines.

In the terms of `rigsim.theory.cubic`, a frequency and a relative amplitude U belong to the force at which
(3/4) gamma X^2/e = U [(U + r)^2 + s^2]; so every column of the sheet runs over U, and nothing is solved but its ends.
"""

from dataclasses import dataclass

import numpy as np

from .. import checks
from ..parameters import oscillator_of
from ..results import Result
from .amplitude import FrequencyResponse, frequency_response
from .cubic import complex_amplitudes, dynamic_stiffness, fold_levels, solve


@dataclass(frozen=True, eq=False, repr=False)
class ResponseSurface(Result):
    """Amplitude over frequency and force; what `ForceScenario.surface` returns.

    Attributes
    ----------
    forces, band : (float, float)
        What it covers (N, Hz).
    quantity : str
        "relative", "mass" or "shaker".
    frequency : (n,) array
        Of its columns (Hz).
    layers : tuple of three (force, amplitude), (n, k) arrays each
        Low, middle and high solutions (N, mm); NaN where a column has no such layer within the forces.
    lines : tuple of two (force, amplitude), (n,) arrays each
        The fold lines: where low and middle solutions meet (gamma_+), where middle and high ones do (gamma_-).
    response : FrequencyResponse
        Its section at one force.
    """

    forces: tuple
    band: tuple
    quantity: str
    frequency: np.ndarray
    layers: tuple
    lines: tuple
    response: FrequencyResponse


def response_surface(
    parameters, forces=(0.3, 7.0), band=(12.0, 65.0), *, force=3.18, quantity="relative", resolution=120
):
    """The response over frequency and force.

    Parameters
    ----------
    parameters : RigParameters or OscillatorParameters
    forces : (float, float)
        Least and largest force amplitude (N, above zero).
    band : (float, float)
        Least and largest forcing frequency (Hz, above zero).
    force : float
        Force (N, within ``forces``) whose response lies on the sheet.
    quantity : {"relative", "mass", "shaker"}
        Whose amplitude is the height.
    resolution : int
        Columns of the sheet, and points of each layer in a column (8 to 2000).

    Returns
    -------
    ResponseSurface

    Raises
    ------
    ValueError
        If an input is not allowed, or the spring has no cubic part.
    """
    oscillator = oscillator_of(parameters)
    forces, band = checks.pair("forces", forces, "N"), checks.pair("band", band, "Hz")
    force = checks.real("force", force, "N", low=forces[0], high=forces[1])
    quantity = checks.one_of("quantity", quantity, ("relative", "mass", "shaker"))
    resolution = checks.integer("resolution", resolution, low=8, high=2000)
    for name, unit in (("k3", "N/m^3"), ("cs", "N s/m")):
        if getattr(oscillator, name) == 0:
            raise ValueError(f"{name} = 0 {unit} is not allowed here; expected one above 0 {unit}")
    frequency = np.linspace(*band, resolution)
    layers, lines = _sheet(oscillator, frequency, forces, quantity, resolution)
    response = frequency_response(oscillator, force, np.linspace(*band, 4 * resolution))
    return ResponseSurface(forces, band, quantity, frequency, layers, lines, response)


def _sheet(oscillator, frequency, forces, quantity, points):
    """Layers, low, middle and high, as (force, amplitude in mm), (n, points) each; lines gamma_+ and gamma_-, (n,).

    Where a column has no folds its inflection parts the low layer from the high one, and the middle one is empty.
    """
    group = oscillator.nondimensional(forces[0])
    Omega = 2 * np.pi * frequency / oscillator.omega_s
    X = Omega**2
    numbers = group.mu, group.zeta_s, group.zeta, group.Omega0
    r, s, e = np.array([dynamic_stiffness(*numbers, x) for x in X]).T
    folded = r < -np.sqrt(3) * s
    deepest = np.minimum(r, -np.sqrt(3) * s)  # where there are levels at all
    U_minus, U_plus = np.array([fold_levels(*pair)[2:] for pair in zip(deepest, s, strict=True)]).T
    U_minus[~folded] = U_plus[~folded] = np.maximum(-2 * r[~folded] / 3, 0)

    def on_sheet(U):
        """Force and amplitude of the solutions U (n, k)."""
        gamma = 4 / 3 * (e / X**2)[:, None] * U * ((U + r[:, None]) ** 2 + s[:, None] ** 2)
        force = oscillator.ks * np.sqrt(gamma * group.mu * oscillator.ks / oscillator.k3)
        amplitudes = complex_amplitudes(group, Omega[:, None], U)
        return force, 1e3 * force / oscillator.ks * abs(amplitudes[("shaker", "mass", "relative").index(quantity)])

    ends = []  # of the three layers, at the least force and at the largest
    for force in forces:
        U, count = solve(*numbers, oscillator.nondimensional(force).gamma, Omega)
        only = np.where(U[:, 0] < U_plus, U_minus, U_plus)
        middle = np.where(count == 3, U[:, 1], only)
        ends.append((np.minimum(U[:, 0], U_plus), middle, np.maximum(np.nanmax(U, axis=1), U_minus)))
    layers = []
    for first, last in zip(*ends, strict=True):
        U = np.linspace(first, last, points, axis=1)
        U[first == last] = np.nan  # wholly outside the forces
        layers.append(on_sheet(U))
    lines = (on_sheet(np.where(folded, U, np.nan)[:, None]) for U in (U_plus, U_minus))
    return tuple(layers), tuple((force[:, 0], amplitude[:, 0]) for force, amplitude in lines)
