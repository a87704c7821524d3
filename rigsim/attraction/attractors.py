"""Every motion that lasts at one force and frequency, found from many starts and told apart by what it is.

States are looked at once a period, when the force peaks (the stroboscopic map), and run until some of them all but
repeat after 1 to 6 periods. Newton's method then makes the orbit exact and its multipliers say whether it lasts. A
start belongs to an orbit once it has come into the orbit's trap: an ellipsoid along the multipliers' directions, shrunk
until every state tried on its shell runs home. Eqs. (3a, b) are odd, so an orbit that is not its own mirror image
-y(t + T/2) has a twin of equal period and amplitude; the two count as one motion.
"""

import math
import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import qmc

from .. import checks
from ..campaign.run import join, run_chunks, split
from ..compiled import compiled
from ..model.oscillator import matrices
from ..parameters import oscillator_of
from ..results import Result
from ..theory.amplitude import frequency_response
from .flow import Flow, accurate_flow, march

LONGEST = 6  # periods of an orbit
BRANCHES = ("low", "middle", "high")
_NEAR = 0.15  # largest relative distance of z from a single-term solution that bears its name
_HARMONICS = 9
_SAMPLES = 64  # a period, for the lines
_BLOCK = 64  # periods between two looks for orbits
_PATIENCE = 30  # e-foldings of the slowest linear mode after which what does not repeat is aperiodic
_CHUNK = 128  # states that one thread takes at a time


@dataclass(frozen=True, eq=False, repr=False)
class Attractor(Result):
    """A motion that lasts.

    Attributes
    ----------
    name : str
        "low", "middle", "high" or "only" where its line at f is that of a single-term solution; "subharmonic 1/n" if
        it repeats after n periods; "aperiodic"; or "other". Names that would be the same carry the amplitude too.
    period : int
        Forcing periods after which it repeats, 1 to 6; 0 for none.
    orbit : (k, 4) array
        States (xs, z, xs', z') at successive peaks of the force, SI; as many as the period, or a sample if it has none.
    amplitude : float
        Largest abs(z) (m).
    frequency : (l,) array
        Lines of the motion (Hz): 0 for the mean, then multiples of f/period up to 9 f. Empty if aperiodic.
    shaker, mass, relative : (l,) complex array
        The lines of xs, x and z (m).
    multipliers : (4,) complex array
        Floquet multipliers over the whole period; NaN if aperiodic.
    symmetric : bool
        Whether it is its own mirror image; if not, its twin is counted with it.
    """

    name: str
    period: int
    orbit: np.ndarray
    amplitude: float
    frequency: np.ndarray
    shaker: np.ndarray
    mass: np.ndarray
    relative: np.ndarray
    multipliers: np.ndarray
    symmetric: bool

    @property
    def giveaway(self):
        """Strongest line of z below the force's frequency: (frequency in Hz, amplitude in m); None at period 1."""
        if self.period < 2:
            return None
        at = 1 + int(np.abs(self.relative[1 : self.period]).argmax())
        return float(self.frequency[at]), float(abs(self.relative[at]))

    def summary(self):
        """One line with name, period and size."""
        if self.period == 0:
            return f"Attractor '{self.name}': no period up to {LONGEST}, z up to {1e3 * self.amplitude:.4g} mm"
        below = ""
        if self.giveaway:
            below = f", line of {1e3 * self.giveaway[1]:.3g} mm at {self.giveaway[0]:.4g} Hz"
        return (
            f"Attractor '{self.name}': period {self.period}, z up to {1e3 * self.amplitude:.4g} mm, "
            f"{1e3 * abs(self.relative[self.period]):.4g} mm at f{below}, "
            f"largest multiplier {abs(self.multipliers).max():.3f}"
        )


def attractors(parameters, force, frequency, *, law="exact", box=None, starts=256, seed=0):
    """Every motion that lasts and that one of many starts leads to.

    Parameters
    ----------
    parameters : RigParameters or OscillatorParameters
        The latter takes the cubic law only.
    force : float
        Amplitude F (N).
    frequency : float
        Hz.
    law : {"exact", "cubic"}
        Eq. (1) or Eq. (2).
    box : (4,) array_like, optional
        Half sizes of the box of starts in (xs, z, xs', z'), SI; by default twice the largest single-term amplitudes
        (or that of the free motion, if larger) and omega times that.
    starts : int
        Quasi-random states to begin from, at least 1. A motion whose basin has the share s of the box is missed with
        a probability of about (1 - s)^starts.
    seed : int

    Returns
    -------
    tuple of Attractor
        Single-term branches first, in order of amplitude, then the others.

    Raises
    ------
    ValueError
        If an argument is not allowed, or the linear system is undamped.

    Examples
    --------
    >>> [one.name for one in attractors(RigParameters(), 3.18, 30.0)]  # doctest: +SKIP
    ['low', 'high']
    """
    return landscape(parameters, force, frequency, law=law, box=box, starts=starts, seed=seed).attractors


