"""Spectra of single sine tests, so that a motion at f/2 or f/3 cannot pass unseen."""

import numpy as np

from ... import checks
from ...experiment.out_of_plane import planar_only
from ...experiment.sine_test import SineTest
from .rig_parts import SETS
from .style import BLACK, ORANGE, legend, outer_labels, style, subplots


def spectrum_figure(test, *, ax=None, indices=0, beside=(), highest=4.0):
    """Amplitude spectra of z and tilt of single sine tests, so that a motion at f/2 or f/3 cannot pass unseen.

    Amplitudes are zero to peak; see `Record.spectrum`.

    Parameters
    ----------
    test : SineTest
    ax : sequence of axes, two a row, optional
    indices : int or sequence of int
        Which of its points, one row each.
    beside : SineTest or sequence of them
        Whose points of these indices follow below.
    highest : float
        Spectra end at this multiple of the force's frequency.

    Raises
    ------
    ValueError
        If there is no index or no such point, or ``highest`` is not above zero.
    """
    highest = checks.real("highest", highest, low=0.0, high=1e6, low_open=True)
    beside = checks.one_or_many("beside", beside, SineTest, "a SineTest")
    if isinstance(indices, (list, tuple)) and not indices:
        raise ValueError("indices is empty; expected at least one")
    indices = checks.integers("indices", indices, low=0)
    shown = [(each, i) for each in (test, *beside) for i in indices]
    records = [each.record(i) for each, i in shown]
    alt = "Amplitude spectra of relative displacement and tilt. " + " ".join(_words(each, i) for each, i in shown)
    with style():
        height = 0.9 + 2.5 * len(shown)
        figure, grid = subplots(len(shown), 2, alt=alt, ax=ax, width=9.5, height=height, squeeze=False, sharey="col")
        for row, (each, i), record in zip(grid, shown, records, strict=True):
            f = each.frequency[i]
            for axes, channel, scale in zip(row, ("relative", "tilt"), (1e3, np.degrees(1.0)), strict=True):
                frequency, amplitude = record.spectrum(channel, f)
                drawn = frequency <= highest * f
                axes.semilogy(frequency[drawn], scale * amplitude[drawn], color=BLACK, linewidth=0.9)
                for part, dash in ((1, "-"), (2, "--"), (3, ":")):
                    label = "f" if part == 1 else f"f/{part}"
                    axes.axvline(f / part, color=ORANGE, linestyle=dash, linewidth=1.3, label=label, zorder=1)
                axes.set(xlim=(0, highest * f), xlabel="frequency [Hz]")
            rig = f"{f:g} Hz, {_rig_words(each.parameters[i])}, {_start_words(each, each.tap[i])}"
            row[0].set_title(rig, loc="left", fontsize=10)
            warned = ", in the plane only" if planar_only([each.parameters[i]]) else ""
            row[1].set_title(f"{each.status[i]}{warned}", loc="left", fontsize=10)
        outer_labels(grid, ax=ax)
        for column, text in zip(grid.T, ("z [mm]", "tilt [°]"), strict=True):
            peaks = [axes.lines[0].get_ydata().max() for axes in column]
            for axes in column:
                axes.set(ylim=(min(1e-5 * max(peaks), 1e-2 * min(peaks)), 3 * max(peaks)), ylabel=text)
        legend(grid, ax=ax, loc="outside upper center", columns=3)
    return figure


def _rig_words(parameters):
    damped = ", rocking damped" if parameters.rocking_damping else ""
    return SETS[parameters.wire_sets] + damped


def _start_words(test, tap):
    return f"from {test.start}" if tap is None else f"tapped at {tap.velocity:g} m/s"


def _words(test, i):
    line, order = test.subharmonic[i]
    return (
        f"{test.frequency[i]:g} Hz, {_start_words(test, test.tap[i])}, {test.status[i]}: z at f "
        f"{1e3 * abs(test.relative[i]):.3g} mm, its strongest line below f {100 * line:.2g} % of that at f/{order:.3g}."
    )
