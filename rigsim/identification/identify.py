"""`identify`: from a record to the underlying linear system, the cubic coefficient and the physical parameters."""

from dataclasses import dataclass

import numpy as np
from scipy import signal

from .. import checks
from ..blas import one_blas_thread
from ..campaign.cost import affordable
from ..campaign.progress import reporting
from ..experiment.record import HOLDS, UNITS, Record
from ..model.modes import Modes, largest_to_one
from ..model.oscillator import oscillator_modes
from ..parameters import OscillatorParameters
from ..results import Result, Status
from . import nsi, physical
from .receptance import RationalFraction, fit_rational_fraction
from .refine import refine_state_space
from .subspace import StateSpace, fit_input_matrices, identify_state_space

_MATRICES, _LINE, _SAMPLE = 6, 6e3, 2e3  # of all block rows, in memory at once; bytes a frequency and a sample
_STEPS = 5  # of work, the first of them twice as long as the others
RESOLUTION = 0.1  # Hz between the frequencies of a result
# Limits of what is believed: a clean record of the right hold leaves a misfit of 1e-9 to 1e-4 ...
MISFIT = 1e-3
UNEXPLAINED = 0.02  # of an output: 1 % of noise leaves 0.3 %, but 4 % where a strong motion's cube carries it into c
NOISE_MISFIT = 0.3  # ... and noise that leaves a share of an output leaves about a thirtieth of it of H_E
MODE_SHIFT = 0.005  # relative
FOLDED = 0.02


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
        Cubic coefficient (N/m^3): fitted together with the parameters where the reading is
        "force", the mean of the coefficient's real part where it is one of the paper's.
    parameters : OscillatorParameters
        The paper's Table 4, with ``k3``.
    misfit : float
        Rms of what the parameters leave of H_E, relative to it, both weighted.
    unexplained : ndarray, shape (2,)
        Rms share of xs and of x over the band that the model of Eq. (8) leaves.
    state_space : StateSpace
        That model; start and offset are those of its first estimate.
    hold, conversion : str
        What the force did between samples, and how H_E was read.
    nominal : OscillatorParameters or None
        What the record says was tested.
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
    misfit: float
    unexplained: np.ndarray
    state_space: StateSpace
    hold: str
    conversion: str
    nominal: OscillatorParameters | None
    status: Status
    message: str

    plots = {
        "identification": "identification_figure",
        "nonlinear coefficient": "nonlinear_coefficient_figure",
        "receptances": "receptance_figure",
        "singular values": "singular_value_figure",
        "readings": "readings_figure",
    }

    def nonlinear_mean(self, band):
        """Mean of the real part of k3(omega) over ``band`` (a pair in Hz), every 0.1 Hz (N/m^3)."""
        frequency = _frequencies(band, self.state_space.sample_rate)
        extended = nsi.extended_receptance(self.state_space, frequency, self.hold, self.conversion)
        return float(nsi.nonlinear_coefficient(extended).real.mean())

    def summary(self):
        """One line: the modes, k3, and what speaks against them."""
        pairs = zip(self.modes.frequency, self.modes.damping, strict=True)
        modes = ", ".join(f"{frequency:.4f} Hz ({damping:.4f})" for frequency, damping in pairs)
        told = f"{self.status}: {self.message}" if self.message else self.status
        return f'Identification ("{self.conversion}"): modes {modes}; k3 = {self.k3:.5g} N/m^3; {told}'

    def table(self):
        """`pandas.DataFrame` of the parameters, with nominal value and error [%] where known."""
        table = self.parameters.table()
        if self.nominal is not None:
            table.insert(1, "nominal", self.nominal.table()["value"])
            table.insert(2, "error [%]", 100 * (table["value"] / table["nominal"] - 1))
        return table


