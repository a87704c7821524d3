"""Mistaken calls of everything public: each ends at once, in one line that names the argument, and nothing is begun.

Every argument of every public call is replaced, one at a time, by what people pass by mistake; what an argument of its
kind does allow of these is left out. Other spellings of a right value give the right answer.
"""

import inspect
import re
import time
import warnings
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pandas as pd
import pytest

import rigsim
from rigsim import (
    OscillatorParameters,
    Record,
    RigParameters,
    Tap,
    attractors,
    basins,
    existence_chart,
    explore,
    feedback_test,
    force_scenario,
    frequency_response,
    harmonics_worth,
    identify,
    integrity,
    linear_modes,
    margins,
    overlay,
    periodic_orbits,
    phase_locked_test,
    response_sheet,
    sine_test,
    static_equilibrium,
    tap_map,
    tolerance_study,
)  # fmt: skip
from rigsim.attraction.taps import SmallestTap
from rigsim.identification.jumps import Jump, parameters_from_jumps
from rigsim.identification.order import model_order
from rigsim.model.shaker import ShakerDrive
from rigsim.orbits.verdict import verdict as verdict_of
from rigsim.paper.ledger import Ledger, LedgerRow
from rigsim.parameters import Nondimensional
from rigsim.present.moving.plot import MovingPlot, Panel
from rigsim.theory.driven import driven_response

RIG = RigParameters()
LONGEST = 2.0  # s of any refusal; most take less than a millisecond
WORDS = 600  # characters of any refusal, at most

# What is passed by mistake, by name.
WRONG = {
    "text of a number": "3.18", "a word": "nonsense", "no text": "", "nothing": None, "true": True, "complex": 3 + 1j,
    "NaN": np.nan, "infinity": np.inf, "negative": -1.0, "zero": 0.0, "huge": 1e300, "tiny": 1e-300, "broken": 2.5,
    "many": 10**15, "no values": [], "a matrix": np.ones((2, 2)), "a cube": np.ones((2, 2, 2)),
    "three values": [3.0, 1.0, 2.0], "text in a list": ["3", "4"], "truth values": [True, False],
    "complex values": [1j, 2.0], "masked": np.ma.array([10.0, 20.0], mask=[0, 1]), "masked one": np.ma.masked,
    "NaN in a list": [1.0, np.nan], "ragged": [[1.0], [1.0, 2.0]], "objects": np.array([object(), None]),
    "dates": np.zeros(2, "M8[s]"), "a set": {1.0, 2.0}, "a dict": {"a": 1}, "a class": RigParameters,
    "an object": object(), "bytes": b"3", "a generator": "(made for each call)", "an object without a dimension":
    np.array(1.0, dtype=object), "a table": pd.DataFrame({"a": [1.0, 2.0]}), "text without a dimension": np.array("3"),
    "a date": pd.Timestamp("2014-07-01"), "a fraction below nought": Fraction(-1, 3), "not a decimal": Decimal("nan"),
}  # fmt: skip
SIGNS = {"negative", "zero", "tiny", "broken", "a fraction below nought"}

# Which of these each kind of argument allows, or may allow; a ? after a kind in a call stands for None as well.
ALLOWED = {
    "number": {"broken", "many"},  # above zero, within what a rig may have
    "not negative but zero": {"tiny", "broken"},
    "any": SIGNS | {"many"},
    "not negative": {"zero", "tiny", "broken", "many"},
    "stiffness": {"tiny", "broken", "many"},
    "in the cylinder": {"zero", "tiny"},
    "within, 2.5": {"broken"},
    "places": {"zero", "many", "three values"},
    "rows": {"broken", "many", "three values", "a matrix", "a table"},
    "texts": {"text of a number", "a word", "no text", "text in a list"},
    "phase": {"zero", "tiny"},
    "size": {"broken"},
    "within": set(),  # a range that holds none of them
    "whole": set(),
    "whole, many": {"many"},
    "seed": {"zero", "many"},
    "motion": {"zero"},
    "first samples": {"zero"},
    "known later": {"zero", "many", "text of a number", "a word", "no text"},
    "array": {"broken", "many", "three values"},
    "any array": SIGNS | {"many", "three values"},
    "any shape": SIGNS | {"many", "three values", "a matrix", "a cube", "no values", "a table"},
    "lines": SIGNS | {"many", "three values", "complex", "complex values"},
    "pair": set(),
    "word": set(),
    "text": {"text of a number", "a word", "no text"},
    "file": {"text of a number", "a word"},
    "object": set(),
    "objects": {"no values"},
    "flag": {"true"},
    "progress": {"true"},
}


