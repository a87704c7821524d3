"""What an identification says in the end: values, intervals, and in words what speaks against them."""

import numpy as np

from ..results import Status
from .alignment import BASE
from .layout import layout_of
from .leftovers import leftovers
from .result import ParameterErrors
from .troubles import told_once

FOLDED = 0.02
MISFIT = 0.05  # of the receptances, by the paper's reading
_WIDE = 0.1  # of a parameter: a half-width beyond it says little
_MOVES = 0.01  # of a parameter: a trouble that moves one by less is in its interval
_DROWNED = 0.5  # of an output
_ODD = 0.02  # of a parameter: half-width that comes from parts of the record that disagree
_SEEN, _MOST = 1e-3, 0.3  # of an output, and of what is left of it: worth a word
_UNIT = 0.01  # kg
_CURED = ("break", "rest")  # without a mend that `Record.realigned` could do
_FILTERED = (
    "all outputs are late and low-passed alike, as where a force is read before its amplifier or filter, whose gain "
    "would scale every parameter: read it at the rig, or weigh a mass"
)


def judged(record, band, modes, values, misfit, folded, trust, mended, told, noise):
    """The fields of `Identification` that say what to believe."""
    layout, mended, doubts, left = layout_of(record), list(mended), [trouble.message for trouble in told], []
    if folded > FOLDED:
        share = f"{100 * folded:.2g} % of z^3 in the band"
        doubts.append(f"{share} is folded from above half the sample rate: sample faster")
    if trust is None:
        errors, modelled, troubles = None, None, ()
        if misfit > MISFIT:
            doubts.append(f"the parameters leave {100 * misfit:.2g} % of the receptances unexplained")
    elif trust.fit is None:
        errors, modelled, troubles = None, None, tuple(trust.troubles)
        doubts += [trouble.message for trouble in troubles]
        if _outside(modes.frequency, band):
            mended = []  # what a response without a resonance looks like says nothing of its channels
            doubts.append(_nothing_in(band))
    else:
        mended += trust.mended
        fit = trust.fit
        left = leftovers(trust.record, fit.freed(fit.outputs - fit.modelled), band)
        record, modelled, troubles = trust.record, fit.modelled, (*trust.troubles, *left)
        errors = errors_of(layout, trust, noise)
        values = errors.value
        doubts += _doubts(layout, errors, trust, record, band)
    values, count = values[: len(layout.names)], len(layout.names)
    k3 = float(values[-1])
    at_bound = [name for name, value in zip(layout.names[:-1], values, strict=False) if value <= 0]
    if k3 < 0 and (errors is None or -k3 > errors.half_width[count - 1]):
        doubts.append(f"k3 = {k3:.3g} N/m^3 is negative, so parameters carry k3 = 0")
    if at_bound:
        doubts.append(f"{' and '.join(at_bound)} would be zero or negative, which no rig of this kind is")
    mended = told_once(mended, record.sample_rate)
    reverse = any(trouble.mend.get("reverse") == ("shaker", "mass") for trouble in mended)
    if errors is not None and reverse and abs(values[0] - 1) < _UNIT:  # as if a force had been divided by its mass
        doubts.append(BASE)
    if errors is not None and _behind_a_filter(record, mended, troubles):
        doubts.append(_FILTERED)
    noticed = [*_noticed(trust, doubts), *(f"noticed: {trouble.message}" for trouble in left)]
    cured = [trouble.message for trouble in mended if trouble.mend or trouble.name in _CURED]
    hopeless = [trouble.message for trouble in mended if trouble.message not in cured]
    message = "; ".join([*hopeless, *doubts, *noticed, *(f"mended: {text}" for text in cured)])
    return {
        "k3": k3, "parameters": rig_of(layout, values, [*mended, *told]), "errors": errors,
        "record": record, "modelled": modelled, "mended": tuple(mended), "troubles": (*told, *troubles),
        "status": Status.DOUBTFUL if hopeless or doubts else Status.IDENTIFIED, "message": message,
    }  # fmt: skip


def _behind_a_filter(record, mended, troubles):
    """Whether all outputs are late and low-passed alike: then the force is, and a filter passes any share of it."""
    late = any(set(trouble.mend.get("delay", ())) == set(record.kinds) for trouble in mended)
    everything = " and ".join(record.kinds)
    return late and any(one.name == "low-pass" and one.message.startswith(everything) for one in troubles)


def rig_of(layout, values, troubles):
    """The parameters of a rig, from values of any sign; `ValueError` with what troubled the record if there is none."""
    try:
        return layout.parameters(*np.maximum(values, 0.0))
    except ValueError as error:
        told = "; ".join(trouble.message for trouble in troubles)
        raise ValueError(f"no rig is to be read from this record: {told or error}") from None


def _noticed(trust, doubts):
    """A trouble that moves no parameter by much, but is most of what is left."""
    if trust is None or trust.fit is None or not trust.left.max() > _SEEN:
        return []
    return [
        f"noticed: {trouble.message}"
        for trouble in trust.troubles[:1]
        if trouble.explains > _MOST and not any(trouble.message in doubt for doubt in doubts)
    ]


