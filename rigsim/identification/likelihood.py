"""The parameters under which a simulated rig repeats a record best, and what the record says of their errors.

Outputs are the simulated rig's plus noise. Gauss-Newton steps minimise what is left, each line of the spectrum weighted
by the noise found there: with Gaussian noise that is maximum likelihood, so no other way to read the same record has
smaller errors (L. Ljung, System Identification, 1999, chapters 7 and 9). The motion that is raised to a power is the
simulated one, without the sensors' noise. Lines are those of blocks that lap by a half under a sine window, whose
squares add to one: sums over blocks and lines are the sums over time, restricted to a band.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from .simulate import Run, Structure, simulate

_STEPS = 20
_SETTLED, _NEAR = 0.03, 3.0  # standard errors
_EXACT = 1e-7  # of a parameter: no smaller step is asked for, whatever the noise
_NOISY = 3e-3  # share of an output
_BLOCKS = 24  # in a record, at least
_RESOLVED = 8.0  # s of a block at most: 0.125 Hz a line
_ROUNDING = 1e-14  # of an information whose diagonal is one
SMOOTH = 9  # lines that a spectrum of noise is averaged over


@dataclass(frozen=True, eq=False)
class Fit:
    """Where the steps ended.

    Attributes
    ----------
    structure : Structure
    run : Run
    values : ndarray, shape (parameters,)
        In the order of the structure's names.
    starts : ndarray, shape (parts, 2 d)
        First states.
    outputs, modelled : ndarray, shape (n, q)
        As recorded, and of the rig.
    reach : ndarray, shape (terms,)
        Largest motion that each term was seen at; see `simulate.simulate`.
    columns : ndarray, shape (n, q, parameters)
        Derivatives of what is modelled, without what other first states would do as well.
    left : ndarray, shape (blocks, lines, q)
        Lines of what the model leaves of the outputs.
    freed : Freed
        Takes from any column what first states and constants of the sensors would do as well.
    settled : bool
        Whether the last step was small against the standard errors.
    """

    structure: Structure
    run: Run
    values: np.ndarray
    starts: np.ndarray
    outputs: np.ndarray
    modelled: np.ndarray
    reach: np.ndarray
    columns: np.ndarray
    left: np.ndarray
    freed: "Freed"
    settled: bool


class Freed:
    """Channels without what the first states of the parts, and a constant of each sensor in each part, can do.

    Made of the derivatives by the first states, (n, q, 2 d), and the deviation of the noise of each output (q,).
    """

    def __init__(self, run, columns, noise):
        self._noise, self._parts = noise, []
        _, q, states = columns.shape
        for part in run.parts():
            size = part.stop - part.start
            own = np.zeros((size, q, states + q))
            own[..., :states] = columns[part]
            own[:, np.arange(q), states + np.arange(q)] = 1.0
            basis, triangle = np.linalg.qr((own / noise[:, None]).reshape(size * q, -1))
            kept = np.abs(np.diag(triangle)) > 1e-12 * np.abs(triangle).max()
            self._parts.append((part, basis[:, kept], triangle[np.ix_(kept, kept)], kept, states))

    def __call__(self, channels):
        """The rest of channels (n, q, ...)."""
        found = np.empty_like(channels)
        shape = (slice(None), *[None] * (channels.ndim - 2))
        for part, basis, *_ in self._parts:
            flat = (channels[part] / self._noise[shape]).reshape(len(basis), -1)
            rest = flat - basis @ (basis.T @ flat)
            found[part] = rest.reshape(channels[part].shape) * self._noise[shape]
        return found

    def states(self, left):
        """Steps of the first states, (parts, 2 d), that take most of ``left`` (n, q)."""
        steps = []
        for part, basis, triangle, kept, states in self._parts:
            step = np.zeros(kept.size)
            step[kept] = np.linalg.solve(triangle, basis.T @ (left[part] / self._noise).ravel())
            steps.append(step[:states])
        return np.array(steps)


class FitError(ValueError):
    """No rig of that structure was found near the start."""


class Lines:
    """Channels (n, ...) as the lines of their blocks within a band, shape (blocks, lines, ...)."""

    def __init__(self, sample_rate, samples, band, blocks=_BLOCKS, resolved=_RESOLVED):
        size = int(min(resolved * sample_rate, 2 * samples / (blocks + 1)))
        self.size = max(size - size % 2, 16)
        self.window = np.sin(np.pi * (np.arange(self.size) + 0.5) / self.size)
        frequency = np.fft.rfftfreq(self.size, 1 / sample_rate)
        self.kept = np.flatnonzero((frequency >= band[0]) & (frequency <= band[1]))
        self.frequency = frequency[self.kept]
        self.begins = np.arange(-self.size // 2, samples, self.size // 2)

    def __call__(self, channels):
        """Lines of the channels."""
        found = np.empty((self.begins.size, self.kept.size, *channels.shape[1:]), dtype=complex)
        window = self.window.reshape(-1, *[1] * (channels.ndim - 1))
        for block, begin in enumerate(self.begins):
            inside = channels[max(begin, 0) : begin + self.size]
            part = np.zeros((self.size, *channels.shape[1:]))
            part[max(-begin, 0) : max(-begin, 0) + len(inside)] = inside
            found[block] = np.fft.rfft(part * window, axis=0)[self.kept]
        return found


def noise_weights(left):
    """Inverse of the variance of what is left of each output at each line, (lines, q): of all blocks, smoothed."""
    power = np.mean(np.abs(left) ** 2, axis=0)
    smooth = uniform_filter1d(power, min(SMOOTH, len(power)), axis=0)
    return 1 / np.maximum(smooth, 1e-12 * smooth.max(axis=0))


def normal_equations(columns, left, weights):
    """Fisher's information (p, p) and the slope (p,) of the weighted squares, from lines of columns and of the rest."""
    p = columns.shape[-1]
    weighted = (weights[..., None] * columns).reshape(-1, p).conj().T
    return (weighted @ columns.reshape(-1, p)).real, (weighted @ left.ravel()).real


