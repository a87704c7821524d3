"""The referee of the multi-body rig, against its own energy, closed forms and SciPy's integrator."""

import numpy as np
import pytest
from scipy.optimize import brentq

from rigsim.parameters import RigParameters
from tests.model import referee

TWO_SETS = RigParameters()
ONE_SET = TWO_SETS.single_set()
RIGS = pytest.mark.parametrize("parameters", [TWO_SETS, ONE_SET], ids=["two sets", "one set"])


def some_states(count=20):
    """Random states of the size the rig really reaches: millimetres, microns of sag, tenths of a radian."""
    random = np.random.default_rng(7)
    size = [1e-3, 2e-3, 1e-4, 0.1, 0.2, 0.5, 0.05, 10.0]
    return [[0, TWO_SETS.LG, 0, 0, 0, 0, 0, 0] + size * random.uniform(-1, 1, 8) for _ in range(count)]


@RIGS
@pytest.mark.parametrize("changes", [{}, {"wire_damping": 2.0}, {"tension_only": True}])
def test_nothing_pulls_out_of_the_plane(parameters, changes):
    rig = referee.spatial(parameters.replace(**changes))
    for state in some_states():
        fx, fy, fz, mx, my, mz = referee.wrench(rig, state)
        assert abs(fz) < 1e-12 * np.hypot(fx, fy)
        assert max(abs(mx), abs(my)) < 1e-12 * max(abs(mz), rig.m * rig.LG)


def test_unequal_side_wires_do_pull_out_of_the_plane():
    rig = referee.spatial(TWO_SETS.replace(k=(4e4, 4e4, 5e4, 4e4) * 2))
    _, _, fz, _, my, _ = referee.wrench(rig, some_states()[0])
    assert abs(fz) > 1e-3 and abs(my) > 1e-7


@RIGS
@pytest.mark.parametrize("tension_only", [False, True])
def test_forces_and_moments_are_the_gradient_of_the_energy(parameters, tension_only):
    rig = referee.spatial(parameters.replace(tension_only=tension_only))
    for state in some_states(5):
        q, forces = state[:4], referee.residual(rig, state[:4])
        for j, nudge in enumerate(np.diag([1e-6, 1e-6, 1e-6, 1e-5])):
            # fourth-order central difference
            slope = 8 * (referee.energy(rig, q + nudge) - referee.energy(rig, q - nudge))
            slope -= referee.energy(rig, q + 2 * nudge) - referee.energy(rig, q - 2 * nudge)
            slope /= 12 * nudge[j]
            assert forces[j] == pytest.approx(-slope, rel=1e-6, abs=1e-6 * np.abs(forces).max())


@RIGS
def test_axial_force_is_the_exact_law(parameters):
    rig = referee.spatial(parameters)
    for z in (1e-5, 1e-3, -5e-3):
        force = referee.wrench(rig, np.array([z, parameters.LG, 0, 0, 0, 0, 0, 0]))[0]
        law = parameters.wire_stiffness.sum() * z * (1 - parameters.d0 / np.hypot(z, parameters.d))
        assert force == pytest.approx(law, rel=1e-10)


def test_damping_takes_the_power_that_the_energy_loses():
    damped = ONE_SET.replace(wire_damping=2.0, rocking_damping=1e-5)
    free, lossy = referee.spatial(ONE_SET.replace(c=0, cs=0)), referee.spatial(damped)
    masses = np.array([free.ms, free.m, free.m, free.inertia])
    for state in some_states(5):
        conservative, real = (referee.rates(rig, referee.Drive(), 0.0, state)[4:] for rig in (free, lossy))
        power = np.sum(masses * (real - conservative) * state[4:])
        # rates of lengths by a small step of time along the velocity
        ahead, behind = (_lengths(lossy, state[:4] + h * state[4:]) for h in (1e-7, -1e-7))
        stretch_rate = (ahead[0] - behind[0]) / 2e-7
        relative = state[4] - (ahead[1] - behind[1]) / 2e-7
        lost = 2.0 * np.sum(stretch_rate**2) + 1e-5 * state[7] ** 2 + 0.026 * relative**2 + 9.86 * state[4] ** 2
        assert power == pytest.approx(-lost, rel=1e-6)


def _lengths(rig, q):
    """Lengths of the wires and x of P."""
    axis, across = np.array([np.cos(q[3]), np.sin(q[3]), 0]), np.array([-np.sin(q[3]), np.cos(q[3]), 0])
    pins = np.array([q[1], q[2], 0]) + rig.mass_pins @ np.array([axis, across, [0, 0, 1]])
    return np.linalg.norm(pins - rig.frame_pins - [q[0], 0, 0], axis=1), q[1] - rig.LG * axis[0]


def test_one_set_tilts_as_much_as_its_tension_lets_it():
    xs, X, Y, tilt = referee.static_equilibrium(ONE_SET)
    p, k = ONE_SET, ONE_SET.wire_stiffness[0]

    def moment(angle):
        """Virtual work of tilting about P, up and down wires only, P held in place."""
        length = np.hypot(p.Rm * np.sin(angle), p.Rm + p.d - p.Rm * np.cos(angle))
        slope = p.Rm * (p.Rm + p.d) * np.sin(angle) / length
        return 2 * k * (length - p.d0) * slope + p.m * p.gravity * p.LG * np.cos(angle)

    assert xs == pytest.approx(0, abs=1e-12)
    # P itself shifts by microns, which the sketch above leaves out
    assert tilt == pytest.approx(brentq(moment, -0.3, 0), rel=2e-3)
    linear = 2 * k * (p.d - p.d0) * p.Rm * (p.Rm + p.d) / p.d
    assert p.m * p.gravity * p.LG / linear == pytest.approx(2 * abs(tilt), rel=0.02)  # hardening halves the tilt
    assert referee.residual(referee.spatial(p), [xs, X, Y, tilt]) == pytest.approx(np.zeros(4), abs=1e-12)


