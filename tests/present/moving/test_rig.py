"""The rig in motion: every frame is where the record says, to scale, and the words agree with it."""

import json
import re

import numpy as np
import pytest

from rigsim.experiment.random_test import simulate
from rigsim.experiment.record import Record
from rigsim.model.planar import rest_position
from rigsim.parameters import RigParameters
from rigsim.present.moving.rig import rig_animation, rig_motion

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


def test_frames_are_the_records_own(records):
    frames = 9
    moving = rig_animation(SINGLE, records[0], 0.1, 0.12, frames, exaggeration=3)
    drawing, tilt = moving.panels
    np.testing.assert_allclose(moving.values, np.linspace(100, 120, frames))
    at = np.round(np.linspace(0.1, 0.12, frames) * RATE).astype(int)  # every fifth sample
    P = curves(drawing, "P")[:, 0]
    np.testing.assert_allclose(P[:, 0], 1e3 * records[0].mass[at], atol=1e-9)
    np.testing.assert_allclose(P[:, 1], 0, atol=1e-12)
    frame = curves(drawing, "frame")
    np.testing.assert_allclose(np.diff(frame[:, 0, 0]), 1e3 * np.diff(records[0].shaker[at]), atol=1e-9)
    mass = curves(drawing, "suspended mass")
    turned = np.arctan2(mass[:, 1, 1] - mass[:, 0, 1], mass[:, 1, 0] - mass[:, 0, 0])
    np.testing.assert_allclose(turned, 3 * records[0].tilt[at], atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(mass[:, 1] - mass[:, 0], axis=-1), 1e3 * SINGLE.Lm)
    dots = np.array([[group[0].x[0], group[0].y[0]] for group in tilt.curves])
    np.testing.assert_allclose(dots, np.column_stack([moving.values, np.degrees(records[0].tilt[at])]), atol=1e-9)


def test_wires_end_on_the_frame_and_on_the_mass(records):
    drawing = rig_animation(RIG, records[1], 0.1, 0.15, 6).panels[0]
    wires, frame, mass = (curves(drawing, name) for name in ("wires", "frame", "suspended mass"))
    begins, ends = wires[:, ::3], wires[:, 1::3]
    shaker = frame[:, 0, 0] - frame[:, 0, 0].mean()
    assert np.ptp(begins[:, 0, 0] - shaker) < 1e-12, "frame pins move with the frame"
    assert np.isin(begins[:, :, 1].round(6), frame[0, :, 1].round(6)).all()
    along = mass[:, 1] - mass[:, 0]
    normal = np.stack([-along[:, 1], along[:, 0]], axis=-1) / (1e3 * RIG.Lm)
    height = np.einsum("fwc,fc->fw", ends - mass[:, None, 0], normal)
    np.testing.assert_allclose(height, np.tile([2e3 * RIG.Rm, 0], (6, 2)), atol=1e-9)


def test_rigs_side_by_side_share_one_slider(records):
    moving = rig_animation([SINGLE, RIG], records, 0.1, 0.15, 12, exaggeration=2)
    assert [panel.title for panel in moving.panels[:2]] == ["One wire set", "Two wire sets"]
    html = moving._repr_html_()
    data = json.loads(re.search(r'<script type="application/json">(.*?)</script>', html)[1])
    assert html.count('type="range"') == 1 and ">Play</button>" in html and len(data["paths"]) > 10
    assert all(len(set(texts)) > 1 for texts in data["paths"]), "every path given for all frames moves"
    assert "http" not in re.sub(r'(xmlns(:\w+)?|rdf:\w+)="[^"]*"', "", html.split("<svg")[0]), "nothing from elsewhere"
    assert "tilt drawn 2 times as large" in html and "times slower than real time" in html
    assert "P is not recorded" in html
    one, two = re.findall(r"its tilt goes from (\S+) to (\S+) degrees", moving.alt)
    assert abs(float(one[0])) > 1 and abs(float(two[0])) < 0.01
    assert moving.notes[0].startswith("One wire set: xs ")
    assert moving.panels[2].ylim == moving.panels[3].ylim, "tilts are compared on one scale"


def test_relative_displacement_may_stand_beside(records):
    panel = rig_animation(RIG, records[1], 0.1, 0.15, 6, channel="relative").panels[1]
    shown = (records[1].time >= 0.1) & (records[1].time <= 0.15)
    np.testing.assert_allclose(panel.fixed[0].y, 1e3 * records[1].relative[shown])
    assert panel.ylabel == "z [mm]" and panel.ylim[0] < panel.fixed[0].y.min() < panel.fixed[0].y.max() < panel.ylim[1]


def test_motion_of_a_resting_record_is_rest():
    still = Record(np.zeros(20), np.zeros(20), np.zeros(20), RATE, tilt=np.zeros(20))
    time, coordinates = rig_motion(RIG, still, frames=4)
    np.testing.assert_allclose(coordinates, np.tile(rest_position(RIG), (4, 1)))
    assert time[0] == 0 and time[-1] == pytest.approx(still.time[-1])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda record: rig_animation(RIG.oscillator, record), "no shape to draw"),
        (lambda record: rig_animation(RIG, Record([0, 1], [0, 1], [0, 1], 10.0)), "record has no tilt"),
        (lambda record: rig_animation(RIG, record, stop=1.0), "stop = 1 s"),
        (lambda record: rig_animation(RIG, record, start=-1.0), "start = -1 s"),
        (lambda record: rig_animation(RIG, record, start=0.1, stop=0.1), "stop = 0.1 s"),
        (lambda record: rig_animation(RIG, record, frames=1), "frames = 1"),
        (lambda record: rig_animation(RIG, record, exaggeration=-2), "exaggeration = -2"),
        (lambda record: rig_animation(RIG, record, channel="force"), "channel = 'force'"),
        (lambda record: rig_animation([RIG], [record] * 2), "record has 2 elements for 1 rigs"),
    ],
)
def test_bad_input_is_named(records, make, message):
    with pytest.raises(ValueError, match=message):
        make(records[1])
