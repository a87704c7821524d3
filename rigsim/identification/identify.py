"""`identify`: from a record to the underlying linear system, the cubic coefficient and the physical parameters."""

from dataclasses import dataclass, replace

import numpy as np
from scipy import signal

from .. import checks
from ..blas import one_blas_thread
from ..campaign.cost import affordable
from ..campaign.progress import reporting
from ..experiment.record import UNITS, Record
from ..model.modes import Modes, largest_to_one
from ..parameters import OscillatorParameters
from . import nsi, physical
from .alignment import brought_together
from .channels import channel_troubles
from .receptance import fit_rational_fraction
from .refine import fit_to_lines, refine_state_space
from .result import RESOLUTION, Identification, frequencies
from .subspace import dynamics, extended_gram, fit_input_matrices
from .terms import Term
from .trust import trusted
from .verdict import judged

_MATRICES, _LINE, _SAMPLE = 8, 6e4, 1e3  # of all block rows, in memory at once; bytes a frequency and a sample
_STEPS = 8  # of work
_APART = 0.05  # of an output left: the channels may not belong together as they are told
_BETTER = 1.5  # times less left once they are brought together


@one_blas_thread
def identify(record, order=4, block_rows=40, band=(2, 80), conversion="force", *, terms=(), noise=None, progress=False):
    """`Identification` of the rig from a random test.

    1. Extended inputs u = [f, -z^3], outputs [xs, x]; z = xs - x about the zero of the springs,
       which a model with z^2 as a third input tells from an offset of the sensors.
    2. Subspace identification of Eq. (8), refined over the band; then once more with the z
       that this model gives, without the measurement's noise, kept where it leaves less unexplained.
    3. H_E, Eq. (9), and from it k3(omega), H11, H21 and H22.
    4. A rational fraction polynomial fitted to the receptances.
    5. The physical parameters from its coefficients, refined by a bounded fit to all of
       H_E, weighted by the spectra of the inputs over the variances of the outputs' residuals.
    6. Where the reading is "force", from these the rig whose simulated motion repeats the record best
       (`likelihood`), its errors (`uncertainty`) and what the rest says against it (`troubles`). Before all
       else the channels are brought together (`alignment`); what was mended is told.

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
    terms : sequence of Term
        What else may act between the masses, or a mass and the ground; see `rigsim.identification.terms`.
    noise : dict of str to float, optional
        ``{"force": 0.01}``: known noise on the recorded force, as a share of its rms, whose bias is taken out.
    progress : bool or callable
        True shows a bar; a callable is told (steps done, steps in all).

    Raises
    ------
    ValueError
        If the record is no `Record`, has too few samples for the block rows or a channel that does not
        vary, if the order is odd or too large, the band empty or beyond half the sample
        rate, or the conversion unknown.
    """
    order, block_rows, band = checked_record(record, order, block_rows, band)
    progress = checks.progress(progress)
    conversion = checks.one_of("conversion", conversion, nsi.CONVERSIONS)
    terms, noise = _checked_terms(terms), _checked_noise(noise)
    reading = {"order": order, "block_rows": block_rows, "band": band, "conversion": conversion, "terms": terms}
    with reporting(progress, _STEPS, "identification") as report:
        found = _read(record, report, **reading)
        mended = []
        if conversion == "force" and found.trust.left.max() > _APART:
            found, mended = _brought_together(found, record, report, reading)
        trust = found.trust
        if conversion == "force" and trust.fit and trust.mended and not trust.fit.settled:
            taken = [*mended, *trust.mended]
            other = _read(trust.record, report, taken=taken, **reading)  # it went astray before the mend
            if other.trust.left.max() < trust.left.max():
                found, mended = other, taken
        report(_STEPS)
    told = channel_troubles(record, band, order)
    return found.told(record, told, mended, noise)


def checked_record(record, order, block_rows, band):
    """Order, block rows and band, checked against a record that must be of force and two displacements that vary."""
    if not isinstance(record, Record):
        raise ValueError(f"record is a {type(record).__name__}; expected a Record")
    if record.mass is None or set(record.kinds.values()) != {"displacement"}:
        given = ", ".join(f"{name}: {kind}" for name, kind in record.kinds.items())
        raise ValueError(f"outputs of the record = {given}; expected displacements of shaker and mass")
    order, block_rows = _checked_orders(order, block_rows, record)
    band = checks.pair("band", band, "Hz", high=record.sample_rate / 2)
    _refuse_endless(record, block_rows, band)
    frequency = frequencies(band, record.sample_rate)
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
    return order, block_rows, band


