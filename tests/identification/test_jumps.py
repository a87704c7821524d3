"""Jump frequencies give the parameters back, with intervals that hold, and agree with what a record says."""

import re
from dataclasses import replace

import numpy as np
import pytest

from rigsim.identification.identify import identify
from rigsim.identification.jumps import KINDS, Jump, _folds, parameters_from_jumps
from rigsim.identification.physical import NAMES
from rigsim.orbits.periodic_orbits import periodic_orbits
from rigsim.parameters import RigParameters
from rigsim.results import Status
from rigsim.theory.detached import folds
from tests.identification.cubic import cubic_record, stepped_amplitudes

RIG = RigParameters()
P = RIG.oscillator
FORCES = (0.7, 1.0, 1.3)


def true_folds(force, law="cubic", parameters=RIG):
    """Frequencies of the folds of orbits with eleven harmonics (Hz)."""
    branches = periodic_orbits(parameters, force, (5, 140), harmonics=11, law=law)
    return np.sort([point.frequency for branch in branches for point in branch.special_points if point.kind == "fold"])


@pytest.fixture(scope="module")
def ends():
    """Force, true frequency, amplitude and sweep of the two ends of the hysteresis at each force."""
    found = []
    for force in FORCES:
        low, high = true_folds(force)
        found += [(force, low, "rises", "down"), (force, high, "falls", "up")]
    return found


def stepped(ends, step, seed=0):
    """Jumps as a test in steps would find them, with its frequencies anywhere."""
    off = np.random.default_rng(seed).uniform(-0.5, 0.5, len(ends)) * step
    return [Jump(force, frequency + one, step / 2, *how)
            for (force, frequency, *how), one in zip(ends, off, strict=True)]  # fmt: skip


@pytest.mark.parametrize("force", [0.25, 1.0, 1.5, 3.18, 4.0, 5.0])
def test_the_third_harmonic_is_nearly_all_that_one_harmonic_misses(force, tell):
    """What the module says about itself, by converged orbits."""
    true, worst = true_folds(force), 0.0
    found = _folds(P, force)
    assert len(found) == len(folds(P, force)) == true.size
    for (_, _, frequency, single, share), one in zip(sorted(found, key=lambda one: one[2]), true, strict=True):
        assert abs(single - one) < 0.76 and abs(single / one - 1) < 0.012
        assert abs(frequency - one) < max(0.1 * abs(single - frequency), 1e-4) and abs(frequency - one) < 0.03
        assert share < 0.06
        worst = max(worst, abs(single - one))
    assert worst > 0.005  # more than a fine test in steps would see
    tell(
        f"folds at {force} N: one harmonic is up to {worst:.2g} Hz off, with the third in closed form less than a tenth"
    )


def test_the_wires_exact_law_moves_folds_by_as_much_as_is_said():
    for force, most in ((1.0, 0.03), (3.18, 0.3)):
        cubic, exact = true_folds(force), true_folds(force, "exact")
        off = np.abs(exact - cubic)
        assert off[cubic < 60].max() < 0.03 and 0.005 < off.max() < most


@pytest.mark.parametrize("free", [("k3",), ("k3", "c"), ("k3", "c", "k1")])
def test_parameters_lie_within_their_intervals(ends, free):
    start = P.replace(**{name: factor * getattr(P, name) for name, factor in zip(free, (0.9, 1.1, 1.03), strict=False)})
    true, inside = np.array([getattr(P, name) for name in free]), []
    for seed in range(5):
        found = parameters_from_jumps(stepped(ends, 0.04, seed), start, free)
        assert found.status is Status.FOUND and found.free == free
        inside.append(np.abs(found.value - true) <= found.half_width)
        assert (found.half_width < 0.1 * true).all()
        assert [getattr(found.parameters, name) for name in free] == list(found.value)
    assert np.mean(inside) >= 0.8
    assert (found.parameters.ms, found.parameters.ks) == (P.ms, P.ks)


@pytest.mark.full
def test_intervals_hold_the_true_values(ends, tell):
    true, inside = np.array([P.k3, P.c]), []
    for seed in range(100):
        found = parameters_from_jumps(stepped(ends[:4], (0.02, 0.1)[seed % 2], seed), P, ("k3", "c"))
        inside.append(np.abs(found.value - true) <= found.half_width)
    tell(f"95 % intervals from four jumps, k3 and c of 100 tests: {np.mean(inside, axis=0)} hold the true value")
    assert (np.mean(inside, axis=0) >= 0.9).all()


def test_finer_steps_narrow_the_interval_as_far_as_higher_harmonics_let_them(ends):
    coarse, fine, finest = (parameters_from_jumps(stepped(ends, step), P).half_width[0] for step in (0.2, 0.02, 2e-5))
    assert fine < coarse / 4 and finest > 0.1 * fine


