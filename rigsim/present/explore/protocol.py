"""Panel: a whole test on the bench at the press of a button, laid over the theory."""

import numpy as np

from ... import checks
from ...experiment.protocols.stepped import stepped_test, tapped_test
from ...experiment.protocols.swept import swept_test
from ...results import Status
from ..figures.rig_parts import only_rigs
from ..figures.style import BLACK, GREY, MOTIONS, ORANGE, style, subplots
from .controls import PAPERS_RIG, choice, reset_label, slider
from .curve import ResponseCurve
from .live import LivePanel

_LOW, _HIGH, _APART, _TAPPED = 10.0, 80.0, 2.0, 5.0  # Hz; steps, and between tapped frequencies
_PROTOCOLS = ("stepped up", "stepped down", "swept up", "swept down", "tapped")


def protocol_panel(parameters=PAPERS_RIG, force=3.18, rate=1.0):
    """`LivePanel` of tests on the bench from 10 to 80 Hz, one at a press of the button, laid over the theory.

    Controls "protocol" (stepped or swept, up or down, or tapped), "force" (N) and "rate" (of a sweep, Hz/s); the button
    ``start`` tests.

    Parameters
    ----------
    parameters : RigParameters
    force : float
        At first (N).
    rate : float
        Of sweeps, at first (Hz/s).

    Raises
    ------
    ValueError
        If the parameters are not a rig's.
    """
    (parameters,), force = only_rigs([parameters]), checks.positive("force", force, "N")
    rate = checks.real("rate", rate, "Hz/s", low=0.1, high=10.0)
    controls = {
        "protocol": choice("protocol", [(name, name) for name in _PROTOCOLS], _PROTOCOLS[0]),
        "force": slider("force F [N]", force, 0.05, 8.0, 0.01, 2),
        "rate": slider("rate of a sweep [Hz/s]", rate, 0.1, 10.0, 0.1, 1),
    }
    with style():
        figure, axes = subplots(1, 1, alt="A test on the bench over the theory", width=9.0, height=4.6)
        theory = ResponseCurve(axes)
        axes.set_title("relative displacement z")
        look = {"linestyle": "none", "animated": True, "markersize": 4, "zorder": 3}
        (path,) = axes.plot([], [], color=BLACK, linewidth=0.8, animated=True, label="in order", zorder=2.5)
        (settled,) = axes.plot([], [], "o", color=BLACK, **look, label="settled, or in passing")
        (other,) = axes.plot([], [], "D", color=MOTIONS["subharmonic"], **look, label="another motion, or not settled")
        (jumps,) = axes.plot([], [], "v", color=ORANGE, **look | {"markersize": 9}, label="jump")
        (before,) = axes.plot([], [], ".", color=GREY, **look, label="the test before")
        figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=5)
    tests = []

    def place(force):
        now = [test for test in tests[-1:] if test.force[0] == force]
        earlier = [test for test in tests[-2:-1] if now and test.force[0] == force]
        path.set_data(*_points([run for test in now for run in test.runs]))
        before.set_data(*_points(earlier))
        settled.set_data(*_points(now, _on_orbit))
        other.set_data(*_points(now, lambda test: ~_on_orbit(test)))
        found = [jump.frequency for test in now for jump in test.jumps]
        jumps.set_data(found, [0.005] * len(found))

    def update(protocol, force, rate):
        words = theory.show(parameters, force)
        place(force)
        swept = f" at {rate:.1f} Hz/s, {(_HIGH - _LOW) / rate / 60:.1f} min on the bench" if "swept" in protocol else ""
        return f"{words} Press <b>Test</b> for a test {protocol}{swept}."

    def act(report, protocol, force, rate):
        tests.append(_tested(parameters, protocol, force, rate, report))
        words = theory.show(parameters, force)
        place(force)
        at = ", ".join(f"{jump.frequency:.2f} Hz (z {jump.amplitude})" for jump in tests[-1].jumps)
        return f"<b>{tests[-1].summary()}</b>. Jumps: {at or 'none'}.<br>{words}"

    return LivePanel(figure, controls, update, action=act, label="Test", reset_label=reset_label(parameters))


def _tested(parameters, protocol, force, rate, report):
    how, _, way = protocol.partition(" ")
    turn = slice(None, None, -1) if way == "down" else slice(None)
    if how == "swept":
        return swept_test(parameters, force, np.array([_LOW, _HIGH])[turn], rate, progress=report)
    if how == "stepped":
        frequency = np.arange(_LOW, _HIGH + _APART / 2, _APART)[turn]
        return stepped_test(parameters, force, frequency, limit=10.0, progress=report)
    frequency = np.arange(_LOW, _HIGH + _TAPPED / 2, _TAPPED)[:, None]
    return tapped_test(parameters, force, frequency, limit=10.0, progress=report)


def _on_orbit(test):
    return np.isin(test.status, (Status.SETTLED, Status.PASSING))


def _points(tests, which=lambda test: np.ones(len(test), dtype=bool)):
    """Frequencies (Hz) and amplitudes of z (mm) of the chosen points, with NaN between the tests."""
    frequency, amplitude = [], []
    for test in tests:
        frequency += [*test.frequency[which(test)], np.nan]
        amplitude += [*1e3 * abs(test.relative[which(test)]), np.nan]
    return frequency, amplitude