@np.errstate(all="ignore")  # on its way a fit may try a rig that flies apart
def fit(structure, values, run, outputs, band, reach, starts=None):
    """`Fit` of a structure to ``outputs`` (n, q), from starting ``values`` and, by default, from rest.

    First with white noise in each output, then with what long steps lose of the motion, then with the spectra of what
    is left then: weights that followed every step would follow a misfit that is no noise, and never settle.

    Raises
    ------
    FitError
        If the rig to start from flies apart, or the record does not hold the parameters.
    """
    d, count = len(structure.masses), len(values)
    lines = Lines(run.sample_rate, len(outputs), band)
    starts = np.zeros((len(run.begins), 2 * d)) if starts is None else starts
    lost, stages, before, step, moved = 0.0, iter((white_weights, white_weights, noise_weights)), np.inf, None, None
    weigh = weights = next(stages)
    for _ in range(_STEPS):
        coarse, columns = simulate(structure, values, run, starts, reach, range(count))
        rest = outputs - coarse - lost
        sound = np.isfinite(rest).all() and np.isfinite(columns).all()
        if sound:
            freed = Freed(run, columns[..., count:], np.maximum(rest.std(axis=0), 1e-14 * outputs.std(axis=0)))
            left = lines(freed(rest))
        elif step is None:
            raise FitError("the motion of the rig it starts from grows without end")
        if not sound or (before < np.inf and not _cost(left, weights) < before * (1 + 1e-3)):  # too far
            step, moved = step / 4, moved / 4
            values, starts = values - 3 * step, starts - 3 * moved
            continue
        weights = weigh(left) if before == np.inf else weights
        before = _cost(left, weights)
        own = freed(columns[..., :count])
        own[..., : int(structure.base)] = 0.0  # what the record says nothing of stays
        step, error = _newton(lines(own), left, weights, values[:d])
        moved = freed.states(rest - columns[..., :count] @ step)
        size = np.minimum(np.abs(step) / error, np.abs(step / values) / _EXACT).max()
        if size < _SETTLED and weigh is noise_weights:
            break
        if size < (_SETTLED if np.ndim(lost) else _NEAR) and weigh is not noise_weights:
            if np.ndim(lost) == 0:
                lost = _lost(structure, values, run, starts, reach, coarse, outputs)
            weigh, before = next(stages), np.inf
        values, starts = values + step, starts + moved
    if not sound:
        raise FitError("no step towards the record is small enough")
    return Fit(structure, run, values, starts, outputs, outputs - rest, reach, own, left, freed, size < _SETTLED)


def _newton(own, left, weights, masses):
    """A Gauss-Newton step that leaves the masses above zero, and its standard errors."""
    information, slope = normal_equations(own, left, weights)
    if not (np.isfinite(information).all() and np.isfinite(slope).all()):
        raise FitError("the record does not hold its parameters")
    covariance = inverse(information)
    step = covariance @ slope
    far = -step[: masses.size] / masses
    return step * min(1.0, 0.8 / max(far.max(), 1e-300)), np.sqrt(np.maximum(np.diag(covariance), 1e-300))


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


def _lost(structure, values, run, starts, reach, coarse, outputs):
    """What long steps lose of the motion, which hardly changes once the parameters are near."""
    finer = lambda times: simulate(structure, values, run, starts, reach, finer=times)[0]  # noqa: E731
    two = finer(2)
    if (np.std(outputs - coarse, axis=0) > _NOISY * np.std(outputs, axis=0)).all():
        return two + (two - coarse) / 15 - coarse
    four = finer(4)
    return four + (four - two) / 15 - coarse


def white_weights(left):
    """Weights of noise that is white, and another in each output, (1, q)."""
    return 1 / np.mean(np.abs(left) ** 2, axis=(0, 1))[None]


def _cost(left, weights):
    return np.sum(weights * np.abs(left) ** 2)