@one_blas_thread
def identify(record, order=4, block_rows=40, band=(2, 80), conversion="force", *, progress=False):
    """`Identification` of the rig from a random test.

    1. Extended inputs u = [f, -z^3], outputs [xs, x]; z = xs - x about the zero of the springs,
       which a model with z^2 as a third input tells from an offset of the sensors.
    2. Subspace identification of Eq. (8), refined over the band; then once more with the z
       that this model gives, without the measurement's noise, kept where it leaves less unexplained.
    3. H_E, Eq. (9), and from it k3(omega), H11, H21 and H22.
    4. A rational fraction polynomial fitted to the receptances.
    5. The physical parameters from its coefficients, refined by a bounded fit to all of
       H_E, weighted by the spectra of the inputs over the variances of the outputs' residuals.

    Parameters
    ----------
    record : Record
        Force, shaker and mass under a force that excites the whole band.
    order : int
        Order of the model, even: two a mode. The rig has 4.
    block_rows : int
        Block rows of the past and of the future in the subspace step.
    band : pair of float
        Frequencies (Hz) the receptances are read at, every 0.1 Hz, fitted and averaged over.
    conversion : {"force", "all", "none"}
        How H_E is read from a sampled model; see `rigsim.identification.nsi`. "force" is
        right, "all" is the paper's, "none" is Eq. (9) as printed.
    progress : bool or callable
        True shows a bar; a callable is told (steps done, steps in all).

    Raises
    ------
    ValueError
        If the record is no `Record`, has too few samples for the block rows or a channel that does not
        vary, if the order is odd or too large, the band empty or beyond half the sample
        rate, or the conversion unknown.
    """
    if not isinstance(record, Record):
        raise ValueError(f"record is a {type(record).__name__}; expected a Record")
    order, block_rows = _checked_orders(order, block_rows, record)
    progress = checks.progress(progress)
    conversion = checks.one_of("conversion", conversion, nsi.CONVERSIONS)
    band = checks.pair("band", band, "Hz", high=record.sample_rate / 2)
    _refuse_endless(record, block_rows, band)
    frequency = _frequencies(band, record.sample_rate)
    lines, needed = int((frequency[-1] - frequency[0]) * record.duration), order * (order + 6)
    if lines < needed:
        raise ValueError(
            f"band = {frequency[0]:g} to {frequency[-1]:g} Hz has {lines} lines in {record.duration:g} s of record; "
            f"expected at least {needed} for order = {order}"
        )
    for name in ("force", "shaker", "mass", "relative"):
        channel = checks.array(name, getattr(record, name), UNITS.get(name, "m"))
        if not np.ptp(channel) > 1e-12 * np.abs(channel).max():
            raise ValueError(f"{name} = {channel[0]:g} throughout is not allowed; expected a channel that varies")

    with reporting(progress, _STEPS, "identification") as report:
        singular_values, inputs, model, noise, unexplained = _model(record, order, block_rows, band, report)
        report(_STEPS)
    extended = nsi.extended_receptance(model, frequency, record.hold, conversion)
    coefficient = nsi.nonlinear_coefficient(extended)
    receptance = nsi.underlying_receptance(extended)

    distinct = receptance[:, [0, 1, 1], [0, 0, 1]]  # H11, H21, H22
    doubts = []
    if conversion == "force":
        weight = _weights(inputs, noise, record.sample_rate, frequency)
        fraction, values, misfit = _fit(frequency, extended, weight)
        doubts = _reading_doubts(record.hold, model, weight, frequency, values, misfit, unexplained)
    else:
        # The paper's steps: one number for the coefficient, its mean; the linear parameters from H11, H21 and H22.
        fraction = fit_rational_fraction(frequency, distinct, 1 / np.abs(distinct), (2, 1, 2), 4)
        model_of = lambda values: physical.oscillator_receptance(values, frequency)[:, [0, 1, 1], [0, 0, 1]]  # noqa: E731
        start = physical.parameters_of_fraction(fraction)
        values, misfit = physical.fit_parameters(model_of, distinct, 1 / np.abs(distinct), start)
        values = np.append(values, coefficient.real.mean())
        if misfit > 0.05:
            doubts.append(f"the parameters leave {100 * misfit:.2g} % of the receptances unexplained")
    folded = nsi.folded_share(record.relative, record.sample_rate, band)
    if folded > FOLDED:
        share = f"{100 * folded:.2g} % of z^3 in the band"
        doubts.append(f"{share} is folded from above half the sample rate: sample faster")
    doubts = _doubts(values, unexplained, doubts)
    h11, h21, h22 = fraction(frequency).T
    fitted = np.stack([h11, h21, h21, h22], axis=1).reshape(-1, 2, 2)
    nominal = None if record.parameters is None else record.parameters.oscillator
    return Identification(
        singular_values=singular_values, modes=_modes(model), frequency=frequency, extended_receptance=extended,
        receptance=receptance, fitted_receptance=fitted, fraction=fraction, nonlinear_coefficient=coefficient,
        k3=float(values[6]), parameters=OscillatorParameters(*np.maximum(values, 0.0)), misfit=misfit,
        unexplained=unexplained, state_space=model, hold=record.hold, conversion=conversion, nominal=nominal,
        status=Status.DOUBTFUL if doubts else Status.IDENTIFIED, message="; ".join(doubts),
    )  # fmt: skip


