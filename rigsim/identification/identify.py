"""`identify`: from a record to the underlying linear system, the cubic coefficient and the physical parameters."""

from dataclasses import dataclass, replace
from itertools import chain

import numpy as np
from scipy import signal

from .. import checks
from ..blas import one_blas_thread
from ..campaign.progress import reporting
from ..experiment.record import Record
from ..model.modes import Modes, largest_to_one
from . import nsi, physical
from .alignment import brought_together
from .asked import checked_noise, checked_record, checked_terms
from .channels import channel_troubles
from .layout import direct, displacing, layout_of, outputs_of, powers_of
from .likeliest import cubic_starts, simulated_motion
from .model import displacements, extended_model
from .order import model_order
from .pieces import combined, piece, pieces, pieces_in
from .receptance import fit_rational_fraction, frequencies
from .refine import response_deviations
from .result import Identification
from .troubles import Trouble
from .trust import trusted
from .verdict import judged, rig_of

_STEPS = 8  # of work
_ROUNDS = 2
_TRIES = 3  # pieces of a long record
_APART = 0.05  # of an output left: the channels may not belong together as they are told
_BETTER = 1.5  # times less left once they are brought together


@one_blas_thread
def identify(
    record, order=None, block_rows=40, band=(2, 80), conversion="force", *, terms=(), noise=None, progress=False
):
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

    A record of one sensor is that of one mass on a spring to the ground: y = [x], z = x. Where outputs are velocities
    or accelerations, lines of the band give a z to start from; then the simulated one takes its place, outputs are used
    as they are, and receptances are divided by powers of i omega. On a base, the first mass is 1.

    A record of a million samples or more is read in pieces (`pieces`): parameters, errors and troubles are those of all
    of it, while receptances and residuals are those of its loudest piece, which ``record`` of the result is then. Such
    a record may be longer than memory: `Record.load` keeps long channels on disk.

    Parameters
    ----------
    record : Record or sequence of Record
        Force and motions under a force that excites the whole band; several tests of one rig are joined.
    order : int or "auto", optional
        Order of the model, even: two a mode. By default that of the rig, 4, or 2 of one mass; "auto" is the one that
        `rigsim.identification.order.model_order` finds.
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
        If the record is no `Record` or no rig is to be read from it, has too few samples for the
        block rows or a channel that does not vary, if the order is odd or too large, the band
        empty or beyond half the sample rate, or the conversion unknown or not for such a record.
    """
    record = Record.joined(checks.one_or_many("record", record, Record, "a Record"))
    auto = isinstance(order, str)
    if auto and order != "auto":
        raise ValueError(f'order = {checks.shown(order)} is not allowed; expected an even whole number or "auto"')
    conversion = checks.one_of("conversion", conversion, nsi.CONVERSIONS)
    at_once = -(-record.force.size // pieces_in(record.force.size)) if conversion == "force" else None
    order, block_rows, band = checked_record(record, None if auto else order, block_rows, band, at_once)
    progress = checks.progress(progress)
    if conversion != "force" and not direct(record):
        raise ValueError(
            f'conversion = "{conversion}" is not allowed; expected "force" where displacements were not measured'
        )
    terms, noise = checked_terms(terms, layout_of(record)), checked_noise(noise)
    reading = {"order": order, "block_rows": block_rows, "band": band, "conversion": conversion, "terms": terms}
    whole, cut = record, [slice(record.force.size)]
    if conversion == "force":
        cut = pieces(record, block_rows, band, order)
    with reporting(progress, _STEPS + 2 * len(cut) - 2, "identification") as report:
        for first in cut[:_TRIES]:
            record = whole if len(cut) == 1 else piece(whole, first)
            choice = model_order(record, None, block_rows, band) if auto else None
            reading |= {"order": choice.chosen} if auto else {}
            found, mended = _mended(_read(record, report, **reading), record, report, reading)
            if conversion != "force" or found.trust.fit:
                break
        others = [samples for samples in cut if samples != first]
        if not direct(record) and found.trust.fit:
            found = _with_simulated_motion(found, report, reading)
        told = channel_troubles(record, band, order)
        if others and found.trust.fit:
            known = chain([(first, [*mended, *told], found.trust)], _others(found, whole, others, report, reading))
            mended, trust = combined(whole, known, band, terms, lambda done: report(_STEPS + len(others) + done))
            found, told = replace(found, trust=trust), []
        report(_STEPS + 2 * len(others))
    told += [Trouble("order", choice.message)] if auto and choice.message else []
    return found.told(record, told, mended, noise)


def _mended(found, record, report, reading):
    """What is read once what one can mend of a record is mended, and what that was before it was read."""
    mended = []
    if reading["conversion"] != "force":
        return found, mended
    if found.trust.left.max() > _APART:
        found, mended = _brought_together(found, record, report, reading)
    trust = found.trust
    if trust.fit and trust.mended and not trust.fit.settled:
        taken = [*mended, *trust.mended]
        other = _read(trust.record, report, taken=taken, **reading)  # it went astray before the mend
        if other.trust.left.max() < trust.left.max():
            found, mended = other, taken
    return found, mended


def _others(found, record, cut, report, reading):
    """Of more pieces of a record, one after the other: slice, what was wrong with it before it was read, and `Trust`.

    Each is read from where the rig that is likeliest for the first is already.
    """
    band, terms, fit = reading["band"], reading["terms"], found.trust.fit
    start = np.array([fit.values[fit.structure.names.index(name)] for name in found.layout.names])
    for done, samples in enumerate(cut):
        report(_STEPS + done)
        one = piece(record, samples)
        again = replace(found, measured=one, trust=trusted(one, [start], band, terms))
        again, mended = _mended(again, one, lambda done: None, reading)
        yield samples, [*mended, *channel_troubles(one, band, reading["order"])], again.trust


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
                other = replace(found, trust=trusted(record, _starts(record, asked[0], found.values, guess), *asked))
            if other.trust.left.max() < least:
                found, mended, least = other, troubles, other.trust.left.max()
    if found.trust.fit is None and all(trouble.mend for trouble in mended):
        found = replace(
            found, trust=trusted(record, _starts(record, asked[0], found.values, None), *asked, sensitive=True)
        )
    return found, mended


def _starts(record, band, values, guess):
    """Values to start from: those of H_E, and others of the linear rig with some cubic coefficients."""
    starts = [values]
    if guess is not None:
        more = () if direct(record) else cubic_starts(record, guess, band)
        starts += [np.append(guess, 0.0), np.append(guess, values[-1]), *more]
    return [start / start[0] for start in starts] if record.base else starts


def _paper_s_fit(layout, frequency, extended):
    """The paper's steps: one number for the coefficient, its mean; the linear parameters from H11, H21 and H22."""
    distinct = layout.distinct(nsi.underlying_receptance(extended))
    fraction = fit_rational_fraction(frequency, distinct, 1 / np.abs(distinct), layout.degrees, layout.order)
    model_of = lambda values: layout.distinct(layout.receptance(values, frequency))  # noqa: E731
    start = layout.of_fraction(fraction)
    values, misfit = physical.fit_parameters(model_of, distinct, 1 / np.abs(distinct), start, layout.least[:-1])
    return fraction, np.append(values, nsi.nonlinear_coefficient(extended).real.mean()), misfit