def _brought_together(found, record, report, reading):
    """What is read once the channels are brought together, where that leaves less, and what was wrong with them."""
    mended, least = [], found.trust.left.max() / _BETTER
    asked = reading["band"], reading["terms"]
    for together, troubles, guess in brought_together(record, reading["band"]):
        if not all(trouble.mend for trouble in troubles):
            mended = troubles
        elif troubles or guess is not None:
            if troubles:
                other = _read(together, report, guess=guess, taken=troubles, **reading)
            else:  # the same record, from another start
                other = replace(found, trust=trusted(record, _starts(found.values, guess), *asked))
            if other.trust.left.max() < least:
                found, mended, least = other, troubles, other.trust.left.max()
    if found.trust.fit is None and all(trouble.mend for trouble in mended):
        found = replace(found, trust=trusted(record, [found.values], *asked, sensitive=True))
    return found, mended


def _starts(values, guess):
    """Values to start from: those of H_E, and others of the linear rig with either cubic coefficient."""
    return [values] if guess is None else [values, np.append(guess, 0.0), np.append(guess, values[6])]


def _paper_s_fit(frequency, extended):
    """The paper's steps: one number for the coefficient, its mean; the linear parameters from H11, H21 and H22."""
    distinct = nsi.underlying_receptance(extended)[:, [0, 1, 1], [0, 0, 1]]
    fraction = fit_rational_fraction(frequency, distinct, 1 / np.abs(distinct), (2, 1, 2), 4)
    model_of = lambda values: physical.oscillator_receptance(values, frequency)[:, [0, 1, 1], [0, 0, 1]]  # noqa: E731
    start = physical.parameters_of_fraction(fraction)
    values, misfit = physical.fit_parameters(model_of, distinct, 1 / np.abs(distinct), start)
    return fraction, np.append(values, nsi.nonlinear_coefficient(extended).real.mean()), misfit


@dataclass(frozen=True, eq=False)
class _Read:
    """What the steps of `identify` made of a record."""

    conversion: str
    singular_values: np.ndarray
    model: object
    unexplained: np.ndarray
    frequency: np.ndarray
    extended: np.ndarray
    fraction: object
    values: np.ndarray
    misfit: float
    trust: object

    def told(self, record, channels, mended, noise):
        """As an `Identification`."""
        h11, h21, h22 = self.fraction(self.frequency).T
        fitted = np.stack([h11, h21, h21, h22], axis=1).reshape(-1, 2, 2)
        used, band = record if self.trust is None else self.trust.record, (self.frequency[0], self.frequency[-1])
        folded = nsi.folded_share(used.relative, used.sample_rate, band)
        try:
            read = OscillatorParameters(*np.maximum(self.values, 0.0))
        except ValueError as error:
            told = "; ".join(trouble.message for trouble in (*channels, *mended))
            raise ValueError(f"no rig is to be read from this record: {told or error}") from None
        nominal = None if record.parameters is None else record.parameters.oscillator
        return Identification(
            singular_values=self.singular_values, modes=_modes(self.model), frequency=self.frequency,
            extended_receptance=self.extended, receptance=nsi.underlying_receptance(self.extended),
            fitted_receptance=fitted, fraction=self.fraction,
            nonlinear_coefficient=nsi.nonlinear_coefficient(self.extended), misfit=self.misfit,
            unexplained=self.unexplained, state_space=self.model, hold=used.hold, conversion=self.conversion,
            nominal=nominal, read=read,
            **judged(
                used, band, _modes(self.model), self.values, self.misfit, folded, self.trust, mended, channels, noise
            ),
        )  # fmt: skip


def _read(record, report, order, block_rows, band, conversion, terms, guess=None, taken=()):
    """Steps 1 to 6 of `identify`; ``guess`` are ms, ks, cs, m, c, k1 from elsewhere."""
    frequency = frequencies(band, record.sample_rate)
    singular_values, inputs, model, noise, unexplained = _model(record, order, block_rows, band, report)
    extended = nsi.extended_receptance(model, frequency, record.hold, conversion)
    trust = None
    if conversion == "force":
        weight = _weights(inputs, noise, record.sample_rate, frequency)
        fraction, values, misfit = _fit(frequency, extended, weight)
        report(6)
        trust = trusted(record, _starts(values, guess), band, terms, taken=taken)
    else:
        fraction, values, misfit = _paper_s_fit(frequency, extended)
    return _Read(conversion, singular_values, model, unexplained, frequency, extended, fraction, values, misfit, trust)


def _refuse_endless(record, block_rows, band):
    """Refuse what cannot be afforded: matrices of all block rows of five channels, and what is read at frequencies."""
    rows, samples, lines = 2.0 * block_rows * 5, record.force.size, (band[1] - band[0]) / RESOLUTION
    affordable(
        f"block_rows = {block_rows}", instead="fewer block rows", memory=8 * _MATRICES * rows**2,
        seconds=4e-10 * samples * rows * 5 + 5e-10 * rows**3,
    )  # fmt: skip
    affordable(
        f"band = {band[0]:g} to {band[1]:g} Hz with a record of {samples} samples", instead="a narrower band",
        memory=_LINE * lines + _SAMPLE * samples, seconds=2e-3 * lines + 2e-5 * samples,
    )  # fmt: skip


