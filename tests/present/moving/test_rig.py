"""The rig in motion: every frame is where the record says, to scale, and the words agree with it."""

import json
import re

import numpy as np
import pytest

from rigsim.experiment.random_test import simulate
from rigsim.experiment.record import Record
from rigsim.experiment.sine_test import sine_test
from rigsim.model import spatial
from rigsim.model.planar import static_equilibrium
from rigsim.parameters import RigParameters
from rigsim.present.figures.style import GREY
from rigsim.present.moving import rig as module
from rigsim.present.moving.rig import rig_animation, rig_motion
from rigsim.present.moving.views import tension_key

RIG = RigParameters()
SINGLE = RIG.single_set()
RATE = 2000.0


@pytest.fixture(scope="module")
def records():
    force = 3.18 * np.cos(2 * np.pi * 30 * np.arange(400) / RATE)
    return [simulate(rig, force, RATE, hold="linear", start="equilibrium") for rig in (SINGLE, RIG)]


def curves(panel, label, kind=None):
    """Points of the one curve of that label (and kind) in each frame, shape (frames, n, 2), in mm."""
    found = [
        [curve for curve in group if curve.label == label and kind in (None, curve.kind)] for group in panel.curves
    ]
    assert all(len(group) == 1 for group in found)
    return np.array([np.column_stack([group[0].x, group[0].y]) for group in found])


def wires(panel, *kinds):
    """Of each frame its wires as (begin, end, colour), in mm, from the lowest pin to the highest."""
    frames = []
    for group in panel.curves:
        drawn = [(np.column_stack([c.x, c.y]), c.color) for c in group if c.kind in kinds]
        ends = [(*p[i : i + 2], color) for p, color in drawn for i in range(0, len(p), 3) if np.isfinite(p[i, 0])]
        frames.append(sorted(ends, key=lambda one: (one[0][1], one[0][0])))
    return frames


def test_frames_are_the_records_own(records):
    frames = 9
    moving = rig_animation(SINGLE, records[0], 0.1, 0.12, frames, exaggeration=3, displacement=1)
    drawing, tilt = moving.panels
    np.testing.assert_allclose(moving.values, np.linspace(100, 120, frames))
    at = np.round(np.linspace(0.1, 0.12, frames) * RATE).astype(int)  # every fifth sample
    P = curves(drawing, "P")[:, 0]
    np.testing.assert_allclose(P[:, 0], 1e3 * records[0].mass[at], atol=1e-9)
    assert np.all(abs(P[:, 1]) < 2e-3), "micrometres: it is where the wires carry the mass"
    frame = curves(drawing, "frame")
    np.testing.assert_allclose(np.diff(frame[:, 0, 0]), 1e3 * np.diff(records[0].shaker[at]), atol=1e-9)
    mass = curves(drawing, "suspended mass")
    turned = np.arctan2(mass[:, 1, 1] - mass[:, 0, 1], mass[:, 1, 0] - mass[:, 0, 0])
    np.testing.assert_allclose(turned, 3 * records[0].tilt[at], atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(mass[:, 1] - mass[:, 0], axis=-1), 1e3 * SINGLE.Lm)
    dots = np.array([[group[0].x[0], group[0].y[0]] for group in tilt.curves])
    np.testing.assert_allclose(dots, np.column_stack([moving.values, np.degrees(records[0].tilt[at])]), atol=1e-9)


def test_displacements_are_drawn_as_large_as_is_said(records):
    once, many = (rig_animation(RIG, records[1], 0.1, 0.12, 5, displacement=factor) for factor in (1, 7))
    for name in ("frame", "P"):
        drawn = [np.diff(curves(moving.panels[0], name)[:, 0, 0]) for moving in (once, many)]
        np.testing.assert_allclose(drawn[1], 7 * drawn[0], atol=1e-9)
    assert "Displacements drawn 7 times as large" in many.caption and "Displacements to scale" in once.caption
    chosen = rig_animation(RIG, records[1], 0.1, None, 5)
    factor = float(re.search(r"Displacements drawn (\S+) times", chosen.caption)[1])
    largest = max(abs(getattr(records[1], name)[200:]).max() for name in ("shaker", "mass", "relative"))
    assert 0.05 < factor * largest / (RIG.Rm + RIG.d) <= 0.15 * 1.01


