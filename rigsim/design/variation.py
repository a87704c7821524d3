"""One rig with some of its numbers changed: many parameter sets at once, by dimensional or non-dimensional names.

Names are applied from the rig to the theory: wires (k, d, d0) give k1 and k3 by Eq. (2), these and the other fields
and the force give the five numbers of Eqs. (4a, b). A name set further along overrides what comes before it.
"""

import math
from dataclasses import dataclass

import numpy as np

from .. import checks
from ..parameters import RigParameters, oscillator_of
from .count import KINDS, existence_forces, judge

_FIELDS = ("ms", "ks", "cs", "m", "c")
_WIRES = ("k", "d", "d0")
_STIFFNESS = ("k1", "k3")
_GROUPS = ("mu", "zeta_s", "zeta", "Omega0", "gamma")
_SHOWN = {"d": ("µm", 1e6), "d0": ("µm", 1e6), "m": ("g", 1e3), "ms": ("g", 1e3)}  # as a builder holds them
_UNITS = {
    "force": "N", "ms": "kg", "ks": "N/m", "cs": "N s/m", "m": "kg", "c": "N s/m", "k": "N/m", "d": "m", "d0": "m",
    "k1": "N/m", "k3": "N/m^3",
}  # fmt: skip
_ABOVE_ZERO = ("force", "ms", "ks", "cs", "m", "k", "d", "d0", "mu", "zeta_s")


@dataclass(frozen=True)
class Quantity:
    """A number of a rig that can be varied; value and physical bounds in SI units, ``unit``.

    ``low_open`` if the lower bound is not allowed itself. People are shown ``shown_unit``, ``factor`` times the SI one:
    micrometres for wire lengths, grams for masses.
    """

    name: str
    value: float
    unit: str
    low: float
    high: float
    low_open: bool
    shown_unit: str
    factor: float


def names_of(parameters):
    """Every name that can be varied (tuple of str)."""
    wires = _WIRES if isinstance(parameters, RigParameters) else ()
    return ("force", *_FIELDS, *wires, *_STIFFNESS, *_GROUPS)


def built_names(parameters):
    """The names that a builder decides: the fields of the tables, and the force."""
    oscillator_of(parameters)
    return (*_FIELDS, *(_WIRES if isinstance(parameters, RigParameters) else _STIFFNESS), "force")


def quantity(parameters, force, name):
    """The checked `Quantity` of a name; ``k`` is the mean of the wires' stiffnesses."""
    name = checks.one_of("quantity", name, names_of(parameters))
    values = _base(parameters, force)
    if name in _STIFFNESS:
        values[name] = getattr(parameters, name)
    elif name in _GROUPS:
        values[name] = getattr(parameters.nondimensional(force), name)
    low, high = parameters.d0 if name == "d" else 0.0, parameters.d if name == "d0" else math.inf
    unit = _UNITS.get(name, "")
    shown, factor = _SHOWN.get(name, (unit, 1.0))
    return Quantity(name, values[name], unit, low, high, low == 0.0 and name in _ABOVE_ZERO, shown, factor)


def _base(parameters, force):
    values = {name: getattr(parameters, name) for name in _FIELDS} | {"force": force}
    if isinstance(parameters, RigParameters):
        values |= {"k": float(parameters.wire_stiffness.mean()), "d": parameters.d, "d0": parameters.d0}
    return values


