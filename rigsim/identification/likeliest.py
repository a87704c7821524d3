"""The rig that repeats a record best: what is given to the fit, and where it starts from."""

from dataclasses import replace
from itertools import chain, product

import numpy as np
from scipy import signal

from ..experiment.joints import slices
from .layout import layout_of, outputs_of
from .likelihood import FitError, fit
from .lines import Lines
from .model import displacements
from .simulate import Run, displaced, simulate

_SHORTEST = 64  # samples
_FORETOLD = (8, 4, 2)  # periods of its shaker, of a motion that cannot be foretold for longer
_TRIES = 3
_CUBIC_SHARES, _DAMPING_SHARES = (0.0, 0.15, 0.4, 0.7, 0.9, -0.2), (1.0, 0.3)
_FLIES = 1e6  # times the outputs
LOST = 0.3  # of an output left by a rig that does not repeat the record
_ENOUGH = 0.03  # of an output left


def likeliest(structure, record, starts, band, sensitive=False):
    """`Fit` of a structure to a record from the best of some ``starts``, values in the order of its names.

    Raises
    ------
    FitError
        If none leads anywhere.
    """
    if sensitive:
        return _in_parts(structure, record, starts[0], band)
    best, error = None, None
    outputs, run, reach = given(structure, record, record.joints, band)
    for values in _nearest_first(structure, starts, outputs, run, reach, band)[:_TRIES]:
        try:
            found = fit(structure, values, run, outputs, band, reach)
        except FitError as why:
            error = why
            continue
        if best is None or found.share_left.max() < best.share_left.max():
            best = found
        if best.share_left.max() < LOST:
            break
    if best is None:
        raise error
    return best


def cubic_starts(record, guess, band):
    """The linear parameters of a response with some cubic coefficients beside them, values in the order of the names.

    The stiffness that a random motion shows is k1 + 3 k3 times the mean square of z: each start gives a share of it to
    the cubic spring. The damping that it shows is too large, since what a harder spring scatters looks like it.
    """
    motion = outputs_of(displacements(record, band))
    square, stiffness = layout_of(record).across(motion).var(), guess[-1]
    return [
        np.array([*guess[:-2], less * guess[-2], (1 - share) * stiffness, share * stiffness / (3 * square)])
        for share, less in product(_CUBIC_SHARES, _DAMPING_SHARES)
    ]


def _in_parts(structure, record, values, band):
    """The fit to parts that are as long as can be."""
    found = None
    outputs, run, reach = given(structure, record, record.joints, band)
    own = dict(zip(structure.names, values, strict=True))
    slowest = np.sqrt(own["ks"] / own["ms"] if "ks" in own else own["k1"] / own["m"])
    for periods in _FORETOLD:
        short = max(_SHORTEST, int(periods * record.sample_rate * 2 * np.pi / slowest))
        tests = slices(record.joints, len(outputs))
        cuts = [range(test.start, max(test.start + 1, test.stop - short // 2), short) for test in tests]
        run = replace(run, begins=tuple(chain(*cuts)))
        try:
            pieces = fit(structure, values, run, outputs, band, reach, states_of(run, record, band))
        except FitError:
            continue
        if found is None or (pieces.share_left < found.share_left / 3).any():
            found = pieces
        if found.share_left.max() < _ENOUGH:
            break
    if found is None:
        raise FitError("its motion grows without end")
    return found


def states_of(run, record, band):
    """First states of the parts as the outputs show them, (parts, 2 d)."""
    motion = outputs_of(displacements(record, band))
    motion = motion - motion.mean(axis=0)
    velocity = signal.savgol_filter(motion, 9, 3, deriv=1, delta=1 / run.sample_rate, axis=0)
    return np.hstack([motion, velocity])[list(run.begins)]


def simulated_motion(record, starts, band):
    """z of the rig of those at some starts that repeats a record best, (n,); None if it flies apart."""
    layout = layout_of(record)
    structure = layout.structure(record)
    outputs, run, reach = given(structure, record, record.joints, band)
    starts = [layout.ordered(values, structure) for values in starts]
    values = _nearest_first(structure, starts, outputs, run, reach, band)[0]
    motion = layout.across(displaced(structure, values, run, None, reach)[0])
    return motion if np.abs(motion).max() < _FLIES * reach[-1] else None


def _nearest_first(structure, starts, outputs, run, reach, band):
    """Starts in the order of what their rigs leave of the outputs."""
    if len(starts) == 1:
        return starts
    lines = Lines(run.sample_rate, len(outputs), band)
    size, costs = np.abs(lines(outputs)).std(axis=(0, 1)), []
    for values in starts:
        rest = outputs - simulate(structure, values, run, None, reach)[0]
        flies = not np.abs(rest).max() < _FLIES * np.abs(outputs).max()
        costs.append(np.inf if flies else np.sum(np.abs(lines(rest - rest.mean(axis=0)) / size) ** 2))
    return [starts[place] for place in np.argsort(costs)]


def given(structure, record, begins, band):
    """Outputs, the `Run`, and how far each term is moved."""
    run = Run(record.force, record.sample_rate, record.hold, begins, record.joints)
    motion = outputs_of(displacements(record, band))
    motion = motion - motion.mean(axis=0)
    velocity = np.gradient(motion, 1 / record.sample_rate, axis=0)
    reach = [
        np.abs((velocity if term.of == "velocity" else motion) @ direction).max()
        for term, direction in zip(structure.terms, structure.directions(), strict=True)
    ]
    return outputs_of(record), run, np.array(reach)
