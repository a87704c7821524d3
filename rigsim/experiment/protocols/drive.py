"""The force on a bench: stretches of a cosine whose amplitude and frequency stay or move on, its phase carried over."""

from dataclasses import astuple, dataclass, replace

import numpy as np

from ...model.excitation import Tap


@dataclass(frozen=True)
class Drive:
    """A stretch F(t) cos(2 pi n(t)), n the periods that the force has turned, t from the stretch's own beginning.

    F runs straight from ``force`` to ``force_end`` (N), and f = dn/dt from ``frequency`` to ``frequency_end`` (Hz),
    straight or, if ``logarithmic``, by equal factors in equal times. n is in closed form and continuous from stretch to
    stretch, so the force is continuous where F is; where F jumps, at a kick, that kick gets the mean of both values.
    Either keeps the leapfrog of second order.
    """

    force: float
    force_end: float
    frequency: float
    frequency_end: float
    steps: int  # of the leapfrog
    step: float  # s
    turns: float = 0.0  # periods turned when it begins, less whole ones
    before: float = np.nan  # N, the amplitude until then; at a start there was none
    logarithmic: bool = False
    velocity: float = 0.0  # m/s, of a tap; 0 for none
    pulse: float = 2e-3  # s
    tapped: float = 0.0  # s, when the tap begins

    @property
    def duration(self):
        """s."""
        return self.steps * self.step

    @property
    def tap(self):
        """The `Tap` in it, its time from the stretch's beginning, or None."""
        return Tap(self.velocity, self.pulse, self.tapped) if self.velocity else None

    def amplitude_at(self, time):
        """N."""
        return self.force + (self.force_end - self.force) / self.duration * time

    def frequency_at(self, time):
        """Hz."""
        share = time / self.duration
        if self.logarithmic:
            return self.frequency * (self.frequency_end / self.frequency) ** share
        return self.frequency + (self.frequency_end - self.frequency) * share

    def turned(self, time):
        """Periods that the force has turned."""
        if self.frequency == self.frequency_end:
            return self.turns + self.frequency * time
        if self.logarithmic:
            pace = np.log(self.frequency_end / self.frequency) / self.duration
            return self.turns + self.frequency * np.expm1(pace * time) / pace
        return self.turns + (self.frequency + (self.frequency_end - self.frequency) / 2 / self.duration * time) * time

    def kicks(self, first, count):
        """Force (N) of its kicks ``first`` to ``first + count - 1``, shape (count,)."""
        time = self.step * np.arange(first, first + count)
        amplitude = self.amplitude_at(time)
        if first == 0 and not np.isnan(self.before):
            amplitude[0] = (self.before + amplitude[0]) / 2
        return amplitude * np.cos(2 * np.pi * self.turned(time))

    def between(self, first, count):
        """F exp(2 pi i n) (N) in the middle of the steps after the same kicks, complex, shape (count,)."""
        time = self.step * (np.arange(first, first + count) + 0.5)
        return self.amplitude_at(time) * np.exp(2j * np.pi * self.turned(time))

    def pulses(self, mass, first, count):
        """Force of the tap (N) on a mass (kg) at the same kicks."""
        time = self.step * np.arange(first, first + count)
        if not self.velocity or time[-1] < self.tapped or time[0] > self.tapped + self.pulse:
            return np.zeros(count)
        return self.tap.force(mass, time)

    def ended(self, steps):
        """A copy that is over after so many steps."""
        return replace(self, steps=steps)

    def then(self, force, frequency, steps, **changes):
        """The stretch that follows, at first at a ``force`` and a ``frequency``, both of which stay unless told."""
        ends = {"force_end": force, "frequency_end": frequency} | changes
        turns = float(self.turned(self.duration) % 1.0)
        return Drive(force, frequency=frequency, steps=steps, step=self.step, turns=turns,
                     before=float(self.amplitude_at(self.duration)), **ends)  # fmt: skip

    def row(self):
        """All of it as numbers; `Drive.of` reads them."""
        return [float(value) for value in astuple(self)]

    @classmethod
    def of(cls, row):
        """The stretch whose `row` it is."""
        values = [float(value) for value in row]
        return cls(*values[:4], int(values[4]), *values[5:8], bool(values[8]), *values[9:])