def _refuse_endless(record, block_rows, band):
    """Refuse what cannot be afforded: matrices of all block rows of five channels, and what is read at frequencies."""
    rows, samples, lines = 2.0 * block_rows * 5, record.force.size, (band[1] - band[0]) / RESOLUTION
    affordable(
        f"block_rows = {block_rows}", instead="fewer block rows", memory=8 * _MATRICES * rows**2,
        seconds=4e-10 * samples * rows * 5 + 2e-9 * rows**3,
    )  # fmt: skip
    affordable(
        f"band = {band[0]:g} to {band[1]:g} Hz with a record of {samples} samples", instead="a narrower band",
        memory=_LINE * lines + _SAMPLE * samples, seconds=1e-4 * lines + 1e-4 * samples,
    )  # fmt: skip


def _checked_orders(order, block_rows, record):
    block_rows = checks.integer("block_rows", block_rows, low=4)
    order = checks.integer("order", order, low=4, high=block_rows)
    if order % 2:
        raise ValueError(f"order = {order} is not allowed; expected an even number, two a mode")
    # As many Hankel columns as rows of all four channels: fewer, and past and future span everything.
    needed = 2 * block_rows * 4 + 2 * block_rows - 1
    n = record.force.size
    if n < needed:
        raise ValueError(f"record has {n} samples; expected at least {needed} for block_rows = {block_rows}")
    return order, block_rows


def _frequencies(band, sample_rate):
    """Every 0.1 Hz over the band, both ends included."""
    low, high = checks.pair("band", band, "Hz", high=sample_rate / 2)
    return np.linspace(low, high, max(int(round((high - low) / RESOLUTION)), 40) + 1)


def _model(record, order, block_rows, band, report):
    """Singular values and inputs, then what `refine_state_space` returns.

    The z that a first model gives is without the measurement's noise, which its cube is biased by. But where
    the nonlinear force is strong that model's error grows in it, so the z that leaves less unexplained is cubed.
    """
    outputs = np.column_stack([record.shaker, record.mass])
    z = record.relative - _springs_zero(record, outputs, order, block_rows, band)
    report(2)
    inputs = nsi.extended_inputs(record.force, z)
    first, singular_values = identify_state_space(inputs, outputs, record.sample_rate, order, block_rows)
    report(3)
    measured = _refined(first, inputs, outputs, band)
    report(4)
    model = fit_input_matrices(measured[0].A, measured[0].C, inputs, outputs, record.sample_rate)
    shaker, mass = (model.simulate(inputs) - model.offset).T
    modelled_inputs = nsi.extended_inputs(record.force, shaker - mass)
    modelled = _refined(model, modelled_inputs, outputs, band)
    if np.linalg.norm(modelled[2] / measured[2]) < np.sqrt(2):
        return singular_values, modelled_inputs, *modelled
    return singular_values, inputs, *measured


def _springs_zero(record, outputs, order, block_rows, band):
    """Reading of z at which the springs' cubic force is zero: an offset of the sensors, not the mean of the motion.

    With w about the mean and z = w - e, -z^3 = -w^3 + 3 e w^2 - 3 e^2 w + e^3. The last two are a stiffness and a
    constant, so [f, -w^3, w^2] are inputs of an exact linear model, whose last column is 3 e times the second.
    """
    mean = record.relative.mean()
    w = record.relative - mean
    inputs = np.column_stack([nsi.extended_inputs(record.force, w), w**2])
    model, _ = identify_state_space(inputs, outputs, record.sample_rate, order, block_rows)
    model, noise, _ = refine_state_space(model, inputs, outputs, band)
    frequency = _frequencies(band, record.sample_rate)
    response = nsi.extended_receptance(model, frequency, record.hold, "none") / noise[:, None]
    cube, square = response[..., 1], response[..., 2]
    offset = np.vdot(cube, square).real / np.vdot(cube, cube).real / 3
    return mean + np.clip(offset, -w.std(), w.std())  # without a cubic force any offset would do


def _refined(model, inputs, outputs, band):
    """`refine_state_space`, with the noise and the share that the refined model leaves."""
    model, *_ = refine_state_space(model, inputs, outputs, band)
    return refine_state_space(model, inputs, outputs, band)


