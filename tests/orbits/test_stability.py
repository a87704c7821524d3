"""Floquet multipliers by Hill's determinant against shooting in time, single-term theory and Liouville's formula."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rigsim.orbits.harmonic_balance import balance
from rigsim.orbits.periodic_orbits import periodic_orbits
from rigsim.orbits.shooting import shoot_orbit
from rigsim.orbits.stability import hill_multipliers
from rigsim.parameters import OscillatorParameters, RigParameters
from rigsim.theory.amplitude import frequency_response

FORCE = 3.18


@pytest.fixture(scope="module")
def branches():
    return periodic_orbits(RigParameters(), FORCE, (5, 120), harmonics=15)


def apart(some, others):
    """Largest distance from a multiplier to the nearest of the others."""
    return max(abs(np.asarray(others) - one).min() for one in some)


def test_hill_and_shooting_agree_on_every_orbit(branches):
    for branch in branches:
        for i in range(0, branch.frequency.size, 3):
            shot = branch.shoot(i)
            assert shot.converged, shot.message
            assert apart(shot.multipliers, branch.multipliers[i]) < 1e-6
            assert apart(branch.multipliers[i], shot.multipliers) < 1e-6
            if i not in branch.folds:
                assert shot.stable == branch.stable[i]
            # The orbit itself, too, and it is the same in every line that was kept.
            few = min(shot.relative.size, branch.relative.shape[1])
            size = abs(branch.relative[i]).max()
            np.testing.assert_allclose(shot.relative[:few], branch.relative[i, :few], atol=1e-7 * size)


def test_half_and_whole_periods_give_the_same_multipliers(branches):
    main = branches[0]
    i = np.arange(0, main.frequency.size, 10)
    whole = balance(RigParameters(), FORCE, 15, "exact", symmetric=False)
    points = np.array([whole.unknowns(f, z) for f, z in zip(main.frequency[i], main.relative[i], strict=True)])
    for some, others in zip(hill_multipliers(whole, points), main.multipliers[i], strict=True):
        assert apart(some, others) < 3e-6  # two equal ones are known to half the digits


def test_one_harmonic_has_the_multipliers_of_single_term_theory():
    for branch in periodic_orbits(RigParameters(), FORCE, (10, 80), harmonics=1, law="cubic"):
        theory = frequency_response(RigParameters(), FORCE, branch.frequency)
        nearest = np.nanargmin(abs(theory.relative - branch.relative[:, 1:]), axis=1)
        for i, k in enumerate(nearest):
            if i not in branch.folds:
                assert apart(branch.multipliers[i], theory.multipliers[i, k]) < 1e-6
        assert branch.disagreements == ()


@settings(max_examples=40)
@given(
    st.floats(-3, -0.3),
    st.floats(-2, -0.7),
    st.floats(-3, -1),
    st.just(0.0) | st.floats(0.1, 1.5),
    st.floats(-4, 0),
    st.booleans(),
)
def test_multipliers_of_any_orbit_have_liouville_s_product(mu, zeta_s, zeta, Omega0, gamma, symmetric):
    p = OscillatorParameters.from_nondimensional(10**mu, 10**zeta_s, 10**zeta, Omega0, 10**gamma)
    equations = balance(p, 1.0, 5, "cubic", symmetric=symmetric)
    trace = 2 * equations.numbers[1] + 2 * equations.numbers[2] * (1 + equations.numbers[0])
    for branch in periodic_orbits(p, 1.0, np.array([0.4, 2]) / (2 * np.pi), harmonics=5, law="cubic"):
        for i in range(0, branch.frequency.size, 40):
            point = equations.unknowns(branch.frequency[i], branch.relative[i])
            values = hill_multipliers(equations, point[None])[0]
            expected = np.exp(-trace * 2 * np.pi / point[-1])
            # The polynomial's coefficients carry the rounding of the largest.
            assert abs(values.prod() - expected) < 1e-7 * np.maximum(1, abs(values)).prod()


@pytest.mark.parametrize(
    ("force", "band", "known"), [(3.18, (2, 30), 5e-10), (20.0, (3, 30), 3e-8), (60.0, (5, 40), 4e-8)]
)
def test_slow_and_strong_orbits_have_liouville_s_product(force, band, known):
    """Many lines matter there, and those beyond the rows kept enter by the tail alone."""
    p = RigParameters()
    for branch in periodic_orbits(p, force, band, harmonics=9):
        expected = np.exp(-(p.cs / p.ms + p.c / p.ms + p.c / p.m) * branch.period / branch.frequency)
        off = abs(branch.multipliers.prod(axis=1) - expected) / np.maximum(1, abs(branch.multipliers)).prod(axis=1)
        assert off.max() < known


def test_special_points_of_the_paper_s_rig(branches):
    main, inner = branches
    assert [(p.kind, round(p.frequency, 2)) for p in main.special_points] == [
        ("Neimark-Sacker", 62.22),
        ("Neimark-Sacker", 74.57),
        ("fold", 107.05),
        ("fold", 56.51),
    ]
    assert sorted(p.kind for p in inner.special_points) == ["Neimark-Sacker", "fold", "fold"]
    for branch in branches:
        for point in branch.special_points:
            modulus = abs(np.array(point.multipliers))
            assert abs(modulus - 1).min() < 1e-6, point
            assert abs(point.relative) == pytest.approx(abs(branch.relative[point.index, 1]), rel=0.1)


def test_neimark_sacker_points_lie_where_shooting_finds_them(branches):
    """A thousandth of a hertz to either side the orbit found in time is stable and unstable."""
    for branch in branches:
        for point in branch.special_points:
            if point.kind == "Neimark-Sacker":
                shot = branch.shoot(point.index)
                verdicts = []
                for f in (point.frequency - 1e-3, point.frequency + 1e-3):
                    for step in np.linspace(0, 1, 5)[1:]:
                        at = branch.frequency[point.index] + step * (f - branch.frequency[point.index])
                        shot = shoot_orbit(RigParameters(), FORCE, at, shot.state)
                    assert shot.converged
                    verdicts.append(shot.stable)
                assert sorted(verdicts) == [False, True]


def test_single_term_verdicts_that_err_are_named(branches):
    main, inner = branches
    # High solution: unstable from 62.2 Hz, not 69, and stable again from 74.6 Hz, not 79; middle one: never stable.
    expected = [(62.2, 69, False), (74.6, 79, True), (72, 107, False)]
    found = [d for d in main.disagreements if d.high - d.low > 1]
    for disagreement, (low, high, stable) in zip(found, expected, strict=True):
        assert (disagreement.low, disagreement.high) == pytest.approx((low, high), abs=1.5)
        assert disagreement.stable is stable
    assert not any(d.high - d.low > 1 for d in inner.disagreements)


def test_shooting_says_when_it_fails_and_refuses_bad_input():
    lost = shoot_orbit(RigParameters(), FORCE, 30.0, [0.1, -0.1, 5, 5], iterations=1)
    assert not lost.converged and "not converged" in lost.message and not lost.stable
    for changes, message in [
        ({"force": 0}, "force = 0 N"),
        ({"frequency": -1}, "frequency = -1 Hz"),
        ({"state": [0, 0]}, "state has 2 values"),
        ({"law": "linear"}, "law = 'linear'"),
        ({"parameters": RigParameters().oscillator, "law": "exact"}, "no wires"),
    ]:
        with pytest.raises(ValueError, match=message):
            shoot_orbit(
                **{"parameters": RigParameters(), "force": FORCE, "frequency": 30.0, "state": [0, 0, 0, 0], **changes}
            )


def test_asymmetric_orbits_branch_off_and_double_their_period_where_shooting_says():
    rig = RigParameters()
    branches = periodic_orbits(rig, 20.0, (30, 80), harmonics=15)
    main, bent = branches[0], next(branch for branch in branches if not branch.symmetric)
    assert main.symmetric
    breaking = [p for p in main.special_points if p.kind == "symmetry breaking"]
    assert [p.frequency for p in breaking] == pytest.approx([bent.frequency[0], bent.frequency[-1]], abs=1e-4)
    for i in range(5, bent.frequency.size - 5, 6):
        shot = bent.shoot(i)
        assert shot.converged and abs(shot.relative[0]) > 1e-3 * abs(shot.relative[1])  # it keeps its mean
        assert shot.relative[:6] == pytest.approx(bent.relative[i, :6], abs=1e-7 * abs(shot.relative[1]))
        assert apart(shot.multipliers, bent.multipliers[i]) < 1e-6
        # The mirror image, half a period later, is an orbit as well.
        mirrored = shoot_orbit(rig, 20.0, bent.frequency[i], _half_a_period_later(bent, i))
        assert mirrored.converged
        assert mirrored.relative[0] == pytest.approx(-shot.relative[0], rel=1e-4)
    doublings = [p for p in bent.special_points if p.kind == "period doubling"]
    assert len(doublings) == 2
    for point in doublings:
        shot = bent.shoot(point.index)
        least = []
        for f in (point.frequency - 1e-3, point.frequency + 1e-3):
            for step in np.linspace(0, 1, 4)[1:]:
                at = bent.frequency[point.index] + step * (f - bent.frequency[point.index])
                shot = shoot_orbit(rig, 20.0, at, shot.state)
            least.append(shot.multipliers.real.min())
        assert min(least) < -1 < max(least)


def _half_a_period_later(branch, i):
    """Minus the state of orbit i half a period after the crest of the force."""
    sign = -((-1.0) ** np.arange(branch.relative.shape[1]))
    rate = 2j * np.pi * branch.frequency[i] * np.arange(branch.relative.shape[1])
    motion = sign * np.array([branch.shaker[i], branch.mass[i]])
    return np.concatenate([motion.real.sum(axis=1), (rate * motion).real.sum(axis=1)])


def test_curves_of_twice_the_period_join_the_doublings():
    rig = RigParameters()
    seeded = {"harmonics": 23, "search": "seeds"}
    bent = periodic_orbits(rig, 20.0, (30, 80), **seeded)[-1]
    (doubled,) = periodic_orbits(rig, 20.0, (30, 80), **seeded, period=2)
    places = sorted(p.frequency for p in bent.special_points if p.kind == "period doubling")
    assert sorted([doubled.frequency[0], doubled.frequency[-1]]) == pytest.approx(places, abs=1e-4)
    assert doubled.stable[1:-1].all()
    for i in range(3, doubled.frequency.size - 3, 4):
        shot = doubled.shoot(i)
        assert shot.converged and abs(shot.relative[1]) > 1e-4 * abs(shot.relative[2])  # a line at half the frequency
        assert shot.relative[:8] == pytest.approx(doubled.relative[i, :8], abs=1e-6 * abs(shot.relative[2]))
        assert apart(shot.multipliers, doubled.multipliers[i]) < 1e-4  # over two periods, from a truncated orbit
    assert not periodic_orbits(rig, FORCE, (40, 80), period=2)


def test_an_orbit_larger_than_its_start_is_not_believed_with_steps_too_long():
    """Steps chosen for the start turned a wild state into an "orbit" a hundred times the response; there is none."""
    rig = OscillatorParameters(1.0, 1.0, 0.03722345744227316, 0.1838036048700382, 0.0021224834198108416,
                               1.8074986424311482e-05, 0.1364192240509811)  # fmt: skip
    state = [-10.08059855, 50.51466283, 471.22499066, -2561.0380802]
    for share in (1.0, 0.1, 0.03):
        shot = shoot_orbit(rig, 1.0, 0.230500769253678, share * np.array(state), "cubic", iterations=40)
        assert not shot.converged or abs(shot.relative).max() < 20
