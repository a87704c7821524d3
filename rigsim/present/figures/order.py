"""The stabilisation diagram of a record, with its singular values beside it."""

import numpy as np

from .style import BLACK, BLUE, GREY, ORANGE, PURPLE, legend, log_scale, style, subplots

_WIDER = 1.3  # times the band's upper end

# What a pole shares with the nearest of the order before (frequency, damping, shape), and how it is drawn.
_LOOKS = {
    "frequency, damping and shape": ((True, True, True), {"marker": "o", "color": BLUE}),
    "frequency and shape": ((True, False, True), {"marker": "D", "color": PURPLE, "markerfacecolor": "none"}),
    "frequency and damping": ((True, True, False), {"marker": "^", "color": ORANGE, "markerfacecolor": "none"}),
    "frequency": ((True, False, False), {"marker": "s", "color": ORANGE, "markerfacecolor": "none"}),
}
_NEW = {"marker": "x", "color": GREY}


def stabilisation_figure(found, *, ax=None):
    """Poles over frequency and model order, marked by what they share with the order before, and singular values."""
    own = np.sort(found.frequency[found.order == found.chosen])
    alt = (
        f"Stabilisation diagram: poles of models of {found.orders[0]} to {found.orders[-1]} states over frequency, "
        f"with order {found.chosen} marked, whose modes are at {', '.join(f'{one:.4g}' for one in own)} hertz; beside "
        f"it the singular values, which fall by a factor of {found.fall(found.chosen):.2g} after that order."
    )
    with style():
        figure, (poles, values) = subplots(1, 2, alt=alt, ax=ax, width=9.5, height=4.8, width_ratios=(3, 1))
        shared = np.zeros(found.frequency.size, dtype=bool)
        for label, (criteria, look) in _LOOKS.items():
            one = (found.meets == criteria).all(axis=1)
            poles.plot(found.frequency[one], found.order[one], linestyle="none", markersize=5, label=label, **look)
            shared |= one
        poles.plot(found.frequency[~shared], found.order[~shared], linestyle="none", label="none of these", **_NEW)
        for frequency in own:
            poles.axvline(frequency, color=GREY, linewidth=0.8, linestyle=":")
        number = np.arange(1, min(found.orders[-1] + 2, found.singular_values.size) + 1)
        kept = number <= found.chosen
        look = {"linestyle": "none", "marker": "o", "markersize": 5}
        values.plot(found.singular_values[: number.size][kept], number[kept], color=BLUE, **look)
        rest = found.singular_values[: number.size][~kept]
        values.plot(rest, number[~kept], color=GREY, markerfacecolor="none", **look)
        log_scale(values, which="x")
        for axis in (poles, values):
            axis.axhline(found.chosen + 0.5, color=BLACK, linestyle="--", linewidth=1.0)
            axis.set_ylim(0, number[-1] + 0.5)
            axis.set_yticks(found.orders)
        poles.set(xlim=(0, _WIDER * found.band[1]), xlabel="frequency [Hz]", ylabel="order")
        values.set(xlabel="singular value", ylabel="number")
        legend([poles], ax=ax, columns=5, title="as the nearest pole of the order before has")
        return figure
