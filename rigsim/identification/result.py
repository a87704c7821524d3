"""`Identification`: what `identify` makes of a record."""

from dataclasses import dataclass

import numpy as np
from scipy import stats

from .. import checks
from ..experiment.record import Record
from ..model.modes import Modes
from ..parameters import OscillatorParameters
from ..results import Result, Status
from . import nsi
from .jumps import parameters_from_jumps
from .physical import NAMES
from .receptance import RationalFraction
from .subspace import StateSpace

RESOLUTION = 0.1  # Hz between the frequencies of a result


@dataclass(frozen=True, eq=False)
class ParameterErrors:
    """How far parameters can be trusted.

    Attributes
    ----------
    names : tuple of str
        ms, ks, cs, m, c, k1, k3, then the terms that were asked for.
    value : ndarray, shape (n,)
        In SI units, of any sign.
    standard_error : ndarray, shape (n,)
        From noise, or from what parts of the record disagree about where that is more than chance.
    half_width : ndarray, shape (n,)
        Of the 95 % interval, with what troubles that are named would move.
    bound : ndarray, shape (n,)
        Cramer-Rao: the smallest standard error that any unbiased reading could have under white noise of this size.
    covariance : ndarray, shape (n, n)
        Of the values, from noise.
    disagreement : ndarray, shape (n,)
        By what factor parts of the record disagree more than noise lets them; 1 where they do not.
    mode_half_width : ndarray, shape (modes, 2)
        Of the 95 % intervals of frequency (Hz) and damping ratio of each mode of the parameters.
    """

    names: tuple
    value: np.ndarray
    standard_error: np.ndarray
    half_width: np.ndarray
    bound: np.ndarray
    covariance: np.ndarray
    disagreement: np.ndarray
    mode_half_width: np.ndarray


