"""The digital loop on the multi-body rig: reads xs and x, and commands a force that is held from sample to sample."""

import numpy as np

from ...compiled import compiled
from ...model.chipmunk import RigSpace, leapfrog


class Loop:
    """n rigs side by side in one `RigSpace`, each under its own digital controller; time goes on from call to call.

    ``rigs`` are one a loop, ``rate`` (Hz) and ``delay`` (samples, at least 1) the controllers', ``limit`` (N) is what
    a shaker can give, ``start`` and ``step`` (s, shortened to divide a sample) are those of the rigs, ``random`` one
    `numpy.random.Generator` a rig.
    """

    def __init__(self, rigs, rate, delay, limit, start, step, random):
        self._every = substeps(rate, step)
        self._space = RigSpace(rigs, 1 / (rate * self._every), start)
        self._limit, self._random, self._rate = limit, random, rate
        n = len(rigs)
        self.done = 0  # samples
        self._offset = np.array([p.LG for p in rigs])
        self._last = np.zeros(n)  # force until now
        self._ahead = np.zeros((delay, n))  # commands under way, that of sample k in row k % delay
        self._error = np.zeros((2, n))

    def run(self, target, forward, gains, noise):
        """Follow ``target`` (samples, 2, n) of (xs, x), with a force ``forward`` (samples, n) that needs no reading.

        ``gains`` (4, n) are P and D of xs and then of x; ``noise`` (2, n) is the standard deviation of what the sensors
        add. Returned are the readings (samples, 2, n), the force (samples, n) that acted from each sample to the next,
        and the feedback's part of it, as far as the limit let it act.
        """
        spread = [noise[:, i] * random.standard_normal((len(forward), 2)) for i, random in enumerate(self._random)]
        readings, force, feedback = np.stack(spread, axis=2), np.empty(forward.shape), np.empty(forward.shape)
        P, D = gains[::2], gains[1::2] * self._rate
        _run(
            *self._space.handed, self._space.step, self._every, self.done, self._offset, target, forward, P, D,
            self._limit, self._last, self._ahead, self._error, readings, force, feedback,
        )  # fmt: skip
        self.done += len(forward)
        self._space.done += len(forward) * self._every
        return readings, force, feedback

    @property
    def parted(self):
        """When each rig flew apart (s), else NaN."""
        return self._space.handed[-1].copy()


def substeps(rate, step):
    """How many steps of at most ``step`` (s) divide a sample."""
    return int(np.ceil(1 / (rate * step) * (1 - 1e-12)))


@compiled(nogil=True)
def _run(
    each_body, space_step, space, read_handles, read, write_handles, write,
    rigs, wires, mass, flown, reach, drives, circuits, slack, parted, h, every, done, offset, target, forward, P, D,
    limit, last, ahead, error, readings, force, feedback,
):  # fmt: skip
    """`Loop.run`, whose state ``last``, ``ahead`` and ``error`` is; ``readings`` come with their noise in them."""
    samples, n = forward.shape
    kicks, taps, positions = np.empty((every, n)), np.zeros((every, n)), np.empty((1, 4, n))
    sent, nominal = np.empty((1, 2, n)), np.zeros((1, 1), dtype=np.complex128)  # no drives
    for k in range(samples):
        slot = (done + k) % len(ahead)
        for i in range(n):
            now = min(max(forward[k, i] + ahead[slot, i], -limit), limit)
            force[k, i], feedback[k, i] = now, now - forward[k, i]
            kicks[0, i], kicks[1:, i] = 0.5 * (last[i] + now), now
            last[i] = now
        leapfrog(
            each_body, space_step, space, read_handles, read, write_handles, write,
            rigs, wires, mass, flown, reach, drives, circuits, slack, parted, kicks, taps, nominal,
            h, (done + k) * every, every, positions, sent,
        )  # fmt: skip
        for i in range(n):
            readings[k, 0, i] += positions[0, 0, i]
            readings[k, 1, i] += positions[0, 1, i] - offset[i] * np.cos(positions[0, 3, i])
            ahead[slot, i] = 0.0
            for j in range(2):
                now = target[k, j, i] - readings[k, j, i]
                ahead[slot, i] += P[j, i] * now + D[j, i] * (now - error[j, i])
                error[j, i] = now