@pytest.fixture(scope="module")
def made():
    """One small result of each kind, for their methods and figures."""
    low = np.array([28.0, 30.0, 32.0])
    found = attractors(RIG, 3.18, 30.0, starts=32)
    test = sine_test(RIG, 3.18, [30.0], duration=1)
    taps = tap_map(RIG, 3.18, 30.0, velocity=[-0.5, 0.0, 0.5], instants=4, starts=32)
    force = np.random.default_rng(1).standard_normal((3, 4000))
    record = Record(*force, 1000.0, tilt=np.zeros(4000))
    under_feedback = feedback_test(RIG, 3.18, 30.0, points=4, average=0.5, settle=0.1)
    bench = rigsim.stepped_test(RIG, 3.18, [30.0], dwell=1)
    orbits = periodic_orbits(RIG, 3.18, (20, 30), 1, search="seeds")
    row = LedgerRow("Table 1", "ms", "0.154", "kg", 0.154, "yes", "")
    return {
        "response": frequency_response(RIG, 3.18, low), "attractors": found, "test": test, "taps": taps,
        "smallest": SmallestTap(found, 0, 1, 0.5, 0.1, 2e-3, True, 1.0), "record": record,
        "feedback": under_feedback, "measured": under_feedback.at(2.0), "held": under_feedback[0],
        "locked": phase_locked_test(RIG, 0.1, average=0.5, patience=0.5),
        "overlay": overlay(RIG, test), "ledger": Ledger((row,), None), "scenario": force_scenario(RIG),
        "orbits": orbits, "bench": bench,
        "comparison": rigsim.compare_tests(orbits, bench), "margins": margins(RIG, 3.18, names=["m"]),
        "sheet": response_sheet(RIG, (20, 30), (3.0, 3.3), 1), "statics": static_equilibrium(RIG),
        "modes": linear_modes(RIG), "study": tolerance_study(RIG, 3.18, {"m": "1 %"}, samples=10),
        "converged": force_scenario(RIG, 2, band=(20, 30), force=(3.0, 3.3)),
        "drives": rigsim.compare_drives(RIG, 3.18, [30.0], ShakerDrive(), tap=None, duration=1),
        "map": rigsim.wobbling_map(RIG, {"LG": [0.0, 0.001]}),
        "integrity": integrity(RIG, 3.18, 30.0, samples=16, starts=16),
    }  # fmt: skip


# The kind of each argument, by its name, where a call does not say another.
KINDS = {
    "parameters": "object", "force": "number", "frequency": "array", "band": "pair", "law": "word?", "seed": "seed",
    "starts": "whole", "samples": "whole", "progress": "progress", "executor": "object?", "checkpoint": "file?",
    "harmonics": "whole", "period": "whole", "tolerance": "within", "kind": "word", "start": "word", "hold": "word",
    "step": "within", "duration": "within", "rms": "number", "sample_rate": "number", "motion": "motion",
    "tolerances": "object", "box": "within?", "rig": "object", "velocity": "any array", "instants": "whole",
    "relative": "lines", "tap": "object?", "names": "object?", "search": "word", "record": "object", "path": "file",
    "terms": "objects", "noise": "object?", "kinds": "object?", "channels": "object?", "units": "object?",
    "channel": "word", "what": "word?", "ax": "object?", "beside": "objects", "exaggeration": "number", "i": "whole",
    "sensors": "object?", "rate": "array?", "spacing": "word", "window": "within, 2.5", "pulse": "within",
    "drive": "object?",
}  # fmt: skip

