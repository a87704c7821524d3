"""Panel: a record of one's own, read with another order, band, block rows or one more term."""

from html import escape

import numpy as np

from ... import checks
from ...experiment.record import Record
from ...identification.identify import identify
from ...identification.layout import layout_of, outputs_of
from ...identification.model import displacements
from ...identification.result import Identification
from ...identification.terms import Friction, Power, Term
from ..figures.style import BLACK, BLUE, GREY, ORANGE, style, subplots
from .controls import choice, slider
from .live import LivePanel

_FIRST = {"low": 2.0, "high": 80.0, "rows": 40, "term": "none"}
_SMOOTHED = 0.1  # of the usual relative speed, over which dry friction changes its sign


def record_panel(record, first=None):
    """`LivePanel` of the identification of a record: its singular values, and the parameters with their intervals.

    Controls "order", "low" and "high" (Hz, the band), "rows" (block rows) and "term" (one more between the masses);
    the button ``start`` identifies. Parameters are shown relative to the usual reading's.

    Parameters
    ----------
    record : Record
    first : Identification, optional
        Of that record by the usual settings; found at the first press where it is not given.

    Raises
    ------
    ValueError
        If the record is no `Record`, or the band of 2 to 80 Hz is beyond its half sample rate.
    """
    record = checks.instance("record", record, Record, "a Record")
    first = None if first is None else checks.instance("first", first, Identification, "an Identification")
    half, layout = record.sample_rate / 2, layout_of(record)
    terms, names, order = _terms(record), layout.names, layout.order
    controls = {
        "order": choice("order of the model", [(str(n), n) for n in range(order, order + 8, 2)], order),
        "low": slider("band from [Hz]", min(_FIRST["low"], half / 4), 0.5, half / 4, 0.5, 1),
        "high": slider("band to [Hz]", min(_FIRST["high"], half), 10.0, min(half, 200.0), 1.0, 0),
        "rows": choice("block rows", [(str(n), n) for n in (20, 30, 40, 60)], _FIRST["rows"]),
        "term": choice("one more term", [("none", "none"), *((name, name) for name in terms)], _FIRST["term"]),
    }
    usual = {"found": first}
    with style():
        figure, (left, right) = subplots(1, 2, alt="Singular values; parameters", width=7.6, height=3.6)
        (values,) = left.semilogy([], [], "o", color=BLUE, markersize=4)
        cut = left.axvline(np.nan, color=GREY, linestyle="--")
        left.set(xlabel="number", ylabel="singular value", xlim=(0, 21), ylim=(1e-3, 1e3))
        place = np.arange(len(names))
        known = right.errorbar(
            place - 0.15, place * np.nan, place * np.nan, fmt="o", color=GREY, label="usual settings"
        )
        changed = right.errorbar(place + 0.15, place * np.nan, place * np.nan, fmt="s", color=ORANGE, label="these")
        right.axhline(0, color=BLACK, linewidth=0.8)
        right.set(xlim=(-0.6, len(names) - 0.4), ylabel="off the usual reading [%]")
        right.set_xticks(place, names)
        figure.legend(handles=[known, changed], loc="outside upper center", ncols=2)

    def show(found):
        base = np.maximum(np.abs(usual["found"].errors.value[: len(names)]), 1e-300)
        reach = 0.0
        for bars, each, offset in ((known, usual["found"], -0.15), (changed, found, 0.15)):
            off = 100 * (each.errors.value[: len(names)] - usual["found"].errors.value[: len(names)]) / base
            wide = 100 * each.errors.half_width[: len(names)] / base
            marks, _, (lines,) = bars
            marks.set_data(place + offset, off)
            lines.set_segments([[(x, y - w), (x, y + w)] for x, y, w in zip(place + offset, off, wide, strict=True)])
            reach = max(reach, np.abs(off).max() + wide.max())
        right.set_ylim(-1.1 * reach, 1.1 * reach)
        shown = found.singular_values[:20]
        values.set_data(np.arange(1, shown.size + 1), shown)
        left.set_ylim(shown[-1] / 3, 3 * shown[0])
        cut.set_xdata([len(found.state_space.A) + 0.5] * 2)

    def update(order, low, high, rows, term):
        return (
            f"Order {order}, {low:g} to {high:g} Hz, {rows} block rows, one more term: {term}. Press <b>Identify</b>, "
            "which takes some seconds."
        )

    def act(report, order, low, high, rows, term):
        if usual["found"] is None:
            usual["found"] = _with_errors(identify(record, progress=lambda done, n: report(done, 2 * n)))
        more = terms.get(term, ())
        part = lambda done, n: report(n + done, 2 * n)  # noqa: E731
        found = _with_errors(identify(record, order, rows, (low, high), terms=more, progress=part))
        show(found)
        report(1, 1)
        return _words(found)

    if first is not None:
        show(_with_errors(first))
    return LivePanel(figure, controls, update, action=act, label="Identify", reset_label="Usual settings")


def _terms(record):
    """Terms that may act beside the cubic spring, one to be chosen, by what they are called."""
    layout = layout_of(record)
    motion = layout.across(outputs_of(displacements(record, (_FIRST["low"], record.sample_rate / 2))))
    speed = _SMOOTHED * record.sample_rate * np.diff(motion).std()
    between = layout.terms[-1].between
    return {
        "quadratic spring": (Term("k2", between, Power(2), unit="N/m^2"),),
        "quintic spring": (Term("k5", between, Power(5), unit="N/m^5"),),
        "cubic damping": (Term("c3", between, Power(3), "velocity", "N s^3/m^3"),),
        "dry friction": (Term("mu", between, Friction(speed), "velocity", "N"),),
    }


def _with_errors(found):
    if found.errors is None:
        raise ValueError(found.message)
    return found


def _words(found):
    table = found.table()[["value", "+- (95 %)", "unit"]].rename_axis(None)
    errors = found.errors
    more = "".join(
        f"<p>{errors.names[i]} = {errors.value[i]:.4g} ± {errors.half_width[i]:.2g}: "
        f"{'there' if abs(errors.value[i]) > errors.half_width[i] else 'not seen in this record'}.</p>"
        for i in range(len(layout_of(found.record).names), len(errors.names))
    )
    verdict = f"<b>{escape(str(found.status))}</b>" + (f": {escape(found.message)}" if found.message else "")
    return f"{verdict}.{more}{table.to_html(float_format='{:.5g}'.format, border=0)}"
