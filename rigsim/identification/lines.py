"""Channels as lines of their spectra, without what the first state of a motion and constants of sensors can do."""

import numpy as np
from scipy import signal

from ..campaign.stop import sliced
from ..compiled import compiled

_BLOCKS = 24  # in a record, at least
_RESOLVED = 8.0  # s of a block at most: 0.125 Hz a line
_PIECE = 4000  # samples at a time
_THIN, _SHORT = 2.5, 64  # times the band's end that half of a thinned rate is at least; samples of a block, at least
_ROUNDING = 1e-14  # of an information whose diagonal is one
_FOLDED = 90.0  # dB that what folds into the lines of a thinned channel is weaker by


class Lines:
    """Channels (n, ...) as the lines of their blocks within a band, shape (blocks, lines, ...).

    Where the band ends far below half the sample rate, of channels that a finite filter smoothes only every so many
    samples are transformed, and its gain is divided out.
    """

    def __init__(self, sample_rate, samples, band, blocks=_BLOCKS, resolved=_RESOLVED):
        longest = min(resolved * sample_rate, 2 * samples / (blocks + 1))
        self._every = int(max(1, min(sample_rate / (2 * _THIN * band[1]), longest / _SHORT)))
        self._count, rate = -(-samples // self._every), sample_rate / self._every
        size = int(longest / self._every)
        size = max(size - size % 2, 16)
        self.window = np.sin(np.pi * (np.arange(size) + 0.5) / size)
        frequency = np.fft.rfftfreq(size, 1 / rate)
        self.kept = np.flatnonzero((frequency >= band[0]) & (frequency <= band[1]))
        self.frequency = frequency[self.kept]
        self.size, self.begins = self._every * size, self._every * np.arange(-size // 2, self._count, size // 2)
        self._taps = np.ones(1)
        if self._every > 1:
            count, shape = signal.kaiserord(_FOLDED, 2 * (rate - 2 * band[1]) / sample_rate)
            self._taps = signal.firwin(count | 1, rate / 2, window=("kaiser", shape), fs=sample_rate)
        turned = 2 * np.pi / sample_rate * np.outer(self.frequency, np.arange(self._taps.size) - self._taps.size // 2)
        self._scale = self._every / (np.cos(turned) @ self._taps)

    def __call__(self, channels):
        """Lines of the channels."""
        thinned = self.nothing(channels[0].size)
        self.add(channels, 0, thinned)
        return self.of(thinned).reshape(self.begins.size, self.kept.size, *channels.shape[1:])

    def owners(self, joints, left):
        """Which test each block belongs to, of those that begin at ``joints``, (blocks,): where two meet, the louder.

        That is by what is ``left`` of the outputs, (blocks, lines, q), whose noise a block in both has.
        """
        last = min(self._every * self._count, self.begins[-1] + self.size) - 1
        ends = np.clip([self.begins, self.begins + self.size - 1], 0, last)
        first, second = np.searchsorted(joints, ends, "right") - 1
        power = np.mean(np.abs(left) ** 2, axis=(1, 2))
        loudness = np.array([np.median(power[(first == test) | (second == test)]) for test in range(len(joints))])
        return np.where(loudness[second] > loudness[first], second, first)

    def nothing(self, count):
        """So many thinned channels without a sample, (count, samples)."""
        return np.zeros((count, self._count))

    def add(self, channels, begin, thinned):
        """Add some samples of channels (n, ...), of which the first is number ``begin``, to ``thinned`` ones."""
        _thin(np.ascontiguousarray(channels.reshape(len(channels), -1).T), begin, self._every, self._taps, thinned)

    def of(self, thinned):
        """Lines of thinned channels, (blocks, lines, count)."""
        found = np.empty((self.begins.size, self.kept.size, len(thinned)), dtype=complex)
        half, padded = self.window.size // 2, np.zeros((self.begins.size + 1) * self.window.size // 2)
        for number, channel in enumerate(thinned):
            if not channel.any():
                found[..., number] = 0.0
                continue
            padded[half : half + channel.size] = channel
            blocks = np.lib.stride_tricks.sliding_window_view(padded, self.window.size)[::half]
            found[..., number] = np.fft.rfft(blocks * self.window)[:, self.kept] * self._scale
        return found


@compiled(fastmath={"reassoc", "contract"})
def _thin(channels, begin, every, taps, thinned):
    """Add to the thinned channels what some samples, from ``begin`` on, of smoothed channels (c, n) are of them."""
    half, n = taps.size // 2, channels.shape[1]
    for c in range(channels.shape[0]):
        channel = channels[c]
        if not channel.any():
            continue
        for i in range(max(0, -((half - begin) // every)), min(thinned.shape[1], (begin + n - 1 + half) // every + 1)):
            shift, total = every * i - half - begin, 0.0
            first, last = max(0, -shift), min(taps.size, n - shift)
            weights, samples = taps[first:last], channel[shift + first : shift + last]
            for t in range(weights.size):
                total += weights[t] * samples[t]
            thinned[c, i] += total


class Freed:
    """Channels without what the first states of the parts, and a constant of each sensor in each part, can do.

    Made of the derivatives by the first states of each part, (n, q, 2 d) or fewer samples where they die away, and the
    deviation of the noise of each output (q,).
    """

    def __init__(self, run, begun, noise):
        self._weights, self._parts, self._basis = noise**-2.0, [], None
        for part, own in zip(run.parts(), begun, strict=True):
            q, states = own.shape[1:]
            information = np.zeros((states + q, states + q))
            information[:, :states] = self._weighted(products(own, own))
            information[:states, states:] = information[states:, :states].T
            information[states:, states:] = np.diag(self._weights * (part.stop - part.start))
            self._parts.append((part, own, inverse(information)))

    def __call__(self, channels):
        """The rest of channels (n, q, ...)."""
        found = np.array(channels, dtype=float)
        flat = found.reshape(len(found), len(self._weights), -1)
        for number, (part, own, _) in enumerate(self._parts):
            rest, states = flat[part], own.shape[2]
            shares = self.shares(number, products(own, rest))
            rest[: len(own)] -= own @ shares[:states]
            for output, constant in enumerate(shares[states:]):
                rest[:, output] -= constant
        return found

    def lines(self, lines, channels):
        """Lines of the rest of channels (n, q, ...)."""
        if len(self._parts) > 1:
            return lines(self(channels))
        flat = channels.reshape(*channels.shape[:2], -1)
        taken = self.basis(lines) @ self.shares(0, products(self._parts[0][1], flat))
        return lines(channels) - taken.reshape(lines.begins.size, -1, *channels.shape[1:])

    def basis(self, lines):
        """Lines of all that the first state and the constants of a single part can do, (blocks lines q, 2 d + q)."""
        if self._basis is None:
            (part, own, _), q = self._parts[0], len(self._weights)
            begun, constant = lines.nothing(own[:1].size), lines.nothing(1)
            lines.add(own, 0, begun)
            lines.add(np.ones((part.stop, 1)), 0, constant)
            begun = lines.of(begun).reshape(lines.begins.size, -1, *own.shape[1:])
            basis = np.concatenate([begun, lines.of(constant)[..., None] * np.eye(q)], axis=-1)
            self._basis = basis.reshape(-1, basis.shape[-1])
        return self._basis

    def alive(self, samples):
        """Derivatives by the first states at a slice of samples of one part, of those where they have not died away."""
        begins = [part.start for part, *_ in self._parts]
        part, own, _ = self._parts[np.searchsorted(begins, samples.start, "right") - 1]
        return own[samples.start - part.start : samples.stop - part.start]

    def shares(self, number, products):
        """Of the first states of a part and of its constants, (2 d + q, c), in channels with such `products`."""
        return self._parts[number][2] @ self._weighted(products)

    def taken(self, number, shares):
        """What is to be taken of channels (n, q, c) for such ``shares``, some samples at a time after their slice."""
        part, own, _ = self._parts[number]
        states = own.shape[2]
        for piece in sliced(part.stop - part.start, _PIECE):
            alive = own[piece] @ shares[:states]
            taken = np.empty((piece.stop - piece.start, *alive.shape[1:]))
            taken[:] = shares[states:]
            taken[: len(alive)] += alive
            yield slice(part.start + piece.start, part.start + piece.stop), taken

    def states(self, left):
        """Steps of the first states, (parts, 2 d), that take most of ``left`` (n, q)."""
        return np.array([
            self.shares(number, products(own, left[part][..., None]))[: own.shape[2], 0]
            for number, (part, own, _) in enumerate(self._parts)
        ])  # fmt: skip

    def motion(self, lines, steps):
        """Lines of what steps of the first states, (parts, 2 d), do, (blocks, lines, q)."""
        if len(self._parts) == 1:
            basis = self.basis(lines)[:, : steps.shape[1]]
            return (basis @ steps[0]).reshape(lines.begins.size, -1, len(self._weights))
        found = np.zeros((self._parts[-1][0].stop, len(self._weights)))
        for (part, own, _), step in zip(self._parts, steps, strict=True):
            found[part][: len(own)] = own @ step
        return lines(found)

    def _weighted(self, products):
        """The right side of the normal equations, (2 d + q, c)."""
        return np.concatenate(
            [np.tensordot(self._weights, products[:, :-1], 1), self._weights[:, None] * products[:, -1]]
        )


def products(begun, channels):
    """Sums over time of first states' columns (alive, q, 2 d) and of one, each times channels, (q, 2 d + 1, c)."""
    early = begun.transpose(1, 2, 0) @ channels[: len(begun)].transpose(1, 0, 2)
    return np.concatenate([early, np.ones((1, len(channels))) @ channels.transpose(1, 0, 2)], axis=1)


class Gathered:
    """Lines of the rest of columns (n, q, c) that come some samples at a time, and are never held as a whole."""

    def __init__(self, lines, begins, q, count):
        self._lines, self._begins, self._shape = lines, begins, (q, count)
        self._thinned, self._sums = lines.nothing(q * count), [0.0] * len(begins)

    def add(self, samples, columns, begun):
        """The columns at a slice of samples, and the derivatives by the first states there."""
        number = np.searchsorted(self._begins, samples.start, "right") - 1
        self._sums[number] = self._sums[number] + products(begun, columns)
        self._lines.add(columns, samples.start, self._thinned)

    def largest(self):
        """Largest sum of all, by which endless columns are known."""
        return max(np.abs(found).max(initial=0.0) for found in (self._thinned, *self._sums))

    def rest(self, freed):
        """Lines (blocks, lines, q, c), and steps of the first states (parts, 2 d, c) that do as much as columns do."""
        lines, shares = self._lines, [freed.shares(number, sums) for number, sums in enumerate(self._sums)]
        if len(shares) > 1:
            for number, share in enumerate(shares):
                for part, taken in freed.taken(number, share):
                    lines.add(-taken, part.start, self._thinned)
        found = lines.of(self._thinned).reshape(lines.begins.size, -1, *self._shape)
        if len(shares) == 1:
            found -= (freed.basis(lines) @ shares[0]).reshape(found.shape)
        return found, np.array(shares)[:, : -self._shape[0]]


def inverse(information):
    """Its inverse, in directions that the record hardly tells of no larger than rounding lets it be known.

    Steps along them are too short then, which is safe, and errors are large; a parameter that is held has neither.
    """
    free = np.flatnonzero(np.diag(information) > 0)
    scale = np.sqrt(np.diag(information)[free])
    values, vectors = np.linalg.eigh(information[np.ix_(free, free)] / np.outer(scale, scale))
    vectors = vectors / scale[:, None]
    found = np.zeros_like(information)
    found[np.ix_(free, free)] = (vectors / np.maximum(values, _ROUNDING)) @ vectors.T
    return found
