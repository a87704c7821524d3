"""What tests under feedback show: S-curves, the measured response sheet and its contours, and phase-locked motions."""

import matplotlib
import numpy as np
from scipy.interpolate import CubicSpline

from ... import checks
from ...orbits.branches import PeriodicOrbits
from ...orbits.response_sheet import ResponseSheet
from ...results import Status
from .sheet import sheet_amplitude_figure
from .style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    MOTIONS,
    ORANGE,
    PURPLE,
    RED,
    SKY,
    in_runs,
    legend,
    log_scale,
    marks,
    outer_labels,
    style,
    subplots,
)  # fmt: skip

_COLORS = (SKY, BLUE, GREEN, ORANGE, RED, PURPLE, BLACK)
_STABLE, _UNSTABLE = {"marker": "o", "markersize": 4}, {"marker": "o", "markersize": 4, "markerfacecolor": "none"}
_FINE = 200  # amplitudes of an S-curve that are drawn


def s_curves_figure(test, *, ax=None, force=None):
    """Force over amplitude of z at each frequency of a `FeedbackTest`, unstable motions hollow; the folds' levels too.

    Parameters
    ----------
    test : FeedbackTest
    ax : axes, optional
    force : float, optional
        A force (N) to be marked.
    """
    force = None if force is None else checks.positive("force", force, "N")
    unstable = sum(one.status is Status.HELD and not one.stable for one in test)
    alt = (
        f"Amplitude of the force in newtons over amplitude of z in millimetres at {len(test.frequency)} frequencies "
        f"from {test.frequency[0]:g} to {test.frequency[-1]:g} Hz: each rises, falls through unstable motions "
        f"({unstable} in all), and rises again."
    )
    with style():
        figure, axes = subplots(1, 1, alt=alt, ax=ax, height=5)
        for number, frequency in enumerate(test.frequency):
            color = _shade(number, len(test.frequency))
            held = test.held(frequency)
            z, F = 1e3 * _amplitudes(held), _forces(held)
            if len(held) >= 4:
                fine = np.linspace(z[0], z[-1], _FINE)
                axes.plot(fine, np.sqrt(np.maximum(CubicSpline(z, F**2)(fine), 0)), color=color, linewidth=0.9)
            for stable, look in ((True, _STABLE), (False, _UNSTABLE)):
                these = np.array([one.stable == stable for one in held], dtype=bool)
                axes.plot(z[these], F[these], linestyle="none", color=color, **look)
            axes.plot([], [], color=color, label=f"{frequency:g} Hz")
        axes.plot([], [], color=GREY, linestyle="none", label="stable", **_STABLE)
        axes.plot([], [], color=GREY, linestyle="none", label="unstable", **_UNSTABLE)
        if force is not None:
            axes.axhline(force, color=BLACK, linestyle="-.", linewidth=1, label=f"{force:g} N")
        axes.set(xlabel="amplitude of z [mm]", ylabel="amplitude of the force [N]", xlim=(0, None), ylim=(0, None))
        legend(axes, ax=ax, columns=6)
    return figure


def _shade(number, count):
    return matplotlib.colormaps["viridis"](0.9 * number / max(count - 1, 1))


def _amplitudes(held):
    return np.array([abs(one.relative[1]) for one in held])


def _forces(held):
    return np.array([abs(one.force[1]) for one in held])


