"""Panel: shake the multi-body rig at one frequency and see on which branch of the theory it ends."""

from collections import namedtuple
from html import escape

import numpy as np

from ... import checks
from ...experiment.out_of_plane import planar_word
from ...experiment.sine_test import sine_test
from ...model.excitation import Tap
from ...paper.virtual_experiment import BRANCHES, overlay, trial_name
from ...results import Status
from ..figures.rig_parts import SETS, only_rigs
from ..figures.style import BLACK, GREY, MOTIONS, ORANGE, style, subplots
from .controls import PAPERS_RIG, changed, choice, offset_slider, reset_label, sets_choice, slider, stretch_slider
from .curve import BAND, ResponseCurve
from .live import LivePanel

_Circle = namedtuple("_Circle", "rig force frequency amplitude branch")
_HIGHEST = 4.0  # the spectrum ends at this multiple of the force's frequency


def shake_panel(parameters=PAPERS_RIG, force=3.18, frequency=30.0):
    """`LivePanel` of sine tests of the multi-body rig, one at a press of the button, laid over the theory.

    Controls "frequency" (Hz), "force" (N), "sets", "stretch" (µm), "offset" (mm), "tap" (m/s, zero for none) and
    "duration" (s); the button ``start`` shakes.

    Parameters
    ----------
    parameters : RigParameters
        What the controls start from.
    force, frequency : float
        At first (N, Hz).

    Raises
    ------
    ValueError
        If the parameters are not a rig's.
    """
    (parameters,), force = only_rigs([parameters]), checks.positive("force", force, "N")
    frequency = checks.real("frequency", frequency, "Hz", low=BAND[0], high=BAND[1])
    controls = {
        "frequency": slider("frequency f [Hz]", frequency, *BAND, 0.1, 1),
        "force": slider("force F [N]", force, 0.05, 8.0, 0.01, 2),
        "sets": sets_choice(parameters),
        "stretch": stretch_slider(parameters),
        "tap": slider("tap at 1 s [m/s, 0: none]", 0.0, -2.0, 2.0, 0.05, 2),
        "offset": offset_slider(parameters),
        "duration": choice("shake for", [("3 s", 3.0), ("6 s", 6.0)], 3.0),
    }
    with style():
        alt = "Sine tests of the rig over the theory, and the spectrum of the last"
        figure, (left, right) = subplots(1, 2, alt=alt, width=9.4, height=4.3)
        picture = _ShakePicture(left, right)
        figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=5)
    circles = []

    def update(frequency, force, sets, stretch, tap, offset, duration):
        rig = changed(parameters, stretch, sets, LG=1e-3 * offset)
        words = picture.theory.show(rig, force)
        picture.place(circles, rig, force, frequency)
        return f"{words} Press <b>Shake</b> to test the rig at {frequency:.1f} Hz."

    def shake(report, frequency, force, sets, stretch, tap, offset, duration):
        rig = changed(parameters, stretch, sets, LG=1e-3 * offset)
        test = sine_test(rig, force, frequency, Tap(tap) if tap else None, duration, progress=report)
        branch = overlay(rig, test).branch[0][0]
        amplitude = 1e3 * abs(test.relative[0])
        circles.append(_Circle(rig, force, frequency, amplitude, branch))
        words = picture.theory.show(rig, force)
        picture.place(circles, rig, force, frequency)
        picture.spectrum(test)
        return f"{_words(test, branch, amplitude)}<br>{words}"

    return LivePanel(figure, controls, update, action=shake, label="Shake", reset_label=reset_label(parameters))


class _ShakePicture:
    """Theory with circles on the left, the spectrum of the last test's z on the right."""

    def __init__(self, left, right):
        self.theory = ResponseCurve(left)
        left.set_title("relative displacement z")
        left.set_ylim(0.01, 10)
        (self.at,) = left.plot([np.nan] * 2, [0, 1], color=GREY, linestyle=":", linewidth=1.0, animated=True,
                               transform=left.get_xaxis_transform())  # fmt: skip
        look = {"linestyle": "none", "animated": True, "zorder": 3}
        (self.other,) = left.plot([], [], "o", color="#A0A0A0", markerfacecolor="none", **look, label="other settings")
        self.settled = {
            name: left.plot([], [], "o", color=MOTIONS[name], markerfacecolor="none", **look, label=f"rig: {name}")[0]
            for name in (*BRANCHES, "only", "elsewhere")
        }
        (self.unsettled,) = left.plot([], [], "x", color=BLACK, markersize=7, **look, label="rig: not settled")
        (self.last,) = left.plot([], [], "o", color=BLACK, markersize=2.5, **look, label="last test")
        self.right = right
        right.set(yscale="log", xlim=(0, 120), ylim=(1e-6, 10), xlabel="frequency [Hz]", ylabel="amplitude [mm]")
        right.set_title("spectrum of z, last second")
        (self.lines,) = right.plot([], [], color=BLACK, linewidth=0.9)
        self.marks = [
            right.axvline(np.nan, color=ORANGE, linestyle=dash, label=label, zorder=1)
            for label, dash in (("f", "-"), ("f/2", "--"), ("f/3", ":"))
        ]
        right.legend(loc="upper right")

    def place(self, circles, rig, force, frequency):
        """Circles of these settings in the colour of their motion, those of others grey."""
        self.at.set_xdata([frequency] * 2)
        kinds = {artist: [] for artist in (self.other, *self.settled.values(), self.unsettled)}
        for circle in circles:
            same = circle.rig == rig and circle.force == force
            kinds[self.settled.get(circle.branch, self.unsettled) if same else self.other].append(circle)
        kinds[self.last] = circles[-1:]
        for artist, members in kinds.items():
            artist.set_data([circle.frequency for circle in members], [circle.amplitude for circle in members])

    def spectrum(self, test):
        """The whole axes move: its limits are the test's."""
        record, (f,) = test.record(0), test.frequency
        self.right.set_xlim(0, _HIGHEST * f)
        for part, mark in enumerate(self.marks, 1):
            mark.set_xdata([f / part] * 2)
        if test.status[0] == Status.FLEW_APART:
            self.lines.set_data([], [])
            return
        frequency, amplitude = record.spectrum("relative", f)
        shown = frequency <= _HIGHEST * f
        self.lines.set_data(frequency[shown], 1e3 * amplitude[shown])
        self.right.set_ylim(1e-3 * amplitude.max(), 3e3 * amplitude.max())


def _words(test, branch, amplitude):
    names = {"only": "on the only solution of the theory", "elsewhere": "but near no solution of the theory"}
    ended = names.get(branch, f"on the {branch} branch") if test.status[0] == Status.SETTLED else "on no branch"
    size = f"z {amplitude:.3g} mm, tilt up to {np.degrees(test.tilt[0]):.2g}°; " if np.isfinite(amplitude) else ""
    return (
        f"{test.frequency[0]:.1f} Hz, {SETS[test.parameters[0].wire_sets]}, {trial_name(test.tap[0])}: "
        f"<b>{test.status[0]}, {ended}</b>; {size}{escape(test.message[0])}{escape(planar_word(test.parameters))}."
    )