@dataclass(frozen=True, eq=False)
class _Read:
    """What the steps of `identify` made of a record."""

    layout: object
    conversion: str
    terms: tuple
    relative: np.ndarray
    singular_values: np.ndarray
    model: object
    unexplained: np.ndarray
    frequency: np.ndarray
    extended: np.ndarray
    fraction: object
    values: np.ndarray
    misfit: float
    measured: object
    inputs: np.ndarray
    noise: np.ndarray
    trust: object

    def told(self, record, channels, mended, noise):
        """As an `Identification`."""
        fitted = self.layout.whole(self.fraction(self.frequency))
        used, band = record if self.trust is None else self.trust.record, (self.frequency[0], self.frequency[-1])
        folded = nsi.folded_share(self.relative, used.sample_rate, band)
        read = rig_of(self.layout, self.values, [*channels, *mended])
        known = record.parameters is not None and record.mass is not None and not record.base
        known = known and not getattr(record.parameters, "gap", 0.0)  # of which theory has no oscillator
        nominal = record.parameters.oscillator if known else None
        modes = _modes(self.model, powers_of(used))
        return Identification(
            singular_values=self.singular_values, modes=modes, frequency=self.frequency,
            extended_receptance=self.extended, receptance=nsi.underlying_receptance(self.extended),
            fitted_receptance=fitted, fraction=self.fraction,
            nonlinear_coefficient=nsi.nonlinear_coefficient(self.extended),
            nonlinear_half_width=self._nonlinear_half_width(), misfit=self.misfit,
            unexplained=self.unexplained, state_space=self.model, terms=self.terms, hold=used.hold,
            conversion=self.conversion, nominal=nominal, read=read,
            **judged(
                used, band, modes, self.values, self.misfit, folded, self.trust, mended, channels, noise
            ),
        )  # fmt: skip

    def _nonlinear_half_width(self):
        """Of k3(omega): what noise does to it, and how far its mean is from the likeliest rig's, which is no noise."""
        if self.conversion != "force":
            return np.full(self.frequency.size, np.nan)
        record, band = self.measured, (self.frequency[0], self.frequency[-1])
        lines = self.inputs, outputs_of(record), self.noise, band, record.joints
        spread = response_deviations(self.model, *lines, self.frequency)
        # For an error's sake what noise does to the response as it is sampled will do for the one behind the hold.
        response = nsi.extended_receptance(self.model, self.frequency, record.hold)
        deviation = nsi.coefficient_deviation(response, spread, self.frequency, powers_of(record), record.base)
        fit = self.trust.fit
        apart = 0.0 if fit is None else abs(self.values[-1] - fit.values[fit.structure.names.index("k3")])
        return 1.96 * deviation + apart


