"""What a shaker's drive makes of the force: its fundamental, its harmonics, and the response, drive by drive."""

import numpy as np

from ...results import Status
from .style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    legend,
    log_scale,
    marks,
    outer_labels,
    style,
    subplots,
)

_COLOURS = (GREY, BLUE, ORANGE, GREEN, PURPLE, SKY)
_PERIODS = 2  # of a waveform


def shaker_figure(comparison, *, ax=None):
    """Force, its harmonics and z of a `DriveComparison` over frequency, a colour a drive.

    Small dots are single-term theory with that drive; circles tests from rest, triangles those after a tap, crosses
    what did not settle.
    """
    test, sent = comparison.test, comparison.test.driven
    settled = test.status == Status.SETTLED
    tapped = np.array([tap is not None for tap in test.tap])
    with style():
        figure, grid = subplots(3, 1, alt=f"{_alt(comparison)}.", ax=ax, height=9.6, sharex=True)
        heights = abs(sent.force), 100 * sent.distortion, 1e3 * abs(test.relative)
        for i, (theory, color) in enumerate(zip(comparison.theory, _cycle(comparison), strict=True)):
            dots = {"linestyle": "none", "marker": ".", "markersize": 1.8, "color": color}
            grid[0].plot(theory.frequency, abs(theory.force), **dots)
            grid[2].plot(theory.frequency, 1e3 * abs(theory.relative), **dots)
            grid[0].plot([], [], color=color, label=f"constant {comparison.drives[i].mode}")
            mine = np.isin(np.arange(test.frequency.size), comparison.points(i))
            for these, marker in ((settled & ~tapped, "o"), (settled & tapped, "^"), (~settled, "x")):
                look = {"marker": marker, "color": color, "markersize": 7 - 1.5 * min(i, 2)}  # one may hide another
                for axes, height in zip(grid, heights, strict=True):
                    marks(axes, test.frequency[mine & these], height[mine & these], look)
        for marker, told in (("o", "from rest"), ("^", "after a tap"), ("x", "not settled")):
            grid[0].plot([], [], color=BLACK, linestyle="none", marker=marker, markerfacecolor="none", label=told)
        labels = "force [N]", "largest harmonic of the force [%]", "|z| [mm]"
        for axes, label in zip(grid, labels, strict=True):
            log_scale(axes, (1,) if axes is grid[1] else (1, 2, 5))
            axes.set(xlabel="frequency [Hz]", ylabel=label)
        grid[0].axhline(comparison.force, color=BLACK, linewidth=0.8, linestyle=":", label="asked for")
        # A constant current has none but those of rounding.
        grid[1].set_ylim(bottom=1e-4)
        outer_labels(grid, ax=ax)
        legend(grid, ax=ax, loc="outside upper center", columns=4)
    return figure


def shaker_waveform_figure(comparison, *, ax=None):
    """Force and voltage over two periods with each drive, at the point where its force has the largest harmonics."""
    test, sent = comparison.test, comparison.test.driven
    settled = test.status == Status.SETTLED
    with style():
        figure, grid = subplots(1, 2, alt=f"Two periods of force and voltage. {_alt(comparison)}.", ax=ax, width=9.5)
        for i, color in enumerate(_cycle(comparison)):
            these = comparison.points(i)[settled[comparison.points(i)]]
            if not these.size:
                continue
            one = these[np.argmax(sent.distortion[these])]
            record = test.record(one)
            turns = (test.time[0] + record.time) * test.frequency[one]
            shown = turns >= np.floor(turns[-1]) - _PERIODS
            turns = turns[shown] - np.floor(turns[shown][0])
            told = f"constant {comparison.drives[i].mode}, {test.frequency[one]:g} Hz"
            for axes, values in zip(grid, (record.force, record.voltage), strict=True):
                axes.plot(turns, values[shown], color=color, linewidth=1.2, label=told)
        for axes, label in zip(grid, ("force on the frame [N]", "voltage at the coil [V]"), strict=True):
            axes.set(xlabel="periods of what is asked for", ylabel=label)
        legend(grid, ax=ax, loc="outside upper center", columns=2)
    return figure


def _cycle(comparison):
    return [_COLOURS[i % len(_COLOURS)] for i in range(len(comparison.drives))]


def _alt(comparison):
    told, sent = [], comparison.test.driven
    for i, drive in enumerate(comparison.drives):
        these = comparison.points(i)
        low = these[np.nanargmin(abs(sent.force[these]))]
        told.append(
            f"constant {drive.mode}: least force {abs(sent.force[low]):.3g} newtons at "
            f"{comparison.test.frequency[low]:g} hertz, largest harmonic {np.nanmax(sent.distortion[these]):.2%}"
        )
    band = comparison.test.frequency
    return (
        f"Force, its largest harmonic and amplitude of z from {band.min():g} to {band.max():g} hertz at "
        f"{comparison.force:g} newtons asked for, drive by drive; {'; '.join(told)}"
    )
