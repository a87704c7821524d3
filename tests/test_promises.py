"""Arguments that users may leave out: what they then get is part of what they were promised."""

import inspect
from dataclasses import MISSING, fields

import pytest

import rigsim

PROMISED = {
    "Tap": {"velocity": 0.5, "duration": 2e-3, "time": 1.0},
    "RigParameters": {
        "ms": 0.154, "ks": 18800.0, "cs": 9.86, "m": 0.0052, "c": 0.026, "k": 4e4, "d": 0.034, "d0": 0.033997,
        "Lm": 0.025, "Rm": 0.004, "LG": 0.003125, "wire_sets": 2, "set_half_spacing": None, "gravity": 9.81,
        "wire_damping": 0.0, "rocking_damping": 0.0, "tension_only": False, "set_centre": 0.0,
    },
    "simulate": {"hold": "zero", "start": "rest", "step": 5e-5},
    "random_test": {
        "rms": 1.115, "duration": 100, "sample_rate": 2000, "seed": 2014, "hold": "zero", "start": "equilibrium",
        "step": 5e-5,
    },
    "sine_test": {"tap": None, "duration": 3, "start": "rest", "step": 5e-5, "drive": None},
    "stepped_test": {"dwell": "settled", "start": "rest", "step": 5e-5},
    "swept_test": {"spacing": "linear", "start": "rest", "step": 5e-5},
    "ramp_test": {"rate": None, "dwell": "settled", "start": "rest", "step": 5e-5},
    "tapped_test": {"velocity": (0.5, 1.0), "dwell": "settled", "start": "rest", "step": 5e-5},
    "identify": {"order": None, "block_rows": 40, "band": (2, 80), "conversion": "force"},
    "force_scenario": {},
    "periodic_orbits": {"band": (5, 80), "law": None},
    "continue_orbit": {"band": (5, 80), "law": None},
    "Record": {"hold": "zero", "tilt": None, "seed": None, "start": None, "parameters": None},
}  # fmt: skip


@pytest.mark.parametrize("name", PROMISED)
def test_what_is_left_out_is_what_was_promised(name):
    public = getattr(rigsim, name)
    defaults = {key: p.default for key, p in inspect.signature(public).parameters.items()}
    if inspect.isclass(public):
        defaults = {item.name: item.default for item in fields(public) if item.default is not MISSING}
    for key, expected in PROMISED[name].items():
        assert defaults[key] == expected, f"{name}({key}={defaults[key]!r})"
        assert type(defaults[key]) is type(expected) or isinstance(expected, int | float)


@pytest.mark.parametrize("name", rigsim.__all__)
def test_progress_is_silent_unless_asked_for(name):
    public = getattr(rigsim, name)
    if inspect.isfunction(public) and "progress" in inspect.signature(public).parameters:
        assert inspect.signature(public).parameters["progress"].default is False