def test_without_the_third_harmonic_the_answer_would_be_wrong(ends):
    """The bias of one harmonic is many of its intervals, so that this is no ornament."""
    jumps = [jump for jump in stepped(ends, 0.02) if jump.amplitude == "falls"]
    found = parameters_from_jumps(jumps, P)
    single = np.array([next(f.frequency for f in folds(P, jump.force) if f.kind == KINDS["falls"]) for jump in jumps])
    measured = np.array([jump.frequency for jump in jumps])
    off = np.log(measured / single).mean() / np.log(found.predicted / single).mean()
    assert off == pytest.approx(1, abs=0.3) and abs(found.shift).min() > 0.1
    assert abs(found.value[0] - P.k3) < found.half_width[0] < 0.005 * P.k3


def test_a_stepped_test_tells_its_jumps_and_they_the_cubic_spring():
    jumps = []
    for force, low, high in ((0.8, 14.2, 48.57), (1.2, 15.2, 51.77)):
        up = np.arange(high - 0.67, high + 0.6, 0.1)
        approach = np.arange(11.0, up[0], 0.2)
        frequencies = np.concatenate([approach, up])
        dwell = np.where(frequencies < up[0], 0.5, 4.0)  # a motion takes long to leave the place of a fold
        jumps += Jump.found_in(force, up, stepped_amplitudes(force, frequencies, dwell)[approach.size :])
        down = np.arange(low + 1.53, low - 0.6, -0.1)
        jumps += Jump.found_in(force, down, stepped_amplitudes(force, down, 4.0))
    assert [(jump.amplitude, jump.sweep) for jump in jumps] == [("falls", "up"), ("rises", "down")] * 2
    found = parameters_from_jumps(jumps, P.replace(k3=1.2e8))
    assert found.status is Status.FOUND
    assert abs(found.value[0] - P.k3) < found.half_width[0] < 0.03 * P.k3


@pytest.fixture(scope="module")
def identified():
    return identify(cubic_record(duration=20, noise=0.01))


def test_both_ways_agree_on_one_rig(ends, identified):
    found = identified.from_jumps(stepped(ends, 0.1), free=("k3", "c"))
    assert found.status is Status.FOUND and (found.apart < 1).all()
    for name, value, width in zip(found.free, found.value, found.half_width, strict=True):
        assert abs(value - getattr(P, name)) < width
    table = found.table()
    np.testing.assert_allclose(table["start +- (95 %)"], identified.errors.half_width[[6, 4]])
    np.testing.assert_allclose(table["start"], [identified.k3, identified.parameters.c])
    alone = parameters_from_jumps(stepped(ends, 0.1), identified.parameters, ("k3", "c"))
    assert found.half_width[0] > 1.5 * alone.half_width[0]  # errors of the other five are carried on
    assert "if all others are exact" in alone.summary() and "exact" not in found.summary()


def test_another_rig_is_noticed(identified):
    other = P.replace(k3=1.15 * P.k3)
    low, high = true_folds(1.0, parameters=other)
    jumps = stepped([(1.0, low, "rises", "down"), (1.0, high, "falls", "up")], 0.05)
    found = identified.from_jumps(jumps, free=("k3", "c"))
    assert found.status is Status.DOUBTFUL and found.apart[0] > 1
    assert "k3 differs from the start's" in found.message
    assert abs(found.value[0] - other.k3) < found.half_width[0]


@pytest.mark.parametrize("name", ["ms", "ks", "cs", "m", "c", "k1"])
def test_errors_of_the_others_are_carried_on_as_the_fit_itself_moves(ends, name):
    """One jump, whose fit is repeated from starts that are off in another parameter."""
    jumps, error, value = stepped(ends, 0.02)[1:2], 0.002, getattr(P, name)
    covariance = np.diag([(error * value) ** 2 * (one == name) for one in NAMES])
    with_it, without = (parameters_from_jumps(jumps, P, covariance=one).half_width for one in (covariance, None))
    moved = [parameters_from_jumps(jumps, P.replace(**{name: value * (1 + sign * error)})).value for sign in (1, -1)]
    added = np.sqrt(with_it**2 - without**2) / 1.96
    np.testing.assert_allclose(added, abs(moved[0] - moved[1]) / 2, rtol=0.05)


def test_what_jumps_do_not_determine_is_said(ends):
    few = parameters_from_jumps(stepped(ends, 0.1)[:2], P, ("k3", "c", "k1"))
    assert few.status is Status.DOUBTFUL and np.isinf(few.half_width).all()
    assert few.message.startswith("not determined by these jumps: k3, c, k1")
    rises = [jump for jump in stepped(ends, 0.1) if jump.amplitude == "rises"]
    low = parameters_from_jumps(rises, P, ("k3", "c"))  # the low motion hardly knows its damping
    assert low.status is Status.DOUBTFUL and "c (+- " in low.message


