"""What sensors make of a motion: noise, drift and resolution, of the measurement and never of the motion."""

from dataclasses import dataclass

import numpy as np

from ... import checks

_MOST = 10.0  # of a channel's rms: more noise than that is no measurement


@dataclass(frozen=True)
class Sensors:
    """Two displacement sensors, of the shaker and of the suspended mass, alike and each with noise of its own.

    The same motion is measured whatever they are: a protocol that waits for a motion to settle waits for the motion
    itself, whose status it tells, and the lines that it reads alone are those of the sensors.

    Attributes
    ----------
    noise : float or str
        White, normal, on every sample: its rms in m, or as text a share of the channel's own rms where it is read, such
        as ``"1 %"``.
    drift : float
        m/s, from the beginning of the test.
    resolution : float
        m, to a multiple of which each sample is rounded; 0 for none.
    seed : int
        Of the noise: the same seed gives the same samples, whoever else is tested.

    Raises
    ------
    ValueError
        If a value is not allowed.
    """

    noise: float | str = 0.0
    drift: float = 0.0
    resolution: float = 0.0
    seed: int = 0

    def __post_init__(self):
        set_field = lambda name, value: object.__setattr__(self, name, value)  # noqa: E731
        set_field("noise", _noise(self.noise))
        set_field("drift", checks.real("drift", self.drift, "m/s"))
        set_field("resolution", checks.real("resolution", self.resolution, "m", low=0.0))
        set_field("seed", checks.seed("seed", self.seed))

    def measured(self, time, displacements, number=0):
        """What they show of ``displacements`` (samples, 2), xs and x (m), at ``time`` (samples,) from the test's begin.

        ``number`` is that of the reading: each has noise of its own.
        """
        time = checks.array("time", time, "s")
        seen = checks.array("displacements", displacements, "m", ndim=2, physical=False)
        if seen.shape != (time.size, 2):
            raise ValueError(f"displacements have the shape {seen.shape}; expected ({time.size}, 2), a row a sample")
        number = checks.integer("number", number, low=0)
        if self.noise:
            share = isinstance(self.noise, str)
            rms = _share(self.noise) * seen.std(axis=0) if share else self.noise
            seen = seen + rms * np.random.default_rng([self.seed, number]).standard_normal(seen.shape)
        if self.drift:
            seen = seen + self.drift * time[:, None]
        return np.round(seen / self.resolution) * self.resolution if self.resolution else seen


def _share(text):
    """The share that "1 %" says, or None."""
    number, percent, rest = text.partition("%")
    try:
        share = float(number) / 100
    except ValueError:
        return None
    return share if percent and not rest.strip() and 0 <= share <= _MOST else None


def _noise(value):
    if not isinstance(value, str):
        return checks.real("noise", value, "m", low=0.0)
    if _share(value) is None:
        raise ValueError(f"noise = {checks.shown(value)} is not allowed; expected an rms in m, or a share as '1 %'")
    return value
