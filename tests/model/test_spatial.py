"""The rig in three dimensions, against its own energy, closed forms and SciPy's integrator."""

import numpy as np
import pytest
from scipy.optimize import brentq

from rigsim.model import spatial
from rigsim.model.excitation import Tap
from rigsim.model.planar import static_equilibrium
from rigsim.parameters import RigParameters
from tests.model import refereed as referee

TWO_SETS = RigParameters()
ONE_SET = TWO_SETS.single_set()
RIGS = pytest.mark.parametrize("parameters", [TWO_SETS, ONE_SET], ids=["two sets", "one set"])
# Everything that a rig may have and keep its motion in the plane.
FULL = TWO_SETS.replace(k=(3e4, 5e4, 4e4, 4e4) * 2, LG=-0.002, set_half_spacing=0.004, wire_damping=2.0)
FULL = FULL.replace(rocking_damping=1e-5)


def some_states(count=20):
    """Random planar states of the size the rig really reaches: millimetres, microns of sag, tenths of a radian."""
    random = np.random.default_rng(7)
    size = [1e-3, 2e-3, 1e-4, 0.1, 0.2, 0.5, 0.05, 10.0]
    numbers = [[0, TWO_SETS.LG, 0, 0, 0, 0, 0, 0] + size * random.uniform(-1, 1, 8) for _ in range(count)]
    return [spatial.planar_state(one[:4], one[4:]) for one in numbers]


def free_states(count=5):
    """The same, anywhere in space: shifted by microns, turned by tenths of a radian, with all rates."""
    random = np.random.default_rng(8)
    states = some_states(count)
    for state in states:
        state[3], state[11] = random.uniform(-1, 1, 2) * [1e-4, 0.05]
        state[12:14] = random.uniform(-10, 10, 2)
        state[4:8] += 0.1 * random.uniform(-1, 1, 4)
        state[4:8] /= np.linalg.norm(state[4:8])
    return states


@RIGS
@pytest.mark.parametrize("changes", [{}, {"wire_damping": 2.0}, {"tension_only": True}])
def test_nothing_pulls_out_of_the_plane(parameters, changes):
    rig, wires = referee.rig_and_wires(parameters.replace(**changes))
    for state in some_states():
        fx, fy, fz, mx, my, mz = spatial.pull_of_wires(state, rig, wires)
        assert abs(fz) < 1e-12 * np.hypot(fx, fy)
        assert max(abs(mx), abs(my)) < 1e-12 * max(abs(mz), rig.m * rig.LG)


def test_unequal_side_wires_do_pull_out_of_the_plane():
    rig, wires = referee.rig_and_wires(TWO_SETS.replace(k=(4e4, 4e4, 5e4, 4e4) * 2))
    _, _, fz, _, my, _ = spatial.pull_of_wires(some_states()[0], rig, wires)
    assert abs(fz) > 1e-3 and abs(my) > 1e-7


@RIGS
@pytest.mark.parametrize("tension_only", [False, True])
def test_forces_and_moments_are_the_gradient_of_the_energy(parameters, tension_only):
    """In the plane, and in all seven coordinates."""
    parameters = parameters.replace(tension_only=tension_only, c=0, cs=0)
    rig, wires = referee.rig_and_wires(parameters)
    inertia = np.array([rig.ms, *[rig.m] * 3, rig.about, rig.across, rig.across])
    for state in some_states(5) + free_states():
        still = np.concatenate([state[:8], np.zeros(7)])
        forces = referee.rates(rig, wires, referee.FREE, False, 0.0, still)[8:] * inertia
        for j, nudge in enumerate([1e-6] * 4 + [1e-5] * 3):
            height = [referee.energy(parameters, moved(still, j, n * nudge)) for n in (-2, -1, 1, 2)]
            # fourth-order central difference
            slope = (height[0] - 8 * height[1] + 8 * height[2] - height[3]) / (12 * nudge)
            assert forces[j] == pytest.approx(-slope, rel=1e-6, abs=1e-6 * np.abs(forces).max())


@RIGS
@pytest.mark.parametrize("tension_only", [False, True])
def test_tensions_add_up_to_the_compiled_pull_of_the_wires(parameters, tension_only):
    parameters = parameters.replace(tension_only=tension_only, wire_damping=0.0)
    rig, wires = referee.rig_and_wires(parameters)
    states = np.array(some_states(5) + free_states())
    tension, way = spatial.wire_pull(parameters, states)
    forces = (tension[..., None] * way / np.linalg.norm(way, axis=-1)[..., None]).sum(axis=1)
    np.testing.assert_allclose(forces, [spatial.pull_of_wires(one, rig, wires)[:3] for one in states], rtol=1e-9)


