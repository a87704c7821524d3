"""Figures for those who will build a rig: existence charts, margins, tolerance studies, best designs."""

import numpy as np
from matplotlib.patches import PathPatch, Rectangle
from matplotlib.path import Path
from matplotlib.ticker import StrMethodFormatter

from ...design.variation import quantity
from .style import BLUE, GREY, ORANGE, PURPLE, SKY, legend, log_scale, style, subplots

_KINDS = {"inner": (ORANGE, "//"), "outer": (PURPLE, "\\\\")}


def existence_chart_figure(result, *, ax=None):
    """The map of an `existence_chart`: regions shaded and hatched by kind, boundary curves, the rig and its box."""
    items = [quantity(result.parameters, result.force, name) for name in result.names]
    x, y = (values * item.factor for values, item in zip((result.x, result.y), items, strict=True))
    here = [value * item.factor for value, item in zip(result.point, items, strict=True)]
    with style():
        figure, axes = subplots(1, 1, alt=_chart_alt(result, items, here), ax=ax, height=4.8)
        for region in result.regions:
            color, hatch = _KINDS[region.kind]
            outline = Path(np.column_stack([region.x * items[0].factor, region.y * items[1].factor]), region.codes)
            look = {"facecolor": color, "edgecolor": color, "hatch": hatch, "alpha": 0.45, "linewidth": 0}
            axes.add_patch(PathPatch(outline, **look, label=f"{region.kind} detached curve"))
        for boundary in result.boundaries:
            color, _ = _KINDS[boundary.kind]
            axes.plot(boundary.x * items[0].factor, boundary.y * items[1].factor, color=color, linewidth=1.8)
        if not result.possible.all():
            axes.contourf(x, y, ~result.possible, levels=[0.5, 1.5], colors=[GREY], alpha=0.5)
            axes.fill([], [], color=GREY, alpha=0.5, label="no such rig (slack wires)")
        width, height = (2 * half * item.factor for half, item in zip(result.box, items, strict=True))
        if width or height:
            corner = here[0] - width / 2, here[1] - height / 2
            look = {"fill": False, "edgecolor": "k", "linewidth": 1.4, "zorder": 3}
            axes.add_patch(Rectangle(corner, width, height, **look, label="its tolerances"))
        if x[0] <= here[0] <= x[-1] and y[0] <= here[1] <= y[-1]:
            axes.plot(*here, "o", color="k", markersize=5, label="this rig", linestyle="none")
        for which, values, item in (("x", x, items[0]), ("y", y, items[1])):
            _set_axis(axes, which, values, item)
        axes.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
        legend(axes, ax=ax, columns=3)
        return figure


def _labelled(item):
    return f"{item.name} [{item.shown_unit}]" if item.shown_unit else item.name


def _set_axis(axes, which, values, item):
    """Label and scale: logarithmic where the grid is."""
    axis = getattr(axes, f"{which}axis")
    axis.set_label_text(_labelled(item))
    if np.ptp(np.diff(values)) <= 1e-6 * np.ptp(values):
        axis.get_major_formatter().set_useOffset(False)
    elif values[-1] / values[0] < 1000:
        log_scale(axes, (1, 2, 5), which)
    else:
        axes.set(**{f"{which}scale": "log"})


def _chart_alt(result, items, here):
    ranges = " and ".join(
        f"{item.name} from {values[0] * item.factor:.6g} to {values[-1] * item.factor:.6g} {item.shown_unit}".strip()
        for values, item in zip((result.x, result.y), items, strict=True)
    )
    shares = ", ".join(
        f"{label} on {100 * np.mean(result.labels == label):.0f} percent"
        for label in ("inner", "outer", "both", "none")
        if (result.labels == label).any()
    )
    place = " and ".join(f"{item.name} = {value:.6g}" for item, value in zip(items, here, strict=True))
    return f"Map of detached curves over {ranges}: {shares} of the map. The rig is at {place}."


def _three(value):
    """Three significant digits, without an exponent where it can be helped."""
    return f"{float(f'{value:.3g}'):g}"


def margins_figure(result, *, ax=None):
    """How far each of `Margins` goes down and up: bars in per cent, logarithmic, with the move in its own unit."""
    entries = [entry for entry in result if entry.value]
    moves = [(100 * entry.down / entry.value, 100 * entry.up / entry.value) for entry in entries]
    finite = [move for pair in moves for move in pair if np.isfinite(move)] or [100.0]
    low, high = 10 ** np.floor(np.log10(min(finite)) - 0.2), 10 ** np.ceil(np.log10(max(finite)) + 0.6)
    alt = f"Bars of how far each quantity may move before the {result.kind} detached curve is lost. {result.summary()}."
    with style():
        figure, axes = subplots(1, 1, alt=alt, ax=ax, height=1.4 + 0.48 * len(entries))
        for row, (entry, pair) in enumerate(zip(entries, moves, strict=True)):
            for move, offset, color, sign in zip(pair, (-0.19, 0.19), (BLUE, ORANGE), "−+", strict=True):
                limited = np.isfinite(move)
                look = {"color": color} if limited else {"facecolor": "none", "edgecolor": color, "hatch": "//"}
                label = {"−": "down", "+": "up"}[sign]
                length = (move if limited else high) - low
                axes.barh(row + offset, length, left=low, height=0.36, linewidth=0, label=label, **look)
                shown = f"{sign}{_three(move / 100 * entry.value * entry.factor)} {entry.shown_unit}"
                text, place = (f" {shown.strip()}", move) if limited else (" never lost", low)
                box = None if limited else {"facecolor": "white", "linewidth": 0, "pad": 0.5}
                axes.text(place, row + offset, text, va="center", fontsize=8, bbox=box)
        names = [f"{entry.name} = {entry.value * entry.factor:.6g} {entry.shown_unit}".strip() for entry in entries]
        axes.set_yticks(range(len(entries)), names)
        axes.invert_yaxis()
        axes.grid(False, axis="y")
        axes.set(xscale="log", xlim=(low, high), xlabel="move before the curve is lost [%]")
        axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axes.set_title(f"{result.kind} detached curve at {result.force:g} N", loc="left")
        legend(axes, ax=ax)
        return figure


