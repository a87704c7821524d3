"""Live panels driven without a browser: a control is set, and picture and words answer."""

import io
import re
import time

import numpy as np
import pytest
from numpy.testing import assert_allclose
from PIL import Image

from rigsim.experiment.record import Record
from rigsim.identification.identify import identify
from rigsim.identification.terms import Power, Term
from rigsim.model.planar import linear_modes, static_equilibrium
from rigsim.parameters import OscillatorParameters, RigParameters
from rigsim.present.explore import (
    LivePanel,
    identification_panel,
    protocol_panel,
    record_panel,
    response_panel,
    rig_panel,
    shake_panel,
)
from rigsim.present.figures.style import MOTIONS, style, subplots
from rigsim.theory.amplitude import frequency_response
from rigsim.theory.detached import detached_curves
from tests.identification.cubic import cubic_record

PANELS = [response_panel, rig_panel, shake_panel, protocol_panel, identification_panel]


@pytest.fixture
def opened():
    """Opens panels, and closes them when the test ends."""
    panels = []

    def open_panel(function, *arguments, **options):
        panels.append(function(*arguments, **options))
        return panels[-1]

    yield open_panel
    for panel in panels:
        panel.close()


def pixels(panel):
    return np.asarray(Image.open(io.BytesIO(panel.image.value)))


def drawn(panel, axes=0):
    """The lines of one axes, by label."""
    return {line.get_label(): line for line in panel.figure.axes[axes].lines}


@pytest.mark.parametrize("function", PANELS)
def test_sliders_have_units_and_words_stand_below(opened, function):
    panel = opened(function)
    assert pixels(panel).shape[1] == 2 * int(panel.image.layout.width.removesuffix("px"))
    assert pixels(panel).shape[0] == 2 * int(panel.image.layout.height.removesuffix("px"))
    assert 'role="status"' in panel.message.value
    for control in panel.controls.values():
        if hasattr(control, "readout_format"):
            assert re.search(r"\[.+\]$", control.description), "a slider says its unit"
            assert len(control.description) <= 26, "and is not cut"


@pytest.mark.parametrize("function", PANELS)
def test_reset_brings_back_the_first_picture(opened, function):
    panel = opened(function)
    first = panel.image.value, panel.message.value, panel.values
    for control in panel.controls.values():
        control.value = control.max if hasattr(control, "max") else control.options[-1][1]
    assert panel.message.value != first[1]
    panel.reset.click()
    assert (panel.image.value, panel.message.value, panel.values) == first


@pytest.mark.parametrize("function", PANELS)
def test_only_a_rig_has_panels(function):
    with pytest.raises(ValueError, match="expected RigParameters"):
        function(OscillatorParameters(1, 1, 1, 1, 1, 1, 1))


@pytest.mark.parametrize(
    ("function", "name"), [(response_panel, "stretch"), (rig_panel, "offset"), (shake_panel, "stretch")]
)
def test_update_moves_the_artists_and_nothing_else(opened, function, name):
    panel = opened(function)
    before, took = pixels(panel), []
    for value in (4.0, 6.0, 8.0):
        begin = time.perf_counter()
        panel.controls[name].value = value
        took.append(time.perf_counter() - begin)
    print(f"{function.__name__}: {1e3 * min(took):.0f} ms an update")
    after = pixels(panel)
    inside = np.zeros(after.shape[:2], dtype=bool)
    for axes in panel.figure.axes:
        left, bottom, width, height = axes.bbox.bounds
        top = after.shape[0] - bottom - height
        inside[int(top) - 8 : int(top + height) + 8, int(left) - 8 : int(left + width) + 8] = True
    changed = (before != after).any(axis=2)
    assert changed[inside].any()
    assert not changed[~inside].any(), "labels, ticks and legend stay where they are"


