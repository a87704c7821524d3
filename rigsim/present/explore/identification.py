"""Panel: a random test of the rig with noise on its sensors, and what identification makes of it."""

from html import escape

import numpy as np

from ... import checks
from ...experiment.random_test import random_test
from ...identification.identify import identify
from ..figures.rig_parts import SETS, only_rigs
from ..figures.style import BLACK, BLUE, GREY, ORANGE, style, subplots
from .controls import PAPERS_RIG, changed, reset_label, sets_choice, slider, stretch_slider
from .live import LivePanel

_TEST_SHARE = 0.5  # of the progress bar


def identification_panel(parameters=PAPERS_RIG, rms=1.115, duration=30.0, seed=2014):
    """`LivePanel` of a random test and its identification: the coefficient's spectrum and the parameters' errors.

    Controls "rms" (N), "stretch" (µm), "sets", "noise" (percent of each displacement's rms) and "duration" (s);
    the button ``start`` tests and identifies.

    Parameters
    ----------
    parameters : RigParameters
        What the controls start from.
    rms : float
        Root mean square of the force at first (N).
    duration : float
        Of the test at first (s).
    seed : int
        Of the force and of the noise.

    Raises
    ------
    ValueError
        If the parameters are not a rig's.
    """
    (parameters,) = only_rigs([parameters])
    rms, duration = checks.positive("rms", rms, "N"), checks.real("duration", duration, "s", low=1.0, high=1e4)
    seed = checks.seed("seed", seed)
    controls = {
        "rms": slider("force [N rms]", rms, 0.05, 4.0, 0.005, 3),
        "stretch": stretch_slider(parameters),
        "sets": sets_choice(parameters),
        "noise": slider("noise on xs and x [% rms]", 0.0, 0.0, 5.0, 0.05, 2),
        "duration": slider("test for [s]", duration, 10.0, 100.0, 5.0, 0),
    }
    with style():
        figure, axes = subplots(alt="Identified nonlinear coefficient over frequency", width=7.6, height=3.6)
        (before,) = axes.plot([], [], color=GREY, linewidth=0.9, label="test before")
        (estimate,) = axes.plot([], [], color=BLUE, label="this test")
        fitted = axes.axhline(np.nan, color=ORANGE, linestyle="--", label="fitted k3")
        true = axes.axhline(parameters.k3, color=BLACK, linestyle=":", label="true k3")
        axes.set(xlim=(2, 80), ylim=(0.9 * parameters.k3, 1.1 * parameters.k3), xlabel="frequency [Hz]")
        axes.set_ylabel("Re $k_3$ [N/m$^3$]")
        figure.legend(loc="outside upper center", ncols=4)

    def update(rms, stretch, sets, noise, duration):
        rig = changed(parameters, stretch, sets)
        return (
            f"{SETS[rig.wire_sets].capitalize()}, {rms:.3f} N rms for {duration:.0f} s, {noise:g} % noise: "
            "press <b>Test and identify</b>."
        )

    def test(report, rms, stretch, sets, noise, duration):
        rig = changed(parameters, stretch, sets)
        record = random_test(rig, rms, duration, seed=seed, progress=lambda done, n: report(_TEST_SHARE * done, n))
        share = lambda done, n: report(_TEST_SHARE + (1 - _TEST_SHARE) * done / n, 1)  # noqa: E731
        result = identify(_with_noise(record, noise / 100, seed), progress=share)
        before.set_data(*estimate.get_data())
        estimate.set_data(result.frequency, result.nonlinear_coefficient.real)
        fitted.set_ydata([result.k3] * 2)
        true.set_ydata([rig.k3] * 2)
        # The edges of the band are the least certain: they must not set the scale.
        low, high = np.quantile(result.nonlinear_coefficient.real, (0.05, 0.95))
        margin = max(high - low, 0.02 * rig.k3)
        axes.set_ylim(min(low, rig.k3) - margin, max(high, rig.k3) + margin)
        report(1, 1)
        return _words(result, rig, rms, noise)

    label = "Test and identify"
    return LivePanel(figure, controls, update, action=test, label=label, reset_label=reset_label(parameters))


def _with_noise(record, share, seed):
    """The record with white noise on both displacements, ``share`` of each one's rms."""
    # A stream of its own: the force is drawn from the seed itself.
    noise = np.random.default_rng([seed, 1]).standard_normal((2, record.force.size))
    shaker, mass = (u + share * u.std() * n for u, n in zip((record.shaker, record.mass), noise, strict=True))
    return record.replace(shaker=shaker, mass=mass)


def _words(result, rig, rms, noise):
    modes = " and ".join(f"{f:.4g} Hz" for f in result.modes.frequency)
    table = result.table().drop(columns="meaning").rename_axis(None)
    table["error [%]"] = table["error [%]"].map("{:.2g}".format)
    table = table.to_html(float_format="{:.5g}".format, border=0)
    verdict = escape(result.message or str(result.status))
    return (
        f"{SETS[rig.wire_sets].capitalize()}, {rms:.3f} N rms, {noise:g} % noise: modes at {modes}, "
        f"<b>k3 off by {100 * (result.k3 / rig.k3 - 1):.2g} %</b>; {verdict}.{table}"
    )
