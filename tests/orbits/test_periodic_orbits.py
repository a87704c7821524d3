"""Curves of periodic orbits against single-term theory, integration in time, and themselves."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from rigsim.experiment.sine_test import sine_test
from rigsim.model.excitation import Tap
from rigsim.model.wires import suspension_force
from rigsim.orbits.harmonic_balance import balance, residual_and_jacobian
from rigsim.orbits.periodic_orbits import continue_orbit, periodic_orbits
from rigsim.parameters import OscillatorParameters, RigParameters
from rigsim.results import Status
from rigsim.theory.amplitude import frequency_response
from rigsim.theory.detached import folds

FORCE = 3.18


@pytest.fixture(scope="module")
def branches():
    return periodic_orbits(RigParameters(), FORCE, (5, 120), harmonics=9)


def motion(orders, lines, frequency, t):
    """Displacement and speed at t of Re(sum lines exp(2 pi i orders frequency t)), lines (..., k)."""
    phasor = lines * np.exp(2j * np.pi * orders * frequency * t)
    return phasor.real.sum(-1), (2j * np.pi * orders * frequency * phasor).real.sum(-1)


def a_period_later(parameters, law, frequency, shaker, mass):
    """State (xs, x, xs', x') of an orbit at t = 0, and after a period of DOP853."""
    p, w = parameters, 2 * np.pi * frequency
    orders = np.arange(shaker.size)
    (xs, x), (vs, v) = motion(orders, np.array([shaker, mass]), frequency, 0.0)

    def rates(t, state):
        xs, x, vs, v = state
        between = p.c * (vs - v) + float(suspension_force(xs - x, p, law))
        return [vs, v, (FORCE * np.cos(w * t) - p.cs * vs - p.ks * xs - between) / p.ms, between / p.m]

    start = np.array([xs, x, vs, v])
    run = solve_ivp(rates, (0, 1 / frequency), start, method="DOP853", rtol=1e-11, atol=1e-13)
    return start, run.y[:, -1]


@pytest.mark.parametrize("law", ["exact", "cubic"])
def test_orbits_return_after_a_period_of_integration(law):
    rig = RigParameters()
    for branch in periodic_orbits(rig, FORCE, (5, 120), harmonics=15, law=law):
        for i in np.linspace(0, branch.frequency.size - 1, 9).astype(int):
            start, end = a_period_later(rig, law, branch.frequency[i], branch.shaker[i], branch.mass[i])
            scale = (
                np.abs(branch.relative[i]).sum()
                * np.array([1, 1, 1, 1])
                * (2 * np.pi * branch.frequency[i]) ** (np.arange(4) // 2)
            )
            # An unstable orbit multiplies what separates it from the truncated one.
            assert (abs(end - start) < 3e-7 * scale).all()


def test_one_harmonic_and_the_cubic_law_are_single_term_theory():
    rig = RigParameters()
    branches = periodic_orbits(rig, FORCE, (10, 80), harmonics=1, law="cubic")
    for branch in branches:
        theory = frequency_response(rig, FORCE, branch.frequency)
        for name in ("shaker", "mass", "relative"):
            found, known = getattr(branch, name)[:, 1], getattr(theory, name)
            off = np.nanmin(abs(known - found[:, None]), axis=1) / abs(found)
            away = np.ones(off.size, dtype=bool)
            away[list(branch.folds)] = False  # a double root is known to half the digits
            assert off[away].max() < 1e-8
    turns = sorted(branch.frequency[i] for branch in branches for i in branch.folds)
    expected = [fold.frequency for fold in folds(rig, FORCE) if 10 < fold.frequency < 80]
    np.testing.assert_allclose(turns, expected, atol=1e-9)


@settings(max_examples=60)
@given(
    st.floats(-3, -0.3),
    st.floats(-2, -0.5),
    st.floats(-3, -1),
    st.just(0.0) | st.floats(0.01, 1.5),
    st.floats(-5, 0.5),
    st.floats(0, 1),
)
def test_no_single_term_piece_is_missed(mu, zeta_s, zeta, Omega0, gamma, top):
    p = OscillatorParameters.from_nondimensional(10**mu, 10**zeta_s, 10**zeta, Omega0, 10**gamma)
    band = np.array([0.15, 1.2 + 1.8 * top]) / (2 * np.pi)
    known = frequency_response(p, 1.0, np.linspace(*band, 3)).pieces
    found = periodic_orbits(p, 1.0, band, harmonics=1, law="cubic")
    assert sorted((b.closed, len(b.folds)) for b in found) == sorted((k.closed, len(k.folds)) for k in known)
    turns = sorted(b.frequency[i] for b in found for i in b.folds)
    np.testing.assert_allclose(turns, sorted(f.frequency for k in known for f in k.folds), atol=1e-9)
    assert not any(b.status is Status.STOPPED for b in found)


def test_pieces_of_the_paper_s_rig(branches):
    main, inner = branches
    assert (main.closed, inner.closed) == (False, True)
    assert main.message == "reaches 5 Hz, reaches 120 Hz"
    assert inner.relative[0] == pytest.approx(inner.relative[-1])
    many = periodic_orbits(RigParameters(), FORCE, (5, 120), harmonics=25)
    for few, more in zip(branches, many, strict=True):
        np.testing.assert_allclose(few.frequency[list(few.folds)], more.frequency[list(more.folds)], atol=1e-6)
    # A turning point: on both sides the frequency is on the same side of it, and no neighbour lies beyond.
    for branch in branches:
        for i in branch.folds:
            assert (branch.frequency[i - 1] - branch.frequency[i]) * (branch.frequency[i + 1] - branch.frequency[i]) > 0


def test_curves_are_traced_without_gaps(branches):
    for branch in branches:
        lines = branch.relative[:, 1]
        assert (abs(np.diff(lines)) < 0.15 * np.maximum(abs(lines[1:]), abs(lines[:-1]))).all()
        assert (abs(np.diff(np.log(branch.frequency))) < 0.15).all()


def test_curves_that_the_band_cuts_know_each_other():
    main, upper, inner = periodic_orbits(RigParameters(), FORCE, (5, 80))
    assert (main.joins, upper.joins, inner.joins) == ((1,), (0,), ())
    parts = periodic_orbits(RigParameters(), FORCE, (25, 45))
    assert len(parts) == 3 and not any(part.closed for part in parts)
    joined = sorted(part.joins for part in parts)
    assert joined[0] == () and sum(map(len, joined)) == 2


def test_power_in_is_power_lost(branches):
    rig = RigParameters()
    for branch in branches:
        w = 2 * np.pi * branch.frequency
        rate = w[:, None] * np.arange(branch.relative.shape[1])
        lost = 0.5 * (rig.cs * abs(rate * branch.shaker) ** 2 + rig.c * abs(rate * branch.relative) ** 2).sum(axis=1)
        given_in = 0.5 * FORCE * w * -branch.shaker[:, 1].imag
        np.testing.assert_allclose(given_in, lost, rtol=1e-9)


@pytest.mark.parametrize(("law", "period", "symmetric"), [("exact", 1, False), ("cubic", 3, True), ("exact", 2, False)])
def test_jacobian_is_the_residual_s(law, period, symmetric):
    equations = balance(RigParameters(), FORCE, 4, law, period, symmetric)
    n = equations.unknowns(1.0, [0]).size
    x = np.append(np.random.default_rng(3).normal(size=n - 1), 0.7)
    work = np.empty((4, 2 * equations.harmonics + 1))
    jacobian, scratch = np.empty((n - 1, n)), np.empty((n - 1, n))
    sides = np.empty((2, n - 1))
    residual_and_jacobian(*equations.system, x, work, sides[0], jacobian)
    for i in range(n):
        for side, h in enumerate((1e-6, -1e-6)):
            moved = x.copy()
            moved[i] += h
            residual_and_jacobian(*equations.system, moved, work, sides[side], scratch)
        np.testing.assert_allclose((sides[0] - sides[1]) / 2e-6, jacobian[:, i], atol=1e-6)


def test_an_orbit_that_is_roughly_known_is_continued(branches):
    inner = branches[1]
    i = 20
    rough = inner.relative[i, :4] * 1.01
    again = continue_orbit(RigParameters(), FORCE, inner.frequency[i], rough, (5, 120))
    assert again.closed
    np.testing.assert_allclose(
        sorted(again.frequency[list(again.folds)]), sorted(inner.frequency[list(inner.folds)]), atol=1e-8
    )
    with pytest.raises(ValueError, match="found none"):
        continue_orbit(RigParameters(), FORCE, 30.0, [0, 1e3])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"force": 0.0}, "force = 0 N is not allowed"),
        ({"force": -1.0}, "force = -1 N"),
        ({"band": (80, 5)}, "band = .80, 5. Hz"),
        ({"band": (5, 5)}, "band"),
        ({"band": (0, 5)}, "band"),
        ({"harmonics": 0}, "harmonics = 0"),
        ({"harmonics": 1.5}, "harmonics = 1.5"),
        ({"law": "quintic"}, "law = 'quintic'"),
        ({"period": 4}, "period = 4"),
        ({"parameters": RigParameters().oscillator, "law": "exact"}, "has no wires"),
        ({"parameters": RigParameters(cs=0.0)}, "cs = 0"),
    ],
)
def test_bad_input_is_refused_in_one_line(changes, message):
    with pytest.raises(ValueError, match=message) as caught:
        periodic_orbits(**{"parameters": RigParameters(), "force": FORCE, **changes})
    assert "\n" not in str(caught.value)


def test_the_multi_body_rig_settles_on_stable_orbits(branches):
    """From rest and after a tap, at frequencies where one or two orbits are stable; the rig may tilt as well."""
    frequency = np.array([15.0, 35.0, 45.0, 70.0, 90.0, 35.0, 45.0])
    test = sine_test(RigParameters(), FORCE, frequency, tap=[None] * 5 + [Tap()] * 2, duration=4.0)
    assert (test.status == Status.SETTLED).all()
    for f, line in zip(frequency, test.relative, strict=True):
        near = []
        for branch in branches:
            for i in np.flatnonzero((branch.frequency[:-1] - f) * (branch.frequency[1:] - f) <= 0):
                share = (f - branch.frequency[i]) / (branch.frequency[i + 1] - branch.frequency[i])
                known = branch.relative[i, 1] + share * (branch.relative[i + 1, 1] - branch.relative[i, 1])
                near.append((abs(line / known - 1), branch.stable[i]))
        gap, stable = min(near)
        assert stable and gap < 5e-3, (f, gap)
    assert abs(test.relative[5] / test.relative[1]) > 2  # the tap led elsewhere