def test_wires_end_on_the_frame_and_on_the_mass(records):
    drawing = rig_animation(RIG, records[1], 0.1, 0.15, 6).panels[0]
    frame, mass = (curves(drawing, name) for name in ("frame", "suspended mass"))
    shown = wires(drawing, "wire")
    assert all(len(each) == 4 for each in shown)
    begins, ends = (np.array([[wire[i] for wire in each] for each in shown]) for i in (0, 1))
    assert np.ptp(begins[:, 0, 0] - frame[:, 0, 0]) < 1e-9, "frame pins move with the frame"
    assert np.isin(begins[:, :, 1].round(6), frame[0, :, 1].round(6)).all()
    along = mass[:, 1] - mass[:, 0]
    normal = np.stack([-along[:, 1], along[:, 0]], axis=-1) / (1e3 * RIG.Lm)
    height = np.einsum("fwc,fc->fw", ends - mass[:, None, 0], normal)
    np.testing.assert_allclose(height, np.tile([0, 0, 2e3 * RIG.Rm, 2e3 * RIG.Rm], (6, 1)), atol=1e-9)


def test_colours_tell_tensions_by_the_key(records):
    """Against lengths of wires between pins placed here, by hand, at the height of P that a still rig has."""
    moving = rig_animation(RIG, records[1], 0.1, 0.15, 26, displacement=1, exaggeration=1)
    limits, colors = moving.key.limits, moving.key.colors
    assert 3 <= len(colors) <= 7 and len(set(colors)) == len(colors) == len(limits) - 1
    sag, agreed = static_equilibrium(RIG).sag, []
    for t, each in zip(moving.values / 1e3, wires(moving.panels[0], "wire"), strict=True):
        z = np.interp(t, records[1].time, records[1].relative)
        for (_, y), _, color in each:
            tension = 4e4 * (np.hypot(z, RIG.d + np.sign(y) * sag) - RIG.d0)
            near = abs(limits - tension).min() < 0.03 * tension  # the ringing of the rig is not in ``sag``
            agreed.append(near or color == colors[np.searchsorted(limits, tension) - 1])
    assert all(agreed) and len(agreed) == 26 * 4
    assert "tension of a wire [N]" == moving.key.label and "Wires carry" in moving.alt


@pytest.mark.parametrize(("tension_only", "word"), [(True, "slack wire"), (False, "wire that pushes")])
def test_wires_that_go_slack_are_dashed_and_grey(tension_only, word):
    loose = RIG.replace(d0=RIG.d - 1e-7, tension_only=tension_only)
    force = 3.18 * np.cos(2 * np.pi * 30 * np.arange(400) / RATE)
    moving = rig_animation(loose, simulate(loose, force, RATE, start="equilibrium"), 0.1, 0.15, 26)
    slack, taut = wires(moving.panels[0], "slack"), wires(moving.panels[0], "wire")
    counts = [len(each) for each in slack]
    assert max(counts) == 2 and min(counts) == 0, "the lower ones, where the mass passes the middle"
    assert all(len(a) + len(b) == 4 for a, b in zip(slack, taut, strict=True))
    assert {color for each in slack for *_, color in each} == {GREY}
    assert all(begin[1] < 0 for each in slack for begin, *_ in each)
    assert {c.label for group in moving.panels[0].curves for c in group if c.kind == "slack"} == {word}


def test_tension_key_holds_what_it_is_given():
    for tensions in ([0.12, 5.2], [0.097, 0.3], [1e-5, 3.0], [2.0, 2.0], [0.5, 1.0], [0.0, -1.0]):
        limits = tension_key([np.array(tensions)]).limits
        assert np.all(np.diff(limits) > 0) and len(limits) <= 8
        taut = [one for one in tensions if one > 0]
        assert not taut or limits[0] <= min(taut) and max(taut) <= limits[-1] * (1 + 1e-9)


