"""The parameters under which a simulated rig repeats a record best, and what the record says of their errors.

Outputs are the simulated rig's plus noise. Gauss-Newton steps minimise what is left, each line of the spectrum weighted
by the noise found there: with Gaussian noise that is maximum likelihood, so no other way to read the same record has
smaller errors (L. Ljung, System Identification, 1999, chapters 7 and 9). The motion that is raised to a power is the
simulated one, without the sensors' noise. Lines are those of blocks that lap by a half under a sine window, whose
squares add to one: sums over blocks and lines are the sums over time, restricted to a band.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.ndimage import uniform_filter1d

from .lines import Freed, Gathered, Lines, inverse
from .simulate import Run, Structure, displaced, marched, simulate

_STEPS = 20
_SETTLED = 0.03  # standard errors
_OUTDATED = 1.5  # times the weights of what was taken for noise
_EXACT = 3e-5  # of a parameter: no smaller step is asked for, whatever the noise
_ENDLESS = 1e100  # of anything
_NOISY = 3e-3  # share of an output
SMOOTH, _AVERAGED = 9, 120  # lines that a spectrum of noise is averaged over at least, and lines of blocks


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
    own : ndarray, shape (blocks, lines, q, parameters)
        Lines of the derivatives of what is modelled, without what other first states would do as well.
    left : ndarray, shape (blocks, lines, q)
        Lines of what the model leaves of the outputs.
    freed : Freed
        Takes from any column what first states and constants of the sensors would do as well.
    settled : bool
        Whether the last step was small against the standard errors.
    lines : Lines
        Of the record's length.
    """

    structure: Structure
    run: Run
    values: np.ndarray
    starts: np.ndarray
    outputs: np.ndarray
    modelled: np.ndarray
    reach: np.ndarray
    own: np.ndarray
    left: np.ndarray
    freed: Freed
    settled: bool
    lines: Lines

    @cached_property
    def owners(self):
        """Which test each block belongs to."""
        return self.lines.owners(self.run.joints, self.left)

    @cached_property
    def share_left(self):
        """Rms of what is left of each output over the band, over that output, (q,)."""
        whole = self.lines(self.outputs - self.outputs.mean(axis=0))
        return np.sqrt(np.mean(np.abs(self.left) ** 2, axis=(0, 1)) / np.mean(np.abs(whole) ** 2, axis=(0, 1)))

    def displaced(self):
        """Displacements and velocities of the masses, (n, d) each."""
        if all(what == "displacement" for _, what in self.structure.sensors):
            return self.modelled, np.gradient(self.modelled, 1 / self.run.sample_rate, axis=0)
        return displaced(self.structure, self.values, self.run, self.starts, self.reach)


class FitError(ValueError):
    """No rig of that structure was found near the start."""


def noise_weights(left, owners):
    """Inverse of the variance of what is left, (blocks, lines, q): of all blocks of a test, smoothed over lines."""
    weights = np.empty(left.shape)
    for owner in np.unique(owners):
        own = owners == owner
        power = np.mean(np.abs(left[own]) ** 2, axis=0)
        smooth = uniform_filter1d(power, min(smoothing(own.sum()), len(power)), axis=0)
        weights[own] = 1 / np.maximum(smooth, 1e-12 * smooth.max(axis=0))
    return weights


