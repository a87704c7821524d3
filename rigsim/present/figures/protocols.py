"""Tests on the bench: their points in the order they were read, how long each took, and all of it over the orbits."""

import itertools

import numpy as np

from ...results import Status
from .style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    MOTIONS,
    ORANGE,
    PURPLE,
    SKY,
    in_runs,
    legend,
    log_scale,
    marks,
    outer_labels,
    style,
    subplots,
)  # fmt: skip

_BENCHES = (BLUE, ORANGE, GREEN, PURPLE, SKY)
_SHAPES = {
    Status.SETTLED: "o", Status.SUBHARMONIC: "D", Status.NOT_PERIODIC: "s", Status.STILL_DRIFTING: "^",
    Status.FLEW_APART: "X", Status.PASSING: ".",
}  # fmt: skip
_WAYS = {("up", "rises"): "jumps up, going up", ("up", "falls"): "falls, going up",
         ("down", "rises"): "jumps up, going down", ("down", "falls"): "falls, going down"}  # fmt: skip
_MANY = 6  # benches: more of them share their colours' key


def bench_test_figure(test, *, ax=None):
    """Amplitudes of z and x of a `BenchTest` over what was moved, one colour a bench, one symbol a status.

    Points are joined in the order of the test; triangles mark jumps, and point where the test was going.
    """
    unit = {"frequency": "frequency [Hz]", "force": "force [N]"}[test.over]
    jumps = ", ".join(f"{jump.frequency:.2f} Hz and {jump.force:.3g} N ({jump.amplitude})" for jump in test.jumps)
    alt = f"Amplitudes of z and x over {unit}: {test.summary()}. Jumps: {jumps or 'none'}."
    with style():
        figure, grid = subplots(2, 1, alt=alt, ax=ax, height=6.6, sharex=True)
        for axes, (name, title) in zip(grid, (("relative", "z"), ("mass", "x")), strict=True):
            log_scale(axes, (1, 2, 5))
            for number, (run, color) in enumerate(zip(test.runs, itertools.cycle(_BENCHES), strict=False)):
                _in_order(axes, run, name, color, _label(test, number, run))
            axes.set(xlabel=unit, ylabel=f"|{title}| [mm]")
        outer_labels(grid, ax=ax)
        legend(grid, ax=ax, loc="outside upper center", columns=4)
    return figure


def _label(test, number, run):
    if not 1 < len(test.runs) < _MANY:
        return None
    change = np.diff(getattr(run, run.over))
    way = ", up" if (change > 0).all() else ", down" if (change < 0).all() else ""
    return f"bench {number}{way if len(run) > 1 else ''}"


def _in_order(axes, run, name, color, label):
    moved, height = getattr(run, run.over), 1e3 * np.abs(getattr(run, name))
    axes.plot(moved, height, color=color, linewidth=1.0, alpha=0.7, label=label)
    if not run.passing:
        for status, shape in _SHAPES.items():
            if (these := run.status == status).any():
                marks(axes, moved[these], height[these], {"marker": shape, "color": color}, label=str(status))
    for jump in run.jumps:
        at = getattr(jump, run.over)
        look = {"color": color, "linestyle": "none", "markersize": 8, "clip_on": False}
        way = _WAYS[jump.sweep, jump.amplitude]
        axes.plot(at, 0.02, marker=">" if jump.sweep == "up" else "<", label=way,
                  transform=axes.get_xaxis_transform(), **look)  # fmt: skip


def waits_figure(test, *, ax=None):
    """How long each point of a `BenchTest` was shaken for, over what was moved."""
    unit = {"frequency": "frequency [Hz]", "force": "force [N]"}[test.over]
    longest = test.dwell.max()
    alt = f"Seconds that each point was shaken for, over {unit}: up to {longest:.3g} s. {test.summary()}."
    with style():
        figure, axes = subplots(1, 1, alt=alt, ax=ax)
        for number, (run, color) in enumerate(zip(test.runs, itertools.cycle(_BENCHES), strict=False)):
            axes.plot(getattr(run, run.over), run.dwell, ".", color=color, label=_label(test, number, run))
        axes.set(xlabel=unit, ylabel="shaken for [s]", ylim=(0, None))
        if axes.get_legend_handles_labels()[0]:
            legend(axes, ax=ax)
    return figure


