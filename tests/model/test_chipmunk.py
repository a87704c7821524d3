"""The rigs in Chipmunk's Space: order of the leapfrog, energy, independence of neighbours, ends of the road."""

import importlib
import sys
from pathlib import Path

import numpy as np
import pymunk
import pymunk.batch
import pytest
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from rigsim.model.chipmunk import PYMUNK, RigSpace
from rigsim.model.excitation import CosineForce, HeldForce, Tap, TapForce
from rigsim.model.planar import (
    centre_damping,
    conservative_forces,
    longest_step,
    mass_matrix,
    pack,
    rest_position,
    static_equilibrium,
)
from rigsim.parameters import RigParameters

RIG = RigParameters()
ONE_SET = RIG.single_set()
FORCE = 3.18
HELD = np.random.default_rng(3).normal(size=101)


def coordinates(space):
    """q and the velocity half a step later of a rig alone, straight from the bodies."""
    frame, cylinder = space._space.bodies
    q = np.array([frame.position.x, *cylinder.position, cylinder.angle])
    return q, np.array([frame.velocity.x, *cylinder.velocity, cylinder.angular_velocity])


def motion(parameters, step, steps, frame_force, tap=None, start="rest", every=1):
    space = RigSpace(parameters, step, start)
    taps = TapForce(tuple([tap] * len(parameters)), np.array([p.m for p in parameters]), step)
    return space.advance(frame_force.kicks(0, steps), taps.kicks(0, steps), every)


def cosine(n, step, force=FORCE, frequency=20.0):
    return CosineForce(np.full(n, force), np.broadcast_to(frequency, n), step)


EXCITATIONS = {
    "cosine": (lambda step: cosine(1, step, frequency=40.0), None),
    "tap": (lambda step: cosine(1, step, frequency=40.0), Tap(0.5, 2e-3, 0.01)),
    "zero hold": (lambda step: HeldForce(HELD, round(5e-4 / step), "zero"), None),
    "linear hold": (lambda step: HeldForce(HELD, round(5e-4 / step), "linear"), None),
}


@pytest.mark.parametrize("name", EXCITATIONS)
@pytest.mark.parametrize("sets", [RIG, ONE_SET], ids=["two sets", "one set"])
def test_the_step_is_of_second_order(name, sets):
    """Differences between steps halved in turn fall by four: self-convergence, no other integrator needed."""
    excite, tap = EXCITATIONS[name]
    rig = sets.replace(wire_damping=2.0, rocking_damping=1e-6)
    runs = []
    for halving in range(4):
        step = 2.5e-5 / 2**halving
        every = 20 * 2**halving
        runs.append(motion([rig], step, 100 * every, excite(step), tap, every=every))
    for channel in ("shaker", "mass", "tilt"):
        values = np.array([getattr(run, channel)[:, 0] for run in runs])
        differences = np.sqrt((np.diff(values, axis=0) ** 2).mean(axis=1))
        np.testing.assert_allclose(differences[:-1] / differences[1:], 4, rtol=0.03, err_msg=channel)


