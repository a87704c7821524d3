"""Single-term theory of a rig that a shaker drives: at each frequency a constant force on a rig with other damping."""

from dataclasses import dataclass

import numpy as np

from .. import checks
from ..model.shaker import ShakerDrive
from ..parameters import OscillatorParameters, oscillator_of
from ..results import Result, frame
from .amplitude import frequency_response


@dataclass(frozen=True, eq=False, repr=False)
class DrivenResponse(Result):
    """Every single-term solution under a `ShakerDrive`; what `driven_response` returns.

    Amplitudes are complex, zero to peak, their phase against the cosine that was asked for; solutions ascend along the
    second axis in abs(relative), padded with NaN.

    Attributes
    ----------
    parameters : OscillatorParameters
    drive : ShakerDrive
    asked : float
        Force that was asked for (N).
    frequency : ndarray, shape (n,)
        Hz.
    shaker, mass, relative : ndarray, complex, shape (n, 3)
        xs, x and z (m).
    force, voltage : ndarray, complex, shape (n, 3)
        On the frame (N) and at the coil (V).
    count : ndarray of int, shape (n,)
        Solutions at each frequency.
    """

    parameters: OscillatorParameters
    drive: ShakerDrive
    asked: float
    frequency: np.ndarray
    shaker: np.ndarray
    mass: np.ndarray
    relative: np.ndarray
    force: np.ndarray
    voltage: np.ndarray
    count: np.ndarray

    def summary(self):
        """One line: how far the force drops, and where there are several solutions."""
        low = np.nanmin(np.abs(self.force)) / self.asked
        several = self.frequency[self.count > 1]
        told = f"three solutions from {several.min():.4g} to {several.max():.4g} Hz" if several.size else "one solution"
        least = f"the force is {low:.0%} of the {self.asked:g} N or more"
        return f"DrivenResponse, constant {self.drive.mode}: {least}; {told}"

    def table(self):
        """`pandas.DataFrame` with a row a frequency, of the solution of the least z."""
        columns = {
            "frequency [Hz]": self.frequency, "solutions": self.count, "|f| [N]": abs(self.force[:, 0]),
            "|u| [V]": abs(self.voltage[:, 0]), "|xs| [mm]": 1e3 * abs(self.shaker[:, 0]),
            "|z| [mm]": 1e3 * abs(self.relative[:, 0]),
        }  # fmt: skip
        return frame(columns)


def driven_response(parameters, force, frequency, drive):
    """`DrivenResponse`: `rigsim.theory.amplitude.frequency_response` of `ShakerDrive.equivalent` at each frequency.

    The circuit is linear, so this is exact for the fundamentals: single-term balance drops no more than without a
    drive. Stability is not told: to a perturbation the drive is not what it is to the fundamental.

    Parameters
    ----------
    parameters : RigParameters or OscillatorParameters
    force : float
        What is asked for (N), as the drive means it.
    frequency : array_like, shape (n,)
        Hz, above zero.
    drive : ShakerDrive

    Raises
    ------
    ValueError
        If an argument is not allowed.
    """
    p, force = oscillator_of(parameters), checks.positive("force", force, "N")
    frequency = checks.array("frequency", frequency, "Hz", low=0.0, low_open=True)
    drive = checks.instance("drive", drive, ShakerDrive, "a ShakerDrive")
    found = []
    for f in frequency:
        equivalent, effective = drive.equivalent(p, force, f)
        one = frequency_response(equivalent, abs(effective), [f])
        turned = effective / abs(effective)
        found.append([turned * one.shaker[0], turned * one.mass[0], turned * one.relative[0]])
    shaker, mass, relative = np.moveaxis(np.array(found), 1, 0)
    omega = 2 * np.pi * frequency[:, None]
    # The frame's equation: shaker and suspended mass are what the force moves.
    acted = (p.ks + 1j * omega * p.cs - omega**2 * p.ms) * shaker - omega**2 * p.m * mass
    impedance = drive.resistance + 1j * omega * drive.inductance
    voltage = impedance * acted / drive.force_factor + 1j * omega * drive.force_factor * shaker
    count = np.isfinite(relative).sum(axis=1)
    return DrivenResponse(p, drive, force, frequency, shaker, mass, relative, acted, voltage, count)