def test_response_is_the_theory(opened):
    rig = RigParameters()
    panel = opened(response_panel, rig)
    (curve,) = detached_curves(rig, 3.18)
    assert f"one inner detached curve, {curve.low:.2f} to {curve.high:.2f} Hz" in panel.message.value
    panel.controls["force"].value = 4.0
    panel.controls["damping"].value = 0.02
    panel.controls["mass"].value = 6.0
    rig = rig.replace(c=0.02, m=0.006)
    (curve,) = detached_curves(rig, 4.0)
    assert f"{curve.low:.2f} to {curve.high:.2f} Hz" in panel.message.value
    for quantity in ("relative", "mass", "shaker"):
        panel.controls["quantity"].value = quantity
        theory = frequency_response(rig, 4.0, [30.0])
        solid, dashed = drawn(panel)["stable"], drawn(panel)["unstable"]
        for amplitude, stable in zip(1e3 * abs(getattr(theory, quantity)[0]), theory.stable[0], strict=True):
            frequency, height = (solid if stable else dashed).get_data()
            assert_allclose(np.nanmin(abs(height[frequency == 30.0] / amplitude - 1)), 0, atol=1e-9)


def test_stretch_is_the_wires_tension(opened):
    panel = opened(response_panel)
    panel.controls["stretch"].value = 20.0
    rig = RigParameters(d0=0.034 - 20e-6)
    expected = 1e3 * abs(frequency_response(rig, 3.18, [60.0]).relative[0, 0])
    frequency, height = drawn(panel)["stable"].get_data()
    assert_allclose(np.nanmin(abs(height[frequency == 60.0] / expected - 1)), 0, atol=1e-8)


def test_detached_curve_is_said_and_shaded_until_it_dies(opened):
    panel = opened(response_panel)
    orange, purple = panel.figure.axes[0].collections
    assert len(orange.get_paths()) == 1 and not purple.get_paths()
    panel.controls["force"].value = 6.5
    assert "no detached curve" in panel.message.value and not orange.get_paths()
    panel.controls["force"].value = 1.5
    assert "one outer detached curve" in panel.message.value and len(purple.get_paths()) == 1


def test_impossible_settings_leave_the_picture_and_say_why(opened):
    panel = opened(shake_panel, RigParameters(set_half_spacing=0.009))
    picture = panel.image.value
    panel.controls["offset"].value = 6.0
    assert 'role="alert"' in panel.message.value and "set_half_spacing = 0.009 m is not allowed" in panel.message.value
    assert panel.image.value == picture and "rigsim-stale" in panel.image._dom_classes
    panel.start.click()
    panel.wait()
    assert "set_half_spacing = 0.009 m is not allowed" in panel.message.value and not panel.start.disabled
    panel.reset.click()
    assert 'role="status"' in panel.message.value and "rigsim-stale" not in panel.image._dom_classes


def test_impossible_from_the_start_shows_the_axes(opened):
    panel = opened(response_panel, RigParameters(cs=0.0))
    assert "Not possible" in panel.message.value and "cs" in panel.message.value
    assert pixels(panel).std() > 0


def test_unexpected_errors_are_shown_and_raised():
    def update():
        raise ZeroDivisionError("<nothing> to divide by")

    with style():
        figure, _ = subplots(alt="Nothing")
    panel = LivePanel(figure, {}, lambda: "words")
    panel._update = update
    with pytest.raises(ZeroDivisionError):
        panel._changed()
    assert "&lt;nothing&gt; to divide by" in panel.message.value
    panel.close()


def test_rig_hangs_as_statics_say(opened):
    panel = opened(rig_panel, exaggeration=1)
    panel.controls["offset"].value = 5.0
    panel.controls["sets"].value = 1
    rig = RigParameters(LG=0.005).single_set()
    at, modes = static_equilibrium(rig), linear_modes(rig)
    assert f"tilts by {np.degrees(-at.tilt):.3g}°</b> clockwise" in panel.message.value
    for frequency in modes.frequency:
        assert f"{frequency:.4g} Hz" in panel.message.value
    assert "<b>inside</b> the paper's test" in panel.message.value
    P, G = (drawn(panel)[name].get_xydata()[0] for name in ("P", "centre of mass"))
    assert_allclose(np.arctan2(*(G - P)[::-1]), at.tilt, rtol=1e-6)
    panel.controls["exaggeration"].value = 10
    P, G = (drawn(panel)[name].get_xydata()[0] for name in ("P", "centre of mass"))
    assert_allclose(np.arctan2(*(G - P)[::-1]), 10 * at.tilt, rtol=1e-6)
    assert panel.figure.axes[0].texts[0].get_text().endswith("drawn 10 times as large")
    panel.controls["exaggeration"].value = 1000
    assert panel.figure.axes[0].texts[0].get_text().endswith("drawn 10 times as large"), "1000 would turn it over"


