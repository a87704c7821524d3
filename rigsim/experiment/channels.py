"""What the channels of a record are called and measure."""

from .. import checks

HOLDS = ("zero", "linear", "band-limited")
UNITS = {"force": "N", "shaker": "m", "mass": "m", "tilt": "rad"}
KINDS = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2"}  # of the outputs, and their units
OUTPUTS = ("shaker", "mass")


def checked_kinds(kinds):
    """What every output is (a dict), from what is said of some."""
    if kinds is not None and not isinstance(kinds, dict):
        expected = 'a dict such as {"shaker": "acceleration"}'
        raise ValueError(f"kinds = {checks.shown(kinds)} is not allowed; expected {expected}")
    said = {checks.one_of("channel of kinds", name, OUTPUTS): kind for name, kind in (kinds or {}).items()}
    return {name: checks.one_of(f"kind of {name}", said.get(name, "displacement"), tuple(KINDS)) for name in OUTPUTS}