@dataclass(frozen=True, eq=False)
class Landscape:
    """The attractors and their traps, and with them the answer to where a state leads.

    Attributes
    ----------
    flow : Flow
    attractors : tuple of Attractor
    box : (4,) array
        Half sizes of the box of starts.
    points : (k, 4) array
        Centres of the traps, at peaks of the force.
    metrics : (k, 4, 4) array
        A state y is trapped at point p if (y - p) M (y - p) < 1.
    owner : (k,) array of int
        Which attractor each belongs to.
    patience : int
        Periods after which a state that nothing has trapped is left undecided.
    """

    flow: Flow
    attractors: tuple
    box: np.ndarray
    points: np.ndarray
    metrics: np.ndarray
    owner: np.ndarray
    patience: int

    @property
    def names(self):
        """Of the attractors, a list."""
        return [one.name for one in self.attractors]

    def find(self, name):
        """The attractor of this name.

        Raises
        ------
        ValueError
            If there is none.
        """
        return self.attractors[self.names.index(checks.one_of("attractor", name, self.names))]

    def settle(self, states, *, patience=None, progress=False, executor=None, checkpoint=None, label="states"):
        """Index of the attractor that each state (n, 4) leads to, -1 where it is undecided, and after how many periods.

        What nothing traps counts as aperiodic where there is an aperiodic attractor.

        Returns
        -------
        tuple of two (n,) arrays of int
        """
        settled = self.run(states, patience or self.patience, progress, executor, checkpoint, label)
        found = settled["label"]
        if self.attractors and self.attractors[-1].period == 0:
            lost = (found < 0) & np.isfinite(settled["states"]).all(axis=1)
            found = np.where(lost, len(self.attractors) - 1, found)
        return found, settled["periods"]

    def run(self, states, patience, progress=False, executor=None, checkpoint=None, label=""):
        """Dict of ``label`` and ``periods`` as in `settle`, and ``states`` in the end."""
        common = {
            "numbers": self.flow.numbers,
            "steps": self.flow.steps,
            "points": self.points,
            "metrics": self.metrics,
            "owner": self.owner,
            "patience": patience,
        }
        chunks = [common | {"states": states[part]} for part in split(len(states), _CHUNK)]
        options = {"progress": progress, "checkpoint": checkpoint, "label": label}
        if executor is not None:
            return join(run_chunks(_settle_chunk, chunks, executor=executor, **options))
        with ThreadPoolExecutor(os.cpu_count()) as threads:  # compiled loops leave the interpreter to the others
            return join(run_chunks(_settle_chunk, chunks, executor=threads, **options))


def _settle_chunk(chunk):
    y = np.ascontiguousarray(chunk["states"].T)
    h = 2 * math.pi / chunk["numbers"][-1] / chunk["steps"]
    arrays = chunk["points"], chunk["metrics"], chunk["owner"]
    label, periods = _settle(y, chunk["numbers"], h, chunk["steps"], *arrays, chunk["patience"])
    return {"label": label, "periods": periods, "states": y.T}


@compiled(nogil=True)
def _settle(y, numbers, h, steps, points, metrics, owner, patience):
    """Run states ``y`` (4, n), in place, period by period until trapped; who trapped them, and when."""
    n = y.shape[1]
    label, periods = np.full(n, -1), np.full(n, patience)
    place = np.arange(n)  # which state a column of ``running`` is
    running = y.copy()
    gap, no_tap = np.empty(4), np.empty(0)
    for period in range(patience + 1):
        left = 0
        for i in range(n):
            trapped = -1
            for k in range(owner.size):
                square = 0.0
                for a in range(4):
                    gap[a] = running[a, i] - points[k, a]
                for a in range(4):
                    row = 0.0
                    for b in range(4):
                        row += metrics[k, a, b] * gap[b]
                    square += gap[a] * row
                if square < 1.0:
                    trapped = owner[k]
                    break
            if trapped < 0:
                place[left] = place[i]
                running[:, left] = running[:, i]
                left += 1
            else:
                label[place[i]], periods[place[i]] = trapped, period
                y[:, place[i]] = running[:, i]
        n = left
        if n == 0 or period == patience:
            break
        march(running, n, numbers, 0.0, h, steps, no_tap, 0.0, 0.0)
    for i in range(n):
        y[:, place[i]] = running[:, i]
    return label, periods