def tolerance_study_figure(result, *, ax=None):
    """Shares of a `ToleranceStudy`'s rigs that keep the curve, with 95 % intervals; how far all are from the edge."""
    names = result.ranking
    alt = (
        f"Left: shares of rigs that keep the curve, all: {result.summary()}. Right: histogram of the force's distance "
        "from the edge of existence."
    )
    with style():
        figure, (left, right) = subplots(1, 2, alt=alt, ax=ax, height=1.9 + 0.36 * len(names), width=9.0)
        whole = result.share
        left.axvspan(100 * whole.low, 100 * whole.high, color=GREY, alpha=0.5, linewidth=0, label="all as drawn")
        for offset, shares, marker, color, label in (
            (-0.15, result.exact, "o", BLUE, "this one exact"),
            (0.15, result.alone, "s", ORANGE, "this one alone"),
        ):
            low, value, high = 100 * np.array([(s.low, s.value, s.high) for s in map(shares.get, names)]).T
            look = {"fmt": marker, "color": color, "markersize": 4, "linewidth": 1.2, "label": label}
            left.errorbar(value, np.arange(len(names)) + offset, xerr=np.abs([value - low, high - value]), **look)
        items = [quantity(result.parameters, result.force, name) for name in names]
        widths = [f"{i.name} ± {_three(result.tolerances[i.name] * i.factor)} {i.shown_unit}".strip() for i in items]
        left.set_yticks(range(len(names)), widths)
        left.invert_yaxis()
        least = min(share.low for share in (*result.alone.values(), *result.exact.values(), whole))
        left.set(xlabel="rigs that keep the curve [%]", xlim=(min(95.0, 100 * least - 2), 100.5))
        left.set_title(f"{100 * whole.value:.1f} % of {whole.tried} rigs keep it", loc="left")
        # As a change of force: how far the force is from where the curve comes or goes.
        percent = 100 * np.expm1(np.clip(result.distance, -1, 1))
        width = max(np.ptp(np.append(percent, 0.0)) / 40, 1e-9)
        # Whole bins from the edge of existence on, where lost and kept part.
        edges = width * np.arange(np.floor(percent.min() / width), np.ceil(percent.max() / width) + 1)
        parts = [percent[~result.kept], percent[result.kept]]
        right.hist(parts, edges, stacked=True, color=[SKY, BLUE], label=["lost", "kept"])
        right.axvline(0, color="k", linewidth=1)
        right.set(xlabel="distance of the force from the edge [%]", ylabel="rigs")
        right.legend()
        if ax is None:
            legend(left, loc="outside lower left", columns=3)
        else:
            left.legend()
        return figure


def design_figure(result, *, ax=None):
    """The margin of a `Design` over each free number, the others at their best."""
    count = len(result.free)
    options = {"width": max(7.5, 4.2 * count), "height": 3.6, "squeeze": False, "sharey": True}
    with style():
        figure, grid = subplots(1, count, alt=f"Margin over the free numbers. {result.summary()}.", ax=ax, **options)
        for axes, (name, (_, _, best)) in zip(grid[0], result.free.items(), strict=True):
            item = quantity(result.parameters, result.force, name)
            values, heights = result.profiles[name]
            axes.plot(values * item.factor, heights, color=BLUE, label="margin")
            axes.axvline(result.start[name] * item.factor, color=GREY, linestyle=":", label="before")
            axes.plot(best * item.factor, result.margin, "o", color="k", markersize=5, label="best", linestyle="none")
            axes.set_xlabel(_labelled(item))
            axes.xaxis.get_major_formatter().set_useOffset(False)
            axes.set_ylim(0, None)
        grid[0, 0].set_ylabel("margin [tolerances]")
        if ax is None:
            figure.suptitle(f"tolerances: {_tolerances(result)}", fontsize=9, wrap=True)
        legend(grid, ax=ax, columns=3)
        return figure


def _tolerances(design):
    """As they were given, in shown units."""
    texts = []
    for name, width in design.tolerances.items():
        item = quantity(design.parameters, design.force, name)
        shown = width if isinstance(width, str) else f"{width * item.factor:g} {item.shown_unit}".strip()
        texts.append(f"{name} ± {shown}")
    return ", ".join(texts)
