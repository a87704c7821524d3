"""Units as people write them, and what a name says of a channel."""

import re
import unicodedata

SI = {
    "force": "N",
    "displacement": "m",
    "velocity": "m/s",
    "acceleration": "m/s^2",
    "angle": "rad",
    "time": "s",
}
_LENGTHS = {
    "m": 1.0,
    "dm": 0.1,
    "cm": 1e-2,
    "mm": 1e-3,
    "um": 1e-6,
    "nm": 1e-9,
    "pm": 1e-12,
    "in": 0.0254,
    "ft": 0.3048,
}
_G = 9.80665
_FACTORS = {
    "force": {"N": 1.0, "mN": 1e-3, "uN": 1e-6, "daN": 10.0, "kN": 1e3, "MN": 1e6, "lbf": 4.4482216152605, "dyn": 1e-5,
              "kgf": _G, "kp": _G, "gf": _G / 1e3, "ozf": 0.27801385095378125},
    "displacement": _LENGTHS | {"mil": 25.4e-6, "thou": 25.4e-6, "km": 1e3},
    "velocity": {f"{length}/s": factor for length, factor in _LENGTHS.items()},
    "acceleration": {f"{length}/s2": factor for length, factor in _LENGTHS.items()}
    | {"g": _G, "mg": _G / 1e3, "ug": _G / 1e6, "kg": None, "Gal": 1e-2},
    "angle": {"rad": 1.0, "mrad": 1e-3, "urad": 1e-6, "deg": 0.017453292519943295},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0},
}  # fmt: skip
_WORDS = {
    "newton": "N", "newtons": "N", "kilonewton": "kN", "meter": "m", "meters": "m", "metre": "m", "metres": "m",
    "millimeter": "mm", "millimeters": "mm", "millimetre": "mm", "millimetres": "mm", "micron": "um", "microns": "um",
    "micrometer": "um", "micrometers": "um", "micrometre": "um", "micrometres": "um", "inch": "in", "inches": "in",
    '"': "in", "feet": "ft", "lb": "lbf", "lbs": "lbf", "pound": "lbf", "pounds": "lbf", "pound-force": "lbf",
    "ips": "in/s", "gn": "g", "g_n": "g", "g0": "g", "gee": "g", "grav": "g", "sec": "s", "secs": "s", "second": "s",
    "seconds": "s", "sekunden": "s", "msec": "ms", "millisecond": "ms", "milliseconds": "ms", "usec": "us",
    "microsecond": "us", "microseconds": "us", "nanosecond": "ns", "nanoseconds": "ns", "minute": "min",
    "minutes": "min", "hour": "h", "hours": "h", "hr": "h", "radian": "rad", "radians": "rad", "degree": "deg",
    "degrees": "deg", "\N{DEGREE SIGN}": "deg", "mu": "um", "mum": "um", "mils": "mil", "kgforce": "kgf",
}  # fmt: skip
# Units of what is measured before it is calibrated: they are units, and none of a record's.
_OTHERS = {"v", "mv", "uv", "volt", "volts", "pc", "ma", "a", "counts", "count", "bit", "bits", "hz", "khz", "pa", "%",
           "-", "1", "db", "k", "c", "lsb", "eu", "kg", "nm/rad", "mv/v", "um/m", "strain"}  # fmt: skip
_KNOWN = {unit: (quantity, factor) for quantity, units in _FACTORS.items() for unit, factor in units.items() if factor}
_LOOSE = {}
for _unit in _KNOWN:  # where only the case of letters differs and two could be meant, none is
    _LOOSE[_unit.casefold()] = None if _unit.casefold() in _LOOSE else _unit
_LONG = 200  # characters of a name or a unit that may mean something
_KIND_WORDS = {
    "displacement": "displacement", "disp": "displacement", "displ": "displacement", "position": "displacement",
    "pos": "displacement", "weg": "displacement", "velocity": "velocity", "vel": "velocity", "speed": "velocity",
    "geschwindigkeit": "velocity", "acceleration": "acceleration", "accel": "acceleration", "acc": "acceleration",
    "accelerometer": "acceleration", "beschleunigung": "acceleration",
}  # fmt: skip
_ROLES = {"force": "force", "kraft": "force", "shaker": "shaker", "mass": "mass", "tilt": "tilt"}
_TIMES = {"time", "t", "zeit", "timestamp", "timestamps", "time stamp", "x value", "elapsed time", "date time", "temps",
          "datetime", "relative time", "rel time", "abs time", "absolute time", "uhrzeit", "zeitstempel", "date",
          "time of day", "sample time", "measurement time", "time axis", "elapsed", "zeit relativ"}  # fmt: skip
_BRACKETS = re.compile(r"^(.*?)\s*[\[({<]\s*([^\[\](){}<>]*?)\s*[\])}>]\s*$", re.DOTALL)
_BETWEEN = re.compile(r"\s*[/,;_|:]\s*|\s+in\s+|\s+")


def unit_of(text):
    """Quantity and factor to its SI unit of a unit as people write it; None where there is no such."""
    if len(text) > _LONG:
        return None
    text = unicodedata.normalize("NFKC", text).replace("\N{GREEK SMALL LETTER MU}", "u").replace("\N{MINUS SIGN}", "-")
    text = text.strip().strip("[](){}<>").strip().partition(" since ")[0]
    word = _WORDS.get(text.casefold(), text)
    word = re.sub(r"(/?)sec(ond)?s?(?=$|[/^*\d-])", r"\1s", word)
    word = re.sub(r"\^|\*\*|\(|\)", "", word).replace("\N{MIDDLE DOT}", " ").replace("*", " ").strip()
    word = re.sub(r"^(\w+) ?s ?-1$", r"\1/s", word)
    word = re.sub(r"^(\w+)( ?s ?-2|/s/s|/ss)$", r"\1/s2", word).replace(" ", "")
    word = word if word in _KNOWN else _LOOSE.get(word.casefold())
    return _KNOWN.get(word)


def is_unit(text):
    """Whether a text is a unit of anything."""
    word = unicodedata.normalize("NFKC", text).strip().strip("[](){}<>").strip()
    return unit_of(text) is not None or word.casefold() in _OTHERS


def bare(name):
    """A name without its unit, and that unit ("" where it has none)."""
    if len(name) > _LONG:
        return name.strip(), ""
    found = _BRACKETS.match(name)
    if found and ((name.rstrip().endswith("]") and not found[2].isdigit()) or is_unit(found[2])):
        return found[1].strip(), found[2]
    for found in _BETWEEN.finditer(name):
        before, behind = name[: found.start()], name[found.end() :]
        if unit_of(behind) and role_of(before)[0]:
            return before.strip(), behind
    return name.strip(), ""


def plain(name):
    """A name without its unit and without the groups that it stands in."""
    return bare(name)[0].rpartition("/")[2].strip()


def role_of(name):
    """Which channel a name without unit must mean ("" where it may mean others), and what kind it says ("" none)."""
    if len(name) > _LONG:
        return "", ""
    spaced = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", unicodedata.normalize("NFKC", name))
    words = re.findall(r"[^\W_]+", spaced.casefold())
    if " ".join(words) in _TIMES:
        return "time", ""
    kinds = {_KIND_WORDS[word] for word in words if word in _KIND_WORDS}
    rest = [word for word in words if word not in _KIND_WORDS]
    role = _ROLES.get(rest[0], "") if len(rest) == 1 and len(kinds) <= 1 else ""
    return role, kinds.pop() if role and kinds else ""