RIGHT = {"parameters": RIG, "force": 3.18, "frequency": 30.0}
NUMBERS = dict.fromkeys(("ms", "ks", "m"), "number") | dict.fromkeys(("cs", "c", "k1", "k3"), "not negative")
LENGTHS = dict.fromkeys(("d", "Lm", "Rm"), "within, 2.5") | {"d0": "within", "LG": "in the cylinder"}
GROUPS = {"mu": "number"} | dict.fromkeys(("zeta_s", "zeta", "Omega0", "gamma"), "not negative")
RIG_KINDS = {name: kind for name, kind in NUMBERS.items() if name not in ("k1", "k3")} | LENGTHS | {
    "k": "stiffness", "wire_sets": "whole", "set_half_spacing": "in the cylinder?", "gravity": "not negative",
    "wire_damping": "not negative", "rocking_damping": "not negative", "tension_only": "flag",
    "set_centre": "in the cylinder", "d0": "number",
}  # fmt: skip


def functions(made):
    """(label, function, right arguments, kinds of some arguments) of public functions and sets of numbers."""
    oscillator = {"ms": 0.154, "ks": 1.88e4, "cs": 9.86, "m": 0.0052, "c": 0.026, "k1": 28.0, "k3": 1.4e8}
    groups = {"mu": 0.03, "zeta_s": 0.09, "zeta": 0.007, "Omega0": 0.2, "gamma": 0.006}
    channels = dict.fromkeys(("force", "shaker", "mass"), np.arange(4.0))
    tolerances = {"tolerances": {"m": "1 %"}}
    yield "OscillatorParameters", OscillatorParameters, oscillator, NUMBERS
    yield (
        "from_nondimensional",
        OscillatorParameters.from_nondimensional,
        groups,
        GROUPS | {"ms": "number", "ks": "number"},
    )
    yield "Nondimensional", Nondimensional, groups, GROUPS
    yield "RigParameters", RigParameters, {}, RIG_KINDS
    yield "Tap", Tap, {}, {"velocity": "any", "duration": "number", "time": "not negative"}
    yield "Tap.force", Tap().force, {"mass": 0.005, "time": 1.0}, {"mass": "number", "time": "any shape"}
    coil = dict.fromkeys(("force_factor", "resistance", "max_voltage", "compression"), "within, 2.5")
    coil |= {"mode": "word", "inductance": "within, 2.5", "bandwidth": "within, 2.5"}
    yield "ShakerDrive", ShakerDrive, {}, coil
    yield "ShakerDrive.replace", ShakerDrive().replace, {"resistance": 3.0}, coil
    asked = {"parameters": RIG, "force": 3.18}
    yield "equivalent", ShakerDrive().equivalent, asked, {"frequency": "not negative"}
    yield "driven_response", driven_response, RIGHT | {"drive": ShakerDrive()}, {"drive": "object"}
    yield "compare_drives", rigsim.compare_drives, RIGHT, {
        "frequency": "within, 2.5", "drives": "object", "duration": "within, 2.5"}  # fmt: skip
    yield "nondimensional", RIG.nondimensional, {"force": 3.18}, {}
    wide = dict.fromkeys(("force", "shaker", "mass", "tilt"), "within")
    known = {"hold": "word", "seed": "seed?", "start": "word?", "parameters": "object?", "step": "within?"}
    known |= {"base": "flag", "joints": "first samples", "voltage": "within?", "slack": "pair?"}
    yield "Record", Record, channels | {"sample_rate": 10.0}, wide | known | {"tilt": "within?", "mass": "within?"}
    yield "cubic_law_error", rigsim.cubic_law_error, {"z": 1e-3, "parameters": RIG}, {"z": "any shape"}
    for name in ("oscillator_modes", "static_equilibrium", "linear_modes"):
        yield name, getattr(rigsim, name), {"parameters": RIG}, {}
    yield "frequency_response", frequency_response, RIGHT, {}
    for name in ("folds", "jump_frequencies", "detached_curves"):
        yield name, getattr(rigsim, name), {"parameters": RIG, "force": 3.18}, {}
    yield "force_scenario", force_scenario, {"parameters": RIG}, {"band": "pair?", "force": "pair?"}
    yield "surface", force_scenario(RIG).surface, {}, {
        "forces": "pair", "force": "within, 2.5", "quantity": "word", "resolution": "whole"}  # fmt: skip
    yield "simulate", rigsim.simulate, {"parameters": RIG, "force": [0.0, 1.0], "sample_rate": 2000.0}, {
        "force": "any array", "seed": "seed?", "sample_rate": "number"}  # fmt: skip
    yield "random_test", rigsim.random_test, {"parameters": RIG}, {"duration": "within, 2.5", "sample_rate": "number"}
    yield "sine_test", sine_test, RIGHT, {
        "force": "array", "frequency": "within, 2.5", "duration": "within, 2.5"}  # fmt: skip
    controller = {"design": "object?", "average": "within, 2.5"}
    yield "feedback_test", feedback_test, RIGHT, controller | {
        "frequency": "within", "amplitude": "within?", "points": "whole", "feedback": "word", "delay": "whole",
        "noise": "in the cylinder", "noise_floor": "in the cylinder", "settle": "not negative",
        "limit": "number?"}  # fmt: skip
    yield "phase_locked_test", phase_locked_test, {"parameters": RIG, "force": 1.0}, controller | {
        "force": "array", "phase": "any array", "frequency": "within, 2.5?", "signal": "word",
        "patience": "within, 2.5"}  # fmt: skip
    turns = {"frequency": (20, 30)}
    waits = {"dwell": "within, 2.5", "limit": "within", "frequency": "within, 2.5", "force": "array"}
    yield "stepped_test", rigsim.stepped_test, RIGHT, waits
    yield "ramp_test", rigsim.ramp_test, RIGHT | {"force": (1.0, 4.0)}, waits | {"force": "rows"}
    yield "tapped_test", rigsim.tapped_test, RIGHT, waits
    yield "swept_test", rigsim.swept_test, RIGHT | turns | {"rate": 1.0}, {
        "force": "array", "frequency": "within", "rate": "array"}  # fmt: skip
    yield "Sensors", rigsim.Sensors, {}, {"noise": "not negative", "drift": "any", "resolution": "not negative"}
    yield (
        "identify",
        identify,
        {"record": made["record"]},
        {"order": "whole?", "block_rows": "whole", "conversion": "word"},
    )
    yield "model_order", model_order, {"record": made["record"]}, {"orders": "object?", "block_rows": "whole"}
    measured = {"force": 1.0, "frequency": 50.35, "half_step": 0.05, "amplitude": "falls", "sweep": "up"}
    numbers = dict.fromkeys(("frequency", "half_step"), "number")
    yield "Jump", Jump, measured, numbers | {"amplitude": "word", "sweep": "word"}
    swept = {"force": 1.0, "frequency": np.arange(4.0, 8.0), "relative": np.ones(4)}
    yield "Jump.found_in", Jump.found_in, swept, {}
    known = {"jumps": "object", "start": "object", "free": "object", "covariance": "object?"}
    yield "parameters_from_jumps", parameters_from_jumps, {"jumps": Jump(**measured), "start": RIG}, known
    shown = {"x": "object", "y": "object", "points": "whole", "tolerances": "object?"}
    yield "existence_chart", existence_chart, {"parameters": RIG, "force": 3.18, "x": "m", "y": "c"}, shown
    yield "margins", margins, {"parameters": RIG, "force": 3.18}, {}
    study = {"distribution": "word"}
    yield "tolerance_study", tolerance_study, {"parameters": RIG, "force": 3.18} | tolerances, study
    best = {"free": "object", "tolerances": "object?"}
    yield "design_for_detached_curve", rigsim.design_for_detached_curve, {"parameters": RIG, "force": 3.18}, best
    mapped = {"over": "object", "fixed": "object?", "force": "number?", "points": "whole", "duration": "within, 2.5"}
    yield "wobbling_map", rigsim.wobbling_map, {"parameters": RIG, "over": {"LG": [0.0]}}, mapped
    yield "periodic_orbits", periodic_orbits, {"parameters": RIG, "force": 3.18}, {}
    yield "response_sheet", response_sheet, {"parameters": RIG}, {"force": "pair"}
    known = {"frequency": "within"}
    yield "continue_orbit", rigsim.continue_orbit, RIGHT | {"relative": 1e-3}, known
    yield "harmonics_worth", harmonics_worth, {"parameters": RIG, "force": 3.18}, {}
    searched = {"frequency": "array?", "follow": "pair"}
    yield "subharmonic_motions", rigsim.subharmonic_motions, {"parameters": RIG, "force": 3.18}, searched
    yield "attractors", attractors, RIGHT, {"frequency": "number"}
    yield (
        "basins",
        basins,
        RIGHT,
        {"frequency": "number", "pixels": "whole", "window": "within?", "motion": "known later"},
    )
    tapped = {"frequency": "number", "duration": "within, 2.5", "motion": "known later", "velocity": "any array?"}
    yield "tap_map", tap_map, RIGHT, tapped
    yield "integrity", integrity, RIGHT, {"branch": "text"}
    yield "Evidence", rigsim.Evidence, {}, {"duration": "number", "frequency": "array"}
    experiment = {"duration": "number", "theory": "object?"}
    yield "virtual_experiment", rigsim.virtual_experiment, {"rig": RIG, "force": 3.18, "frequency": 30.0}, experiment
    yield "ledger", rigsim.ledger, {}, {"rig": "object?", "evidence": "object?"}
    yield "printed", rigsim.printed, {"section": "Table 1", "symbol": "ms"}, {"section": "word", "symbol": "word"}
    yield "identification_panel", explore.identification_panel, {}, {"duration": "within, 2.5", "rms": "number"}
    yield "record_panel", explore.record_panel, {"record": made["record"]}, {"first": "object?"}
    yield "response_panel", explore.response_panel, {}, {"quantity": "word"}
    yield "rig_panel", explore.rig_panel, {}, {"exaggeration": "word"}
    yield "protocol_panel", explore.protocol_panel, {}, {"rate": "within, 2.5"}
    yield "shake_panel", explore.shake_panel, {}, {"frequency": "within"}


