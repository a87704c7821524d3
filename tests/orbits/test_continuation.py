"""Curves that are easily lost: narrow gaps and necks, near-returns, sharp turns, and bands that end at a fold.

With one harmonic of the cubic law the curves are those of single-term theory, whose folds, pieces and events of the
force come from polynomials: what they must be is known however close two curves pass.
"""

import numpy as np
import pytest

from rigsim import (
    RigParameters,
    continue_orbit,
    detached_curves,
    folds,
    force_scenario,
    frequency_response,
    periodic_orbits,
)

RIG = RigParameters()
BAND = (5, 150)
SCENARIO = force_scenario(RIG)
# So close to an event the force's distance from it is this share; gaps, necks and tiny curves go with its root.
NEAR = (-1e-2, -1e-4, -1e-6, -1e-8, 1e-8, 1e-6, 1e-4, 1e-2)


def traced(force, band=BAND):
    return periodic_orbits(RIG, force, band, harmonics=1, law="cubic")


def fold_frequencies(*branches):
    return sorted(branch.frequency[i] for branch in branches for i in branch.folds)


def sharpest_corner(branch):
    """Largest angle (rad) between a chord of a curve and the next, in relative lengths; not those at the ends."""
    z, f = branch.relative[:, 1], branch.frequency
    share = 2 * np.diff(z) / abs(z[1:] + z[:-1])
    chords = np.column_stack([share.real, share.imag, np.diff(np.log(f))])[1:-1]
    chords /= np.linalg.norm(chords, axis=1)[:, None]
    return np.arccos(np.clip((chords[1:] * chords[:-1]).sum(axis=1), -1, 1)).max()


def assert_theory_s(branches, force):
    """As many curves as theory has, closed where it has detached ones, with its folds and not too many orbits."""
    detached = detached_curves(RIG, force)
    closed = [branch for branch in branches if branch.closed]
    assert len(branches) == len(closed) + 1 and len(closed) == len(detached)
    expected = sorted(fold.frequency for fold in folds(RIG, force))
    np.testing.assert_allclose(fold_frequencies(*branches), expected, rtol=1e-7)
    for branch, curve in zip(sorted(closed, key=lambda b: b.frequency.min()), detached, strict=True):
        assert (branch.frequency.min(), branch.frequency.max()) == pytest.approx((curve.low, curve.high), rel=1e-7)
        np.testing.assert_array_equal(branch.relative[0], branch.relative[-1])
    for branch in branches:
        assert 40 < branch.frequency.size < 500 and sharpest_corner(branch) < 0.5
        steps = abs(np.diff(branch.relative[:, 1])) / abs(branch.relative[1:, 1])
        assert steps.max() < 0.1 and abs(np.diff(np.log(branch.frequency))).max() < 0.1  # no leap to another curve


@pytest.mark.parametrize("near", NEAR)
@pytest.mark.parametrize("event", SCENARIO, ids=lambda event: f"{event.kind} at {event.force:.3g} N")
def test_next_to_an_event_the_curves_are_theory_s(event, near):
    if event == SCENARIO[0] and near == 1e-8:
        pytest.skip("folds 1e-12 apart")
    force = event.force * (1 + near)
    assert_theory_s(traced(force), force)


def test_between_events_too():
    forces = [event.force for event in SCENARIO]
    for force in np.sqrt(np.multiply(forces[:-1], forces[1:])):
        assert_theory_s(traced(force), force)


@pytest.mark.parametrize(
    ("event", "near"),
    [(0, 5e-2), (1, 1e-6), (2, -1e-6), (2, 1e-6), (4, -1e-6), (4, 1e-6), (5, -1e-6), (5, 1e-6), (6, -1e-6)],
)
def test_a_curve_is_the_same_from_wherever_it_is_entered(event, near):
    """From either side of a neck, beside a second pass at almost the same place, at a fold.

    Two folds closer than a step, as where the hysteresis begins, may be passed over from elsewhere.
    """
    force = SCENARIO[event].force * (1 + near)
    for branch in traced(force):
        turns = np.array([*branch.folds, 0, branch.frequency.size - 1])
        starts = np.clip((turns[:, None] + [-7, -2, -1, 1, 2, 7]).ravel(), 1, branch.frequency.size - 2)
        for i in {*starts.tolist(), *np.linspace(1, branch.frequency.size - 2, 9).astype(int).tolist()}:
            again = continue_orbit(RIG, force, branch.frequency[i], branch.relative[i], BAND, 1, "cubic")
            assert (again.closed, again.status, again.message) == (branch.closed, branch.status, branch.message)
            if event > 0:
                np.testing.assert_allclose(fold_frequencies(again), fold_frequencies(branch), rtol=1e-7)
            if not again.closed:
                assert (again.frequency[0], again.frequency[-1]) == pytest.approx(BAND, rel=1e-12)