def smoothing(blocks):
    """Lines that a spectrum of so many blocks is averaged over."""
    return max(SMOOTH, -(-_AVERAGED // blocks))


def normal_equations(columns, left, weights):
    """Fisher's information (p, p) and the slope (p,) of the weighted squares, from lines of columns and of the rest."""
    p = columns.shape[-1]
    information, slope = np.zeros((p, p)), np.zeros(p)
    every = np.broadcast_to(weights, left.shape)
    for block, rest, own in zip(columns, left, every, strict=True):  # one at a time stays in the processor's cache
        weighted = (own[..., None] * block).reshape(-1, p).conj().T
        information += (weighted @ block.reshape(-1, p)).real
        slope += (weighted @ rest.ravel()).real
    return information, slope


@dataclass(frozen=True, eq=False)
class _Look:
    """What a rig leaves of a record, (n, q) and as lines, and what steps from there, or from near there, would do."""

    values: np.ndarray
    starts: np.ndarray
    rest: np.ndarray
    left: np.ndarray
    toward: np.ndarray
    begun: np.ndarray
    own: np.ndarray
    freed: Freed
    shares: np.ndarray

    @classmethod
    def at(cls, values, starts, rest, lines, own, freed, shares):
        """The look from some place, with derivatives of it or of one nearby."""
        toward = freed.states(rest)
        return cls(
            values, starts, rest, freed.lines(lines, rest), toward, freed.motion(lines, toward), own, freed, shares
        )

    def moved(self, step):
        """Step of the first states beside one of the parameters."""
        return self.toward - self.shares @ step


@np.errstate(all="ignore")  # on its way a fit may try a rig that flies apart
def fit(structure, values, run, outputs, band, reach, starts=None):
    """`Fit` of a structure to ``outputs`` (n, q), from starting ``values`` and, by default, from rest.

    First with white noise in each output, then with what long steps lose of the motion, then with the spectra of what
    is left then: weights that followed every step would follow a misfit that is no noise, and never settle. Derivatives
    are taken anew after a step that goes beyond what they foretell, and where the steps end.

    Raises
    ------
    FitError
        If the rig to start from flies apart, or the record does not hold the parameters.
    """
    starts = np.zeros((len(run.begins), 2 * len(structure.masses))) if starts is None else starts
    search = _Search(structure, run, outputs, reach, Lines(run.sample_rate, len(outputs), band), values, starts)
    for _ in range(_STEPS):
        if search.arrived():
            search.aim()
        if search.settled:
            break
    if search.lost_its_way:
        raise FitError("no step towards the record is small enough")
    return _found(structure, run, outputs, reach, search.lines, search.look, search.settled)


@np.errstate(all="ignore")
def at(structure, values, run, outputs, band, reach, starts):
    """`Fit` that takes no step; arguments and errors as of `fit`."""
    lines, usual = Lines(run.sample_rate, len(outputs), band), (structure, values, run, starts, reach)
    _, lost = _lost(usual, outputs)
    look = _look(structure, run, outputs, reach, lines, values, starts, lost)
    if look is None:
        raise FitError("its motion grows without end")
    return _found(structure, run, outputs, reach, lines, look, False)


def _found(structure, run, outputs, reach, lines, look, settled):
    modelled, own, left, freed = outputs - look.rest, look.own, look.left, look.freed
    return Fit(structure, run, look.values, look.starts, outputs, modelled, reach, own, left, freed, settled, lines)


class _Search:
    """Where the steps of a `fit` are, and where they go: it looks around there, then aims."""

    def __init__(self, structure, run, outputs, reach, lines, values, starts):
        self._rig, self._outputs, self.lines, self._whole = (structure, run, reach), outputs, lines, lines(outputs)
        self._values, self._starts, self._step, self._lost, self._spectral = values, starts, None, None, False
        self.look, self.settled, self.lost_its_way = None, False, False

    def arrived(self):
        """Look around, or go back where the step here was too far: whether it was not."""
        structure, run, reach = self._rig
        lost = 0.0 if self._lost is None else self._lost
        fresh = _look(structure, run, self._outputs, reach, self.lines, self._values, self._starts, lost)
        self.lost_its_way = fresh is None
        if fresh is None and self.look is None:
            raise FitError("the motion of the rig it starts from grows without end")
        lower = fresh and self.look and self._cost(fresh.left) < self._cost(self.look.left) * (1 + 1e-3)
        if self.look and not lower and (fresh is None or self.look is self._near):
            self._go(*(step / 4 for step in self._step))
            return False
        if not lower:  # the first look, or one that was foretold wrong
            self._weights, self._spectral = white_weights(fresh.left), False
        self.look = self._near = fresh
        return True

    def aim(self):
        """The next step: all that can be done with the derivatives of the last look, and then another look."""
        fresh = self.look
        while True:
            look = self.look
            if self._spectral and look is self._near:
                weights = self._noise_weights(look.left)
                if (weights > _OUTDATED * self._weights).any():
                    self._weights = weights  # what was foretold to be left was no noise
            step, error = _newton(look.own, look.left, self._weights, look.values[: len(self._rig[0].masses)])
            size = np.minimum(np.abs(step) / error, np.abs(step / look.values) / _EXACT).max()
            self.settled = bool(self._spectral and look is self._near and size < _SETTLED)
            # What the step and the first states do, and that by the share that it is of the motion.
            foretold = look.own @ step
            beyond = self._cost(foretold + look.begun) / np.sqrt(self._cost(self._whole))
            done = self.settled or not beyond < _SETTLED
            if not done and self._lost is not None and not self._spectral:
                self._weights, self._spectral = self._noise_weights(look.left - foretold), True
                continue
            self._go(step, look.moved(step))
            if done or (self._spectral and look is not fresh):
                return
            self._look_again(look.left - foretold)

    def _go(self, step, moved):
        """On from the last look."""
        self._step = step, moved
        self._values, self._starts = self.look.values + step, self.look.starts + moved

    def _look_again(self, foretold):
        """With the derivatives of the last look, and what long steps lose if that is not known."""
        (structure, run, reach), look = self._rig, self.look
        usual = structure, self._values, run, self._starts, reach
        if self._lost is None:
            once, self._lost = _lost(usual, self._outputs)
        else:
            once, _ = simulate(*usual)
        rest = self._outputs - once - self._lost
        self.look = _Look.at(self._values, self._starts, rest, self.lines, look.own, look.freed, look.shares)
        if not self._spectral:
            self._weights = white_weights(self.look.left)
        elif self._cost(self.look.left - foretold) < _SETTLED**2:
            self._near = self.look

    def _noise_weights(self, left):
        return noise_weights(left, self.lines.owners(self._rig[1].joints, left))

    def _cost(self, left):
        return np.sum(self._weights * np.abs(left) ** 2)


def _look(structure, run, outputs, reach, lines, values, starts, lost):
    """A fresh look at a rig, or None if it flies apart."""
    (_, q), count, coarse = outputs.shape, len(values), np.empty(outputs.shape)
    gathered, none = Gathered(lines, run.begins, q, count), np.empty((0, q, starts.shape[1]))
    begun = [[none] for _ in run.begins]
    for part, seen, columns in marched(structure, values, run, starts, reach, range(count)):
        alive = columns[..., count:].copy() if columns.shape[2] > count else none
        coarse[part] = seen
        gathered.add(part, columns[..., :count], alive)
        begun[np.searchsorted(run.begins, part.start, "right") - 1].append(alive)
    rest, begun = outputs - coarse - lost, [np.concatenate(pieces) for pieces in begun]
    if not all(np.abs(found).max(initial=0.0) < _ENDLESS for found in (gathered.largest(), rest, *begun)):
        return None
    freed = Freed(run, begun, np.maximum(_size(rest), 1e-14 * _size(outputs)))
    own, shares = gathered.rest(freed)
    own[..., : int(structure.base)] = 0.0  # what the record says nothing of stays
    return _Look.at(values, starts, rest, lines, own, freed, shares)


def moved_beside(fit, structure, values, reach, wanted, extra):
    """What a fitted rig does, (n, q), and lines of the rest of what more terms and small forces would move.

    The rig is the fit's, with more terms in its ``structure``, ``values`` and ``reach``; ``wanted`` and ``extra`` are
    those of `simulate.simulate`.
    """
    outputs, count = np.empty_like(fit.outputs), len(wanted) + extra.shape[1]
    gathered = Gathered(fit.lines, fit.run.begins, outputs.shape[1], count)
    for part, seen, columns in marched(structure, values, fit.run, fit.starts, reach, wanted, extra, states=False):
        outputs[part] = seen
        gathered.add(part, columns, fit.freed.alive(part))
    return outputs, gathered.rest(fit.freed)[0]


def _newton(own, left, weights, masses):
    """A Gauss-Newton step that leaves the masses above zero, and its standard errors."""
    information, slope = normal_equations(own, left, weights)
    if not (np.isfinite(information).all() and np.isfinite(slope).all()):
        raise FitError("the record does not hold its parameters")
    covariance = inverse(information)
    step = covariance @ slope
    far = -step[: masses.size] / masses
    return step * min(1.0, 0.8 / max(far.max(), 1e-300)), np.sqrt(np.maximum(np.diag(covariance), 1e-300))


def _lost(rig, outputs):
    """What a rig does in long steps, and what these lose, which hardly changes once the parameters are near.

    That falls with the fourth power of the step, and what is beyond it with the fifth.
    """
    once, twice = (simulate(*rig, finer=times)[0] for times in (1, 2))
    if (_size(outputs - once) > _NOISY * _size(outputs)).all():
        return once, (twice - once) * (16 / 15)
    thrice = simulate(*rig, finer=3)[0]
    return once, (243 * thrice - 64 * twice - 179 * once) / 180


def _size(channels):
    """Deviation of each channel (n, q), which NumPy takes long for where they lie side by side."""
    return np.ascontiguousarray(channels.T).std(axis=1)


def white_weights(left, owners=None):
    """Weights of noise that is white, and another in each output (1, q), or in each of every test, (blocks, 1, q)."""
    if owners is None:
        return 1 / np.mean(np.abs(left) ** 2, axis=(0, 1))[None]
    power = np.mean(np.abs(left) ** 2, axis=1, keepdims=True)
    return 1 / np.stack([power[owners == owner].mean(axis=0) for owner in owners])
