"""Frequency response of the two-degree-of-freedom theory: Eqs. (5a, b), every solution at every frequency."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .. import checks
from ..campaign.cost import affordable
from ..parameters import OscillatorParameters, oscillator_of
from ..results import Result, frame
from .cubic import complex_amplitudes, solve
from .floquet import is_stable, orbit_multipliers
from .pieces import connected_pieces

_POINT = 400  # bytes a frequency


@dataclass(frozen=True, eq=False, repr=False)
class FrequencyResponse(Result):
    """Every single-term solution at every frequency; what `frequency_response` returns.

    Amplitudes are complex: u(t) = Re(U exp(i omega t)), zero to peak, phase against the force F cos(omega t).
    Along the second axis solutions ascend in abs(relative); where there is one, the other two are NaN.

    Attributes
    ----------
    parameters : OscillatorParameters
    force : float
        Amplitude F (N).
    frequency : (n,) array
        Hz.
    shaker, mass, relative : (n, 3) complex array
        Displacements xs, x and z = xs - x (m).
    count : (n,) array of int
        Solutions at each frequency, 1 or 3.
    """

    parameters: OscillatorParameters
    force: float
    frequency: np.ndarray
    shaker: np.ndarray
    mass: np.ndarray
    relative: np.ndarray
    count: np.ndarray

    plots = {"response": "frequency_response_figure"}

    @cached_property
    def multipliers(self):
        """(n, 3, 4) complex Floquet multipliers about the single-term orbits, over one forcing period.

        As in the paper, the equations are linearised about the single-term approximation, not about the true
        periodic orbit: Neimark-Sacker bifurcations are misplaced by several Hz (see `rigsim.theory.floquet`).
        """
        return orbit_multipliers(self.parameters, self.force, self.frequency[:, None], self.relative)

    @cached_property
    def stable(self):
        """(n, 3) bool: whether all `multipliers` lie inside the unit circle; False where there is no solution."""
        return is_stable(self.multipliers)

    @cached_property
    def pieces(self):
        """Tuple of `Piece`: the connected curves over the band; `ValueError` if the shaker is undamped."""
        return connected_pieces(self.parameters, self.force, self.frequency)

    def table(self):
        """`pandas.DataFrame` of the `pieces`; None if the shaker is undamped, since they are not known then."""
        if self.parameters.cs == 0:
            return None
        rows = [(p.kind, p.closed, p.frequency.min(), p.frequency.max(), len(p.folds)) for p in self.pieces]
        return frame(rows, ["piece", "closed", "from [Hz]", "to [Hz]", "folds"])

    def summary(self):
        """One line: the band, and at how many frequencies there are several solutions."""
        band = f"{self.frequency.size} frequencies from {self.frequency.min():g} to {self.frequency.max():g} Hz"
        return f"FrequencyResponse: {band} at {self.force:g} N, three solutions at {(self.count > 1).sum()} of them"


def frequency_response(parameters, force, frequency):
    """Every solution of the amplitude-frequency equation (5a) at every frequency, with Eq. (5b) and the phases.

    The cubic (5a) is solved as the Duffing cubic of `rigsim.theory.cubic`: in closed form, then polished.

    Parameters
    ----------
    parameters : RigParameters or OscillatorParameters
        A rig is taken with the cubic law of Eq. (2).
    force : float
        Force amplitude F (N, above zero).
    frequency : (n,) array_like
        Hz, above zero, in any order.

    Returns
    -------
    FrequencyResponse

    Raises
    ------
    ValueError
        If an input is not allowed, or a frequency is an undamped linear resonance, where nothing is steady.
    """
    oscillator = oscillator_of(parameters)
    force = checks.positive("force", force, "N")
    frequency = checks.array("frequency", frequency, "Hz", low=0.0, low_open=True)
    affordable(
        f"frequency of {frequency.size} values", memory=_POINT * frequency.size, seconds=2e-6 * frequency.size,
        instead="fewer frequencies",
    )  # fmt: skip
    frequency = frequency.copy()
    group = oscillator.nondimensional(force)
    Omega = 2 * np.pi * frequency / oscillator.omega_s
    U, count = solve(group.mu, group.zeta_s, group.zeta, group.Omega0, group.gamma, Omega)
    unit = force / oscillator.ks
    shaker, mass, relative = (unit * values for values in complex_amplitudes(group, Omega[:, None], U))
    lost = ~(np.isfinite(relative[:, 0]) & np.isfinite(shaker[:, 0]))
    if lost.any():
        expected = "none at which the undamped linear system resonates"
        raise ValueError(f"frequency = {frequency[lost][0]:g} Hz is not allowed; expected {expected}")
    return FrequencyResponse(oscillator, force, frequency, shaker, mass, relative, count)