def test_spacing_of_the_sets_holds_the_tilt(opened):
    panel = opened(rig_panel)
    panel.controls["spacing"].value = 20.0
    at = static_equilibrium(RigParameters(set_half_spacing=0.2 * 0.009375))
    assert f"tilts by {np.degrees(-at.tilt):.3g}°" in panel.message.value
    assert "3.75 mm apart" in panel.message.value


def test_single_set_given_can_become_two(opened):
    panel = opened(rig_panel, RigParameters().single_set())
    assert panel.reset.description == "Rig as given"
    panel.controls["sets"].value = 2
    at = static_equilibrium(RigParameters())
    assert f"tilts by {np.degrees(-at.tilt):.3g}°" in panel.message.value


def test_shaking_puts_a_circle_on_the_theory(opened):
    panel = opened(shake_panel)
    seen = []
    panel.progress.observe(lambda change: seen.append((change.new, panel.start.description)), "value")
    panel.start.click()
    panel.wait()
    assert "30.0 Hz, two wire sets, from rest: <b>settled, on the low branch</b>" in panel.message.value
    assert (1.0, "Stop") in seen and panel.start.description == "Shake" and panel.progress.layout.visibility == "hidden"
    low = 1e3 * abs(frequency_response(RigParameters(), 3.18, [30.0]).relative[0, 0])
    circles = drawn(panel)["rig: low"]
    assert_allclose(circles.get_xydata(), [[30.0, low]], rtol=2e-2)
    panel.controls["force"].value = 3.0
    assert not circles.get_xydata().size and drawn(panel)["other settings"].get_xydata().shape == (1, 2)
    panel.controls["force"].value = 3.18
    panel.controls["tap"].value = 0.5
    panel.controls["duration"].value = 6.0
    panel.start.click()
    panel.wait()
    assert "tap 0.5 m/s" in panel.message.value and "on the high branch" in panel.message.value
    high = drawn(panel)["rig: high"]
    assert circles.get_xydata().shape == high.get_xydata().shape == (1, 2) and high.get_ydata()[0] > 4 * low
    assert (circles.get_color(), high.get_color()) == (MOTIONS["low"], MOTIONS["high"])


def long_test(panel):
    panel.controls["duration"].options = (3.0, 3000.0)
    panel.controls["duration"].value = 3000.0


def test_slow_work_is_stopped_by_its_button_and_shows_what_was_moved_meanwhile(opened):
    panel = opened(shake_panel)
    picture = panel.image.value
    long_test(panel)
    panel.start.click()
    assert panel.start.description == "Stop" and panel.progress.layout.visibility == "visible"
    panel.controls["force"].value = 2.0  # not shown before the work is over
    time.sleep(0.5)
    assert panel.start.description == "Stop" and "3.18 N" in panel.message.value
    panel.start.click()
    begun = time.perf_counter()
    panel.wait(10)
    assert time.perf_counter() - begun < 2
    assert panel.start.description == "Shake" and not panel.start.disabled
    assert "2 N" in panel.message.value and panel.image.value != picture


def test_what_is_stopped_says_so_and_closing_stops(opened):
    panel = opened(shake_panel)
    long_test(panel)
    panel.start.click()
    panel.start.click()
    panel.wait(10)
    assert "<b>Stopped</b>" in panel.message.value
    panel.start.click()
    begun = time.perf_counter()
    panel.close()
    assert time.perf_counter() - begun < 2