@dataclass(frozen=True, eq=False, repr=False)
class Identification(Result):
    """What a random test says about the rig; see `identify`.

    Attributes
    ----------
    singular_values : ndarray, shape (2 block_rows,)
        Of the subspace step, descending (the paper's Fig. 5).
    modes : Modes
        Natural frequencies (Hz), damping ratios (Table 3) and shapes over [xs, x] of the underlying linear system.
    frequency : ndarray, shape (n,)
        Hz, over the band: every 0.1 Hz, or 41 points where that gives fewer.
    extended_receptance : ndarray, shape (n, 2, 2)
        H_E of Eq. (9): columns in m/N and m per m^3.
    receptance : ndarray, shape (n, 2, 2)
        Of the underlying linear system, estimated (m/N); the order is [xs, x].
    fitted_receptance : ndarray, shape (n, 2, 2)
        The rational fraction fitted to it (m/N).
    fraction : RationalFraction
        That fit of H11, H21 and H22.
    nonlinear_coefficient : ndarray, shape (n,)
        k3(omega), complex (N/m^3): the paper's Fig. 3 is its real part.
    k3 : float
        Cubic coefficient (N/m^3) with its sign; for the paper's readings the mean of the coefficient's real part.
    parameters : OscillatorParameters
        The paper's Table 4, with ``k3``: where the reading is "force", of the simulated rig that is likeliest.
    read : OscillatorParameters
        The same from H_E alone, a second and independent way.
    misfit : float
        Rms of what ``read`` leaves of H_E, relative to it, both weighted.
    unexplained : ndarray, shape (2,)
        Rms share of xs and of x over the band that the model of Eq. (8) leaves.
    state_space : StateSpace
        That model; start and offset are those of its first estimate.
    hold, conversion : str
        What the force did between samples, and how H_E was read.
    nominal : OscillatorParameters or None
        What the record says was tested.
    errors : ParameterErrors or None
        How far the parameters can be trusted; None for the paper's readings.
    record : Record
        As it was read in the end, with what could be mended.
    modelled : ndarray, shape (n, 2), or None
        Shaker and mass of the simulated rig with these parameters (m).
    mended, troubles : tuple of Trouble
        What was wrong with the record and was mended, and what is still wrong.
    status : Status
        Identified or doubtful.
    message : str
        What is to be distrusted, and why; empty where nothing is.
    """

    singular_values: np.ndarray
    modes: Modes
    frequency: np.ndarray
    extended_receptance: np.ndarray
    receptance: np.ndarray
    fitted_receptance: np.ndarray
    fraction: RationalFraction
    nonlinear_coefficient: np.ndarray
    k3: float
    parameters: OscillatorParameters
    read: OscillatorParameters
    misfit: float
    unexplained: np.ndarray
    state_space: StateSpace
    hold: str
    conversion: str
    nominal: OscillatorParameters | None
    errors: ParameterErrors | None
    record: Record
    modelled: np.ndarray | None
    mended: tuple
    troubles: tuple
    status: Status
    message: str

    plots = {
        "identification": "identification_figure",
        "nonlinear coefficient": "nonlinear_coefficient_figure",
        "receptances": "receptance_figure",
        "singular values": "singular_value_figure",
        "readings": "readings_figure",
        "parameters": "parameter_figure",
        "residuals": "residual_figure",
        "prediction": "prediction_figure",
        "detached curves": "detached_probability_figure",
    }

    def nonlinear_mean(self, band):
        """Mean of the real part of k3(omega) over ``band`` (a pair in Hz), every 0.1 Hz (N/m^3)."""
        frequency = frequencies(band, self.state_space.sample_rate)
        extended = nsi.extended_receptance(self.state_space, frequency, self.hold, self.conversion)
        return float(nsi.nonlinear_coefficient(extended).real.mean())

    def from_jumps(self, jumps, free=("k3",)):
        """`FromJumps`: a second way to the free parameters, from where a stepped test jumped, the others as found here.

        Errors of the others are carried on, and the status is doubtful where both ways differ by more than they may.

        Parameters
        ----------
        jumps, free
            See `rigsim.identification.jumps.parameters_from_jumps`, for what is raised, too.
        """
        if self.errors is None or len(self.errors.names) > len(NAMES):
            told = (
                "the paper's readings have no errors"
                if self.errors is None
                else "closed forms have a cubic spring only"
            )
            raise ValueError(f'{told}; expected an identification by the reading "force" without further terms')
        sure = self.errors
        grown = sure.half_width / np.sqrt(np.maximum(np.diag(sure.covariance), 1e-300)) / stats.norm.ppf(0.975)
        return parameters_from_jumps(jumps, self.parameters, free, sure.covariance * np.outer(grown, grown))

    def summary(self):
        """One line: the modes, k3, and what speaks against them."""
        pairs = zip(self.modes.frequency, self.modes.damping, strict=True)
        modes = ", ".join(f"{frequency:.4f} Hz ({damping:.4f})" for frequency, damping in pairs)
        told = f"{self.status}: {self.message}" if self.message else self.status
        sure = "" if self.errors is None else f" +- {self.errors.half_width[self.errors.names.index('k3')]:.2g}"
        return f'Identification ("{self.conversion}"): modes {modes}; k3 = {self.k3:.5g}{sure} N/m^3; {told}'

    def table(self):
        """`pandas.DataFrame` of the parameters: 95 % half-widths, Cramer-Rao bounds, nominal values and errors [%]."""
        table = self.parameters.table()
        if self.errors is not None:
            known = [self.errors.names.index(name) for name in table.index]
            table.insert(1, "+- (95 %)", self.errors.half_width[known])
            table.insert(2, "standard error", self.errors.standard_error[known])
            table.insert(3, "least possible", self.errors.bound[known])
        if self.nominal is not None:
            table.insert(1, "nominal", self.nominal.table()["value"])
            table.insert(2, "error [%]", 100 * (table["value"] / table["nominal"] - 1))
        return table


def frequencies(band, sample_rate):
    """Every 0.1 Hz over the band, both ends included."""
    low, high = checks.pair("band", band, "Hz", high=sample_rate / 2)
    return np.linspace(low, high, max(int(round((high - low) / RESOLUTION)), 40) + 1)