@pytest.mark.parametrize(
    ("parameters", "miss"),
    [(TWO_SETS, 1e-5), (ONE_SET, 3e-3), (TWO_SETS.replace(d0=0.0339998, tension_only=True), 0.05)],
)
def test_tensions_of_a_motion_without_its_heights_are_those_with_them(parameters, miss):
    """One set rocks, so that the mass's own acceleration counts; wires that go slack let it fall for a moment."""
    rig, wires = referee.rig_and_wires(parameters)
    state, trace = spatial.planar_state(static_equilibrium(parameters).coordinates), np.empty((400, spatial.SIZE))
    spatial.march(state, 0.0, 5e-6, 40_000, rig, wires, spatial.drive(3.18, 50.0), True, trace)
    tilt = spatial.angles(trace)[2]
    lift = parameters.LG * np.gradient(np.gradient(np.sin(tilt))) * 2000.0**2
    found = spatial.hung(parameters, trace[:, 0], spatial.axial_position(parameters, trace), tilt, lift)
    told, known = (spatial.wire_pull(parameters, states)[0] for states in (found, trace))
    assert np.abs(told - known).max() < miss * known.max()
    slack = known <= 0
    assert slack.any() == parameters.tension_only and (slack == (told <= 0)).mean() > 0.99


def moved(state, j, by):
    """A state moved along coordinate j: xs, the centre of mass, or turned about one of the body's axes."""
    state = state.copy()
    if j < 4:
        state[j] += by
        return state
    w, vector, turn = state[4], state[5:8], np.sin(by / 2) * np.eye(3)[j - 4]
    state[4] = w * np.cos(by / 2) - vector @ turn
    state[5:8] = w * turn + np.cos(by / 2) * vector + np.cross(vector, turn)
    return state


@RIGS
def test_axial_force_is_the_exact_law(parameters):
    rig, wires = referee.rig_and_wires(parameters)
    for z in (1e-5, 1e-3, -5e-3):
        force = spatial.pull_of_wires(spatial.planar_state([z, parameters.LG, 0, 0]), rig, wires)[0]
        law = parameters.wire_stiffness.sum() * z * (1 - parameters.d0 / np.hypot(z, parameters.d))
        assert force == pytest.approx(law, rel=1e-10)


@pytest.mark.parametrize("anywhere", [False, True], ids=["in the plane", "anywhere"])
def test_damping_takes_the_power_that_the_energy_loses(anywhere):
    damped = ONE_SET.replace(wire_damping=2.0, rocking_damping=1e-5)
    free, lossy = (referee.rig_and_wires(p) for p in (ONE_SET.replace(c=0, cs=0), damped))
    masses = np.array([free[0][name] for name in ("ms", "m", "m", "m", "about", "across", "across")])
    for state in free_states() if anywhere else some_states(5):
        conservative, real = (referee.rates(*rig, referee.FREE, False, 0.0, state) for rig in (free, lossy))
        power = np.sum(masses * (real - conservative)[8:] * state[8:])
        # rates of lengths by a small step of time along the velocity
        ahead, behind = (_lengths(lossy[1], state + h * real) for h in (1e-7, -1e-7))
        stretch_rate = (ahead[0] - behind[0]) / 2e-7
        relative = state[8] - (ahead[1] - behind[1]) / 2e-7
        rocking = state[13] ** 2 + state[14] ** 2
        lost = 2.0 * np.sum(stretch_rate[:4] ** 2) + 1e-5 * rocking + 0.026 * relative**2 + 9.86 * state[8] ** 2
        assert power == pytest.approx(-lost, rel=1e-6)


def test_rocking_damping_leaves_a_spin_about_the_axis_alone_and_is_the_planar_one_in_the_plane():
    rig, wires = referee.rig_and_wires(ONE_SET.replace(rocking_damping=1e-5))
    free = referee.rig_and_wires(ONE_SET)
    for spin, damped in (([7.0, 0, 0], [0, 0, 0]), ([0, 7.0, 0], [0, 7e-5, 0]), ([0, 0, 7.0], [0, 0, 7e-5])):
        state = free_states(1)[0]
        state[12:] = spin
        lost = [referee.rates(*one, referee.FREE, False, 0.0, state)[12:] for one in (free, (rig, wires))]
        np.testing.assert_allclose((lost[0] - lost[1])[1:] * rig.across, damped[1:], rtol=1e-6, atol=1e-14)
        assert lost[0][0] == lost[1][0]


