"""What a shaker gave in a sine test: the force that acted, the voltage that it took, and what was not asked for."""

from dataclasses import dataclass

import numpy as np

from .lines import fit_sines
from .steady import HARMONICS

NOTHING = np.full(3, np.nan + 0j)  # of a reading without a drive


@dataclass(frozen=True, eq=False)
class Driven:
    """Force and voltage of n tests with a `rigsim.model.shaker.ShakerDrive`; those without have the force asked for.

    Attributes
    ----------
    drive : tuple of ShakerDrive or None, length n
    force, voltage : ndarray, complex, shape (n,)
        Lines at the frequency of the test of the force on the frame (N) and of the voltage at the coil (V, 0 without a
        drive), zero to peak, phase against the cosine that was asked for. The current is the force over Bl.
    distortion : ndarray, shape (n,)
        Largest harmonic 2-10 of the force over its fundamental.
    limited : ndarray of bool, shape (n,)
        Whether the amplifier's largest voltage was reached: in the end, or with constant voltage ever.
    traces : ndarray, shape (n, 2, samples)
        Force (N) and voltage (V) over the window.
    """

    drive: tuple
    force: np.ndarray
    voltage: np.ndarray
    distortion: np.ndarray
    limited: np.ndarray
    traces: np.ndarray

    @classmethod
    def of(cls, drive, columns):
        """From the ``columns`` (a dict) of tests, out of which it takes its own."""
        force, voltage = columns.pop("sent").T
        return cls(
            drive, force, voltage, *(columns.pop(name) for name in ("sent distortion", "limited", "sent traces"))
        )


def check_force(name, drives, allowed):
    """Refuse tests whose force was not that of the ``allowed`` modes of a drive; ``drives`` are those of a test."""
    for drive in drives:
        if drive is not None and drive.mode not in allowed:
            expected = f"none, or constant {' or '.join(allowed)}, since the force is asked for as a cosine"
            raise ValueError(f"{name} with a drive of constant {drive.mode} is not allowed; expected {expected}")


def read_sent(time, traces, f, parted):
    """Lines of force and voltage (2,) of a window and the force's largest harmonic over its fundamental.

    ``time`` (samples,) is evenly spaced (s), ``traces`` (samples, 2) are N and V; NaN of a rig that flew apart at
    ``parted`` (s).
    """
    if not np.isnan(parted):
        return np.full(2, np.nan + 0j), np.nan
    whole = np.floor((time[-1] - time[0]) * f * (1 + 1e-9)) / f
    inside = time > time[-1] - (1 - 1e-9) * whole
    lines, _ = fit_sines(time[inside], traces[inside], f * np.arange(1, HARMONICS + 1))
    size = np.abs(lines[:, 0])
    return lines[0], size[1:].max() / size[0]