def quasi_random(count, box, seed):
    """Scrambled Sobol points (count, 4) in the box of half sizes ``box``."""
    # Drawn in whole powers of two, for which the points are balanced.
    points = qmc.Sobol(4, rng=np.random.default_rng(seed)).random_base2(max(1, math.ceil(math.log2(count))))[:count]
    return (2 * points - 1) * box


def default_box(parameters, force, frequency):
    """Half sizes (4,): twice the largest single-term amplitudes of xs and z, and omega times that; SI.

    Where no single-term solution is as large as the mass's free motion at this frequency on a still shaker, z is
    measured by that: motions of longer periods outlast the high branch.
    """
    oscillator, omega = oscillator_of(parameters), 2 * np.pi * frequency
    response = frequency_response(oscillator, force, [frequency])
    shaker, relative = (np.nanmax(np.abs(values)) for values in (response.shaker, response.relative))
    if oscillator.k3 > 0:
        relative = max(relative, math.sqrt(max(oscillator.m * omega**2 - oscillator.k1, 0.0) / (0.75 * oscillator.k3)))
    sizes = 2 * np.array([shaker, relative])
    return np.concatenate([sizes, omega * sizes])


def landscape(parameters, force, frequency, *, law="exact", box=None, starts=256, seed=0):
    """Find the attractors and build their traps; arguments as of `attractors`.

    Returns
    -------
    Landscape
    """
    force = checks.positive("force", force, "N")
    frequency = checks.positive("frequency", frequency, "Hz")
    starts = checks.integer("starts", starts, low=1)
    if box is None:
        box = default_box(parameters, force, frequency)
    box = checks.array("box", box, low=0.0, low_open=True, min_size=4)
    if box.size != 4:
        raise ValueError(f"box has {box.size} elements; expected 4, one for each of xs, z, xs', z'")
    states = quasi_random(starts, box, seed)
    corners = box * np.array(np.meshgrid(*4 * [[-1, 1]])).reshape(4, 16).T
    flow = accurate_flow(parameters, law, force, frequency, np.concatenate([corners, states[:240]]), box)
    patience = math.ceil(_PATIENCE * frequency / _slowest_rate(parameters))
    return _search(flow, box, patience, [], [], states)


def settle_and_learn(found, states, **options):
    """`Landscape.settle`, and where nothing traps a state, a search for the motion that it leads to.

    So a motion too rare for the first search is found from the very states that lead to it.

    Returns
    -------
    tuple of Landscape and (n,) array of int
        The landscape with what was learnt, and the index of the motion that each state leads to.
    """
    label, _ = found.settle(states, **options)
    for _ in range(5):
        lost = np.flatnonzero(label < 0)
        if not lost.size:
            break
        names, traps = found.names, []
        for i in range(len(names)):
            traps.append((found.points[found.owner == i], found.metrics[found.owner == i]))
        wider = _search(found.flow, found.box, found.patience, list(found.attractors), traps, states[lost[:64]])
        # Motions keep their order when others come between them.
        place = [
            next(j for j, one in enumerate(wider.attractors) if one.orbit is old.orbit) for old in found.attractors
        ]
        label = np.where(label < 0, -1, np.array([*place, -1])[label])
        found = wider
        label[lost], _ = found.settle(states[lost])
    return found, label


def _search(flow, box, patience, orbits, traps, states):
    """The landscape of some orbits and of all that is found from some states besides."""
    response = frequency_response(oscillator_of(flow.parameters), flow.force, [flow.frequency])
    orbits, traps = list(orbits), list(traps)

    def known():
        return Landscape(flow, tuple(orbits), box, *_gather(traps), patience)

    waited = 0
    while len(states) and waited < patience:
        states = _untrapped(known(), states)
        waited += _BLOCK
        while len(states) and (new := _new_orbit(known(), states)) is not None:
            period, orbit, multipliers = new
            images = -flow.advance(orbit, 0.5)
            symmetric = _near(images[0], orbit, box).any()
            orbits.append(_describe(flow, response, period, orbit, multipliers, bool(symmetric)))
            centres = orbit if symmetric else np.concatenate([orbit, images])
            traps.append((centres, _traps(flow, period, centres, box)))
            states = _untrapped(known(), states)
    if len(states):
        orbits.append(_aperiodic(flow, states))
        traps.append((np.empty((0, 4)), np.empty((0, 4, 4))))
    order = sorted(range(len(orbits)), key=lambda i: _rank(orbits[i]))
    orbits, traps = _distinct([orbits[i] for i in order]), [traps[i] for i in order]
    return known()


def _slowest_rate(parameters):
    """Of decay of the underlying linear system (1/s)."""
    mass, damping, stiffness = matrices(parameters)
    inverse = np.linalg.inv(mass)
    system = np.block([[np.zeros((2, 2)), np.eye(2)], [-inverse @ stiffness, -inverse @ damping]])
    rate = -np.linalg.eigvals(system).real.max()
    if rate <= 0:
        raise ValueError("cs and c leave the linear system undamped; expected damping, for else nothing settles")
    return rate