def _lengths(wires, state):
    """Lengths of the wires and x of P."""
    state[4:8] /= np.linalg.norm(state[4:8])
    w, vector = state[4], state[5:8]
    turn = lambda pins: pins + 2 * np.cross(vector, w * pins + np.cross(vector, pins))  # noqa: E731
    lines = state[1:4] + turn(wires[:, 3:6]) - wires[:, :3] - [state[0], 0, 0]
    return np.linalg.norm(lines, axis=1), state[1] - ONE_SET.LG * turn(np.array([1.0, 0, 0]))[0]


def test_a_free_body_turns_as_eulers_top():
    """No wires to speak of, no weight: momenta stay, and the rest of the angular velocity goes round the axis."""
    loose = TWO_SETS.replace(k=1e-20, gravity=0, c=0, rocking_damping=0)
    (rig, wires), state = referee.rig_and_wires(loose), free_states(1)[0]
    state[8:] = 0, 0.1, 0.2, 0.3, 20.0, 5.0, -3.0
    before, begun = state.copy(), state[12:] * [rig.about, rig.across, rig.across]
    spatial.march(state, 0.0, 1e-3, 100, rig, wires, referee.FREE, False, referee.NO_TRACE)
    np.testing.assert_allclose(state[1:4] - before[1:4], 0.1 * before[9:12], rtol=1e-12)
    turn = (5.0 - 3.0j) * np.exp(-1j * (rig.across - rig.about) / rig.across * 20.0 * 0.1)
    assert state[12] == 20.0 and complex(*state[13:]) == pytest.approx(turn, rel=1e-11)
    ended = state[12:] * [rig.about, rig.across, rig.across]
    np.testing.assert_allclose(_in_space(state, ended), _in_space(before, begun), rtol=1e-10)


def _in_space(state, vector):
    w, axis = state[4] / np.linalg.norm(state[4:8]), state[5:8] / np.linalg.norm(state[4:8])
    return vector + 2 * np.cross(axis, w * vector + np.cross(axis, vector))


def test_a_rig_without_dampers_keeps_its_energy_in_space():
    free = ONE_SET.replace(c=0, cs=0)
    (rig, wires), state = referee.rig_and_wires(free), free_states(1)[0]
    masses = np.array([rig[name] for name in ("ms", "m", "m", "m", "about", "across", "across")])
    energy = lambda state: referee.energy(free, state) + np.sum(masses * state[8:] ** 2) / 2  # noqa: E731
    begun, roll = energy(state), spatial.angles(state)[0]
    spatial.march(state, 0.0, 2e-5, 5000, rig, wires, referee.FREE, False, referee.NO_TRACE)
    assert abs(spatial.angles(state)[0] - roll) > 0.01
    assert energy(state) == pytest.approx(begun, rel=1e-9)


@pytest.mark.parametrize("parameters", [TWO_SETS, ONE_SET, FULL], ids=["two sets", "one set", "everything"])
def test_linear_equations_out_of_the_plane_are_the_derivative_of_the_others(parameters):
    rig, wires = referee.rig_and_wires(parameters)
    for state in some_states(8):

        def deviation(u, state=state):
            """Rates of a deviation u from a planar state, by the equations in space: both states a little later."""
            moved = spatial.turned(state, u[1], u[2])
            moved[3], moved[11:14] = u[0], u[3:]
            both = [(one, referee.rates(rig, wires, referee.FREE, False, 0.0, one)) for one in (state, moved)]
            turns = [_against(*(one + h * rate for one, rate in both)) for h in (1e-6, -1e-6)]
            return np.array([moved[11], *(np.subtract(*turns) / 2e-6), *both[1][1][11:14]])

        with_six = np.concatenate([state, np.eye(6).ravel()])
        linear = referee.rates(rig, wires, referee.FREE, True, 0.0, with_six)[15:].reshape(6, 6).T
        for j, size in enumerate([1e-7, 1e-5, 1e-5, 1e-2, 1e-2, 1e-2]):
            slope = (deviation(size * np.eye(6)[j]) - deviation(-size * np.eye(6)[j])) / (2 * size)
            scale = np.array([1, 1, 1, *np.abs(linear[3:]).max(axis=1)])
            assert np.abs((linear[:, j] - slope) / scale).max() < 1e-6
            np.testing.assert_allclose(linear[3:, j], slope[3:], rtol=1e-5, atol=1e-6 * np.abs(slope[3:]).max())


