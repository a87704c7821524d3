"""`Identification`: what `identify` makes of a record."""

from dataclasses import dataclass

import numpy as np
from scipy import stats

from .. import checks
from ..experiment.record import Record
from ..model.modes import Modes
from ..parameters import MassParameters, OscillatorParameters
from ..results import Result, Status
from . import nsi
from .jumps import parameters_from_jumps
from .layout import layout_of, powers_of
from .likeliest import given
from .order import LEAST_ROWS, model_order
from .physical import NAMES
from .receptance import RationalFraction, frequencies
from .simulate import simulate
from .subspace import StateSpace

_FINER = 4  # times the steps of a fit


@dataclass(frozen=True, eq=False)
class ParameterErrors:
    """How far parameters can be trusted.

    Attributes
    ----------
    names : tuple of str
        ms, ks, cs, m, c, k1, k3, or m, c, k1, k3 of one mass, then the terms that were asked for.
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

    Of two sensors, q is 2; of one it is 1, for one mass on a spring to the ground.

    Attributes
    ----------
    singular_values : ndarray, shape (q block_rows,)
        Of the subspace step, descending (the paper's Fig. 5).
    modes : Modes
        Natural frequencies (Hz), damping ratios (Table 3) and shapes over the outputs of the underlying linear system.
    frequency : ndarray, shape (n,)
        Hz, over the band: every 0.1 Hz, or 41 points where that gives fewer.
    extended_receptance : ndarray, shape (n, q, 2)
        H_E of Eq. (9): columns in m/N and m per m^3.
    receptance : ndarray, shape (n, q, q)
        Of the underlying linear system, estimated (m/N); the order is [xs, x].
    fitted_receptance : ndarray, shape (n, q, q)
        The rational fraction fitted to it (m/N).
    fraction : RationalFraction
        That fit of H11, H21 and H22, or of H11 alone.
    nonlinear_coefficient : ndarray, shape (n,)
        k3(omega), complex (N/m^3): the paper's Fig. 3 is its real part.
    nonlinear_half_width : ndarray, shape (n,)
        Of the 95 % interval of its real part (N/m^3); not a number in the paper's readings.
    k3 : float
        Cubic coefficient (N/m^3) with its sign; for the paper's readings the mean of the coefficient's real part.
    parameters : OscillatorParameters or MassParameters
        The paper's Table 4, with ``k3``: where the reading is "force", of the simulated rig that is likeliest. On a
        base, ms (or the one m) is 1 and the others are relative to it.
    read : OscillatorParameters or MassParameters
        The same from H_E alone, a second and independent way.
    misfit : float
        Rms of what ``read`` leaves of H_E, relative to it, both weighted.
    unexplained : ndarray, shape (q,)
        Rms share of each output over the band that the model of Eq. (8) leaves.
    state_space : StateSpace
        That model; start and offset are those of its first estimate.
    terms : tuple of Term
        What was asked for beside the usual ones; its coefficients are in ``errors``.
    hold, conversion : str
        What the force did between samples, and how H_E was read.
    nominal : OscillatorParameters or None
        What the record says was tested.
    errors : ParameterErrors or None
        How far the parameters can be trusted; None for the paper's readings.
    record : Record
        As it was read in the end, with what could be mended; of a record that was read in pieces the loudest one.
    modelled : ndarray, shape (n, q), or None
        Outputs of the simulated rig with these parameters, in their units.
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
    nonlinear_half_width: np.ndarray
    k3: float
    parameters: OscillatorParameters | MassParameters
    read: OscillatorParameters | MassParameters
    misfit: float
    unexplained: np.ndarray
    state_space: StateSpace
    terms: tuple
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
        extended = nsi.of_displacements(extended, frequency, powers_of(self.record), self.record.base)
        return float(nsi.nonlinear_coefficient(extended).real.mean())

    def predicted(self, record):
        """What the identified rig would have done in another test, from rest: outputs as of ``record``, (n, q).

        Raises
        ------
        ValueError
            If the record has other sensors, another kind of input, or there is no rig to simulate.
        """
        record = checks.instance("record", record, Record, "a Record")
        if self.errors is None:
            raise ValueError("identification.errors is None; expected an identification with a rig to simulate")
        asked, known = ((one.kinds, "base" if one.base else "force") for one in (record, self.record))
        if asked != known:
            told, expected = (f"{kinds} and a {source}" for kinds, source in (asked, known))
            raise ValueError(f"record measures {told}; expected {expected}, as what was identified")
        structure = layout_of(record).structure(record, self.terms)
        values = np.array([self.errors.value[self.errors.names.index(name)] for name in structure.names])
        _, run, reach = given(structure, record, record.joints, self.frequency[[0, -1]])
        return simulate(structure, values, run, None, reach, finer=_FINER)[0]

    def model_order(self):
        """`ModelOrder` of the record, once mended, over the band and with the block rows of the identification."""
        rows = self.singular_values.size // len(self.record.kinds)
        return model_order(self.record, block_rows=max(rows, LEAST_ROWS), band=self.frequency[[0, -1]])

    def from_jumps(self, jumps, free=("k3",)):
        """`FromJumps`: a second way to the free parameters, from where a stepped test jumped, the others as found here.

        Errors of the others are carried on, and the status is doubtful where both ways differ by more than they may.

        Parameters
        ----------
        jumps, free
            See `rigsim.identification.jumps.parameters_from_jumps`, for what is raised, too.
        """
        if self.errors is None or self.errors.names != NAMES or self.record.base:
            told = (
                f'by the reading "{self.conversion}" this record has no parameters with errors'
                if self.errors is None
                else "closed forms have two masses, a force and a cubic spring only"
            )
            raise ValueError(f'{told}; expected one by the reading "force" of such a rig')
        sure = self.errors
        grown = sure.half_width / np.sqrt(np.maximum(np.diag(sure.covariance), 1e-300)) / stats.norm.ppf(0.975)
        return parameters_from_jumps(jumps, self.parameters, free, sure.covariance * np.outer(grown, grown))

    def summary(self):
        """One line: the modes, k3, and what speaks against them."""
        pairs = zip(self.modes.frequency, self.modes.damping, strict=True)
        modes = ", ".join(f"{frequency:.4f} Hz ({damping:.4f})" for frequency, damping in pairs)
        told = f"{self.status}: {self.message}" if self.message else self.status
        sure = "" if self.errors is None else f" +- {self.errors.half_width[self.errors.names.index('k3')]:.2g}"
        unit = "N/m^3 per kg of the first mass" if self.record.base else "N/m^3"
        return f'Identification ("{self.conversion}"): modes {modes}; k3 = {self.k3:.5g}{sure} {unit}; {told}'

    def table(self):
        """`pandas.DataFrame` of the parameters: 95 % half-widths, Cramer-Rao bounds, nominal values and errors [%]."""
        table = self.parameters.table()
        if self.record.base:  # shares of the first mass
            table["unit"] = ["1" if unit == "kg" else f"{unit}/kg" for unit in table["unit"]]
        if self.errors is not None:
            known = [self.errors.names.index(name) for name in table.index]
            table.insert(1, "+- (95 %)", self.errors.half_width[known])
            table.insert(2, "standard error", self.errors.standard_error[known])
            table.insert(3, "least possible", self.errors.bound[known])
        if self.nominal is not None:
            table.insert(1, "nominal", self.nominal.table()["value"])
            table.insert(2, "error [%]", 100 * (table["value"] / table["nominal"] - 1))
        return table
