"""Dynamical integrity: how large a disturbance a motion surely survives, at one frequency or along a branch."""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri
from scipy.stats import qmc

from .. import checks
from ..campaign.progress import reporting
from ..parameters import OscillatorParameters, RigParameters, law_of, oscillator_of
from ..results import Result, Status, frame
from ..theory.amplitude import frequency_response
from .attractors import BRANCHES, affordable_states, attractors, settle_and_learn

_LARGEST = 20.0  # radii beyond so many times the motion's own amplitude are not looked for


@dataclass(frozen=True, eq=False, repr=False)
class Integrity(Result):
    """Largest ball about a motion that lies in its basin, when the force peaks.

    The distance of two states is sqrt(dxs^2 + dz^2 + (dxs'^2 + dz'^2)/omega^2), a length: a disturbance of one
    millimetre is one of xs or z by that much, or of a velocity by omega times that, or a mix of them.

    Attributes
    ----------
    branch, parameters, law, force, frequency
        As given: the name of the motion that is followed, N, Hz (n,).
    attractors : tuple of Attractors
        The motions at each frequency.
    motion : (n,) array of int
        Which of them is the branch's; -1 where none is.
    amplitude : (n,) array
        Of the motion's z at f (m); NaN where there is no such motion.
    radius : (n,) array
        Of the ball (m): distance of the nearest state that was found to lead elsewhere; NaN where there is no motion.
    offset : (n, 4) array
        That state less the motion's own (SI).
    neighbour : (n,) array of int
        The motion it leads to; -1 where no such state was found, or it is undecided.
    status : tuple of Status
        FOUND, or NOT_FOUND where there is no such motion or nothing leads elsewhere.
    message : tuple of str
        Which of these, and how far was looked.
    """

    branch: str
    parameters: RigParameters | OscillatorParameters
    law: str
    force: float
    frequency: np.ndarray
    attractors: tuple
    motion: np.ndarray
    amplitude: np.ndarray
    radius: np.ndarray
    offset: np.ndarray
    neighbour: np.ndarray
    status: tuple
    message: tuple

    plots = {"integrity": "integrity_figure"}

    def table(self):
        """`pandas.DataFrame`: a row a frequency."""
        pairs = zip(self.attractors, self.neighbour, strict=True)
        columns = {
            "frequency [Hz]": self.frequency,
            "motion": self.motion,
            "|z| [mm]": 1e3 * self.amplitude,
            "radius [mm]": 1e3 * self.radius,
            "radius over |z|": self.radius / self.amplitude,
            "beyond it": [found.names[i] if i >= 0 else "" for found, i in pairs],
            "status": [str(one) for one in self.status],
        }
        return frame(columns)

    def summary(self):
        """One line with the range of radii."""
        known = self.radius[np.isfinite(self.radius)]
        told = f"radius {1e3 * known.min():.3g} to {1e3 * known.max():.3g} mm" if known.size else "no such motion"
        return f"Integrity of '{self.branch}' at {self.force:g} N and {self.frequency.size} frequencies: {told}"