def comparison_figure(comparison, *, ax=None):
    """A panel a test: the orbits, the pieces that it found thick and those that it walked past dotted, and its points.

    Points on a piece are circles (dots, where they were read in passing), all others have the symbol of their status.
    """
    tests = comparison.tests
    columns = 2 if ax is None and len(tests) > 1 else 1  # a user's axes are one a test
    rows = -(-len(tests) // columns)
    with style():
        figure, grid = subplots(
            rows, columns, alt=_alt(comparison), ax=ax, width=9.6, height=0.9 + 2.8 * rows, sharex=True, sharey=True,
            squeeze=False,
        )  # fmt: skip
        panels = grid.ravel()
        for axes in panels[len(tests) :]:
            axes.set_axis_off()
        for i, axes in enumerate(panels[: len(tests)]):
            _compared(axes, comparison, i)
            axes.set_title(f"{comparison.names[i]}: {tests[i].bench_time / 60:.1f} min", loc="left")
            axes.set(xlabel="frequency [Hz]", ylabel="|z| [mm]", xlim=comparison.orbits.band)
        if ax is None:
            for axes in panels[: len(tests) - columns]:
                axes.set_xlabel("")
            for axes in panels[1::2]:
                axes.set_ylabel("")
        legend(panels, ax=ax, loc="outside upper center", columns=4)
    return figure


def _compared(axes, comparison, i):
    test, on = comparison.tests[i], comparison.on[i]
    log_scale(axes, (1, 2, 5))
    for branch in comparison.orbits:
        in_runs(axes, branch, 1e3 * np.abs(branch.relative[:, branch.period]), "orbits", color=GREY, linewidth=0.8)
    known = zip(comparison.pieces, comparison.found(i), comparison.walked_past(i), strict=True)
    for piece, found, past in known:
        look, told = None, None
        if found:
            look, told = {"color": SKY, "linewidth": 5, "alpha": 0.6}, "piece that was found"
        elif past:
            look, told = {"color": ORANGE, "linewidth": 4, "linestyle": (0, (0.6, 0.6))}, "piece that was walked past"
        if look:
            height = 1e3 * np.abs(piece.relative)
            axes.plot(piece.frequency, height, zorder=1.5, label=told, **look)
        middle = len(piece.frequency) // 2
        place = piece.frequency[middle], 1e3 * abs(piece.relative[middle])
        axes.annotate(piece.name, place, xytext=(-3, 7), textcoords="offset points", fontsize=9, color=BLACK)
    height, passing = 1e3 * np.abs(test.relative), test.status == Status.PASSING
    for these, look, told in (
        ((on >= 0) & ~passing, {"marker": "o", "markersize": 3.5, "color": BLACK}, "settled on an orbit"),
        ((on >= 0) & passing, {"marker": ".", "markersize": 2.5, "color": BLACK}, "on an orbit in passing"),
        ((on < 0) & passing, {"marker": ".", "markersize": 2.5, "color": MOTIONS["high"]}, "elsewhere in passing"),
        ((on < 0) & (test.status == Status.SETTLED), {"marker": "v", "color": BLACK, "markersize": 4}, "elsewhere"),
    ):
        if these.any():
            marks(axes, test.frequency[these], height[these], look, label=told, zorder=3)
    for status, shape in _SHAPES.items():
        these = (test.status == status) & (status not in (Status.SETTLED, Status.PASSING))
        if these.any():
            color = MOTIONS.get(str(status), BLACK)
            look = {"marker": shape, "color": color, "markersize": 4, "label": str(status), "zorder": 3}
            marks(axes, test.frequency[these], height[these], look)


def _alt(comparison):
    told = "; ".join(
        f"{row.test}: {row[2]:.1f} minutes, found {row.found}, walked past {row[5]}"
        for row in comparison.table().itertuples()
    )
    pieces = "; ".join(
        f"{piece.name} from {piece.frequency[0]:.1f} to {piece.frequency[-1]:.1f} hertz" for piece in comparison.pieces
    )
    return (
        f"Amplitude of z in millimetres, logarithmic, over frequency at {comparison.orbits.force:g} newtons, a panel a "
        f"test: points over periodic orbits. Stable pieces: {pieces}. {told}."
    )
