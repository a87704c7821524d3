"""A periodic orbit made exact, and the traps about its points: what has come into one surely stays."""

import math

import numpy as np
from scipy.stats import qmc


def closed_orbit(flow, state, period, box):
    """Newton's method on the stroboscopic map, from a state that nearly repeats after ``period`` periods.

    Returns the least period, states (period, 4) at the peaks of the force and multipliers (4,), whether stable or not;
    or None if the method strays by more than a tenth of the box or does not converge.
    """
    start = state
    for _ in range(15):
        end, jacobian = _map(flow, state, period, box)
        step = np.linalg.solve(jacobian - np.eye(4), (state - end) / box)
        state = state + box * step
        if not (np.abs(state - start) < 0.1 * box).all():
            return None
        if np.abs(step).max() < 1e-10:
            break
    else:
        return None
    path = [state]
    for _ in range(period - 1):
        path.append(flow.advance(path[-1][None])[0])
    orbit = np.array(path)
    least = min(p for p in range(1, period + 1) if period % p == 0 and near(state, orbit[p % period][None], box)[0])
    if least < period:
        return closed_orbit(flow, state, least, box)
    return period, orbit, np.linalg.eigvals(jacobian).astype(complex)


def _map(flow, state, period, box):
    """The state ``period`` periods on, and the Jacobian of that in units of the box, by central differences."""
    shift = 1e-6 * np.eye(4)
    states = state + box * np.concatenate([np.zeros((1, 4)), shift, -shift])
    ends = flow.advance(states, period)
    return ends[0], ((ends[1:5] - ends[5:9]) / (2e-6 * box)).T


def traps_about(flow, period, centres, box):
    """Metrics (k, 4, 4) of the traps about the points of an orbit."""
    directions = qmc.MultivariateNormalQMC(np.zeros(4), rng=np.random.default_rng(1)).random(32)
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    metrics = []
    for centre in centres:
        _, jacobian = _map(flow, centre, period, box)
        values, vectors = np.linalg.eig(jacobian)
        inverse = np.linalg.inv(vectors)
        metric = (inverse.conj().T @ inverse).real  # in it the linear map shrinks every distance
        lengths, axes = np.linalg.eigh(metric)
        radius = 0.2 * math.sqrt(lengths[0])
        home = 2 * math.ceil(math.log(0.1) / math.log(min(np.abs(values).max(), 0.999)))
        while True:
            shell = (directions / np.sqrt(lengths)) @ axes.T * radius
            ends = flow.advance(centre + box * np.concatenate([shell, shell / 2]), home * period)
            gaps = (ends - centre) / box
            if (np.einsum("ni,ij,nj->n", gaps, metric, gaps) < (radius / 4) ** 2).all():
                break
            radius /= 2
        # Half of what was seen to run home.
        metrics.append(metric / np.outer(box, box) / (radius / 2) ** 2)
    return np.array(metrics)


def near(state, orbit, box):
    """Whether each point of an orbit is the given state but for rounding, (k,) bool."""
    return (np.abs(orbit - state) < 1e-5 * box).all(axis=1)
