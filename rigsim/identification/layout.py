"""The rigs that a record can be of: two masses of which a force shakes the first, or one mass on a spring.

A record of two sensors is of the first kind, one of a single sensor of the second. Either may stand on a base whose
acceleration was recorded instead of a force.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..model.modes import modes_of
from ..parameters import MassParameters, OscillatorParameters
from .physical import NAMES, mass_of_fraction, mass_receptance, oscillator_receptance, parameters_of_fraction
from .simulate import SENSED, Structure
from .terms import CUBIC, LINEAR


@dataclass(frozen=True, eq=False)
class Layout:
    """A kind of rig.

    Attributes
    ----------
    names : tuple of str
        Of its parameters in the order they are told in, k3 last.
    parameters : type
        What holds them.
    masses : tuple of str
        Those of them that are masses, d of them, one for each sensor.
    terms : tuple of Term
        Linear ones, then the cubic one.
    receptance : callable
        Of values, in the order of the names, and frequencies (n,) in Hz: complex, shape (n, d, d) (m/N).
    entries : tuple of tuple
        Rows and columns of the receptances that differ.
    degrees : tuple of int
        Of their numerators.
    of_fraction : callable
        The linear parameters that a `RationalFraction` of those names.
    """

    names: tuple
    parameters: type
    masses: tuple
    terms: tuple
    receptance: Callable
    entries: tuple
    degrees: tuple
    of_fraction: Callable

    @property
    def least(self):
        """Shares of usual values of the parameters, in the order of the names, below which no rig has them."""
        least = dict.fromkeys((*self.masses, "ks"), 1e-3) | {"k3": -np.inf}
        return np.array([least.get(name, 0.0) for name in self.names])

    @property
    def order(self):
        """Of its state-space model, two a mode."""
        return 2 * len(self.masses)

    def across(self, motion):
        """What the cubic spring is stretched by, shape (n,), of displacements (n, d)."""
        return motion @ self.terms[-1].direction(len(self.masses))

    def structure(self, record, terms=()):
        """The `Structure` of a record's rig, with more ``terms`` at its end."""
        sensors = tuple(enumerate(record.kinds.values()))
        driven = tuple(1.0 * (place == 0) for place in range(len(self.masses)))
        return Structure(self.masses, (*self.terms, *terms), sensors, driven, record.base)

    def distinct(self, receptance):
        """The receptances that differ, shape (n, r), of all of them (n, d, d)."""
        return receptance[:, *np.transpose(self.entries)]

    def whole(self, distinct):
        """All receptances (n, d, d), of those that differ (n, r)."""
        d = len(self.masses)
        places = [self.entries.index((max(i, j), min(i, j))) for i in range(d) for j in range(d)]
        return distinct[:, places].reshape(-1, d, d)

    def ordered(self, values, structure):
        """Values in the order of the names as those of a structure, none that no rig can have."""
        known = dict(zip(self.names, np.maximum(values, 1e-3 * self.least), strict=True))
        return np.array([known.get(name, 0.0) for name in structure.names])

    def modes(self, values):
        """`Modes` of its linear system, of values in the order of the names; None where one does not oscillate."""
        known = dict(zip(self.names, np.maximum(values[: len(self.names)], 0.0), strict=True))
        d = len(self.masses)
        damping, stiffness = np.zeros((d, d)), np.zeros((d, d))
        for term in self.terms[:-1]:
            direction = term.direction(d)
            matrix = damping if term.of == "velocity" else stiffness
            matrix += known[term.name] * np.outer(direction, direction)
        names = ("shaker", "mass") if d == 2 else ("mass",)
        try:
            found = modes_of(np.diag([known[name] for name in self.masses]), damping, stiffness, names)
        except ValueError:
            return None
        return found if found.frequency.size == d else None


TWO_MASSES = Layout(
    NAMES, OscillatorParameters, ("ms", "m"), (*LINEAR, CUBIC), oscillator_receptance, ((0, 0), (1, 0), (1, 1)),
    (2, 1, 2), parameters_of_fraction,
)  # fmt: skip
_TO_GROUND = tuple(replace(term, between=(0,)) for term in (*LINEAR[2:], CUBIC))
ONE_MASS = Layout(
    ("m", "c", "k1", "k3"), MassParameters, ("m",), _TO_GROUND, mass_receptance, ((0, 0),), (0,), mass_of_fraction
)


def layout_of(record):
    """The `Layout` of a record's rig."""
    return ONE_MASS if record.mass is None else TWO_MASSES


def outputs_of(record):
    """Its outputs as they were measured, shape (n, d)."""
    return np.column_stack([getattr(record, name) for name in record.kinds])


def powers_of(record):
    """How often each output is to be integrated to be a displacement, a tuple of 0, 1 and 2."""
    return tuple(SENSED.index(kind) for kind in record.kinds.values())


def direct(record):
    """Whether z was measured, and a force shook the rig."""
    return displacing(record) and not record.base


def displacing(record):
    """Whether all its outputs are displacements."""
    return not any(powers_of(record))