def methods(made):
    """The same of the methods of results, of their figures and of what moves."""
    record, taps, orbits, found = (made[name] for name in ("record", "taps", "orbits", "attractors"))
    yield "replace", RIG.replace, {"m": 0.005, "k": 4e4}, {"m": "number", "k": "stiffness"}
    yield "spectrum", record.spectrum, {"channel": "mass", "frequency": 30.0}, {"frequency": "within, 2.5"}
    yield "strongest_line", record.strongest_line, {"channel": "mass", "band": (5, 50)}, {}
    yield "save", record.save, {"path": "x.csv"}, {}
    yield "load", Record.load, {"path": "x.csv"}, {"hold": "word?", "sample_rate": "number?"}
    yield "inspect", Record.inspect, {"path": "x.csv"}, {}
    moved = dict.fromkeys(("delay", "clock", "spikes"), "object?") | {"swap": "flag", "reverse": "objects"}
    yield "realigned", record.realigned, {}, moved
    yield "SineTest.record", made["test"].record, {"i": 0}, {"i": "motion"}
    yield "FeedbackTest.held", made["feedback"].held, {"frequency": 30.0}, {"frequency": "within"}
    yield "FeedbackTest.at", made["feedback"].at, {"force": 3.0}, {}
    test, compared = made["test"], lambda tests, orbits, names=None: rigsim.compare_tests(orbits, tests, names=names)
    yield "SineTest.record", test.record, {"i": 0}, {"i": "motion"}
    yield "SineTest.in_space", test.in_space, {"i": 0}, {"i": "motion"}
    yield "SineTest.out_of_plane", test.out_of_plane, {}, {}
    yield "compare_tests", compared, {"tests": test, "orbits": made["comparison"].orbits}, {
        "tests": "object", "orbits": "object", "names": "text?"}  # fmt: skip
    for name in ("found", "walked_past"):
        yield f"Comparison.{name}", getattr(made["comparison"], name), {"i": 0}, {"i": "motion"}
    for name in ("points", "apart"):
        yield f"DriveComparison.{name}", getattr(made["drives"], name), {"i": 0}, {"i": "motion"}
    yield "BenchTest.to_record", made["bench"].to_record, {}, {"run": "motion", "sample_rate": "number"}
    yield "BenchTest.column", made["bench"].column, {"name": "time"}, {"name": "word"}
    sensed = {"time": np.arange(3.0), "displacements": np.zeros((3, 2))}
    yield "Sensors.measured", rigsim.Sensors().measured, sensed, {
        "time": "any array", "displacements": "within", "number": "seed"}  # fmt: skip
    yield "OrbitBranch.shoot", orbits[0].shoot, {"i": 0}, {"i": "motion"}
    verdict = {"frequencies": "within?"}
    yield "verdict", verdict_of, {"orbits": orbits}, verdict | {"orbits": "object"}
    yield "ResponseSheet.at", made["sheet"].at, {"force": 3.1}, {"force": "within"}
    yield "over", made["converged"].over, {"name": "m", "values": [0.005]}, {"name": "word", "values": "within, 2.5"}
    yield "find", found.find, {"motion": 0}, {}
    yield "settle", found.settle, {"states": np.zeros((1, 4))}, {"states": "within"}
    yield "reached", taps.reached, {"motion": 0}, {}
    yield "surest", taps.surest, {"motion": 0}, {}
    places = {"row": "motion", "column": "motion", "after": "not negative"}
    yield "TapMap.tap", taps.tap, {"row": 0, "column": 0}, places
    yield "SmallestTap.tap", made["smallest"].tap, {}, {"after": "not negative"}
    shown = {"instant": 0.0, "velocity": 0.1, "periods": 2, "samples": 4}
    yield "paths", taps.paths, shown, {"instant": "phase", "periods": "whole"}
    yield "smallest_tap", rigsim.smallest_tap, {"taps": taps, "target": 0}, {
        "taps": "object", "target": "motion", "rounds": "whole"}  # fmt: skip
    yield "sweep", made["statics"].sweep, {}, {"points": "whole"}
    yield "theory", made["overlay"].theory, {}, {"parameters": "object?"}
    yield "overlay", lambda parameters: overlay(parameters, made["test"]), {"parameters": RIG}, {}
    yield "overlay of tests", lambda tests: overlay(RIG, tests), {"tests": made["test"]}, {"tests": "object"}
    yield "count", made["ledger"].count, {"kind": "number", "agrees": "yes"}, {"agrees": "word"}
    yield "only", lambda section: made["ledger"].only(section), {"section": "Table 1"}, {"section": "word"}
    yield "row", made["ledger"].row, {"section": "Table 1", "item": "ms"}, {"section": "word", "item": "word"}
    inside = rigsim.Evidence().inside
    yield "inside", inside, {"frequency": 30.0}, {"frequency": "any shape"}