def _against(state, moved):
    """Roll and yaw of a state against another, about the axes of the other's body: twice conj(q0) q."""
    w, vector, other = state[4], -state[5:8], moved[5:8]
    return 2 * (w * other + moved[4] * vector + np.cross(vector, other))[:2]


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
    assert referee.residual(p, [xs, X, Y, tilt]) == pytest.approx(np.zeros(4), abs=1e-12)


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
    "parameters, tap", [(TWO_SETS, None), (ONE_SET, Tap(time=0.1))], ids=["two sets", "one set, tapped"]
)
def test_compiled_march_agrees_with_scipy(parameters, tap):
    case = (parameters, 3.18, 30.0, 1.0, tap)
    compiled, scipy = referee.simulate_sine(*case), referee.simulate_sine(*case, method="scipy")
    np.testing.assert_allclose(compiled[0], scipy[0], rtol=0, atol=1e-12)
    for one, other in zip(compiled[1:4], scipy[1:4], strict=True):
        assert np.abs(one - other).max() < 1e-6 * np.abs(other).max()


def test_one_set_yaws_and_either_rolls_as_pendulums_of_their_tension():
    """And two sets yaw as a beam of their side wires; installed, weightless, by the equations out of the plane."""
    p, tension = ONE_SET, ONE_SET.wire_stiffness[0] * (ONE_SET.d - ONE_SET.d0)
    yaw = 2 * tension * p.Rm * (p.Rm + p.d) / p.d / (p.inertia + p.m * p.LG**2)
    roll = 4 * tension * p.Rm * (p.Rm + p.d) / p.d / (p.m * p.Rm**2 / 2)
    found = out_of_plane_modes(ONE_SET)
    assert found[:2] == pytest.approx(np.sqrt([yaw, roll]) / (2 * np.pi), rel=3e-4)
    assert found[:2] == pytest.approx([12.6, 51.1], abs=0.05)
    middle = TWO_SETS.replace(set_centre=TWO_SETS.LG)
    beam = 4 * middle.k * middle.half_spacing**2 / middle.inertia
    assert out_of_plane_modes(middle)[[0, 2]] == pytest.approx(np.sqrt([roll, beam]) / (2 * np.pi), rel=1e-3)


def out_of_plane_modes(p):
    rig, wires = referee.rig_and_wires(p)
    deviations = np.concatenate([spatial.planar_state([0, p.LG, 0, 0]), np.eye(6).ravel()])
    matrix = spatial.rates(deviations, rig, wires)[15:].reshape(6, 6)
    return np.sort(np.linalg.eigvals(matrix).imag)[3:] / (2 * np.pi)


@pytest.mark.parametrize("parameters", [TWO_SETS, ONE_SET], ids=["two sets", "one set"])
def test_the_random_test_is_too_weak_to_leave_the_plane(parameters):
    (rig, wires), rate = referee.rig_and_wires(parameters), 2000.0
    force = np.random.default_rng(2014).normal(0, 1.115, 20_000)
    state = spatial.turned(referee.starting_state(parameters, "equilibrium"), 2e-6, 1e-6)
    largest = 0.0
    for k, level in enumerate(force):
        drive = np.array([0, 0, level, 0, 0, 0, 0, 1.0])
        spatial.march(state, k / rate, 1 / rate / 4, 4, rig, wires, drive, False, referee.NO_TRACE)
        largest = max(largest, *np.abs(spatial.angles(state)[:2]))
    assert largest < 1e-4


def test_compiled_march_agrees_with_scipy_in_space():
    case = (ONE_SET, 3.18, 22.0, 1.0, Tap(time=0.1))
    compiled, scipy = (referee.simulate_sine(*case, method=m, turned=(0.02, 0.01)) for m in ("compiled", "scipy"))
    assert np.abs(compiled[4:6]).max(axis=1).min() > 0.01
    for one, other in zip(compiled[1:], scipy[1:], strict=True):
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
    rig, rate = referee.rig_and_wires(ONE_SET), 2000.0
    for hold, slopes in (("zero", np.zeros(39)), ("linear", np.diff(force) * rate)):
        state = referee.starting_state(ONE_SET, "equilibrium")
        z = referee.simulate_held(ONE_SET, force, rate, hold)[2]
        for k, slope in enumerate(slopes):
            tilt = spatial.angles(state)[2]
            assert z[k] == pytest.approx(state[0] - state[1] + ONE_SET.LG * np.cos(tilt), rel=1e-7, abs=1e-13)
            drive = np.array([0, 0, force[k], slope, k / rate, 0, 0, 1.0])
            state = referee.scipy_march(state, k / rate, np.array([(k + 1) / rate]), *rig, drive)[-1]


def test_fourier_reads_amplitude_and_phase_against_a_cosine():
    t = 2 + np.arange(20001) / 20000
    u = 0.3 + 2 * np.cos(2 * np.pi * 23.4 * t + 0.7) + 0.5 * np.cos(6 * np.pi * 23.4 * t)
    assert referee.fourier(t, u, 23.4) == pytest.approx(2 * np.exp(0.7j), rel=1e-4)