def integrity(
    parameters, force, frequency, branch="high", *, law=None, samples=1024, starts=128, seed=0, progress=False
):
    """Radius of the largest ball of disturbances from which a motion recovers, at every frequency.

    Quasi-random states fill a ball about the motion; the nearest that leads elsewhere becomes the next ball's radius,
    until none does in two balls running. Between balls the neighbourhood of the nearest is searched for a nearer one.

    Parameters
    ----------
    parameters, force, law, starts, seed
        See `attractors`.
    frequency : float or (n,) array_like
        Hz.
    branch : str
        Name of the motion: "low" or "high" for the branches of a detached curve; see `attractors`. Where several bear
        it, the one whose line at f is nearest to the single-term solution (of that name, if there is one).
    samples : int
        States a ball.
    progress : bool or callable
        True shows a bar; a callable is told (frequencies done, frequencies in all).

    Returns
    -------
    Integrity
    """
    progress, force = checks.progress(progress), checks.positive("force", force, "N")
    frequency = checks.array("frequency", frequency, "Hz", low=0.0, low_open=True)
    samples, seed = checks.integer("samples", samples, low=16), checks.seed("seed", seed)
    starts, branch = checks.integer("starts", starts, low=1), checks.text("branch", branch)
    law, n = law_of(parameters, law), frequency.size
    for name, count, most in (("samples", samples, 20), ("starts", starts, 1)):  # twenty balls are many
        states = most * n * count
        affordable_states(f"{name} at {n} frequencies", states, parameters, float(frequency.max()), at_once=count)
    amplitude, radius, offset = np.full(n, np.nan), np.full(n, np.nan), np.full((n, 4), np.nan)
    motion, neighbour = np.full(n, -1), np.full(n, -1)
    landscapes, message = [], [""] * n
    with reporting(progress, n, "frequencies") as report:
        for i, f in enumerate(frequency):
            found = attractors(parameters, force, f, law=law, starts=starts, seed=seed)
            one = _on_branch(found, branch)
            if one is None:
                message[i] = f"no motion {branch!r} was found; there are {', '.join(found.names)}"
            else:
                motion[i], amplitude[i] = one.motion, abs(one.relative[one.period])
                found, radius[i], offset[i], neighbour[i] = _ball(found, one, samples, seed)
                if np.isnan(offset[i]).any():
                    message[i] = f"no state within {_LARGEST:g} amplitudes leads elsewhere"
            landscapes.append(found)
            report(i + 1)
    status = tuple(Status.NOT_FOUND if told else Status.FOUND for told in message)
    return Integrity(
        branch, parameters, law, force, frequency, tuple(landscapes), motion, amplitude, radius, offset,
        neighbour, status, tuple(message),
    )  # fmt: skip


def _on_branch(found, branch):
    """The motion of this name, the nearest to a single-term solution if several bear it; None if there is none."""
    named = [one for one in found if one.name == branch]
    if any(one.period == 0 for one in named):
        raise ValueError(f"branch = {branch!r} is not allowed; expected a motion with a period")
    if len(named) < 2:
        return named[0] if named else None
    response = frequency_response(oscillator_of(found.flow.parameters), found.flow.force, [found.flow.frequency])
    theory = response.relative[0, : response.count[0]]
    theory = theory[[BRANCHES.index(branch)]] if branch in BRANCHES else theory
    return min(named, key=lambda one: np.abs(one.relative[one.period] / theory - 1).min())


def _ball(found, motion, samples, seed):
    """What was learnt, and radius, offset (4,) and motion reached of the nearest state that leads elsewhere."""
    omega = 2 * np.pi * found.flow.frequency
    scale = np.array([1.0, 1.0, omega, omega])
    size = abs(motion.relative[motion.period])
    nearest, beyond, radius, quiet = None, -1, size, 0
    for turn in range(100):
        batch = _in_ball(samples, seed + turn) * radius
        if nearest is not None:
            near = nearest + 0.2 * radius * _in_ball(samples // 2, seed + 1000 + turn)
            batch = np.concatenate([batch, near[np.linalg.norm(near, axis=1) < radius]])
        found, label = settle_and_learn(found, motion.orbit[0] + batch * scale)
        astray = np.flatnonzero(label != motion.motion)
        if astray.size:
            closest = astray[np.linalg.norm(batch[astray], axis=1).argmin()]
            nearest, beyond, quiet = batch[closest], label[closest], 0
            radius = float(np.linalg.norm(nearest))
        elif nearest is None:
            if radius >= _LARGEST * size:
                return found, radius, np.full(4, np.nan), -1
            radius *= 2
        else:
            quiet += 1
            if quiet == 2:
                break
    return found, radius, nearest * scale, beyond


def _in_ball(count, seed):
    """Quasi-random points (count, 4) of the unit ball, uniform in volume."""
    points = qmc.Sobol(5, rng=np.random.default_rng(seed)).random_base2(int(np.ceil(np.log2(count))))[:count]
    normal = ndtri(np.clip(points[:, :4], 1e-12, 1 - 1e-12))
    return normal / np.linalg.norm(normal, axis=1)[:, None] * points[:, 4:] ** 0.25