def test_a_test_on_the_bench_is_drawn_with_its_jump_and_the_one_before_stays(opened):
    panel = opened(protocol_panel, rate=5.0)
    panel.controls["protocol"].value = "swept down"
    panel.start.click()
    panel.wait()
    assert "swept_test" in panel.message.value and "(z rises)" in panel.message.value
    lines = drawn(panel)
    swept = lines["settled, or in passing"].get_xydata()
    assert len(swept) > 40 and swept[0, 0] > 75 and 50 < lines["jump"].get_xdata()[0] < 57
    assert not lines["the test before"].get_xydata().size
    panel.controls["protocol"].value = "swept up"
    panel.start.click()
    panel.wait()
    np.testing.assert_array_equal(lines["the test before"].get_xydata(), swept)
    panel.controls["force"].value = 2.0
    assert not lines["settled, or in passing"].get_xydata().size


def test_spectrum_is_that_of_the_last_test(opened):
    panel = opened(shake_panel, frequency=40.0)
    panel.start.click()
    panel.wait()
    frequency, amplitude = panel.figure.axes[1].lines[0].get_data()
    assert panel.figure.axes[1].get_xlim() == (0, 160)
    assert_allclose(frequency[np.argmax(amplitude)], 40.0, atol=0.1)
    assert_allclose(amplitude.max(), drawn(panel)["last test"].get_ydata()[0], rtol=0.01)


def test_identification_of_a_clean_and_of_a_noisy_test(opened):
    panel = opened(identification_panel, duration=4.0)
    panel.start.click()
    panel.wait()
    assert panel.progress.value == 1.0
    (error,) = re.findall(r"k3 off by (\S+) %", panel.message.value)
    assert abs(float(error)) < 0.2
    assert all(f"<th>{name}</th>" in panel.message.value for name in ("ms", "ks", "cs", "m", "c", "k1", "k3"))
    clean = drawn(panel)["this test"].get_ydata()
    panel.controls["noise"].value = 2.0
    panel.start.click()
    panel.wait()
    assert_allclose(drawn(panel)["test before"].get_ydata(), clean)
    (noisy,) = re.findall(r"k3 off by (\S+) %", panel.message.value)
    assert abs(float(noisy)) > abs(float(error))
    assert "2 % noise" in panel.message.value


def test_a_record_is_read_with_other_settings(opened):
    record = cubic_record(duration=10, noise=0.01)
    first = identify(record)
    panel = opened(record_panel, record, first)
    known, these = (bars.lines[0] for bars in panel.figure.axes[1].containers)
    assert_allclose(known.get_ydata(), 0)
    panel.controls["term"].value = "quintic spring"
    panel.controls["high"].value = 70.0
    assert "quintic spring" in panel.message.value and "2 to 70 Hz" in panel.message.value
    panel.start.click()
    panel.wait()
    again = identify(record, band=(2, 70), terms=(Term("k5", (0, 1), Power(5)),))
    off = 100 * (again.errors.value[:7] / first.errors.value - 1)
    assert_allclose(these.get_ydata(), off, rtol=1e-6, atol=1e-9)
    assert "k5 = " in panel.message.value and "not seen in this record" in panel.message.value
    assert panel.progress.value == 1.0


def test_a_record_that_no_rig_repeats_says_so_in_its_panel(opened):
    noise = np.random.default_rng(0).standard_normal((3, 10_000))
    panel = opened(record_panel, Record(noise[0], 1e-4 * noise[1], 1e-4 * noise[2], 2000))
    panel.start.click()
    panel.wait()
    assert "Not possible" in panel.message.value and "no rig of this kind" in panel.message.value
    with pytest.raises(ValueError, match="expected a Record"):
        record_panel(RigParameters())


def test_closing_takes_every_widget_away():
    panel = response_panel()
    parts = [panel, panel.image, panel.message, panel.reset, *panel.controls.values()]
    assert all(part.comm is not None for part in parts)
    panel.close()
    assert all(part.comm is None for part in parts)