def pictures(made):
    """The same of figures and of what moves."""
    for name, what, options in (
        ("response", "response", {"beside": "objects", "label": "text", "beside_label": "text?", "key": "flag"}),
        ("scenario", "scenario", {"force": "number?", "band": "pair"}),
        ("scenario", "surface", {"resolution": "whole", "quantity": "word"}),
        ("orbits", "orbits", {"beside": "objects", "circles": "object?", "circles_label": "text"}),
        ("taps", "taps", {"smallest": "objects"}),
        ("integrity", "integrity", {"beside": "objects"}),
        ("overlay", "branches", {"nominal": "object?", "band": "pair", "space": "objects"}),
        ("test", "lines", {"space": "objects"}),
        ("record", "record", {"interval": "pair?"}),
        ("test", "spectrum", {"indices": "places", "beside": "objects", "highest": "not negative but zero"}),
        ("statics", "rig", {"beside": "objects", "exaggeration": "not negative but zero", "titles": "text?"}),
        ("statics", "statics", {"points": "whole"}),
        ("statics", "pymunk", {}),
        ("modes", "shapes", {"largest": "number"}),
        ("sheet", "sheet", {"force": "number?"}),
        ("sheet", "amplitude", {"forces": "within?"}),
        ("converged", "scenario", {"force": "number?"}),
        ("feedback", "s-curves", {"force": "number?"}),
        ("feedback", "sheet", {"forces": "array?", "beside": "object?"}),
        ("measured", "response", {"beside": "object?"}),
        ("held", "record", {"periods": "whole, many"}),
        ("locked", "backbone", {"beside": "object?"}),
        ("margins", None, {}),
        ("bench", "points", {}),
        ("bench", "waits", {}),
        ("comparison", "tests", {}),
        ("drives", "drives", {}),
        ("drives", "waveforms", {}),
        ("study", None, {}),
        ("map", None, {"modes": "objects"}),
        ("attractors", None, {}),
    ):  # fmt: skip
        yield f"{name}.plot({what})", made[name].plot, {"what": what}, options
    yield "wire law", RIG.plot, {"what": "wire law"}, {"reached": "pair?", "largest": "number"}
    responses = [made["response"]] * 2
    slider = {"name": "Force", "values": [1.0, 2.0], "unit": "N", "responses": responses}
    kinds = {"name": "text", "values": "within", "unit": "text", "responses": "object", "alt": "text?"}
    more = {"beside": "object?", "circles": "object?"}
    yield "response_slider", rigsim.response_slider, slider, kinds | more
    shown = {"instant": "phase", "periods": "whole", "velocity": "any array?", "taps": "object"}
    yield "tap_slider", rigsim.tap_slider, {"taps": made["taps"]}, shown
    frames = {
        "start": "not negative",
        "stop": "within, 2.5?",
        "exaggeration": "not negative but zero",
        "displacement": "not negative but zero",
        "channel": "word",
        "frames": "whole",
        "seconds": "number",
        "titles": "text?",
    }
    animated = {"parameters": RIG, "record": made["record"]}
    yield "rig_animation", rigsim.rig_animation, animated, frames
    panel = Panel([[], []], "x [mm]", "y [mm]")
    moving = {"name": "Force", "values": [1.0, 2.0], "unit": "N", "panels": panel, "alt": "words"}
    texts = dict.fromkeys(("name", "unit", "alt", "caption"), "text")
    others = {"values": "within", "panels": "object", "notes": "texts?", "start": "motion", "seconds": "number?"}
    sizes = {"digits": "whole", "width": "size", "height": "size?", "columns": "whole, many", "key": "object?"}
    yield "MovingPlot", MovingPlot, moving, texts | others | sizes