def _read(record, report, order, block_rows, band, conversion, terms, guess=None, taken=()):
    """Steps 1 to 6 of `identify`; ``guess`` are the linear parameters from elsewhere."""
    layout, asked, trust = layout_of(record), (order, block_rows, band, conversion), None
    read = _by_subspace(displacements(record, band), report, *asked)
    starts = _starts(record, band, read["values"], guess)
    for _ in range(0 if displacing(record) else _ROUNDS):  # the simulated z is better than one from lines of a band
        relative = simulated_motion(record, starts, band)
        if relative is None:
            break
        read = _by_subspace(record, report, *asked, relative)
        starts = _starts(record, band, read["values"], None) + starts
    report(6)
    if conversion == "force":
        trust = trusted(record, starts, band, terms, taken=taken)
    return _Read(layout, conversion, terms, trust=trust, **read)


def _with_simulated_motion(found, report, reading):
    """The same with the z of the likeliest rig, and outputs as they were measured."""
    relative = found.layout.across(found.trust.fit.displaced()[0])
    asked = (reading[name] for name in ("order", "block_rows", "band", "conversion"))
    return replace(found, **_by_subspace(found.trust.record, report, *asked, relative))


def _by_subspace(record, report, order, block_rows, band, conversion, relative=None):
    """Steps 1 to 5, fields of `_Read`; ``relative`` is z where it was simulated."""
    layout, frequency, powers = layout_of(record), frequencies(band, record.sample_rate), powers_of(record)
    singular_values, inputs, model, noise, unexplained = extended_model(
        record, order, block_rows, band, report, relative
    )
    extended = nsi.extended_receptance(model, frequency, record.hold, conversion)
    extended = nsi.of_displacements(extended, frequency, powers, record.base)
    if conversion == "force":
        # A unit of misfit of a displacement's receptance is one of its output's times powers of omega.
        weight = _weights(inputs, noise, record.sample_rate, frequency)
        weight = weight * (2 * np.pi * frequency[:, None, None]) ** np.array(powers)[:, None]
        fraction, values, misfit = _fit(layout, frequency, extended, weight)
    else:
        fraction, values, misfit = _paper_s_fit(layout, frequency, extended)
    return {
        "relative": layout.across(outputs_of(record)) if relative is None else relative,
        "singular_values": singular_values, "model": model, "unexplained": unexplained, "frequency": frequency,
        "extended": extended, "fraction": fraction, "values": values, "misfit": misfit,
        "measured": record, "inputs": inputs, "noise": noise,
    }  # fmt: skip


def _weights(inputs, noise, sample_rate, frequency):
    """What a misfit of H_E does to the outputs, over their noise: sqrt(input spectrum) / residual deviation."""
    segment = min(len(inputs), int(2 * sample_rate))
    lines, spectra = signal.welch(inputs, sample_rate, nperseg=segment, axis=0)
    spectra = np.column_stack([np.interp(frequency, lines, column) for column in spectra.T])
    return np.sqrt(spectra)[:, None, :] / noise[None, :, None]


def _modes(model, powers):
    """Oscillating modes of the model, each with its shape over displacements [xs, x]; see `powers_of`."""
    values, vectors = np.linalg.eig(model.A)
    poles = np.log(values.astype(complex)) * model.sample_rate
    kept = sorted(np.flatnonzero(values.imag > 0), key=lambda i: abs(poles[i]))
    poles, shapes = poles[kept], (model.C @ vectors).T[kept]
    shapes = shapes / poles[:, None] ** np.array(powers)
    names = tuple(f"mode {number + 1}" for number in range(len(kept)))
    return Modes(np.abs(poles) / (2 * np.pi), -poles.real / np.abs(poles), largest_to_one(shapes), names)


def _fit(layout, frequency, extended, weight):
    """Fraction of the receptances, the parameters, and the rms share of H_E that they leave."""
    share = np.abs(weight[:, 0, 1] * nsi.across(extended[..., 0])) ** 2
    k3 = nsi.nonlinear_coefficient(extended).real @ share / share.sum()
    # What each of the receptances that differ is read from: the force's column, and the springs' for H22.
    fraction_weight = np.column_stack([weight[..., 0], abs(k3) * weight[:, 1:, 1]])
    distinct = layout.distinct(nsi.underlying_receptance(extended))
    fraction = fit_rational_fraction(frequency, distinct, fraction_weight, layout.degrees, layout.order)
    model_of = lambda values: nsi.extended_from(layout.receptance(values, frequency), values[-1])  # noqa: E731
    start = np.append(layout.of_fraction(fraction), k3)
    return fraction, *physical.fit_parameters(model_of, extended, weight, start, layout.least)