def test_two_sets_sag_and_rock_as_beams_of_their_wires():
    p, k, s = TWO_SETS, TWO_SETS.wire_stiffness[0], TWO_SETS.set_positions[1]
    _, X, Y, tilt = referee.static_equilibrium(p)
    # up and down wires carry the weight; side wires help by their tension only, one part in ten thousand
    assert Y - p.LG * np.sin(tilt) == pytest.approx(-p.m * p.gravity / (4 * k), rel=1e-3)
    assert tilt == pytest.approx(-p.m * p.gravity * p.LG / (4 * k * s**2), rel=1e-3)


def test_axial_and_frame_modes_are_those_of_two_degrees_of_freedom():
    p = TWO_SETS
    stiffness, mass = np.array([[p.ks + p.k1, -p.k1], [-p.k1, p.k1]]), np.array([p.ms, p.m])
    expected = np.sqrt(np.linalg.eigvals(stiffness / mass[:, None])) / (2 * np.pi)
    frequency, _ = referee.linear_modes(p)
    assert frequency[:2] == pytest.approx(np.sort(expected), rel=1e-6)


def test_one_set_rocks_as_a_pendulum_of_its_tension():
    p = ONE_SET
    stiffness = 2 * p.wire_stiffness[0] * (p.d - p.d0) * p.Rm * (p.Rm + p.d) / p.d
    expected = np.sqrt(stiffness / (p.inertia + p.m * p.LG**2)) / (2 * np.pi)
    installed = referee.linear_modes(p, [0, p.LG, 0, 0])[0]
    # P is held by the bounce stiffness, which is not quite rigid: one part in ten thousand
    assert installed[1] == pytest.approx(expected, rel=2e-4)
    # tilted at rest, it is stiffer: two thirds of the restoring moment are cubic there
    assert referee.linear_modes(p)[0][1] > 1.5 * installed[1]


@pytest.mark.parametrize(
    "parameters, tap", [(TWO_SETS, None), (ONE_SET, referee.Tap(time=0.1))], ids=["two sets", "one set, tapped"]
)
def test_compiled_march_agrees_with_scipy(parameters, tap):
    case = (parameters, 3.18, 30.0, 1.0, tap)
    compiled, scipy = referee.simulate_sine(*case), referee.simulate_sine(*case, method="scipy")
    np.testing.assert_allclose(compiled[0], scipy[0], rtol=0, atol=1e-12)
    for one, other in zip(compiled[1:4], scipy[1:4], strict=True):
        assert np.abs(one - other).max() < 1e-6 * np.abs(other).max()


def test_compiled_march_is_of_eighth_order():
    coarse, middle, fine = (
        referee.simulate_sine(TWO_SETS, 3.18, 30.0, 1.0, step=step)[4][-1] for step in (2e-4, 1e-4, 1e-5)
    )
    assert abs(coarse - fine) > 2**7 * abs(middle - fine)


def test_held_cosine_tends_to_the_cosine():
    frequency, rate = 30.0, 8000.0
    force = 3.18 * np.cos(2 * np.pi * frequency * np.arange(rate + 1) / rate)
    t, _, _, z, _ = referee.simulate_sine(TWO_SETS, 3.18, frequency, 1.0, step=1 / rate / 2)
    _, _, held, _ = referee.simulate_held(TWO_SETS, force, rate, "linear", "rest")
    assert np.abs(held - z[::2]).max() < 2e-4 * np.abs(z).max()


def test_held_force_matches_scipy_interval_by_interval():
    force = np.random.default_rng(3).normal(0, 1.115, 40)
    rig, rate = referee.spatial(ONE_SET), 2000.0
    for hold, slopes in (("zero", np.zeros(39)), ("linear", np.diff(force) * rate)):
        state = np.array([0, ONE_SET.LG, 0, 0, 0, 0, 0, 0])
        state[:4] = referee.static_equilibrium(ONE_SET)
        z = referee.simulate_held(ONE_SET, force, rate, hold)[2]
        for k, slope in enumerate(slopes):
            assert z[k] == pytest.approx(state[0] - state[1] + rig.LG * np.cos(state[3]), rel=1e-7, abs=1e-13)
            drive = referee.Drive(level=force[k], slope=slope, since=k / rate)
            state = referee.scipy_march(state, k / rate, np.array([(k + 1) / rate]), rig, drive)[-1]


def test_fourier_reads_amplitude_and_phase_against_a_cosine():
    t = 2 + np.arange(20001) / 20000
    u = 0.3 + 2 * np.cos(2 * np.pi * 23.4 * t + 0.7) + 0.5 * np.cos(6 * np.pi * 23.4 * t)
    assert referee.fourier(t, u, 23.4) == pytest.approx(2 * np.exp(0.7j), rel=1e-4)
