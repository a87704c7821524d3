"""How rigs hang, rock and come out of their tests, over what a builder decides and gets wrong."""

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.ticker import LogLocator

from ... import checks
from ...design.wobbling import QUANTITIES, RIGID, STARTS, WHERE
from .style import BLUE, GREEN, GREY, ORANGE, PURPLE, RED, SKY, legend, log_scale, outer_labels, style, subplots

_COLOURS = dict(zip(RIGID, (RED, BLUE, GREEN, GREY, SKY), strict=True))
_TESTED = {0: BLUE, 1: ORANGE}
_BAND = (10.0, 80.0)  # Hz, of the paper's test


def wobbling_figure(result, *, ax=None, modes=("rocking", "yaw", "roll")):
    """A `WobblingMap`: tilt at rest, frequencies of ``modes``, and the share of tests that settled where they should.

    Over one quantity three panels, the closed forms dashed, the paper's band of test shaded and a cross on the lower
    edge where no stable rest was found; two where nothing was tested. Over two quantities as many maps, of the
    tilt, of the slowest of the modes, and of the tests in space; hatched where nothing was found or tested.

    Raises
    ------
    ValueError
        If a mode is not one of "rocking", "yaw", "roll", "bounce" and "sway".
    """
    modes = checks.names("modes", modes, RIGID)
    return (_lines if len(result.over) == 1 else _maps)(result, ax, modes)


def _label(name):
    words, unit, _ = QUANTITIES[name]
    return f"{words} [{unit}]"


def _alt(result, modes):
    return f"{result.summary()}. Shown are the tilt at rest, the frequencies of {', '.join(modes)}, and the tests."


def _lines(result, ax, modes):
    ((name, values),) = result.over.items()
    x, tested = QUANTITIES[name][2] * values, np.isfinite(result.kept).any()
    with style():
        figure, panels = subplots(
            2 + tested, 1, alt=_alt(result, modes), ax=ax, height=2.4 + 2.3 * (1 + tested), sharex=ax is None
        )
        tilt, rocking = panels[:2]
        tilt.plot(x, np.degrees(abs(result.tilt)), "o-", color=PURPLE, markersize=3.5, label="tilt at rest")
        tilt.plot(x, np.degrees(abs(result.by_hand[:, 0])), "--", color=GREY, label="closed form")
        tilt.set(ylabel="tilt at rest [°]")
        rocking.axhspan(*_BAND, color=SKY, alpha=0.2, linewidth=0, label="the paper's test, 10 to 80 Hz")
        for mode in modes:
            j, look = RIGID.index(mode), {"color": _COLOURS[mode]}
            rocking.plot(x, result.frequency[:, j], "o-", markersize=3.5, label=mode, **look)
            rocking.plot(x, result.by_hand[:, j + 1], "--", color=GREY, label="closed form")
        rocking.set(ylabel="frequency [Hz]")
        log_scale(rocking, (1, 2, 5))
        lost = ~np.isfinite(result.tilt)
        for axes in panels[:2]:
            if lost.any():
                axes.plot(x[lost], np.full(lost.sum(), 0.04), "x", color=GREY, label="no stable rest found",
                          transform=axes.get_xaxis_transform())  # fmt: skip
        if tested:
            for i, start in enumerate(STARTS):
                for j, where in enumerate(WHERE):
                    look = {"color": _TESTED[i], "linestyle": "-" if j else ":", "marker": "o" if j else "s"}
                    look |= {"markerfacecolor": None if j else "none", "markersize": 3.5 + 3 * (1 - j)}
                    panels[2].plot(x, 100 * result.survives[:, i, j], label=f"{start}, {where}", **look)
            panels[2].set(ylabel="tests that end\nwhere they should [%]", ylim=(-5, 105))
        positive = abs(result.tilt[~lost])
        if positive.size and positive.min() > 1e-9:
            log_scale(tilt, (1, 2, 5))
        for axes in panels:
            axes.set_xlabel(_label(name))
            if x.min() > 0 and x.max() > 20 * x.min():
                log_scale(axes, (1, 2, 5), "x")
        outer_labels(panels, ax=ax)
        legend(panels, ax=ax, columns=3)
    return figure


def _maps(result, ax, modes):
    (first, second), (x, y) = result.over, result.over.values()
    x, y = QUANTITIES[first][2] * x, QUANTITIES[second][2] * y
    shape, tested = (x.size, y.size), np.isfinite(result.kept[..., 1]).any()
    slowest = result.frequency[:, [RIGID.index(mode) for mode in modes]].min(axis=1)
    shown = [
        ("tilt at rest [°]", np.degrees(abs(result.tilt)), LogNorm, "viridis_r"),
        (f"slowest of {', '.join(modes)} [Hz]", slowest, LogNorm, "viridis"),
    ]
    if tested:
        right = 100 * result.survives[:, :, 1].mean(axis=1)
        shown.append(("tests in space that end where they should [%]", right, None, "viridis"))
    with style():
        figure, panels = subplots(1, len(shown), alt=_alt(result, modes), ax=ax, width=4.2 * len(shown), height=3.9)
        for axes, (label, values, norm, colours) in zip(panels, shown, strict=True):
            values = np.ma.masked_invalid(np.reshape(values, shape).T)
            limits = {"vmin": 0, "vmax": 100}
            if norm:
                low, high = _decades(values)
                values, limits = (
                    np.ma.maximum(values, low),
                    {"norm": norm(low, high)},
                )  # no tilt at all has no logarithm
            axes.patch.set(facecolor="#E6E6E6", hatch="xx", edgecolor=GREY)
            drawn = axes.pcolormesh(x, y, values, cmap=colours, shading="nearest", **limits)
            ticks = {} if norm is None else {"ticks": LogLocator(subs=(1, 2, 5)), "format": "{x:g}"}
            bar = axes.figure.colorbar(drawn, ax=axes, label=label, location="top", **ticks)
            bar.ax.minorticks_off()
            axes.set(xlabel=_label(first), ylabel=_label(second))
            axes.grid(False)
            own = [_own(result.parameters, name) for name in result.over]
            if None not in own and min(x) <= own[0] <= max(x) and min(y) <= own[1] <= max(y):
                axes.plot(*own, "o", color="white", markeredgecolor=PURPLE, markeredgewidth=2, label="this rig")
                axes.legend()
        outer_labels(panels, ax=ax)
    return figure


def _own(parameters, name):
    """What the rig itself has of a quantity, as it is shown; None of what it does not know."""
    known = {"stretch": parameters.d - parameters.d0, "set_half_spacing": parameters.half_spacing}
    value = known.get(name, getattr(parameters, name, 0.0))
    return None if value is None else QUANTITIES[name][2] * value


def _decades(values):
    """Limits of a logarithmic scale of positive values, at least a factor of two apart."""
    positive = np.ma.masked_less_equal(values, 1e-12).compressed()
    if not positive.size:
        return 0.1, 1.0
    return positive.min(), max(positive.max(), 2 * positive.min())
