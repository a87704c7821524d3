"""The digital loop on the multi-body rig: reads xs and x, and commands a force that is held from sample to sample."""

import numpy as np

from ...model.chipmunk import RigSpace


class Loop:
    """n rigs side by side in one `RigSpace`, each under its own digital controller; time goes on from call to call.

    ``rigs`` are one a loop, ``rate`` (Hz) and ``delay`` (samples, at least 1) the controllers', ``limit`` (N) is what
    a shaker can give, ``start`` and ``step`` (s, shortened to divide a sample) are those of the rigs, ``random`` one
    `numpy.random.Generator` a rig.
    """

    def __init__(self, rigs, rate, delay, limit, start, step, random):
        self._every = int(np.ceil(1 / (rate * step) * (1 - 1e-12)))
        self._space = RigSpace(rigs, 1 / (rate * self._every), start)
        self._delay, self._limit, self._random = delay, limit, random
        n = len(rigs)
        self.done = 0  # samples
        self._last = np.zeros(n)  # force until now
        self._ahead = np.zeros((delay, n))  # commands under way, oldest first
        self._error = np.zeros((2, n))
        self._kicks, self._taps = np.empty((self._every, n)), np.zeros((self._every, n))
        self._rate = rate
        self.parted = np.full(n, np.nan)

    def run(self, target, forward, gains, noise):
        """Follow ``target`` (samples, 2, n) of (xs, x), with a force ``forward`` (samples, n) that needs no reading.

        ``gains`` (4, n) are P and D of xs and then of x; ``noise`` (2, n) is the standard deviation of what the sensors
        add. Returned are the readings (samples, 2, n), the force (samples, n) that acted from each sample to the next,
        and the feedback's part of it.
        """
        samples, n = forward.shape
        P, D = gains[::2], gains[1::2] * self._rate
        readings, force, feedback = np.empty((samples, 2, n)), np.empty((samples, n)), np.empty((samples, n))
        spread = [noise[:, i] * random.standard_normal((samples, 2)) for i, random in enumerate(self._random)]
        sensors = np.stack(spread, axis=2)
        for k in range(samples):
            ready = k % self._delay
            feedback[k] = self._ahead[ready]
            now = np.clip(forward[k] + feedback[k], -self._limit, self._limit)
            force[k] = now
            self._kicks[0], self._kicks[1:] = 0.5 * (self._last + now), now
            motion = self._space.advance(self._kicks, self._taps, self._every)
            readings[k, 0], readings[k, 1] = motion.shaker[0], motion.mass[0]
            readings[k] += sensors[k]
            error = target[k] - readings[k]
            self._ahead[ready] = (P * error + D * (error - self._error)).sum(axis=0)
            self._error, self._last = error, now
        self._ahead = np.roll(self._ahead, -(samples % self._delay), axis=0)
        self.done += samples
        self.parted = motion.parted
        return readings, force, feedback
