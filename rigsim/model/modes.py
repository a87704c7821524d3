"""Natural frequencies and damping ratios of M q'' + C q' + K q = 0, shared by the oscillator and the rig."""

from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.optimize

from ..results import Result, frame


@dataclass(frozen=True, eq=False, repr=False)
class Modes(Result):
    """Modes of a linear system, ascending in frequency.

    Attributes
    ----------
    frequency : ndarray, shape (n,)
        Natural frequency abs(lambda)/(2 pi) (Hz), as the paper's Table 3 gives it.
    damping : ndarray, shape (n,)
        Damping ratio -Re(lambda)/abs(lambda).
    shape : ndarray, complex, shape (n, n)
        Row i is the shape of mode i over the coordinates, largest entry 1.
    names : tuple of str
        What each mode mostly moves.
    about : StaticEquilibrium or None
        The equilibrium of the rig that they are about, where it is one's: `plot` draws them on it.
    """

    frequency: np.ndarray
    damping: np.ndarray
    shape: np.ndarray
    names: tuple
    about: object = None

    plots = {"shapes": "modes_figure"}

    def summary(self):
        """One line with every mode."""
        modes = zip(self.names, self.frequency, self.damping, strict=True)
        return "Modes: " + ", ".join(f"{name} {f:.4f} Hz ({zeta:.2%})" for name, f, zeta in modes)

    def table(self):
        """`pandas.DataFrame` with a row per mode."""
        columns = {"mode": self.names, "frequency [Hz]": self.frequency, "damping ratio": self.damping}
        return frame(columns, index="mode")


def largest_to_one(shape):
    """Mode shapes, shape (modes, coordinates), each over its largest entry."""
    return shape / np.take_along_axis(shape, np.abs(shape).argmax(axis=1)[:, None], axis=1)


def modes_of(mass, damping, stiffness, names):
    """`Modes` of the quadratic eigenvalue problem, named by where their kinetic energy is.

    The matrices are (n, n) in SI units, ``mass`` positive definite, and ``names`` one for each coordinate. `ValueError`
    if the equilibrium is unstable or a mode does not oscillate (overdamped).
    """
    n = len(mass)
    # Symmetric scaling by the modal mass keeps metres and radians comparable.
    half = np.sqrt(np.diag(mass))
    scale = 1 / np.outer(half, half)
    m, c, k = mass * scale, damping * scale, stiffness * scale
    companion = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(m, k), -np.linalg.solve(m, c)]])
    values, vectors = scipy.linalg.eig(companion)
    keep = np.argsort(np.abs(values[values.imag > 0]))
    if len(keep) != n:
        told = f"{n - len(keep)} of {n} modes do not oscillate"
        raise ValueError(f"{told}: the equilibrium is unstable or overdamped; expected stiffness, and less damping")
    order = np.flatnonzero(values.imag > 0)[keep]
    energy_shape = vectors[:n, order].T
    shape = largest_to_one(energy_shape / half)
    # Each coordinate names the mode it takes the largest share of; assigned once each.
    share = np.abs(energy_shape) ** 2
    share /= share.sum(axis=1, keepdims=True)
    row, column = scipy.optimize.linear_sum_assignment(-share)
    named = tuple(names[j] for j in column[np.argsort(row)])
    values = values[order]
    return Modes(np.abs(values) / (2 * np.pi), -values.real / np.abs(values), shape, named)
