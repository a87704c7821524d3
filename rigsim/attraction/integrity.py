"""Dynamical integrity: how large a disturbance a motion surely survives, at one frequency or along a branch."""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri
from scipy.stats import qmc

from .. import checks
from ..campaign.progress import reporting
from ..results import Result
from .attractors import landscape, settle_and_learn

_LARGEST = 20.0  # radii beyond so many times the motion's own amplitude are not looked for


@dataclass(frozen=True, eq=False, repr=False)
class Integrity(Result):
    """Largest ball about a motion that lies in its basin, when the force peaks.

    The distance of two states is sqrt(dxs^2 + dz^2 + (dxs'^2 + dz'^2)/omega^2), a length: a disturbance of one
    millimetre is one of xs or z by that much, or of a velocity by omega times that, or a mix of them.

    Attributes
    ----------
    name : str
        Of the motion.
    force : float
        N.
    frequency : (n,) array
        Hz.
    amplitude : (n,) array
        Of the motion's z at f (m); NaN where there is no such motion.
    radius : (n,) array
        Of the ball (m): distance of the nearest state that was found to lead elsewhere; NaN where there is no motion.
    offset : (n, 4) array
        That state less the motion's own (SI).
    neighbour : tuple of str
        Where it leads; "" where none was found.
    status : tuple of str
        "found", or why there is no radius.
    """

    name: str
    force: float
    frequency: np.ndarray
    amplitude: np.ndarray
    radius: np.ndarray
    offset: np.ndarray
    neighbour: tuple
    status: tuple

    plots = {"integrity": "integrity_figure"}

    def table(self):
        """`pandas.DataFrame`: a row a frequency."""
        import pandas as pd

        return pd.DataFrame(
            {
                "frequency [Hz]": self.frequency,
                "|z| [mm]": 1e3 * self.amplitude,
                "radius [mm]": 1e3 * self.radius,
                "radius over |z|": self.radius / self.amplitude,
                "beyond it": self.neighbour,
                "status": self.status,
            }
        )

    def summary(self):
        """One line with the range of radii."""
        known = self.radius[np.isfinite(self.radius)]
        told = f"radius {1e3 * known.min():.3g} to {1e3 * known.max():.3g} mm" if known.size else "no such motion"
        return f"Integrity of '{self.name}' at {self.force:g} N and {self.frequency.size} frequencies: {told}"


def integrity(
    parameters,
    force,
    frequency,
    name="high",
    *,
    law="exact",
    samples=1024,
    starts=128,
    seed=0,
    progress=False,
):
    """Radius of the largest ball of disturbances from which a motion recovers, at every frequency.

    Quasi-random states fill a ball about the motion; the nearest that leads elsewhere becomes the next ball's radius,
    until none does in two balls running. Between balls the neighbourhood of the nearest is searched for a nearer one.

    Parameters
    ----------
    parameters : RigParameters or OscillatorParameters
        The latter takes the cubic law only.
    force : float
        Amplitude F (N).
    frequency : float or (n,) array_like
        Hz.
    name : str
        Of the motion: "low" or "high" for the branches of a detached curve; see `attractors`.
    law : {"exact", "cubic"}
        Eq. (1) or Eq. (2).
    samples : int
        States a ball.
    starts, seed : int
        Of the search for motions; see `attractors`.
    progress : bool or callable
        True shows a bar; a callable is told (frequencies done, frequencies in all).

    Returns
    -------
    Integrity

    Raises
    ------
    ValueError
        If an argument is not allowed.
    """
    frequency = checks.array("frequency", frequency, "Hz", low=0.0, low_open=True)
    samples = checks.integer("samples", samples, low=16)
    n = frequency.size
    amplitude, radius, offset = np.full(n, np.nan), np.full(n, np.nan), np.full((n, 4), np.nan)
    neighbour, status = [""] * n, ["found"] * n
    with reporting(progress, n, "frequencies") as report:
        for i, f in enumerate(frequency):
            found = landscape(parameters, force, f, law=law, starts=starts, seed=seed)
            if name not in found.names:
                status[i] = f"no motion {name!r} was found; there are {', '.join(found.names)}"
            else:
                motion = found.find(name)
                if motion.period == 0:
                    raise ValueError(f"name = {name!r} is not allowed; expected a motion with a period")
                amplitude[i] = abs(motion.relative[motion.period])
                radius[i], offset[i], neighbour[i] = _ball(found, motion, samples, seed)
                if not neighbour[i]:
                    status[i] = f"no state within {_LARGEST:g} amplitudes leads elsewhere"
            report(i + 1)
    return Integrity(name, float(force), frequency, amplitude, radius, offset, tuple(neighbour), tuple(status))


def _ball(found, motion, samples, seed):
    """Radius, offset (4,) and motion of the nearest state that leads elsewhere."""
    omega = 2 * np.pi * found.flow.frequency
    scale = np.array([1.0, 1.0, omega, omega])
    size = abs(motion.relative[motion.period])
    nearest, beyond, radius, quiet = None, "", size, 0
    for turn in range(100):
        batch = _in_ball(samples, seed + turn) * radius
        if nearest is not None:
            near = nearest + 0.2 * radius * _in_ball(samples // 2, seed + 1000 + turn)
            batch = np.concatenate([batch, near[np.linalg.norm(near, axis=1) < radius]])
        found, label = settle_and_learn(found, motion.orbit[0] + batch * scale)
        astray = np.flatnonzero(label != found.names.index(motion.name))
        if astray.size:
            closest = astray[np.linalg.norm(batch[astray], axis=1).argmin()]
            nearest, beyond, quiet = batch[closest], found.names[label[closest]], 0
            radius = float(np.linalg.norm(nearest))
        elif nearest is None:
            if radius >= _LARGEST * size:
                return radius, np.full(4, np.nan), ""
            radius *= 2
        else:
            quiet += 1
            if quiet == 2:
                break
    return radius, nearest * scale, beyond


def _in_ball(count, seed):
    """Quasi-random points (count, 4) of the unit ball, uniform in volume."""
    points = qmc.Sobol(5, rng=np.random.default_rng(seed)).random_base2(int(np.ceil(np.log2(count))))[:count]
    normal = ndtri(np.clip(points[:, :4], 1e-12, 1 - 1e-12))
    return normal / np.linalg.norm(normal, axis=1)[:, None] * points[:, 4:] ** 0.25