@pytest.mark.parametrize("near", [3e-4, 1e-3, 3e-3, 1e-2])
def test_another_pass_beside_the_start_does_not_close_the_curve(near):
    """Just above the birth of the hysteresis two sheets run side by side, a few per cent of z apart."""
    force = SCENARIO[0].force * (1 + near)
    low, high = sorted(fold.frequency for fold in folds(RIG, force))
    for share in (0.2, 0.5, 0.8):
        frequency = low + share * (high - low)
        solutions = frequency_response(RIG, force, [frequency]).relative[0]
        assert abs(solutions[2] / solutions[0] - 1) < 0.35
        for z in solutions:
            branch = continue_orbit(RIG, force, frequency, [0, z], BAND, 1, "cubic")
            assert not branch.closed and branch.frequency[[0, -1]] == pytest.approx(BAND, rel=1e-12)
            np.testing.assert_allclose(fold_frequencies(branch), [low, high], rtol=1e-9)


# Upper folds at 3.18 N, of the detached curve and of the main one, and a frequency below at which there are three.
@pytest.mark.parametrize(("which", "low"), [(1, 30.0), (3, 60.0)])
@pytest.mark.parametrize("beyond", [1e-3, 1e-5, 1e-7])
def test_a_band_that_ends_beyond_a_fold_holds_it(which, low, beyond):
    fold = sorted(fold.frequency for fold in folds(RIG, 3.18))[which]
    through, turning = sorted(traced(3.18, (low, fold * (1 + beyond))), key=lambda branch: len(branch.folds))
    assert fold_frequencies(turning) == pytest.approx([fold], rel=1e-9) and not through.folds
    assert turning.frequency[[0, -1]] == pytest.approx([low, low], rel=1e-12)
    assert through.frequency[[0, -1]] == pytest.approx([low, fold * (1 + beyond)], rel=1e-12)


@pytest.mark.parametrize(("which", "low"), [(1, 30.0), (3, 60.0)])
def test_a_band_that_ends_short_of_a_fold_cuts_the_curve_in_two_that_join(which, low):
    fold = sorted(fold.frequency for fold in folds(RIG, 3.18))[which]
    high = fold * (1 - 1e-3)
    branches = traced(3.18, (low, high))
    assert len(branches) == 3
    for branch in branches:
        assert not branch.folds and not branch.closed
        assert branch.frequency[[0, -1]] == pytest.approx([low, high], rel=1e-12)
    # Those two lie next to each other there.
    pairs = [(0, 1), (0, 2), (1, 2)]
    i, j = min(pairs, key=lambda pair: abs(branches[pair[0]].relative[-1, 1] - branches[pair[1]].relative[-1, 1]))
    assert j in branches[i].joins and i in branches[j].joins


def test_a_detached_curve_cut_at_both_ends_is_two_that_join():
    (curve,) = detached_curves(RIG, 3.18)
    branches = traced(3.18, (curve.low * (1 + 1e-3), curve.high * (1 - 1e-3)))
    assert len(branches) == 3 and not any(branch.closed or branch.folds for branch in branches)
    assert sorted(branch.joins for branch in branches) == [(), (0,), (1,)]


@pytest.mark.parametrize("force", [3.18, 20.0])
def test_many_harmonics_lead_to_the_same_curves_from_every_seed(force):
    """The exact law: no curve twice, every curve found again from the middle of itself."""
    branches = periodic_orbits(RIG, force, (30, 120), harmonics=5)
    for branch in branches:
        if not branch.symmetric:
            continue
        i = branch.frequency.size // 2
        again = continue_orbit(RIG, force, branch.frequency[i], branch.relative[i], (30, 120), 5)
        assert again.closed == branch.closed
        np.testing.assert_allclose(fold_frequencies(again), fold_frequencies(branch), rtol=1e-7)
    places = [(round(branch.frequency.min(), 6), round(abs(branch.relative[:, 1]).max(), 9)) for branch in branches]
    assert len(set(places)) == len(places)