def test_no_unit_of_mass_is_in_jumps(ends):
    """All seven scale together, k3 with the cube: the jumps are the same."""
    found = parameters_from_jumps(stepped(ends, 0.01), P, ("ms", "ks", "cs", "m", "c", "k1", "k3"))
    assert np.isinf(found.half_width).all() and found.status is Status.DOUBTFUL


def test_jumps_that_disagree_are_named(ends):
    jumps = stepped(ends, 0.05)
    jumps[1] = replace(jumps[1], frequency=jumps[1].frequency + 0.6)
    found = parameters_from_jumps(jumps, P, ("k3", "c"))
    assert found.status is Status.DOUBTFUL and f"that at {jumps[1].frequency:.4g} Hz and 0.7 N" in found.message
    assert 0.3 < float(re.search("is ([0-9.]+) Hz from where the others", found.message)[1]) < 0.9


def test_a_fall_that_higher_harmonics_make_is_no_confident_answer():
    """At 0.5 N a test stepped up falls at 18.9 Hz, by a third of the shaker's resonance."""
    assert any(abs(true_folds(0.5) - 18.86) < 0.05)
    jumps = [Jump(0.5, 18.9, 0.05, "falls", "up"), Jump(1.0, 50.35, 0.05, "falls", "up")]
    found = parameters_from_jumps(jumps, P, ("k3", "c"))
    assert found.status is Status.DOUBTFUL and "the jump at 18.9 Hz and 0.5 N may be at another fold" in found.message


def test_where_a_fold_is_about_to_merge_coarse_steps_are_a_doubt():
    fold = next(frequency for kind, end, frequency, *_ in _folds(P, 1.55) if (kind, end) == ("upper", 1))
    fine, coarse = (parameters_from_jumps([Jump(1.55, fold, half, "falls", "up")], P) for half in (0.05, 0.5))
    assert fine.status is Status.FOUND and coarse.status is Status.DOUBTFUL
    assert coarse.message == "within the interval a fold ends or bends away: it is too narrow"


def test_too_much_third_harmonic_is_a_doubt():
    """With a tenth of the shaker's damping z gets larger where the high motion ends."""
    lightly = P.replace(cs=1.0)
    fold = next(frequency for kind, end, frequency, *_ in _folds(lightly, 1.2) if (kind, end) == ("upper", 1))
    found = parameters_from_jumps([Jump(1.2, fold, 0.05, "falls", "up")], lightly)
    assert found.status is Status.DOUBTFUL and "% of third harmonic at a jump" in found.message


def test_a_jump_stands_out_of_its_neighbours():
    frequency = np.arange(20.0, 30.0)
    smooth = np.exp(-0.3 * np.arange(10.0))
    assert Jump.found_in(1.0, frequency, smooth) == ()
    jumped = np.where(frequency > 24, 3.0, 1.0) * np.exp(0.01 * frequency)
    assert Jump.found_in(1.0, frequency, jumped) == (Jump(1.0, 24.5, 0.5, "rises", "up"),)
    assert Jump.found_in(1.0, frequency[::-1], jumped[::-1]) == (Jump(1.0, 24.5, 0.5, "falls", "down"),)
    assert Jump.found_in(1.0, frequency, 1j * jumped) == Jump.found_in(1.0, frequency, jumped)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"start": P.replace(k3=0.0)}, "k3 of the start = 0 is not allowed; expected it above zero"),
        ({"start": P.replace(k3=1e5)}, "jumps at .* Hz and 0.7 N, where z rises .* expected a start with such a fold"),
        ({"free": ("k3", "k5")}, "free"),
        ({"jumps": []}, "jumps are empty; expected at least one Jump"),
        ({"jumps": [13.4]}, "jumps = 13.4 is not allowed; expected a Jump"),
        ({"covariance": np.ones((2, 2))}, r"covariance of shape \(2, 2\) is not allowed; expected \(7, 7\)"),
        ({"covariance": -np.eye(7)}, "covariance has a variance of -1; expected none below zero"),
    ],
)
def test_mistakes_are_named(ends, change, message):
    with pytest.raises(ValueError, match=message):
        parameters_from_jumps(**({"jumps": stepped(ends, 0.1), "start": P} | change))


def test_a_test_that_turns_back_and_a_reading_without_errors_are_refused(ends):
    with pytest.raises(ValueError, match="frequency turns back; expected"):
        Jump.found_in(1.0, [20, 21, 20, 19], np.ones(4))
    with pytest.raises(ValueError, match="relative has 3 amplitudes; expected 4"):
        Jump.found_in(1.0, [20, 21, 22, 23], np.ones(3))
    paper = identify(cubic_record(duration=5), conversion="all")
    with pytest.raises(ValueError, match="this record has no parameters with errors; expected"):
        paper.from_jumps(stepped(ends, 0.1))
