"""Which motion is reached from which state: a picture on the plane (z, z') and shares of a four-dimensional box."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import binomtest

from .. import checks
from ..parameters import law_of
from ..results import Result, frame
from .attractors import FARTHEST, affordable_states, attractors, quasi_random, settle_and_learn
from .motions import Attractors


@dataclass(frozen=True, eq=False, repr=False)
class Basins(Result):
    """Basins of attraction at one force and frequency.

    Attributes
    ----------
    attractors : Attractors
        The motions, the flow and the box.
    motion : int
        On which the shaker is when the force peaks: all states of the picture share its xs and xs'.
    z, speed : (p,) array
        Axes of the picture: z (m) and z' (m/s).
    label : (p, p) array of int
        Motion reached, -1 for none; rows follow ``speed``, columns ``z``.
    share, share_low, share_high : (k,) array
        Of each motion in the box, by its number, and its 95 % interval (Wilson's, for as many independent points;
        quasi-random ones are spread more evenly, so it errs on the wide side).
    samples : int
        Quasi-random states in the box.
    """

    attractors: Attractors
    motion: int
    z: np.ndarray
    speed: np.ndarray
    label: np.ndarray
    share: np.ndarray
    share_low: np.ndarray
    share_high: np.ndarray
    samples: int

    plots = {"basins": "basins_figure"}

    def table(self):
        """`pandas.DataFrame`: a row a motion, with its size and its share."""
        shares = 100 * np.array([self.share, self.share_low, self.share_high]).T
        rows = [
            (one.motion, one.name, one.period or "none", 1e3 * one.amplitude, share, f"{low:.2f} to {high:.2f}")
            for one, (share, low, high) in zip(self.attractors, shares, strict=True)
        ]
        return frame(rows, ["motion", "name", "period", "largest |z| [mm]", "share [%]", "95 % interval [%]"])

    def summary(self):
        """One line: the motions and their shares."""
        told = ", ".join(f"{name} {share:.1%}" for name, share in zip(self.attractors.names, self.share, strict=True))
        flow = self.attractors.flow
        return f"Basins at {flow.frequency:g} Hz and {flow.force:g} N: {told} of {self.samples} states"


def basins(
    parameters, force, frequency, motion=0, *, law=None, pixels=121, window=None, samples=2048, box=None, starts=256,
    seed=0, progress=False, executor=None, checkpoint=None,
):  # fmt: skip
    """Find the motions that last at one frequency, and which states lead to each.

    Parameters
    ----------
    parameters, force, frequency, law, box, starts, seed
        See `attractors`; the box is also that of the shares.
    motion : int or str
        That the shaker is on in the picture: its number, or a name that only one bears; see `attractors`.
    pixels : int
        Of the picture along each side.
    window : (2,) array_like, optional
        Half sizes of the picture in z (m) and z' (m/s); by default those of the box.
    samples : int
        Quasi-random states for the shares.
    progress, executor, checkpoint
        See `rigsim.campaign.run.run_chunks`; by default a thread a core. Results do not depend on it.

    Returns
    -------
    Basins

    Raises
    ------
    ValueError
        If an argument is not allowed, or names no motion.

    Examples
    --------
    >>> basins(RigParameters(), 3.18, 30.0)  # doctest: +SKIP
    Basins at 30 Hz and 3.18 N: low 8.4%, high 91.6% of 2048 states
    """
    progress, executor, checkpoint = checks.running(progress, executor, checkpoint)
    frequency, law = checks.positive("frequency", frequency, "Hz"), law_of(parameters, law)
    pixels = checks.integer("pixels", pixels, low=2)
    samples = checks.integer("samples", samples, low=1)
    if window is not None:
        window = checks.array("window", window, low=0.0, low_open=True, high=FARTHEST, size=2)
    shared = executor or checkpoint
    affordable_states("pixels^2 + samples", pixels**2 + samples, parameters, frequency, shared)
    found = attractors(parameters, force, frequency, law=law, box=box, starts=starts, seed=seed)
    around = found.find(motion)
    halves = found.box[[1, 3]] if window is None else window
    z, speed = (np.linspace(-half, half, pixels) for half in halves)
    plane = np.empty((pixels, pixels, 4))
    plane[..., 0], plane[..., 2] = around.orbit[0, [0, 2]]
    plane[..., 1], plane[..., 3] = z, speed[:, None]
    states = np.concatenate([plane.reshape(-1, 4), quasi_random(samples, found.box, seed + 1)])
    found, label = settle_and_learn(found, states, progress=progress, executor=executor, checkpoint=checkpoint)
    picture, drawn = label[: pixels**2].reshape(pixels, pixels), label[pixels**2 :]
    count = [int((drawn == one.motion).sum()) for one in found]
    interval = np.array([binomtest(k, samples).proportion_ci(0.95, method="wilson") for k in count])
    return Basins(found, around.motion, z, speed, picture, np.array(count) / samples, *interval.T, samples)