def _gather(traps):
    owner = np.repeat(np.arange(len(traps)), [len(points) for points, _ in traps])
    points = np.concatenate([np.empty((0, 4)), *(points for points, _ in traps)])
    metrics = np.concatenate([np.empty((0, 4, 4)), *(metrics for _, metrics in traps)])
    return points, metrics, owner


def _untrapped(known, states):
    """States one block of periods later, without those that were trapped."""
    done = known.run(states, _BLOCK)
    return done["states"][(done["label"] < 0) & np.isfinite(done["states"]).all(axis=1)]


def _near(state, orbit, box):
    return (np.abs(orbit - state) < 1e-5 * box).all(axis=1)


def _new_orbit(known, states):
    """Period, orbit and multipliers of a stable orbit that some state has all but settled on, or None.

    The dozen states that come nearest to repeating are tried.
    """
    path = [states]
    for _ in range(LONGEST):
        path.append(known.flow.advance(path[-1]))
    gaps = np.stack([(np.abs(later - states) / known.box).max(axis=1) for later in path[1:]], axis=1)
    # The shortest period that repeats nearly as well as the best one.
    period = 1 + (gaps <= 2 * gaps.min(axis=1, keepdims=True)).argmax(axis=1)
    for i in np.argsort(gaps.min(axis=1), kind="stable")[:12]:
        found = closed_orbit(known.flow, states[i], int(period[i]), known.box)
        if found is None or (np.abs(found[2]) >= 1).any():
            continue
        if not _near(found[1][0], known.points, known.box).any():
            return found
    return None


def closed_orbit(flow, state, period, box):
    """Newton's method on the stroboscopic map, from a state that nearly repeats after ``period`` periods.

    Returns
    -------
    tuple of int, (period, 4) array and (4,) complex array, or None
        Least period, states at the peaks of the force and multipliers, whether stable or not; None if the method
        strays by more than a tenth of the box or does not converge.
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
    least = min(p for p in range(1, period + 1) if period % p == 0 and _near(state, orbit[p % period][None], box)[0])
    if least < period:
        return closed_orbit(flow, state, least, box)
    return period, orbit, np.linalg.eigvals(jacobian).astype(complex)


def _map(flow, state, period, box):
    """The state ``period`` periods on, and the Jacobian of that in units of the box, by central differences."""
    shift = 1e-6 * np.eye(4)
    states = state + box * np.concatenate([np.zeros((1, 4)), shift, -shift])
    ends = flow.advance(states, period)
    return ends[0], ((ends[1:5] - ends[5:9]) / (2e-6 * box)).T


def _traps(flow, period, centres, box):
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


def _describe(flow, response, period, orbit, multipliers, symmetric):
    trace = flow.trace(orbit[:1], period, _SAMPLES)[0]
    count = _HARMONICS * period + 1
    lines = np.fft.rfft(trace[:, :2], axis=0)[:count] * (2 / len(trace))
    lines[0] /= 2
    shaker, relative = lines.T
    if period > 1:
        name = f"subharmonic 1/{period}"
    else:
        theory = response.relative[0, : response.count[0]]
        distance = np.abs(theory - relative[1]) / np.abs(theory)
        at = int(distance.argmin())
        name = "other" if distance[at] > _NEAR else "only" if len(theory) == 1 else BRANCHES[at]
    frequency = np.arange(count) * flow.frequency / period
    amplitude = float(np.abs(trace[:, 1]).max())
    order = np.argsort(-np.abs(multipliers), kind="stable")
    return Attractor(
        name, period, orbit, amplitude, frequency, shaker, shaker - relative, relative, multipliers[order], symmetric
    )


def _aperiodic(flow, states):
    """What never came to repeat, seen from the first of the states."""
    trace = flow.trace(states[:1], 256, 16)[0]
    none = np.empty(0)
    return Attractor(
        "aperiodic", 0, trace[::16], float(np.abs(trace[:, 1]).max()), none, none + 0j, none + 0j, none + 0j,
        np.full(4, np.nan + 0j), False,
    )  # fmt: skip


def _rank(one):
    names, name = [*BRANCHES, "only", "other"], one.name.partition(" (")[0]
    return (names.index(name) if name in names else len(names)) if one.period else 99, one.period, one.amplitude


def _distinct(orbits):
    names = [one.name.partition(" (")[0] for one in orbits]
    return [
        replace(one, name=name if names.count(name) == 1 else f"{name} ({1e3 * one.amplitude:.3g} mm)")
        for name, one in zip(names, orbits, strict=True)
    ]
