"""Every motion that lasts at one force and frequency, found from many starts and told apart by what it is.

States are looked at once a period, when the force peaks (the stroboscopic map), and run until some of them all but
repeat after 1 to 6 periods. Newton's method then makes the orbit exact and its multipliers say whether it lasts. A
start belongs to an orbit once it has come into the orbit's trap: an ellipsoid along the multipliers' directions, shrunk
until every state tried on its shell runs home. Eqs. (3a, b) are odd, so an orbit that is not its own mirror image
-y(t + T/2) has a twin of equal period and amplitude; the two count as one motion.
"""

import math
from dataclasses import replace

import numpy as np
from scipy.stats import qmc

from .. import checks
from ..campaign.cost import affordable
from ..campaign.progress import reporting
from ..model.oscillator import matrices
from ..parameters import law_of, oscillator_of
from ..theory.amplitude import frequency_response
from .flow import accurate_flow
from .motions import Attractor, Attractors
from .settle import until_trapped
from .traps import closed_orbit, near, traps_about

LONGEST = 6  # periods of an orbit
BRANCHES = ("low", "middle", "high")
_NEAR = 0.15  # largest relative distance of z from a single-term solution that bears its name
_HARMONICS = 9
_SAMPLES = 64  # a period, for the lines
_BLOCK = 64  # periods between two looks for orbits
FARTHEST = 1e9  # of a box (m, m/s)
_STATE, _PERIOD = 400, 2e-6  # of a state: bytes, and seconds a period
_PATIENCE = 30  # e-foldings of the slowest linear mode after which what does not repeat is not periodic


def attractors(parameters, force, frequency, *, law=None, box=None, starts=256, seed=0, progress=False):
    """Every motion that lasts and that one of many starts leads to.

    Parameters
    ----------
    parameters : RigParameters or OscillatorParameters
    force : float
        Amplitude F (N).
    frequency : float
        Hz.
    law : {"exact", "cubic"}, optional
        See `rigsim.parameters.law_of`.
    box : (4,) array_like, optional
        Half sizes of the box of starts in (xs, z, xs', z'), SI; by default twice the largest single-term amplitudes
        (or that of the free motion, if larger) and omega times that.
    starts : int
        Quasi-random states to begin from, at least 1. A motion whose basin has the share s of the box is missed with
        a probability of about (1 - s)^starts.
    seed : int
    progress : bool or callable
        True shows a bar; a callable is told (periods waited, periods to wait at most).

    Returns
    -------
    Attractors
        Numbered from 0: single-term branches first, in order of amplitude, then the others.

    Raises
    ------
    ValueError
        If an argument is not allowed, or the linear system is undamped.

    Examples
    --------
    >>> attractors(RigParameters(), 3.18, 30.0).names  # doctest: +SKIP
    ['low', 'high']
    """
    law = law_of(parameters, law)
    force = checks.positive("force", force, "N")
    frequency = checks.positive("frequency", frequency, "Hz")
    starts, seed = checks.integer("starts", starts, low=1), checks.seed("seed", seed)
    if box is None:
        box = default_box(parameters, force, frequency)
    box = checks.array("box", box, low=0.0, low_open=True, high=FARTHEST)
    if box.size != 4:
        raise ValueError(f"box has {box.size} elements; expected 4, one for each of xs, z, xs', z'")
    affordable_states("starts", starts, parameters, frequency)
    states = quasi_random(starts, box, seed)
    corners = box * np.array(np.meshgrid(*4 * [[-1, 1]])).reshape(4, 16).T
    flow = accurate_flow(parameters, law, force, frequency, np.concatenate([corners, states[:240]]), box)
    patience = _patience(parameters, frequency)
    none = np.empty((0, 4)), np.empty((0, 4, 4)), np.empty(0, dtype=int)
    with reporting(progress, patience, "periods at most") as report:
        found = _search(Attractors((), flow, box, starts, seed, patience, *none), states, report)
        report(patience)
    return found


