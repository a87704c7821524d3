"""What the channels of a record are called and measure."""

import reprlib

from .. import checks

HOLDS = ("zero", "linear", "band-limited")
UNITS = {"force": "N", "shaker": "m", "mass": "m", "tilt": "rad", "voltage": "V"}
OPTIONAL = ("mass", "tilt", "voltage")
KINDS = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2"}  # of the outputs, and their units
OUTPUTS = ("shaker", "mass")
# What a file may say of a record beside its channels, and as what: fields of a record, and what is read and then gone.
DETAILS = {"sample_rate": (int, float), "hold": (str,), "seed": (int, float), "start": (str,), "parameters": (dict,)}
DETAILS |= {"step": (int, float), "kinds": (dict,), "base": (bool,), "joints": (list, tuple)}
DETAILS |= {"slack": (list, tuple)}
BESIDES = {"samples": (int,), "units": (dict,)}
_EXPECTED = {int: "a number", str: "a text", dict: "an object", bool: "true or false", list: "a list"}


def checked_details(path, details):
    """Details that a file says, each of the type that it must have."""
    known = DETAILS | BESIDES
    for name, value in details.items():
        kind = known[checks.one_of(f"detail in {path}", name, tuple(known))]
        if not isinstance(value, kind) or (isinstance(value, bool) and kind != (bool,)):
            told = f"{name} in {path} = {reprlib.repr(value)}"
            raise ValueError(f"{told} is not allowed; expected {_EXPECTED[kind[0]]}")
    return dict(details)


def checked_kinds(kinds):
    """What every output is (a dict), from what is said of some."""
    if kinds is not None and not isinstance(kinds, dict):
        expected = 'a dict such as {"shaker": "acceleration"}'
        raise ValueError(f"kinds = {checks.shown(kinds)} is not allowed; expected {expected}")
    said = {checks.one_of("channel of kinds", name, OUTPUTS): kind for name, kind in (kinds or {}).items()}
    return {name: checks.one_of(f"kind of {name}", said.get(name, "displacement"), tuple(KINDS)) for name in OUTPUTS}