def test_rigs_side_by_side_share_one_slider(records):
    moving = rig_animation([SINGLE, RIG], records, 0.1, 0.15, 12, exaggeration=2)
    assert [panel.title for panel in moving.panels[:2]] == ["One wire set", "Two wire sets"]
    html = moving._repr_html_()
    data = json.loads(re.search(r'<script type="application/json">(.*?)</script>', html)[1])
    assert html.count('type="range"') == 1 and ">Play</button>" in html and len(data["paths"]) > 10
    assert all(len(set(texts)) > 1 for texts in data["paths"]), "every path given for all frames moves"
    assert "http" not in re.sub(r'(xmlns(:\w+)?|rdf:\w+)="[^"]*"', "", html.split("<svg")[0]), "nothing from elsewhere"
    assert "angles drawn 2 times as large" in html and "times slower than real time" in html
    assert "P is not recorded" in html and re.search(r"0\.1\d MB of this page", html)
    one, two = re.findall(r"its tilt goes from (\S+) to (\S+) degrees", moving.alt)
    assert abs(float(one[0])) > 1 and abs(float(two[0])) < 0.01
    assert moving.notes[0].startswith("One wire set: xs ") and "one wire set may yaw" in moving.caption
    assert moving.panels[2].ylim == moving.panels[3].ylim, "tilts are compared on one scale"


def test_records_of_unequal_length_are_shown_while_both_last(records):
    half = Record(*(getattr(records[1], name)[:200] for name in ("force", "shaker", "mass")), RATE,
                  tilt=records[1].tilt[:200])  # fmt: skip
    moving = rig_animation([RIG, RIG], [half, records[1]], frames=4, titles=["half", "whole"])
    assert moving.values[-1] == pytest.approx(1e3 * half.time[-1])
    np.testing.assert_allclose(*(curves(panel, "P") for panel in moving.panels[:2]), rtol=0, atol=1e-6)
    assert moving.notes[0].startswith("half: ") and "; whole: " in moving.notes[0]


def test_phase_portrait_and_spectrum_are_of_the_same_window():
    time, a, f = np.arange(4000) / 4000, 2e-3, 40.0
    z = a * np.cos(2 * np.pi * f * time)
    sine = Record(np.zeros(4000), z, 0 * z, 4000.0, tilt=0 * z)
    moving = rig_animation(RIG, sine, 0.2, 0.5, 13, channel=["phase portrait", "spectrum"])
    _, phase, spectrum = moving.panels
    at = moving.values / 1e3
    dots = np.array([[group[0].x[0], group[0].y[0]] for group in phase.curves])
    w = 2 * np.pi * f
    exact = np.column_stack([1e3 * a * np.cos(w * at), -a * w * np.sin(w * at)])
    np.testing.assert_allclose(dots, exact, atol=2e-3 * abs(exact).max())
    np.testing.assert_allclose(np.hypot(phase.fixed[0].x / (1e3 * a), phase.fixed[0].y / (a * w)), 1, atol=2e-3)
    line = spectrum.fixed[0]
    assert line.x[line.y.argmax()] == pytest.approx(f, abs=0.1) and line.y.max() == pytest.approx(1e3 * a, rel=1e-3)
    assert spectrum.xlim[1] == pytest.approx(6 * f, rel=0.01) and not any(spectrum.curves)
    assert "phase portrait, spectrum" in moving.alt