def measured_sheet_figure(test, *, ax=None, forces=None, beside=None):
    """The measured sheet from above: contours of the force over frequency and amplitude of z, and the folds' lines.

    Parameters
    ----------
    test : FeedbackTest
    ax : axes, or two of them if there is a sheet beside, optional
    forces : sequence of float, optional
        N; by default five up to the test's.
    beside : ResponseSheet, optional
        The computed one, drawn beside with the same contours.
    """
    if forces is None:
        forces = test.force * np.array([0.3, 0.5, 0.7, 0.8, 1.0])
    forces = checks.array("forces", forces, "N", low=0.0, low_open=True)
    if beside is not None:
        beside = checks.instance("beside", beside, ResponseSheet, "a ResponseSheet")
    told = ", ".join(f"{one:.3g}" for one in forces)
    alt = (
        "Amplitude of z in millimetres, logarithmic, over frequency in hertz: contours of the measured force at "
        f"{told} newtons among {len(test)} motions"
        + (", and beside them those of the computed sheet." if beside else ".")
    )
    panels = 1 + (beside is not None)
    with style():
        figure, grid = subplots(1, panels, alt=alt, ax=ax, width=7.5 + 3 * (panels - 1), height=5.2, sharey=True)
        first = np.ravel(np.array(grid, dtype=object))[0]
        for number, force in enumerate(forces):
            color = _COLORS[number % len(_COLORS)]
            response = test.at(float(force))
            for stable, look in ((True, _STABLE), (False, _UNSTABLE)):
                these = response.stable == stable
                z = 1e3 * abs(response.relative[these])
                first.plot(response.frequency[these], z, linestyle="none", color=color, **look)
            first.plot([], [], color=color, linestyle="none", label=f"{force:.3g} N", **_STABLE)
        for frequency, amplitude, _ in test.fold_levels.values():
            first.plot(frequency, 1e3 * amplitude, color=GREY, linewidth=1, label="fold line")
        first.set(xlabel="frequency [Hz]", ylabel="amplitude of z [mm]", title="measured")
        log_scale(first, (1, 2, 5))
        if beside is not None:
            sheet_amplitude_figure(beside, ax=grid[1], forces=forces)  # in the same colours
            grid[1].get_legend().remove()
            grid[1].set(title="computed", xlim=first.get_xlim(), ylabel="")
        legend(first, ax=ax, columns=6, title="stable filled or solid, unstable hollow or dashed")
    return figure


def measured_response_figure(response, *, ax=None, beside=None):
    """The measured response at one force: amplitude of z over frequency, each motion in its colour, folds marked.

    Parameters
    ----------
    response : MeasuredResponse
    ax : axes, optional
    beside : PeriodicOrbits, optional
        Computed orbits, drawn as lines behind.
    """
    if beside is not None:
        beside = checks.instance("beside", beside, PeriodicOrbits, "PeriodicOrbits")
    folds = ", ".join(f"{fold.frequency:.2f}" for fold in response.folds) or "none"
    alt = (
        f"Amplitude of z in millimetres over frequency at {response.force:g} N: {len(response)} measured motions, "
        f"{int((~response.stable).sum())} of them unstable, folds at {folds} hertz"
        + (", on the lines of the computed orbits." if beside else ".")
    )
    with style():
        figure, axes = subplots(1, 1, alt=alt, ax=ax, height=5)
        for number, branch in enumerate(beside or ()):
            amplitude = 1e3 * abs(branch.relative[:, branch.period])
            in_runs(axes, branch, amplitude, "computed" if number == 0 else None, color=GREY, linewidth=1)
        z = 1e3 * abs(response.relative)
        for motion in ("low", "middle", "high", "only"):
            for stable, look in ((True, _STABLE), (False, _UNSTABLE)):
                these = np.array([one.motion == motion and one.stable == stable for one in response], dtype=bool)
                if these.any():
                    label = f"{motion}, {'stable' if stable else 'unstable'}"
                    key = {"color": MOTIONS[motion], "linestyle": "none", "label": label}
                    axes.plot(response.frequency[these], z[these], **key, **look)
        for fold in response.folds:
            place = fold.frequency, 1e3 * fold.amplitude
            axes.plot(*place, "D", color=BLACK, markersize=5, label="fold")
            text = f"{fold.frequency:.2f} Hz"
            axes.annotate(text, place, xytext=(8, -3), textcoords="offset points", fontsize=8)
        log_scale(axes, (1, 2, 5))
        axes.set(xlabel="frequency [Hz]", ylabel="amplitude of z [mm]")
        legend(axes, ax=ax, columns=4, title="measured under feedback, by its estimated multipliers")
    return figure


