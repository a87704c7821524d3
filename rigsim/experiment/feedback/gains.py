"""Gains of a sampled feedback loop, designed from a model of two degrees of freedom about the motion to be held.

What is designed for is what a digital controller does. At sample k it reads y = (xs, x), takes the deviation
e_k = y*_k - y_k from its target and the backward difference of it, and commands

    u_k = sum over the signals of P e_k + D (e_k - e_{k-1})/T,

which the shaker gets ``delay`` samples later and for one sample (zero-order hold). About the motion the model is
linear, with the slope k1 + 3 k3 z(t)^2 of its suspension, periodic in time: over a sample, with the slope at the
sample's middle, s_{k+1} = E_k s_k + B_k u_{k-delay} by a matrix exponential. With the last reading and the commands
under way as further states, a period's product of such steps is the monodromy matrix of the whole loop, and the moduli
of its eigenvalues, the multipliers, say how fast what deviates dies away in a period.

Where a period is no whole number of samples, the nearest whole number is taken, with samples longer or shorter by as
much: within half a sample in a period.
"""

import numpy as np
import scipy.linalg

from ...model.oscillator import matrices

FEEDBACKS = {
    "both": np.eye(4),
    "mass": np.eye(4)[2:],
    "relative": np.array([[1.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, -1.0]]),
}  # rows: numbers that are free; columns: P and D of the shaker, then of the mass
_MARGIN = (0.9, 1.0, 1.1)  # amplitudes over the target's at which gains must do; the slope's change is twice that
_FAST = 0.6  # a multiplier that is fast enough: below it, quieter gains are better than faster ones
_QUIET = 0.1  # worth, in multipliers, of commands that jump by ms/T^2 for a metre of sensor noise
_FIRST, _DRAWN, _ROUNDS, _NARROWER = 400, 48, 5, 0.6  # of the random search


def transitions(model, relative, frequency, steps):
    """Matrices (steps, 4, 5) that take (xs, x, xs', x', u) over the steps of a period, and the length of one (s).

    ``relative`` (lines,) complex are the mean and harmonics of z (m) about which ``model`` is linearised, ``frequency``
    is in Hz.
    """
    phase = 2 * np.pi * (np.arange(steps) + 0.5) / steps
    z = (relative * np.exp(1j * np.outer(phase, np.arange(len(relative))))).real.sum(axis=1)
    mass, damping, stiffness = matrices(model)
    inverse = 1 / np.diag(mass)[:, None]
    rate = np.zeros((steps, 5, 5))
    rate[:, :2, 2:4] = np.eye(2)
    hardening = 3 * model.k3 * z[:, None, None] ** 2 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    rate[:, 2:4, :2] = -inverse * (stiffness + hardening)
    rate[:, 2:4, 2:4] = -inverse * damping
    rate[:, 2, 4] = 1 / model.ms
    length = 1 / (frequency * steps)
    return scipy.linalg.expm(rate * length)[:, :4], length


def multipliers(steps):
    """Floquet multipliers (4,) of the open rig from the `transitions` of a period."""
    product = np.eye(4)
    for step in steps:
        product = step[:, :4] @ product
    return np.linalg.eigvals(product)


def loop_multipliers(steps, length, gains, delay, reading=None):
    """Multipliers (g, k + 2 + delay) of the loop closed with each of ``gains`` (g, 4), from its steps, one a sample.

    ``steps`` (samples, k, k + 1) are `transitions`, or those of more states, of which ``reading`` (2, k) then says what
    xs and x are. The loop's states are these, the last reading, and the ``delay`` commands under way, oldest first.
    """
    g, k = len(gains), steps.shape[1]
    n, reading = k + 2 + delay, np.eye(2, k) if reading is None else reading
    P, D = gains[:, ::2], gains[:, 1::2] / length
    one = np.zeros((g, n, n))
    one[:, k : k + 2, :k] = reading  # what is read now is the last reading then
    one[:, np.arange(k + 2, n - 1), np.arange(k + 3, n)] = 1.0  # commands move up
    one[:, n - 1, :k], one[:, n - 1, k : k + 2] = -(P + D) @ reading, D
    product = np.broadcast_to(np.eye(n), (g, n, n))
    for step in steps:
        one[:, :k, :k], one[:, :k, k + 2] = step[:, :k], step[:, k]
        product = one @ product
    return np.linalg.eigvals(product)


def designed(model, relative, frequency, *, sample_rate, delay, feedback, start=None):
    """Gains (4,) that hold a motion, P and D of xs and then of x (N/m, N s/m), and the loop's largest multiplier.

    The largest of the target's amplitude and of a tenth more and less, by a random search (of its own fixed seed, about
    ``start`` if there is one) that prefers quiet gains among those that are fast enough. Whether it is below 1 is for
    the caller to see.
    """
    count = max(round(sample_rate / frequency), 4)
    cases = [transitions(model, part * relative, frequency, count) for part in _MARGIN]
    free = FEEDBACKS[feedback]

    def judged(numbers):
        gains = numbers @ free
        largest = np.max([abs(loop_multipliers(*case, gains, delay)).max(axis=1) for case in cases], axis=0)
        P, D = gains[:, ::2], gains[:, 1::2] * sample_rate
        noise = np.sqrt(((P + D) ** 2 + D**2).sum(axis=1)) / (model.ms * sample_rate**2)
        return largest, np.maximum(largest, _FAST) + _QUIET * noise

    random = np.random.default_rng(0)
    scale = np.resize([model.ks, model.ms * model.omega_s], len(free))
    if start is None:
        drawn = scale * random.standard_normal((_FIRST, len(free)))
        rounds = 3 * _ROUNDS
    else:
        drawn = np.linalg.lstsq(free.T, start, rcond=None)[0][None]
        rounds = _ROUNDS
    spread, best = 0.3 * scale, None
    for _ in range(rounds):
        largest, cost = judged(drawn)
        i = cost.argmin()
        if best is None or cost[i] < best[0]:
            best = cost[i], largest[i], drawn[i]
        else:
            spread = _NARROWER * spread
        drawn = best[2] + spread * random.standard_normal((_DRAWN, len(free)))
    return best[2] @ free, float(best[1])
