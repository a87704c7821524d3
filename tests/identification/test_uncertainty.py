"""Intervals hold what they promise: 95 % of them the true value, whatever is noisy."""

import numpy as np
import pytest

from rigsim.identification.layout import TWO_MASSES
from rigsim.identification.physical import NAMES
from rigsim.identification.trust import trusted
from rigsim.identification.verdict import errors_of
from rigsim.parameters import RigParameters
from tests.identification.cubic import cubic_record

P = RigParameters().oscillator
TRUE = np.array([getattr(P, name) for name in NAMES])
CELLS = [(on_force, on_outputs) for on_force in (0, 1e-3, 0.01, 0.05) for on_outputs in (0, 1e-3, 0.01, 0.05)][1:]


def estimated(on_force, on_outputs, seed, duration=20, noise=None):
    """`ParameterErrors` of a record with noise in shares of each channel's rms."""
    record = cubic_record(duration=duration, noise=on_outputs, seed=seed)
    disturbed = np.random.default_rng((seed, 1)).normal(size=record.force.size) * on_force * record.force.std()
    away = np.random.default_rng((seed, 2)).uniform(0.99, 1.01, size=7)
    return errors_of(TWO_MASSES, trusted(record.replace(force=record.force + disturbed), [TRUE * away], (2, 80)), noise)


def covered(cells, seeds, tell, declared=False):
    """Share of the intervals that hold the true value, by cell."""
    found = {}
    for cell in cells:
        errors = [estimated(*cell, seed, noise=cell[0] if declared else None) for seed in range(seeds)]
        inside = [np.abs(one.value - TRUE) <= one.half_width for one in errors]
        found[cell] = float(np.mean(inside))
    shares = ", ".join(f"force {a:g} outputs {b:g}: {100 * share:.1f} %" for (a, b), share in found.items())
    tell(f"95 % intervals, {seeds} seeds each{', force noise declared' if declared else ''}: {shares}")
    return found


def test_noise_on_the_outputs_is_told_as_the_least_possible(tell):
    errors = [estimated(0, 0.01, seed) for seed in range(3)]
    for one in errors:
        assert (np.abs(one.value - TRUE) < 4 * one.standard_error).all()
        np.testing.assert_allclose(one.standard_error, one.bound, rtol=0.15)
        assert (one.disagreement == 1).all()


@pytest.mark.full
def test_intervals_hold_the_true_values(tell):
    found = covered([(0, 0.01), (0.01, 0), (0.05, 0.05)], 20, tell)
    assert min(found.values()) > 0.85


@pytest.mark.soak
def test_intervals_hold_the_true_values_over_many_records(tell):
    found = covered(CELLS, 200, tell)
    assert min(found.values()) > 0.88
    declared = covered([cell for cell in CELLS if cell[0]], 200, tell, declared=True)
    assert min(declared.values()) > 0.88