def errors_of(layout, trust, noise=None):
    """Values and intervals in the layout's order, with what noise on the force and named troubles add."""
    fit, sure = trust.fit, trust.uncertainty
    order = [fit.structure.names.index(name) for name in (*layout.names, *fit.structure.names[len(layout.names) :])]
    value, half_width = fit.values[order], sure.half_width[order]
    # A force that is seen with noise seems larger than it is, and the rig heavier and stiffer by that much.
    if noise is not None:
        value = value / (1 + noise**2)
    else:
        half_width = half_width + trust.force_share**2 * np.abs(value)
    for trouble in trust.troubles:
        half_width = half_width + np.abs(trouble.shift[order])
    covariance = sure.covariance[np.ix_(order, order)]
    found = ParameterErrors(
        tuple(fit.structure.names[i] for i in order), value, sure.standard_error[order], half_width, sure.bound[order],
        covariance, sure.disagreement[order], _mode_half_widths(layout, value, half_width, covariance),
    )  # fmt: skip
    if fit.structure.base:  # the first mass is 1, and nothing of it is found
        for errors in (found.standard_error, found.half_width, found.bound):
            errors[0] = 0.0
    return found


def _mode_half_widths(layout, value, half_width, covariance):
    """Of frequency and damping of the modes: what the parameters' errors make of them, to first order."""
    linear, unknown = len(layout.names) - 1, np.full((len(layout.masses), 2), np.nan)
    if _modes_of(layout, value) is None:
        return unknown
    slopes = []
    for index in range(linear):
        step = 1e-5 * max(abs(value[index]), 1e-12)
        moved = [_modes_of(layout, value + sign * step * (np.arange(value.size) == index)) for sign in (1, -1)]
        if any(found is None for found in moved):
            return unknown
        slopes.append((moved[0] - moved[1]) / (2 * step))
    slopes = np.array(slopes)
    wider = half_width[:linear] / np.sqrt(np.maximum(np.diag(covariance)[:linear], 1e-300))
    grown = covariance[:linear, :linear] * np.outer(wider, wider)
    return np.sqrt(np.maximum(np.einsum("pmk,pq,qmk->mk", slopes, grown, slopes), 0.0))


def _modes_of(layout, values):
    """Frequency (Hz) and damping of each mode, or None."""
    modes = layout.modes(values)
    return None if modes is None else np.column_stack([modes.frequency, modes.damping])


def _doubts(layout, errors, trust, record, band):
    doubts = []
    for name, share in zip(record.kinds, trust.left, strict=True):
        if share > _DROWNED:
            doubts.append(f"the simulated rig leaves {100 * share / np.hypot(1, share):.2g} % of {name} unexplained")
    if not trust.fit.settled and trust.left.max() > _SEEN:
        doubts.append("the search for the likeliest rig did not settle")
    scale = _scales(layout, errors, trust.fit)
    for trouble in trust.troubles:
        order = [trust.fit.structure.names.index(name) for name in errors.names]
        move = np.abs(trouble.shift[order]) / scale
        if move.max() > _MOVES:
            most = errors.names[int(move.argmax())]
            doubts.append(f"{trouble.message}, which would move {most} by {100 * move.max():.2g} %")
    wide = errors.half_width / scale
    if (wide > _WIDE).any():
        names = ", ".join(
            f"{name} (+- {100 * share:.2g} %)" for name, share in zip(errors.names, wide, strict=True) if share > _WIDE
        )
        doubts.append(f"not determined by this record: {names}; {_help(layout, wide.max(), errors, band)}")
    odd = (errors.disagreement > 1) & (wide > _ODD)
    if odd.any() and not doubts:
        names = ", ".join(name for name, one in zip(errors.names, odd, strict=True) if one)
        doubts.append(
            f"parts of the record disagree about {names} by more than noise allows, and no known trouble explains it"
        )
    return doubts


def _scales(layout, errors, fit):
    """What an error of each parameter is measured by: its value, or what would be felt beside the others."""
    value = dict(zip(errors.names, np.abs(errors.value), strict=True))
    motion, _ = fit.displaced()
    m, k1, k3, square = value["m"], value["k1"], value["k3"], layout.across(motion).var()
    least = {"c": 0.01 * np.sqrt((k1 + 3 * k3 * square) * m), "k1": 0.3 * k3 * square, "k3": 1e-7 * k1 / square}
    if "ms" in value:
        least["cs"] = 0.01 * np.sqrt(value["ks"] * value["ms"])
    return np.array([max(size, least.get(name, 0.0)) for name, size in value.items()]) + 1e-300


def _outside(frequency, band):
    return ((frequency < band[0]) | (frequency > band[1])).all()


def _nothing_in(band):
    return f"no resonance lies in the band {band[0]:g} to {band[1]:g} Hz: give band= the rig's own"


def _help(layout, worst, errors, band):
    """What would narrow the intervals."""
    modes = _modes_of(layout, errors.value)
    if modes is not None and _outside(modes[:, 0], band):
        return _nothing_in(band)
    times = (worst / _WIDE) ** 2
    if times < 100:
        return f"a record {times:.2g} times as long would do, or a cleaner one"
    return "a longer or cleaner record, or a harder shake, is needed"