def affordable_states(name, count, parameters, frequency, shared=False, at_once=None):
    """Refuse more states than memory holds ``at_once``, or than can be run in time until most of them are trapped."""
    periods = 5 + 0.2 * _patience(parameters, frequency)
    affordable(
        f"{name} = {count:.6g}", memory=_STATE * (at_once or count), seconds=_PERIOD * count * periods, shared=shared,
        instead="fewer of them",
    )  # fmt: skip


def _patience(parameters, frequency):
    """Periods after which what does not repeat is not periodic."""
    return math.ceil(_PATIENCE * frequency / _slowest_rate(parameters))


def settle_and_learn(found, states, **options):
    """`Attractors.settle`, and where nothing traps a state, a search for the motion that it leads to.

    So a motion too rare for the first search is found from the very states that lead to it. It is numbered after those
    that are known, which keep their numbers. Returns the `Attractors` with what was learnt, and the motions (n,).
    """
    label, _ = found.settled(states, **options)
    for _ in range(5):
        lost = np.flatnonzero(label < 0)
        if not lost.size:
            break
        found = _search(found, states[lost[:64]])
        label[lost], _ = found.settled(states[lost])
    return found, label


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


def _search(known, states, report=lambda waited: None):
    """What is known, and all that is found from some states besides."""
    flow, box = known.flow, known.box
    response = frequency_response(oscillator_of(flow.parameters), flow.force, [flow.frequency])
    found, new, waited = known, [], 0
    while len(states) and waited < known.patience:
        states = _untrapped(found, states)
        waited += _BLOCK
        report(min(waited, known.patience))
        while len(states) and (orbit := _new_orbit(found, states)) is not None:
            period, points, _ = orbit
            images = -flow.advance(points, 0.5)
            symmetric = bool(near(images[0], points, box).any())
            centres = points if symmetric else np.concatenate([points, images])
            new.append((_describe(flow, response, *orbit, symmetric), centres, traps_about(flow, period, centres, box)))
            found = _joined(known, new)
            states = _untrapped(found, states)
    if len(states):
        new.append((_not_periodic(flow, states), np.empty((0, 4)), np.empty((0, 4, 4))))
    return _joined(known, sorted(new, key=lambda one: _rank(one[0])))


def _joined(known, new):
    """What is known, and after it new motions with their traps, numbered on."""
    for one, centres, shapes in new:
        number = len(known)
        traps = {"points": centres, "metrics": shapes, "owner": np.full(len(centres), number)}
        joined = {name: np.concatenate([getattr(known, name), more]) for name, more in traps.items()}
        known = replace(known, members=(*known.members, replace(one, motion=number)), **joined)
    return known


def _slowest_rate(parameters):
    """Of decay of the underlying linear system (1/s)."""
    mass, damping, stiffness = matrices(parameters)
    inverse = np.linalg.inv(mass)
    system = np.block([[np.zeros((2, 2)), np.eye(2)], [-inverse @ stiffness, -inverse @ damping]])
    rate = -np.linalg.eigvals(system).real.max()
    if rate <= 0:
        raise ValueError("cs and c leave the linear system undamped; expected damping, for else nothing settles")
    return rate


def _untrapped(known, states):
    """States one block of periods later, without those that were trapped."""
    done = until_trapped(known, states, _BLOCK)
    return done["states"][(done["label"] < 0) & np.isfinite(done["states"]).all(axis=1)]


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
        if not near(found[1][0], known.points, known.box).any():
            return found
    return None


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
    lines = shaker, shaker - relative, relative
    return Attractor(-1, name, period, orbit, amplitude, frequency, *lines, multipliers[order], symmetric)


def _not_periodic(flow, states):
    """What never came to repeat, seen from the first of the states."""
    trace = flow.trace(states[:1], 256, 16)[0]
    amplitude, none = float(np.abs(trace[:, 1]).max()), 3 * [np.empty(0, dtype=complex)]
    return Attractor(
        -1, "not periodic", 0, trace[::16], amplitude, np.empty(0), *none, np.full(4, np.nan + 0j), symmetric=False
    )


def _rank(one):
    names = [*BRANCHES, "only", "other"]
    return names.index(one.name) if one.name in names else len(names), one.period or 99, one.amplitude
