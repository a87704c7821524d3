"""Terms of a rig: what acts between two of its masses, or a mass and the ground, and on which motion it depends."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Term:
    """A force p phi(r) between two masses that grows with a coefficient p.

    Attributes
    ----------
    name : str
        Of the coefficient.
    between : tuple of int
        The mass it acts on and the one it acts from, counted from the shaker, 0; one number is a mass and the ground.
    law : callable or None
        phi, of arrays; None is phi(r) = r.
    of : {"displacement", "velocity"}
        What r is: the first mass's displacement or velocity, less the second's.
    unit : str
        Of the coefficient.
    """

    name: str
    between: tuple
    law: Callable | None = None
    of: str = "displacement"
    unit: str = "N/m"

    def direction(self, masses):
        """What r takes of each of so many masses, shape (masses,)."""
        found = np.zeros(masses)
        found[list(self.between)] = (1.0, -1.0)[: len(self.between)]
        return found


@dataclass(frozen=True)
class Power:
    """phi(r) = r^exponent, or |r|^exponent with the sign of r."""

    exponent: float
    signed: bool = False

    def __call__(self, r):
        """Of an array."""
        return np.sign(r) * np.abs(r) ** self.exponent if self.signed else r**self.exponent


@dataclass(frozen=True)
class Gap:
    """phi(r) of a spring that is met at r = width on either side (m)."""

    width: float

    def __call__(self, r):
        """Of an array."""
        return np.sign(r) * np.maximum(np.abs(r) - self.width, 0.0)


@dataclass(frozen=True)
class Friction:
    """phi(r') of dry friction: its sign, smoothed over a speed (m/s)."""

    speed: float

    def __call__(self, r):
        """Of an array."""
        return np.tanh(r / self.speed)


LINEAR = (
    Term("ks", (0,)),
    Term("cs", (0,), of="velocity", unit="N s/m"),
    Term("c", (0, 1), of="velocity", unit="N s/m"),
    Term("k1", (0, 1)),
)
CUBIC = Term("k3", (0, 1), Power(3), unit="N/m^3")