def _checked_terms(terms):
    terms = () if isinstance(terms, (tuple, list)) and not terms else checks.one_or_many("terms", terms, Term, "a Term")
    names = [*physical.NAMES, *(term.name for term in terms)]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(
                f"terms name {name} twice; expected names of their own, none of {', '.join(physical.NAMES)}"
            )
    return tuple(terms)


def _checked_noise(noise):
    """Share of the recorded force that is noise, or None."""
    if noise is None:
        return None
    noise = checks.instance("noise", noise, dict, "a dict such as {'force': 0.01}")
    shares = {checks.one_of("noise of", name, ("force",)): share for name, share in noise.items()}
    return checks.real("noise of force", shares.get("force", 0.0), low=0.0, high=1.0)


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


def _model(record, order, block_rows, band, report):
    """Singular values and inputs, then what `refine_state_space` returns.

    The z that a first model gives is without the measurement's noise, which its cube is biased by. But where
    the nonlinear force is strong that model's error grows in it, so the z that leaves less unexplained is cubed.
    """
    inputs, outputs, gram, scale = about_springs_zero(record, order, block_rows, band)
    report(2)
    A, C, singular_values = dynamics(gram, scale, 2, order)
    report(3)
    measured = _refined(fit_to_lines(A, C, inputs, outputs, record.sample_rate, band), inputs, outputs, band)
    report(4)
    model = fit_input_matrices(measured[0].A, measured[0].C, inputs, outputs, record.sample_rate)
    shaker, mass = (model.simulate(inputs) - model.offset).T
    modelled_inputs = nsi.extended_inputs(record.force, shaker - mass)
    modelled = _refined(model, modelled_inputs, outputs, band)
    if np.linalg.norm(modelled[2] / measured[2]) < np.sqrt(2):
        return singular_values, modelled_inputs, *modelled
    return singular_values, inputs, replace(measured[0], start=model.start, offset=model.offset), *measured[1:]


def about_springs_zero(record, order, block_rows, band):
    """Inputs [f, -z^3] with z about the springs' zero, outputs, the Gram matrix of both, and what they were divided by.

    Shapes (n, 2), (n, 2), (8 block_rows, 8 block_rows) and (4,); ``order`` is that of the model that tells the zero.
    """
    outputs = np.column_stack([record.shaker, record.mass])
    mean = record.relative.mean()
    w = record.relative - mean
    # About the mean -z^3 is a sum of these columns and constants, so one Gram matrix serves any zero of the springs.
    channels = np.column_stack([nsi.extended_inputs(record.force, w), w**2, outputs])
    deviation = channels.std(axis=0)
    gram = extended_gram((channels - channels.mean(axis=0)) / deviation, 2 * block_rows)
    e = _springs_zero(record, channels, gram, deviation, order, block_rows, band)
    inputs = nsi.extended_inputs(record.force, w - e)
    mixed = np.eye(5)[[0, 1, 3, 4]]
    mixed[1] = [0, 1, 3 * e, -3 * e**2, 3 * e**2]
    scale = np.concatenate([inputs.std(axis=0), deviation[3:]])
    mixed *= deviation / scale[:, None]
    gram = (mixed @ (gram.reshape(-1, 5, len(gram)).transpose(1, 0, 2).reshape(5, -1))).reshape(4, -1, len(gram))
    gram = gram.transpose(1, 0, 2).reshape(-1, 2 * block_rows, 5) @ mixed.T
    return inputs, outputs, gram.reshape(len(gram), -1), scale


def _springs_zero(record, channels, gram, deviation, order, block_rows, band):
    """Reading of z, about its mean, at which the springs' cubic force is zero: an offset of the sensors.

    With w about the mean and z = w - e, -z^3 = -w^3 + 3 e w^2 - 3 e^2 w + e^3. The last two are a stiffness and a
    constant, so [f, -w^3, w^2] are inputs of an exact linear model, whose last column is 3 e times the second.
    ``gram`` is that of the ``channels`` (n, 5), these inputs and the outputs, over their ``deviation``.
    """
    inputs, outputs = channels[:, :3], channels[:, 3:]
    rows = 10 * max(block_rows // 2, order)  # the model is refined below: half the block rows do
    A, C, _ = dynamics(gram[:rows, :rows], deviation, 3, order)
    model = fit_to_lines(A, C, inputs, outputs, record.sample_rate, band)
    model, noise, _ = refine_state_space(model, inputs, outputs, band)
    frequency = frequencies(band, record.sample_rate)
    response = nsi.extended_receptance(model, frequency, record.hold, "none") / noise[:, None]
    cube, square = response[..., 1], response[..., 2]
    offset = np.vdot(cube, square).real / np.vdot(cube, cube).real / 3
    size = np.std(channels[:, 3] - channels[:, 4])
    return np.clip(offset, -size, size)  # without a cubic force any offset would do


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