@pytest.mark.parametrize("rig", [RIG, ONE_SET, ONE_SET.replace(d0=RIG.d)], ids=["two sets", "one set", "no tension"])
def test_energy_neither_drifts_nor_leaks_without_damping(rig):
    """100 000 steps after a tap, at the step of the sweeps; the energy error of a leapfrog is bounded."""
    rig = rig.replace(c=0, cs=0)
    step, block, blocks = 5e-5, 500, 200
    rigs, wires = pack([rig])
    mass, force = np.diag(mass_matrix(rig)), np.empty(4)
    space = RigSpace([rig], step, "rest")
    taps = TapForce((Tap(0.5, 2e-3, 0.0),), np.array([rig.m]), step)

    def potential(q):
        r = np.array(
            [
                (q[1] + np.cos(q[3]) * w["along"] - np.sin(q[3]) * w["across"] - q[0] - w["anchor_x"],
                 q[2] + np.sin(q[3]) * w["along"] + np.cos(q[3]) * w["across"] - w["anchor_y"], w["hidden"])
                for w in wires[0]
            ]
        )  # fmt: skip
        stretch = np.linalg.norm(r, axis=1) - rig.d0
        return rig.ks * q[0] ** 2 / 2 + rig.m * rig.gravity * q[2] + (wires[0]["k"] * stretch**2).sum() / 2

    energies = []
    for i in range(blocks):
        space.advance(np.zeros((block, 1)), taps.kicks(i * block, block), block)
        q, ahead = coordinates(space)
        conservative_forces(q, rigs[0], wires[0], force)
        velocity = ahead - step / 2 * force / mass
        energies.append((mass * velocity**2).sum() / 2 + potential(q) - potential(rest_position(rig)))
    energies = np.array(energies)
    given = rig.m * 0.5**2 / 2
    assert np.ptp(energies) < 0.01 * given
    assert abs(energies[: blocks // 4].mean() - energies[-blocks // 4 :].mean()) < 1e-3 * given
    assert energies.mean() == pytest.approx(given, rel=0.05)


def test_rigs_side_by_side_move_as_each_alone():
    rigs = [RIG, ONE_SET, RIG.replace(k=tuple(np.linspace(3e4, 5e4, 8)), wire_damping=1.0), RIG.replace(m=0.01), RIG]
    frequency, step = np.array([20.0, 30.0, 40.0, 50.0, 60.0]), 5e-5
    together = motion(rigs, step, 4000, cosine(5, step, frequency=frequency), Tap(0.5, 2e-3, 0.05))
    for i, rig in enumerate(rigs):
        alone = motion([rig], step, 4000, cosine(1, step, frequency=frequency[i]), Tap(0.5, 2e-3, 0.05))
        for channel in ("shaker", "mass", "tilt"):
            np.testing.assert_array_equal(getattr(together, channel)[:, i], getattr(alone, channel)[:, 0])


def test_motion_does_not_depend_on_how_it_is_cut():
    step = 5e-5
    whole = motion([RIG], step, 3000, cosine(1, step), every=10)
    space, force = RigSpace([RIG], step, "rest"), cosine(1, step)
    pieces = [space.advance(force.kicks(k, n), np.zeros((n, 1)), 10) for k, n in ((0, 10), (10, 990), (1000, 2000))]
    np.testing.assert_array_equal(np.concatenate([piece.mass for piece in pieces]), whole.mass)


@pytest.mark.parametrize("rig", [RIG, ONE_SET, RIG.replace(k=tuple(np.linspace(3e4, 5e4, 8)))])
def test_a_rig_started_in_equilibrium_stays_put(rig):
    q = static_equilibrium(rig).coordinates
    still = motion([rig], 5e-5, 20000, cosine(1, 5e-5, force=0.0), start="equilibrium", every=100)
    np.testing.assert_allclose(still.tilt, q[3], rtol=0, atol=1e-12)
    np.testing.assert_allclose(still.shaker, q[0], rtol=0, atol=1e-15)
    np.testing.assert_allclose(still.mass, q[1] - rig.LG * np.cos(q[3]), rtol=0, atol=1e-13)


def test_pymunk_draws_the_rig_where_its_bodies_are():
    space = RigSpace([ONE_SET, RIG], 5e-5, "equilibrium")
    space.advance(np.full((400, 1), 30.0), np.zeros((400, 2)), 400)
    axes = Figure().subplots()
    space.debug_draw(axes, 1)
    frame, cylinder = tuple(space._space.bodies)[2:]
    box = next(patch for patch in axes.patches if isinstance(patch, Polygon)).get_xy()[:4]
    np.testing.assert_allclose(box.mean(axis=0), 1e4 * np.array(cylinder.position), atol=1e-3)
    np.testing.assert_allclose(np.ptp(box, axis=0), 1e4 * np.array([RIG.Lm, 2 * RIG.Rm]), rtol=1e-3)
    dots = [patch.center for patch in axes.patches if isinstance(patch, Circle)]
    assert len(dots) == 8, "both ends of four wires in the plane"
    assert max(x for x, _ in dots) == pytest.approx(1e4 * (frame.position.x + RIG.set_positions[1]), abs=0.1)
    assert axes.get_xlabel() == "x [mm]" and frame.position.x > 1e-4


def test_a_rig_started_at_rest_begins_at_zero_and_then_sags():
    fall = motion([ONE_SET], 5e-5, 2000, cosine(1, 5e-5, force=0.0))
    assert fall.shaker[0] == fall.mass[0] == fall.tilt[0] == 0
    # undamped, the mass swings about its equilibrium
    assert fall.tilt.min() < static_equilibrium(ONE_SET).tilt < fall.tilt.max() < 1e-3


def test_a_tap_sets_a_nearly_free_mass_moving_at_its_velocity():
    free = RIG.replace(k=1e-6, c=0, gravity=0)
    step = 1e-5
    tapped = motion([free], step, 4000, cosine(1, step, force=0.0), Tap(0.5, 2e-3, 0.01))
    velocity = np.diff(tapped.mass[:, 0]) / step
    assert not velocity[:990].any()
    np.testing.assert_allclose(velocity[1210:], 0.5, rtol=3e-5)


@pytest.mark.parametrize("step", [0.0, -1e-5, 1e-3, np.nan])
def test_an_unstable_step_is_refused(step):
    with pytest.raises(ValueError, match="step = .* s is unstable; expected above 0 and below 2/omega = 0.000178 s"):
        RigSpace([RIG.replace(m=0.1), RIG], step, "rest")


@pytest.mark.parametrize("rig", [RIG, ONE_SET, ONE_SET.replace(k=40.0, d0=0.017, gravity=0)])
def test_just_below_the_longest_step_the_motion_stays_bounded(rig):
    step = 0.99 * longest_step(rig)
    moved = motion([rig], step, 20000, cosine(1, step), Tap(0.1, 5e-3, 0.0))
    assert np.isnan(moved.parted[0])
    assert abs(moved.mass).max() < 0.01


@pytest.mark.parametrize("force", [1e8, 1e200, 1.7e308])
def test_a_rig_that_flies_apart_is_parked_and_its_neighbours_feel_nothing(force):
    step, amplitude = 5e-5, np.array([FORCE, force, FORCE])
    shake = CosineForce(amplitude, np.array([20.0, 20.0, 45.0]), step)
    together = motion([RIG] * 3, step, 4000, shake)
    assert np.isfinite(together.parted).tolist() == [False, True, False]
    assert 0 < together.parted[1] < 1e-3
    late = together.mass[100:, 1]
    assert np.isfinite(late).all() and np.ptp(late) == 0
    for i in (0, 2):
        alone = motion([RIG], step, 4000, cosine(1, step, frequency=shake.frequency[i]))
        np.testing.assert_array_equal(together.mass[:, i], alone.mass[:, 0])


def test_one_set_that_tilts_past_its_wires_reach_is_parked():
    heavy = ONE_SET.replace(m=0.5, k=200.0)
    parted = motion([heavy, ONE_SET], 5e-5, 20000, cosine(2, 5e-5, force=0.0)).parted
    assert 0 < parted[0] < 1 and np.isnan(parted[1])


def test_a_rig_without_equilibrium_cannot_start_there():
    with pytest.raises(ValueError, match="past its wires' reach"):
        RigSpace([RIG, ONE_SET.replace(m=500)], 5e-5, "equilibrium")


def test_only_rigs_go_into_a_space():
    with pytest.raises(ValueError, match="expects RigParameters"):
        RigSpace([RIG.oscillator], 5e-5, "rest")


def public_loop(parameters, step, frame_force, tap_force):
    """Positions (steps, n, 4) of the leapfrog driven by pymunk's public calls alone, slowly."""
    fields = pymunk.batch.BodyFields
    state = fields.POSITION | fields.ANGLE | fields.VELOCITY | fields.ANGULAR_VELOCITY
    rigs, wires = pack(parameters)
    space, read, write = pymunk.Space(), pymunk.batch.Buffer(), pymunk.batch.Buffer()
    for p in parameters:
        frame, cylinder = pymunk.Body(p.ms, float("inf")), pymunk.Body(p.m, p.inertia)
        cylinder.position = rest_position(p)[1], 0.0
        space.add(frame, cylinder)
    forces = np.zeros((len(parameters), 2, 3))  # x, y and moment of each body
    write.set_float_buf(forces.ravel())
    positions, force, damping = [], np.empty(4), np.empty((4, 4))
    for k in range(len(tap_force) + 1):
        read.clear()
        pymunk.batch.get_space_bodies(space, state, read)
        bodies = np.frombuffer(read.float_buf()).reshape(-1, 12)
        positions.append(bodies[:, [0, 6, 7, 8]].copy())
        if k == len(tap_force):
            return np.array(positions[1:])
        for i, p in enumerate(parameters):
            v = bodies[i, [3, 9, 10, 11]]
            q = positions[-1][i] + v * step
            conservative_forces(q, rigs[i], wires[i], force)
            force[0] += frame_force[k, i]
            force[1] += tap_force[k, i]
            if k == 0:
                force /= 2
            else:
                centre_damping(q, v, rigs[i], wires[i], np.diag(mass_matrix(p)).copy(), step, damping, force)
            forces[i] = (force[0], 0, 0), force[1:]
        pymunk.batch.set_space_bodies(space, fields.FORCE | fields.TORQUE, write)
        space.step(step)


def test_the_compiled_loop_does_what_public_calls_do_to_the_last_bit():
    rigs, step = [RIG, ONE_SET, RIG.replace(wire_damping=2.0, rocking_damping=1e-6, tension_only=True)], 5e-5
    shake, taps = (
        cosine(3, step, frequency=[20.0, 40.0, 60.0]),
        TapForce((Tap(0.5, 2e-3, 0.01),) * 3, np.full(3, RIG.m), step),
    )
    expected = public_loop(rigs, step, shake.kicks(0, 500), taps.kicks(0, 500))
    moved = motion(rigs, step, 500, shake, Tap(0.5, 2e-3, 0.01))
    np.testing.assert_array_equal(moved.shaker, expected[..., 0])
    np.testing.assert_array_equal(moved.tilt, expected[..., 3])
    np.testing.assert_array_equal(moved.mass, expected[..., 1] - RIG.LG * np.cos(expected[..., 3]))
    assert abs(moved.tilt).max() > 0 and abs(moved.mass).max() > 1e-5


@pytest.mark.parametrize("wrong", ["fields", "count"])
def test_a_space_that_public_calls_read_otherwise_is_refused(wrong, monkeypatch):
    fields, get = pymunk.batch.BodyFields, pymunk.batch.get_space_bodies

    def other(space, wanted, buffer):
        get(space, wanted if wrong == "count" else wanted ^ fields.POSITION ^ fields.VELOCITY, buffer)
        if wrong == "count":
            get(space, wanted, buffer)

    monkeypatch.setattr(pymunk.batch, "get_space_bodies", other)
    with pytest.raises(RuntimeError, match="lays out its bodies otherwise than rigsim's compiled loop expects"):
        RigSpace([RIG], 5e-5, "rest")


def test_other_versions_of_pymunk_are_refused(monkeypatch):
    monkeypatch.setattr(pymunk, "version", "7.3.0")
    monkeypatch.delitem(sys.modules, "rigsim.model.chipmunk")
    with pytest.raises(ImportError, match=f"pymunk 7.3.0 is not allowed; the multi-body rig expects pymunk=={PYMUNK}"):
        importlib.import_module("rigsim.model.chipmunk")


def test_the_version_allowed_is_the_one_installed_by_set_up():
    top = Path(__file__).parents[2]
    assert f'"pymunk=={PYMUNK}"' in (top / "pyproject.toml").read_text()
    assert f"\npymunk=={PYMUNK} " in (top / "environment.txt").read_text()
