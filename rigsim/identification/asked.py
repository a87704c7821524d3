"""What `identify` and `model_order` are asked for, checked."""

from .. import checks
from ..campaign.cost import affordable
from ..campaign.stop import sliced
from ..experiment.on_disk import let_go
from .layout import layout_of
from .receptance import RESOLUTION, frequencies
from .terms import Term

_PIECE = 1_000_000  # samples that are looked at
_MATRICES, _LINE, _SAMPLE = 8, 6e4, 1e3  # of all block rows, in memory at once; bytes a frequency and a sample


def checked_record(record, order, block_rows, band, at_once=None):
    """Order (that of the rig, where it is None), block rows and band, checked against a record that must vary.

    So many samples are read ``at_once``, by default all of them.
    """
    order, block_rows = _checked_orders(order, block_rows, record)
    band = checks.pair("band", band, "Hz", high=record.sample_rate / 2)
    afford(at_once or record.force.size, block_rows, band)
    frequency = frequencies(band, record.sample_rate)
    lines, needed = int((frequency[-1] - frequency[0]) * record.duration), order * (order + 6)
    if lines < needed:
        raise ValueError(
            f"band = {frequency[0]:g} to {frequency[-1]:g} Hz has {lines} lines in {record.duration:g} s of record; "
            f"expected at least {needed} for order = {order}"
        )
    parts = sliced(record.force.size, _PIECE)
    ends = [{name: (channel.min(), channel.max()) for name, channel in _signals(record, part)} for part in parts]
    for name in ends[0]:
        least, most = min(part[name][0] for part in ends), max(part[name][1] for part in ends)
        if not most - least > 1e-12 * max(-least, most):
            raise ValueError(f"{name} = {most:g} throughout is not allowed; expected a channel that varies")
    return order, block_rows, band


def _signals(record, samples):
    """Names and samples of force and outputs and of z, of a record that may be longer than memory."""
    channels = {name: channel[samples] for name, channel in record.channels.items() if name not in ("tilt", "voltage")}
    yield from channels.items()
    if record.mass is not None and len(set(record.kinds.values())) == 1:
        yield "relative", channels["shaker"] - channels["mass"]
    let_go(*record.channels.values())


def afford(samples, block_rows, band):
    """Refuse what cannot be afforded: matrices of all block rows of five channels, and what is read at frequencies."""
    rows, lines = 2.0 * block_rows * 5, (band[1] - band[0]) / RESOLUTION
    affordable(
        f"block_rows = {block_rows}", instead="fewer block rows", memory=8 * _MATRICES * rows**2,
        seconds=4e-10 * samples * rows * 5 + 5e-10 * rows**3,
    )  # fmt: skip
    affordable(
        f"band = {band[0]:g} to {band[1]:g} Hz with a record of {samples} samples", instead="a narrower band",
        memory=_LINE * lines + _SAMPLE * samples, seconds=2e-3 * lines + 2e-5 * samples,
    )  # fmt: skip


def checked_terms(terms, layout):
    """Tuple of the terms, each between masses that a rig of that layout has."""
    terms = () if isinstance(terms, (tuple, list)) and not terms else checks.one_or_many("terms", terms, Term, "a Term")
    names = [*layout.names, *(term.name for term in terms)]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"terms name {name} twice; expected names of their own, none of {', '.join(layout.names)}")
    for term in terms:
        if max(term.between) >= len(layout.masses):
            least = f"masses of the record, numbers below {len(layout.masses)}"
            raise ValueError(f"term {term.name} is between {term.between}; expected {least}")
    return tuple(terms)


def checked_noise(noise):
    """Share of the recorded force that is noise, or None."""
    if noise is None:
        return None
    noise = checks.instance("noise", noise, dict, "a dict such as {'force': 0.01}")
    shares = {checks.one_of("noise of", name, ("force",)): share for name, share in noise.items()}
    return checks.real("noise of force", shares.get("force", 0.0), low=0.0, high=1.0)


def _checked_orders(order, block_rows, record):
    block_rows, least = checks.integer("block_rows", block_rows, low=4), layout_of(record).order
    order = least if order is None else checks.integer("order", order, low=least, high=block_rows)
    if order % 2:
        raise ValueError(f"order = {order} is not allowed; expected an even number, two a mode")
    # As many Hankel columns as rows of all channels: fewer, and past and future span everything.
    needed = 2 * block_rows * (2 + len(record.kinds)) + 2 * block_rows - 1
    n = min(test.force.size for test in record.tests)
    if n < needed:
        which = "record" if len(record.joints) == 1 else "shortest test of the record"
        raise ValueError(f"{which} has {n} samples; expected at least {needed} for block_rows = {block_rows}")
    return order, block_rows