# By what another name a message may call an argument: that of the slider, or the motion that a tap is to lead to.
CALLED = {"values": "Force"}


def mistakes(function, right, kinds):
    """(argument, what is wrong, all arguments) of every mistaken call."""
    signature = inspect.signature(function).parameters.values()
    taken = [p.name for p in signature if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)]
    for argument in dict.fromkeys([*taken, *kinds]):
        kind = kinds.get(argument) or KINDS[argument]
        allowed = ALLOWED[kind.removesuffix("?")] | ({"nothing"} if kind.endswith("?") else set())
        for wrong, value in WRONG.items():
            if wrong not in allowed:
                value = (i for i in (1.0, 2.0)) if wrong == "a generator" else value
                yield argument, wrong, right | {argument: value}


def fault(function, argument, arguments):
    """What is wrong with the end of a mistaken call, or None."""
    begun = time.perf_counter()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            function(**arguments)
    except ValueError as error:
        told = str(error)
    except BaseException as error:
        return f"{type(error).__name__}: {error}"
    else:
        return "nothing was refused"
    took = time.perf_counter() - begun
    if "\n" in told or len(told) > WORDS:
        return f"not one line: {told[:300]!r}"
    if not re.search(rf"\b({argument}|{CALLED.get(argument)})\b", told) or not re.search("expect|must", told):
        return f"not told what and why: {told}"
    return f"only after {took:.1f} s: {told}" if took > LONGEST else None


