"""Connected curves: every solution lies on exactly one of them, and they run through their folds."""

import numpy as np
import pytest

from rigsim.parameters import OscillatorParameters, RigParameters
from rigsim.theory.amplitude import frequency_response
from rigsim.theory.detached import detached_curves, force_scenario, jump_frequencies


def test_the_papers_rig_has_a_main_curve_and_a_closed_inner_one():
    main, inner = frequency_response(RigParameters(), 3.18, np.linspace(10, 120, 300)).pieces
    assert (main.kind, main.closed, inner.kind, inner.closed) == ("main", False, "inner", True)
    assert [fold.kind for fold in main.folds] == ["upper", "lower"]
    assert [fold.kind for fold in inner.folds] == ["lower", "lower"]
    assert main.frequency[0] == 10 and main.frequency[-1] == 120
    assert inner.frequency[0] == inner.frequency[-1] and inner.relative[0] == inner.relative[-1]
    for piece in (main, inner):
        steps = abs(np.diff(piece.relative)) / abs(piece.relative).max()
        assert steps.max() < 0.1  # no gap, at the folds neither
        turns = np.flatnonzero(np.diff(np.sign(np.diff(piece.frequency)))) + 1
        found = set(piece.frequency[turns]) | ({piece.frequency[0]} if piece.closed else set())
        assert found == {fold.frequency for fold in piece.folds}
        assert piece.stable.shape == piece.frequency.shape and 0 < piece.stable.sum() < piece.stable.size


@pytest.mark.parametrize(
    ("band", "expected"),
    [
        ((30, 50), [("inner", False), ("inner", False), ("main", False)]),
        ((30, 60), [("inner", False), ("main", False), ("main", False)]),
        ((60, 100), [("main", False)] * 3),
        ((5, 15), [("main", False)]),
    ],
)
def test_a_band_may_cut_curves(band, expected):
    pieces = frequency_response(RigParameters(), 3.18, np.linspace(*band, 50)).pieces
    assert sorted((piece.kind, piece.closed) for piece in pieces) == expected


def test_one_frequency_gives_its_solutions():
    pieces = frequency_response(RigParameters(), 3.18, [30.0]).pieces
    assert [piece.kind for piece in pieces] == ["inner", "inner", "main"]
    assert all(piece.frequency.tolist() == [30.0] for piece in pieces)


def test_a_curve_narrower_than_the_grid_is_drawn():
    rig, force = RigParameters(), 5.905
    (curve,) = detached_curves(rig, force)
    assert curve.high - curve.low < 1
    _, inner = frequency_response(rig, force, [10.0, 20.0, 60.0]).pieces
    assert inner.closed and inner.frequency.size > 50
    np.testing.assert_allclose([inner.frequency.min(), inner.frequency.max()], [curve.low, curve.high])


def stages(count, seed):
    """Random rigs at a force between every two neighbouring events, each over a whole band and over a cut one."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        mu, zeta_s, zeta = 10 ** rng.uniform([-3, -3, -3], [0, -0.5, -0.5])
        parameters = OscillatorParameters.from_nondimensional(mu, zeta_s, zeta, rng.uniform(0, 2), 1.0)
        edges = [event.force for event in force_scenario(parameters)]
        for below, above in zip(edges, [*edges[1:], 2 * edges[-1]], strict=True):
            force = np.sqrt(below * above)
            jumps = jump_frequencies(parameters, force) or (0.1,)
            whole = 0.5 * jumps[0], 1.5 * jumps[-1]
            yield parameters, force, whole
            yield parameters, force, np.sort(rng.uniform(*whole, 2))


def test_every_solution_lies_on_exactly_one_piece_for_any_rig_force_and_band():
    closed = {"inner": 0, "outer": 0}
    for parameters, force, (low, high) in stages(count=50, seed=11):
        response = frequency_response(parameters, force, np.linspace(low, high, 37))
        expected = np.sort(abs(response.relative[np.isfinite(response.relative)]))
        on_grid = [
            abs(a)
            for piece in response.pieces
            for f, a in zip(piece.frequency, piece.relative, strict=True)
            if f in response.frequency
        ]
        np.testing.assert_allclose(np.sort(on_grid), expected, rtol=1e-9)
        found = [piece.kind for piece in response.pieces if piece.closed]
        assert found == [c.kind for c in detached_curves(parameters, force) if low < c.low and c.high < high]
        for kind in found:
            closed[kind] += 1
    assert min(closed.values()) >= 5