def invasiveness_figure(test, *, ax=None):
    """What the feedback of a `FeedbackTest` adds off the force's own line, over the force, and the 1 % allowed."""
    percent = 100 * np.array([one.invasive for one in test])
    held = np.array([one.status is Status.HELD for one in test], dtype=bool)
    frequency = np.array([one.frequency for one in test])
    alt = (
        "Largest line of the feedback off the fundamental, in per cent of the force, over frequency: "
        f"{int(held.sum())} of {len(test)} motions held, at most {np.nanmax(percent[held], initial=0.0):.2g} per cent."
    )
    with style():
        figure, axes = subplots(1, 1, alt=alt, ax=ax, height=3.6)
        for these, look in ((held, {"marker": "o", "color": BLUE, "label": "held"}),
                            (~held, {"marker": "X", "color": RED, "label": "not held"})):  # fmt: skip
            if these.any():
                marks(axes, frequency[these], percent[these], look)
        axes.axhline(1, color=BLACK, linestyle="--", linewidth=1.2, label="1 %")
        log_scale(axes)
        axes.set(xlabel="frequency [Hz]", ylabel="feedback off f [% of F]")
        legend(axes, ax=ax, columns=3)
    return figure


def held_motion_figure(motion, *, ax=None, periods=4):
    """The last periods of a `HeldMotion` as read: force, xs and x over time.

    Parameters
    ----------
    motion : HeldMotion
    ax : sequence of three axes, optional
    periods : int
        1 or more, as far as the window reaches.
    """
    periods = checks.integer("periods", periods, low=1)
    record = motion.to_record()
    samples = min(int(periods / motion.frequency * record.sample_rate) + 1, record.force.size)
    rows = (("force [N]", record.force, "steps-post"), ("xs [mm]", 1e3 * record.shaker, "default"))
    rows += (("x [mm]", 1e3 * record.mass, "default"),)
    alt = f"Force, shaker and mass over the last {periods} periods. {motion.summary()}"
    with style():
        figure, grid = subplots(3, 1, alt=alt, ax=ax, height=6, sharex=True)
        for axes, (name, values, drawn) in zip(grid, rows, strict=True):
            axes.plot(record.time[-samples:], values[-samples:], drawstyle=drawn, color=BLUE, linewidth=1.1)
            axes.set(ylabel=name, xlabel="time in the window [s]")
        outer_labels(grid, ax=ax)
    return figure


def phase_locked_figure(test, *, ax=None, beside=None):
    """Amplitude of z over frequency as a `PhaseLockedTest` went through its motions; those not held are crosses.

    Parameters
    ----------
    test : PhaseLockedTest
    ax : axes, optional
    beside : PeriodicOrbits, optional
        Computed orbits at one force, drawn as lines behind.
    """
    if beside is not None:
        beside = checks.instance("beside", beside, PeriodicOrbits, "PeriodicOrbits")
    held = np.array([one.status is Status.HELD for one in test], dtype=bool)
    z = 1e3 * np.array([abs(one.relative) for one in test])
    alt = f"Amplitude of z in millimetres, logarithmic, over frequency. {test.summary()}"
    with style():
        figure, axes = subplots(1, 1, alt=alt, ax=ax, height=4.6)
        for number, branch in enumerate(beside or ()):
            amplitude = 1e3 * abs(branch.relative[:, branch.period])
            label = f"orbits at {beside.force:g} N" if number == 0 else None
            in_runs(axes, branch, amplitude, label, color=GREY, linewidth=1)
        axes.plot(test.frequency, z, color=ORANGE, linewidth=0.8)
        marks(axes, test.frequency[held], z[held], {"marker": "o", "color": BLUE, "label": "held"}, filled=True)
        if not held.all():
            marks(axes, test.frequency[~held], z[~held], {"marker": "X", "color": RED, "label": "not held"})
        log_scale(axes, (1, 2, 5))
        axes.set(xlabel="frequency [Hz]", ylabel="amplitude of z [mm]")
        legend(axes, ax=ax, columns=3)
    return figure