def test_every_mistaken_call_ends_in_one_line(made, tell):
    count, faults = 0, []
    for label, function, right, kinds in (*functions(made), *methods(made), *pictures(made)):
        for argument, wrong, arguments in mistakes(function, right, kinds):
            count += 1
            if told := fault(function, argument, arguments):
                faults.append(f"{label}({argument}: {wrong}): {told}")
    print("\n".join(faults))
    assert not faults, f"{len(faults)} of {count} mistaken calls"
    tell(f"mistaken calls: {count}, each refused at once, in one line that names argument, value and what is allowed")


def test_every_public_function_is_called_mistakenly(made):
    called = {label for label, *_ in (*functions(made), *methods(made), *pictures(made))}
    public = {name for name in rigsim.__all__ if inspect.isfunction(getattr(rigsim, name))}
    assert not public - called
    assert not {f"{name}" for name in explore.__all__ if name.endswith("_panel")} - called


def test_a_wrong_name_or_number_of_arguments_is_pythons_own_line():
    for call in (lambda: frequency_response(RIG, 3.18, 30.0, forc=3), lambda: sine_test(RIG), lambda: RIG.plot(axes=1)):
        with pytest.raises(TypeError) as caught:
            call()
        assert "\n" not in str(caught.value)


# Other spellings of 3, of 30 and of (20, 30), which are as right.
THREES = (np.float32(3), np.int8(3), np.array(3), np.array(3.0), Decimal(3), Fraction(3), 3)
THIRTIES = (
    [30],
    (30.0,),
    np.array([30], dtype="u1"),
    pd.Series([30.0]),
    range(30, 31),
    [Decimal(30)],
    30,
    np.float16(30),
)
PAIRS = ([20, 30], np.array([20.0, 30.0]), pd.Series([20, 30]), (Decimal(20), Fraction(30)), range(20, 31, 10))