def _weights(inputs, noise, sample_rate, frequency):
    """What a misfit of H_E does to the outputs, over their noise: sqrt(input spectrum) / residual deviation."""
    segment = min(len(inputs), int(2 * sample_rate))
    lines, spectra = signal.welch(inputs, sample_rate, nperseg=segment, axis=0)
    spectra = np.column_stack([np.interp(frequency, lines, column) for column in spectra.T])
    return np.sqrt(spectra)[:, None, :] / noise[None, :, None]


def _modes(model):
    """Oscillating modes of the model, each with its shape over [xs, x]."""
    values, vectors = np.linalg.eig(model.A)
    poles = np.log(values.astype(complex)) * model.sample_rate
    shapes = (model.C @ vectors).T
    kept = sorted(np.flatnonzero(values.imag > 0), key=lambda i: abs(poles[i]))
    poles, shapes = poles[kept], shapes[kept]
    names = tuple(f"mode {number + 1}" for number in range(len(kept)))
    return Modes(np.abs(poles) / (2 * np.pi), -poles.real / np.abs(poles), largest_to_one(shapes), names)


def _fit(frequency, extended, weight):
    """Fraction of the receptances, the seven parameters, and the rms share of H_E that they leave."""
    share = np.abs(weight[:, 0, 1] * (extended[:, 0, 0] - extended[:, 1, 0])) ** 2
    k3 = nsi.nonlinear_coefficient(extended).real @ share / share.sum()
    fraction_weight = np.column_stack([weight[:, 0, 0], weight[:, 1, 0], abs(k3) * weight[:, 1, 1]])
    distinct = nsi.underlying_receptance(extended)[:, [0, 1, 1], [0, 0, 1]]  # H11, H21, H22
    fraction = fit_rational_fraction(frequency, distinct, fraction_weight, (2, 1, 2), 4)
    model_of = lambda values: nsi.extended_from(physical.oscillator_receptance(values, frequency), values[6])  # noqa: E731
    start = np.append(physical.parameters_of_fraction(fraction), k3)
    return fraction, *physical.fit_parameters(model_of, extended, weight, start)


def _reading_doubts(hold, model, weight, frequency, values, misfit, unexplained):
    """What speaks against the hold or the order of the channels, and the reading that would fit, if one does."""
    doubts = []
    noise = unexplained.max()
    if misfit > MISFIT + NOISE_MISFIT * noise:
        doubts.append(f"the parameters leave {100 * misfit:.2g} % of H_E unexplained")
    seen = _modes(model).frequency
    try:
        meant = oscillator_modes(OscillatorParameters(*np.maximum(values, 0.0))).frequency
    except ValueError:  # a mode without stiffness or overdamped has no frequency to compare
        meant = None
    if meant is not None and seen.size == meant.size and (np.abs(meant / seen - 1) > MODE_SHIFT + noise).any():
        pairs = ", ".join(f"{a:.2f} against {b:.2f} Hz" for a, b in zip(meant, seen, strict=True))
        doubts.append(f"the parameters' modes are not the model's ({pairs})")
    if not doubts:
        return doubts
    readings = {f'hold = "{other}"': (other, False) for other in HOLDS if other != hold}
    readings["shaker and mass swapped"] = (hold, True)
    left = {}
    for name, (other, swapped) in readings.items():
        extended = nsi.extended_receptance(model, frequency, other)
        # z changes its sign with the channels.
        channels = (extended[:, ::-1] * [1, -1], weight[:, ::-1]) if swapped else (extended, weight)
        left[name] = _fit(frequency, *channels)[2]
    best = min(left, key=left.get)
    hint = "check the hold and the order of the channels"
    if left[best] < misfit / 4:
        hint = f"{best} would leave {100 * left[best]:.2g} %"
    return [*doubts, hint]


def _doubts(values, unexplained, doubts):
    """The doubts of the reading, with those that model and fit raise themselves."""
    doubts = [
        f"the model leaves {100 * share:.2g} % of {name} unexplained"
        for name, share in zip(("shaker", "mass"), unexplained, strict=True)
        if share > UNEXPLAINED
    ] + doubts
    if values[6] < 0:
        doubts.append(f"k3 = {values[6]:.3g} N/m^3 is negative, so parameters carry k3 = 0")
    at_bound = [name for name, value in zip(physical.NAMES[:6], values[:6], strict=True) if value <= 0]
    if at_bound:
        doubts.append(f"the fit ends at the bound 0 of {', '.join(at_bound)}")
    return doubts
