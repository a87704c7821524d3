"""Forces on the rig, read at the steps of the leapfrog: held samples, a cosine, a tap.

A kick at time t gives the velocity the impulse of half a step before and half a step after,
so a force that jumps at t enters as the mean of its left and right values. The first kick, at t = 0,
covers only the half step after.
"""

from dataclasses import dataclass

import numpy as np

from .. import checks

HOLDS = ("zero", "linear")


@dataclass(frozen=True)
class Tap:
    """A light tap on the suspended mass: a half-sine force pulse along +x through its centre of mass.

    The impulse is m ``velocity``: the pulse alone would set the free mass moving at that velocity.

    Attributes
    ----------
    velocity : float
        m/s; negative for a tap along -x.
    duration : float
        s.
    time : float
        Start of the pulse (s).

    Raises
    ------
    ValueError
        If a value is not finite, the duration is not above zero or the time is negative.
    """

    velocity: float = 0.5
    duration: float = 2e-3
    time: float = 1.0

    def __post_init__(self):
        set_field = lambda name, value: object.__setattr__(self, name, value)  # noqa: E731
        set_field("velocity", checks.real("tap velocity", self.velocity, "m/s"))
        set_field("duration", checks.positive("tap duration", self.duration, "s"))
        set_field("time", checks.real("tap time", self.time, "s", low=0.0))

    def force(self, mass, time):
        """Force (N) on a mass of ``mass`` kg at ``time`` (s), with the shape of ``time``."""
        mass, time = checks.positive("mass", mass, "kg"), checks.array("time", time, "s", ndim=None)
        phase = (time - self.time) / self.duration
        peak = mass * self.velocity * np.pi / (2 * self.duration)
        return np.where((phase > 0) & (phase < 1), peak * np.sin(np.pi * phase), 0.0)


@dataclass(frozen=True, eq=False)
class HeldForce:
    """A sampled force on one frame, held between its samples."""

    samples: np.ndarray  # N, shape (n,)
    substeps: int  # of the leapfrog, a sample interval
    hold: str  # of HOLDS

    def kicks(self, first, count):
        """Force (N) of the kicks ``first`` to ``first + count - 1``, shape (count, 1)."""
        step = np.arange(first, first + count)
        sample, part = np.divmod(step, self.substeps)
        last = len(self.samples) - 1
        right = self.samples[np.minimum(sample, last)]
        if self.hold == "zero":
            left = self.samples[np.maximum(sample - 1, 0)]
            kick = np.where(part == 0, (left + right) / 2, right)
        else:
            kick = right + (self.samples[np.minimum(sample + 1, last)] - right) * (part / self.substeps)
        return kick[:, None]

    def between(self, first, count):
        """Force (N) in the middle of the steps after the same kicks, complex, shape (count, 1)."""
        sample, part = np.divmod(np.arange(first, first + count), self.substeps)
        last = len(self.samples) - 1
        value = self.samples[np.minimum(sample, last)].astype(complex)
        if self.hold == "linear":
            value += (self.samples[np.minimum(sample + 1, last)] - value) * ((part + 0.5) / self.substeps)
        return value[:, None]


@dataclass(frozen=True, eq=False)
class CosineForce:
    """F cos(2 pi f t) on each of n frames."""

    amplitude: np.ndarray  # N, shape (n,)
    frequency: np.ndarray  # Hz, shape (n,)
    step: float  # of the leapfrog (s)

    def kicks(self, first, count):
        """Force (N) of the kicks ``first`` to ``first + count - 1``, shape (count, n)."""
        time = self.step * np.arange(first, first + count)
        return self.amplitude * np.cos(2 * np.pi * self.frequency * time[:, None])

    def between(self, first, count):
        """F exp(2 pi i f t) (N) in the middle of the steps after the same kicks, complex, shape (count, n)."""
        time = self.step * (np.arange(first, first + count) + 0.5)
        return self.amplitude * np.exp(2j * np.pi * self.frequency * time[:, None])


@dataclass(frozen=True, eq=False)
class TapForce:
    """Taps on each of n masses."""

    taps: tuple  # of Tap or None, length n
    mass: np.ndarray  # kg, shape (n,)
    step: float  # of the leapfrog (s)

    def kicks(self, first, count):
        """Force (N) of the kicks ``first`` to ``first + count - 1``, shape (count, n)."""
        time = self.step * np.arange(first, first + count)
        result = np.zeros((count, len(self.taps)))
        for i, tap in enumerate(self.taps):
            if tap is not None and tap.time <= time[-1] and tap.time + tap.duration >= time[0]:
                result[:, i] = tap.force(self.mass[i], time)
        return result