@pytest.mark.parametrize("three", THREES, ids=repr)
def test_another_spelling_of_a_number_gives_the_same_bits(three):
    for function in (
        rigsim.folds,
        rigsim.jump_frequencies,
        rigsim.detached_curves,
        lambda rig, force: rig.oscillator.nondimensional(force),
    ):
        assert repr(function(RIG, three)) == repr(function(RIG, 3.0))
    assert RIG.replace(cs=three) == RIG.replace(cs=3.0) and RIG.nondimensional(three) == RIG.nondimensional(3.0)
    assert type(frequency_response(RIG, three, 30.0).force) is float
    assert Tap(velocity=three, time=three) == Tap(3.0, 2e-3, 3.0)
    one = tolerance_study(RIG, 3.18, {"m": "1 %"}, samples=three, seed=three)
    other = tolerance_study(RIG, 3.18, {"m": "1 %"}, samples=3, seed=3)
    np.testing.assert_array_equal(one.values["m"], other.values["m"])
    record = rigsim.random_test(RIG, three, 0.01, seed=three)
    np.testing.assert_array_equal(record.mass, rigsim.random_test(RIG, 3.0, 0.01, seed=3).mass)
    assert record.seed == 3 and type(record.seed) is int


@pytest.mark.parametrize("given", THIRTIES, ids=repr)
def test_another_spelling_of_an_array_gives_the_same_bits(given):
    right = frequency_response(RIG, 3.18, [30.0])
    np.testing.assert_array_equal(frequency_response(RIG, 3.18, given).relative, right.relative)
    np.testing.assert_array_equal(rigsim.cubic_law_error(given, RIG), rigsim.cubic_law_error(np.array([30.0]), RIG)
                                  .reshape(np.shape(given)))  # fmt: skip


@pytest.mark.parametrize("given", PAIRS, ids=lambda given: type(given).__name__)
def test_another_spelling_of_a_band_gives_the_same_bits(given):
    found, right = (periodic_orbits(RIG, 3.18, band, 1, search="seeds") for band in (given, (20.0, 30.0)))
    assert found.band == right.band == (20.0, 30.0)
    np.testing.assert_array_equal(found[0].frequency, right[0].frequency)


def test_seeds_beyond_the_floats_are_kept_to_the_last_digit(tmp_path):
    for seed in (2**53 + 1, 2**64 + 1, 2**128 - 1):
        record = rigsim.random_test(RIG, 1.0, 0.01, seed=seed)
        assert record.seed == seed
        other = rigsim.random_test(RIG, 1.0, 0.01, seed=seed - 1)
        assert not np.array_equal(record.force, other.force)
        record.save(tmp_path / "record.csv")
        assert Record.load(tmp_path / "record.csv").seed == seed


def test_a_value_in_another_unit_is_refused():
    xarray = pytest.importorskip("xarray")
    kilo = xarray.DataArray([0.03], attrs={"units": "kHz"})
    with pytest.raises(ValueError, match="frequency is in 'kHz'; expected numbers in Hz"):
        frequency_response(RIG, 3.18, kilo)
    assert frequency_response(RIG, 3.18, xarray.DataArray([30.0], attrs={"units": "Hz"})).frequency == [30.0]


def test_degrees_are_no_radians():
    channels = np.zeros((3, 4))
    with pytest.raises(
        ValueError, match=r"tilt\[1\] = 45 rad is not allowed; expected a number from -1.57.* to 1.57.* rad"
    ):
        Record(*channels, 100.0, tilt=[0, 45, 0, 0])
    with pytest.raises(ValueError, match="sample_rate = 1e.30 Hz is not allowed"):
        Record(*channels, 1e30)
    with pytest.raises(ValueError, match="step = 0.5 s is not allowed; expected .*0.01"):
        Record(*channels, 100.0, step=0.5)