def test_a_rig_that_leaves_the_plane_is_seen_from_above_too():
    record = sine_test(SINGLE, 3.18, 20.0).in_space(0)
    moving = rig_animation(SINGLE, record, stop=0.1, frames=11, exaggeration=1, displacement=1, channel="yaw")
    side, above, yaw = moving.panels
    assert above.downwards and above.ylabel == "out of the plane [mm]" and above.title.endswith("from above")
    _, true, tilt = spatial.angles(record.states)
    at = np.round(moving.values / 1e3 * record.sample_rate).astype(int)
    np.testing.assert_allclose([group[0].y[0] for group in yaw.curves], np.degrees(true[at]), atol=1e-9)
    assert abs(true[at]).max() > 0.03 and "may yaw" not in moving.caption
    for panel, angle in ((side, tilt), (above, -true)):
        axis = curves(panel, "centre of mass")[:, 0] - curves(panel, "P")[:, 0]
        np.testing.assert_allclose(np.arctan2(axis[:, 1], axis[:, 0]), angle[at], atol=2e-4)
        shown = wires(panel, "wire")
        assert all(len(each) == 2 for each in shown)
    # Both ends of a wire that is seen end on from one place are pins of the other view.
    pins = curves(above, "", "dot")
    np.testing.assert_allclose(pins[:, :2, 0] - pins[:, :1, 0], 0, atol=1e-9)
    long = np.linalg.norm(np.diff([one[:2] for one in wires(above, "wire")[0]], axis=1), axis=-1)
    np.testing.assert_allclose(long, 1e3 * SINGLE.d, atol=0.05)
    outline = curves(side, "suspended mass")
    reach = np.array([np.ptp(one @ [np.cos(t), np.sin(t)]) for one, t in zip(outline, tilt[at], strict=True)])
    cos, sin = np.cos(true[at]), abs(np.sin(true[at]))
    np.testing.assert_allclose(reach, 1e3 * (SINGLE.Lm * cos + 2 * SINGLE.Rm * sin), rtol=0.02)


def test_relative_displacement_may_stand_beside(records):
    panel = rig_animation(RIG, records[1], 0.1, 0.15, 6, channel="relative").panels[1]
    shown = (records[1].time >= 0.1) & (records[1].time <= 0.15)
    np.testing.assert_allclose(panel.fixed[0].y, 1e3 * records[1].relative[shown])
    assert panel.ylabel == "z [mm]" and panel.ylim[0] < panel.fixed[0].y.min() < panel.fixed[0].y.max() < panel.ylim[1]


def test_an_animation_that_fills_a_page_is_refused(records, monkeypatch):
    monkeypatch.setattr(module, "_MEGABYTES", 0.1)
    assert rig_animation(RIG, records[1], frames=5).megabytes < 0.1
    with pytest.raises(ValueError, match="frames = 100 makes 0.* MB of a page; expected at most 0.1 MB: fewer frames"):
        rig_animation(RIG, records[1], frames=100)


def test_motion_of_a_resting_record_is_rest():
    still = Record(np.zeros(20), np.zeros(20), np.zeros(20), RATE, tilt=np.zeros(20))
    time, states = rig_motion(RIG, still, frames=4)
    hanging = [[0, RIG.LG, -static_equilibrium(RIG).sag]] * 4
    np.testing.assert_allclose(states[:, :3], hanging, atol=1e-8)  # the tilt at rest is not zero
    assert not spatial.angles(states)[2].any()
    assert time[0] == 0 and time[-1] == pytest.approx(still.time[-1])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda record: rig_animation(RIG.oscillator, record), "no shape to draw"),
        (lambda record: rig_animation(RIG, Record([0, 1], [0, 1], [0, 1], 10.0)), "record has no tilt"),
        (lambda record: rig_animation(RIG, record.replace(kinds={"mass": "velocity"})), "mass, tilt in N, m, m/s, rad"),
        (lambda record: rig_animation(RIG, record, stop=1.0), "stop = 1 s"),
        (lambda record: rig_animation(RIG, record, start=-1.0), "start = -1 s"),
        (lambda record: rig_animation(RIG, record, start=0.1, stop=0.1), "stop = 0.1 s"),
        (lambda record: rig_animation(RIG, record, frames=1), "frames = 1"),
        (lambda record: rig_animation(RIG, record, exaggeration=-2), "exaggeration = -2"),
        (lambda record: rig_animation(RIG, record, exaggeration="more"), "exaggeration = 'more'.*'auto'"),
        (lambda record: rig_animation(RIG, record, displacement=0), "displacement = 0"),
        (lambda record: rig_animation(RIG, record, channel="force"), "channel = 'force'"),
        (lambda record: rig_animation(RIG, record, channel=[]), "channel is empty"),
        (lambda record: rig_animation(RIG, record, stop=5e-3, channel="spectrum"), "stop = 0.005 s leaves 11 samples"),
        (lambda record: rig_animation([RIG], [record] * 2), "record has 2 elements for 1 rigs"),
    ],
)
def test_bad_input_is_named(records, make, message):
    with pytest.raises(ValueError, match=message):
        make(records[1])