def varied_sets(parameters, force, changes):
    """Non-dimensional sets (n, 5) of a rig with some numbers changed; NaN where such a rig is not possible.

    Not possible are masses and stiffnesses that are not above zero, and slack wires, d0 > d. A damping below zero is
    read as zero. ``changes`` is a dict of new values (n,), SI, by some of `names_of`; NaN leaves a number as it follows
    from the others.
    """

    def changed(name, usual):
        new = np.asarray(changes.get(name, np.nan), dtype=float)
        return np.where(np.isnan(new), usual, new)

    value = {name: changed(name, usual) for name, usual in _base(parameters, force).items()}
    if isinstance(parameters, RigParameters):
        number = parameters.wire_stiffness.size
        with np.errstate(all="ignore"):
            k1 = number * value["k"] * (value["d"] - value["d0"]) / value["d"]
            k3 = number * value["k"] * value["d0"] / (2 * value["d"] ** 3)
        possible = (value["k"] > 0) & (value["d0"] > 0) & (value["d0"] <= value["d"])
    else:
        k1, k3, possible = parameters.k1, parameters.k3, True
    k1, k3 = changed("k1", k1), changed("k3", k3)
    ms, ks, cs, m, c, force = (value[name] for name in (*_FIELDS, "force"))
    # Dampings stop at zero, the shaker's just above it, where the theory of folds ends.
    cs, c = np.maximum(cs, 1e-9 * parameters.cs), np.maximum(c, 0.0)
    possible = possible & (ms > 0) & (ks > 0) & (m > 0) & (force > 0)
    with np.errstate(all="ignore"):
        omega_s, mu = np.sqrt(ks / ms), m / ms
        groups = {
            "mu": mu,
            "zeta_s": cs / (2 * ms * omega_s),
            "zeta": c / (2 * m * omega_s),
            "Omega0": np.sqrt(k1 / m) / omega_s,
            "gamma": k3 * (force / ks) ** 2 / (mu * ks),
        }
    columns = np.broadcast_arrays(*(changed(name, groups[name]) for name in _GROUPS), possible)
    sets = np.array(np.stack(columns[:5], axis=-1).reshape(-1, 5), dtype=float)
    good = np.isfinite(sets).all(axis=1) & (sets >= 0).all(axis=1) & (sets[:, :2] > 0).all(axis=1)
    sets[~(good & columns[5].ravel())] = np.nan
    return sets


def judge_varied(parameters, force, changes, **options):
    """`rigsim.design.count.judge` of `varied_sets`: an impossible rig has no curve, at a distance of -infinity."""
    sets = varied_sets(parameters, force, changes)
    good = np.isfinite(sets[:, 0])
    counts, distances = np.zeros((len(sets), 2), dtype=np.int64), np.full((len(sets), 2), -np.inf)
    counts[good], distances[good] = judge(sets[good], **options)
    return counts, distances


def replaced(parameters, force, values):
    """(parameters, force) with the numbers a builder decides replaced; one ``k`` scales all wires alike."""
    values = dict(values)
    force = values.pop("force", force)
    if "k" in values and isinstance(parameters, RigParameters) and np.ndim(parameters.k):
        values["k"] = tuple((parameters.wire_stiffness * (values["k"] / parameters.wire_stiffness.mean())).tolist())
    return parameters.replace(**values), force


def kind_number(kind):
    """0 for "inner", 1 for "outer"; checked."""
    return KINDS.index(checks.one_of("kind", kind, KINDS))


def checked_start(parameters, force, kind):
    """(force, number of the kind) of a rig that has a curve of the kind at the force; a ValueError if it has none."""
    oscillator_of(parameters)
    force = checks.positive("force", force, "N")
    number = kind_number(kind)
    spans = existence_forces(parameters, kind)
    if not any(low < force < high for low, high in spans):
        ranges = " or ".join(f"between {low:.5g} and {high:.5g} N" for low, high in spans)
        wanted = f"expected one {ranges}" if spans else "there is none at any force"
        raise ValueError(f"force = {force:g} N gives no {kind} detached curve; {wanted}")
    return force, number


def _number(text):
    """The number that a text says, or the text, to be refused."""
    try:
        return float(text)
    except ValueError:
        return text


def half_widths(parameters, force, tolerances):
    """Checked tolerances (dict of str to float) in SI units: a number as it is, "5 %" of the quantity's own value."""
    if not isinstance(tolerances, dict) or not tolerances:
        raise ValueError(
            f"tolerances = {checks.shown(tolerances)} is not allowed; expected a dict of at least one name"
        )
    widths = {}
    for name, given in tolerances.items():
        item = quantity(parameters, force, name)
        label = f"tolerance of {name}"
        if isinstance(given, str):
            text = given.strip()
            if not text.endswith("%"):
                told = f"{label} = {checks.shown(given)} is not allowed"
                raise ValueError(f'{told}; expected a number ({item.unit}) or "5 %"')
            percent = checks.real(label, _number(text[:-1]), "%", low=0.0, high=1e6, low_open=True)
            widths[name] = abs(item.value) * percent / 100
        else:
            widths[name] = checks.positive(label, given, item.unit)
        if widths[name] == 0:
            raise ValueError(f"{label} = {given!r} is not allowed; {name} is zero, expected a number ({item.unit})")
    return widths
