"""The shaker's circuit in the leapfrog: order, another integrator, energy, limits, and what a stinger would change."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rigsim.model.chipmunk import RigSpace
from rigsim.model.excitation import CosineForce, HeldForce, Tap, TapForce
from rigsim.model.oscillator import matrices
from rigsim.model.shaker import MODES, ShakerDrive
from rigsim.model.spatial import planar_state
from rigsim.parameters import RigParameters

from .refereed import rates, rig_and_wires

RIG = RigParameters()
LINEAR = RIG.replace(k=RIG.k1 / 4, d0=RIG.d / 2, gravity=0, c=0.1)
VOLTAGE = ShakerDrive()
B, R, L = VOLTAGE.force_factor, VOLTAGE.resistance, VOLTAGE.inductance


def run(rigs, drives, force, steps, step=5e-5, every=1, tap=None):
    """Motion of rigs under a force's kicks and what it asks of drives in between."""
    space = RigSpace(rigs, step, "rest", drives)
    taps = TapForce((tap,) * len(rigs), np.array([p.m for p in rigs]), step)
    return space.advance(force.kicks(0, steps), taps.kicks(0, steps), every, force.between(0, steps))


def cosine(n=1, step=5e-5, force=3.18, frequency=40.0):
    return CosineForce(np.full(n, force), np.broadcast_to(float(frequency), n), step)


HELD = np.random.default_rng(3).normal(size=101)
EXCITED = {
    "cosine": lambda step: cosine(step=step),
    "zero hold": lambda step: HeldForce(HELD, round(5e-4 / step), "zero"),
    "linear hold": lambda step: HeldForce(HELD, round(5e-4 / step), "linear"),
}


@pytest.mark.parametrize("name", EXCITED)
def test_the_step_stays_of_second_order(name):
    """Differences between steps halved in turn fall by four, of the motion and of the coil's force, jumps included."""
    runs = []
    for halving in range(4):
        step, every = 2.5e-5 / 2**halving, 20 * 2**halving
        runs.append(run([RIG], [VOLTAGE], EXCITED[name](step), 100 * every, step, every, Tap(0.5, 2e-3, 0.01)))
    for channel in ("shaker", "mass", "force"):
        values = np.array([getattr(one, channel)[:, 0] for one in runs])
        differences = np.sqrt((np.diff(values, axis=0) ** 2).mean(axis=1))
        np.testing.assert_allclose(differences[:-1] / differences[1:], 4, rtol=0.04, err_msg=channel)


@pytest.mark.parametrize("sets", [RIG, RIG.single_set()], ids=["two sets", "one set"])
def test_another_integrator_finds_the_same(sets):
    """SciPy's DOP853 on the three-dimensional referee's rates and the circuit's equation; halved steps come closer."""
    (rig, wires), omega, amplitude = rig_and_wires(sets), 2 * np.pi * 40.0, 3.18 * R / B

    def derivative(t, y):
        drive = np.array([0, 0, B * y[-1], 0, 0, 0, 0, 1.0])  # a force held at this instant's
        out = rates(rig, wires, drive, True, t, y[:-1])
        return np.append(out, (amplitude * np.cos(omega * t) - R * y[-1] - B * y[8]) / L)

    times = np.arange(0, 0.1, 1e-3)
    start = np.append(planar_state([0.0, sets.LG, 0.0, 0.0]), 0.0)
    scale = np.concatenate([[1e-6] * 4, [5e-5] * 4, [1e-4] * 4, [1e-2] * 3, [1e-4]])
    exact = solve_ivp(derivative, (0, times[-1]), start, method="DOP853", t_eval=times, rtol=1e-10, atol=1e-6 * scale).y
    errors = []
    for step in (5e-5, 2.5e-5):
        found = run([sets], [VOLTAGE], cosine(step=step), round(0.1 / step), step, round(1e-3 / step))
        pairs = (found.shaker[:, 0], exact[0]), (found.force[:, 0], B * exact[-1])
        errors.append([abs(one - other).max() / abs(other).max() for one, other in pairs])
    errors = np.array(errors)
    assert (errors[0] < 1e-3).all()
    np.testing.assert_allclose(errors[0] / errors[1], 4, rtol=0.1)


def test_power_is_balanced_to_the_last_digits():
    """Electrical work is heat in the coil, energy in its field and work on the frame, which is what the rig gets."""
    step, steps, rig = 5e-5, 4000, LINEAR
    moved = run([rig], [VOLTAGE], cosine(), steps, step)
    force, xs, x = moved.force[:, 0], moved.shaker[:, 0], moved.mass[:, 0]
    current, speed = force / B, np.diff(xs) / step  # at half steps
    middle, volts = (current[1:] + current[:-1]) / 2, R / B * cosine().between(0, steps).real[:-1, 0]
    work, heat, taken = step * np.cumsum([volts * middle, R * middle**2, B * speed * middle], axis=1)
    np.testing.assert_allclose(work, heat + L * current[1:] ** 2 / 2 + taken, rtol=0, atol=1e-10 * work[-1])
    # The frame's share, at the instants of the kicks: the same sum by parts.
    on_frame = step * np.cumsum(force[1:-1] * (speed[1:] + speed[:-1]) / 2)
    np.testing.assert_allclose(on_frame, taken[1:] - step / 2 * force[2:] * speed[1:], rtol=0, atol=1e-10 * taken[-1])
    # And the rig's: energy stored and dampers' heat, by equations of its own.
    both, place = np.diff(np.stack([xs, x]), axis=1) / step, np.stack([xs, x])
    mass, damping, stiffness = matrices(rig)
    middle = (both[:, 1:] + both[:, :-1]) / 2
    lost = step * np.cumsum(form(middle, damping, middle))
    stored = form(both[:, 1:], mass, both[:, 1:]) / 2 + form(place[:, 1:-1], stiffness, place[:, 2:]) / 2
    gained = lost + stored
    np.testing.assert_allclose(on_frame - on_frame[0], gained - gained[0], rtol=0, atol=1e-4 * on_frame.max())


def form(one, matrix, other):
    """One' matrix other at each instant, of vectors (2, instants)."""
    return np.einsum("it,ij,jt->t", one, matrix, other)


def test_a_shorted_coil_only_takes_energy_and_all_of_it_is_heat():
    """No voltage, a tap: energy of rig and field falls by the coil's heat at every step; an open circuit keeps it."""
    rig, step = LINEAR.replace(cs=0, c=0), 5e-5
    moved = run([rig, rig], [VOLTAGE, None], cosine(2, force=0.0), 20000, step, tap=Tap(5e-3, 2e-3, 0.0))
    mass, _, stiffness = matrices(rig)
    totals = []
    for i in (0, 1):
        place, force = np.stack([moved.shaker[:, i], moved.mass[:, i]]), moved.force[:, i]
        speed = np.diff(place, axis=1) / step
        total = form(speed, mass, speed) / 2 + form(place[:, :-1], stiffness, place[:, 1:]) / 2
        totals.append((total + L * (force[1:] / B) ** 2 / 2 + step / 2 * force[1:] * speed[0])[100:])
    shorted, opened = totals
    middle = (moved.force[101:, 0] + moved.force[100:-1, 0])[1:] / (2 * B)
    heat = step * np.cumsum(R * middle**2)
    np.testing.assert_allclose(shorted[0] - shorted[1:], heat, rtol=0, atol=1e-5 * shorted[0])
    assert heat[-1] > 0.01 * shorted[0] and np.diff(shorted).max() < 1e-8 * shorted[0]
    assert np.ptp(opened) < 1e-5 * opened[0]


def test_a_prescribed_force_is_what_it_was_to_the_last_bit():
    """Without a drive, with one of constant current, and beside rigs with others."""
    drives = [None, ShakerDrive("current"), *map(ShakerDrive, MODES[1:]), None]
    together = run([RIG] * 6, drives, cosine(6), 2000, tap=Tap(0.5, 2e-3, 0.02))
    alone = run([RIG], None, cosine(), 2000, tap=Tap(0.5, 2e-3, 0.02))
    for i in (0, 1, 5):
        for channel in ("shaker", "mass", "tilt", "force"):
            np.testing.assert_array_equal(getattr(together, channel)[:, i], getattr(alone, channel)[:, 0])
    for i in (2, 3, 4):
        one = run([RIG], [drives[i]], cosine(), 2000, tap=Tap(0.5, 2e-3, 0.02))
        np.testing.assert_array_equal(together.mass[:, i], one.mass[:, 0])
        assert (one.mass != alone.mass).any()
    assert not together.voltage[:, 0].any() and together.voltage[:, 1].any()


def test_the_voltage_of_a_constant_current_drives_the_same_motion():
    """What a current amplifier has to give, given by a voltage amplifier: half a step apart, of second order."""
    apart = []
    for step in (5e-5, 2.5e-5):
        force = cosine(step=step, frequency=30.0)
        first = run([RIG], [ShakerDrive("current")], force, round(0.2 / step), step)
        volts = (first.voltage[1:, 0] + first.voltage[:-1, 0]) / 2 * B / R
        volts = np.append(volts, volts[-1]).astype(complex)[:, None]
        space = RigSpace([RIG], step, "rest", [ShakerDrive("voltage")])
        again = space.advance(np.zeros((len(volts), 1)), np.zeros((len(volts), 1)), 1, volts)
        late = slice(round(0.05 / step), -2)  # a current that starts at once takes a pulse, which no amplifier gives
        apart.append(abs(again.force - first.force)[late].max())
    assert apart[0] < 0.02 * 3.18 and apart[1] < apart[0]


@pytest.mark.parametrize("mode", ["force", "acceleration"])
def test_a_controller_takes_away_deviations_at_the_pace_it_is_given(mode):
    """A linear rig at 20 Hz: the logarithm of what is held over what is asked for falls as exp(-2 pi bandwidth t)."""
    drive = ShakerDrive(mode, bandwidth=0.5, max_voltage=100.0, compression=1e3)
    moved = run([LINEAR], [drive], cosine(force=0.05, frequency=20.0), 80000, every=1)
    held = moved.force[1:-1, 0]
    if mode == "acceleration":
        held = LINEAR.ms * np.diff(moved.shaker[:, 0], 2) / 5e-5**2
    turns = np.exp(-2j * np.pi * 20.0 * 5e-5 * np.arange(1, 79999))
    lines = 2 * (held * turns)[:79000].reshape(79, 1000).mean(axis=1) / 0.05  # of each period
    deviation = abs(np.log(lines))
    time = 0.05 * (np.arange(79) + 0.5)
    early, late = 10, 30
    pace = np.log(deviation[early] / deviation[late]) / (time[late] - time[early])
    assert pace == pytest.approx(2 * np.pi * 0.5, rel=0.12)  # a period's delay makes it faster
    assert deviation[-1] < 1e-4


def test_an_amplifier_clips_and_a_controller_stops_at_its_largest_voltage():
    weak = [ShakerDrive(mode, max_voltage=0.5) for mode in MODES]
    moved = run([RIG] * 4, weak, cosine(4, frequency=56.0), 40000)
    assert moved.limited.all()
    assert abs(moved.voltage[20000:, 0]).max() > 0.5 >= abs(moved.voltage[:, 1:]).max()
    # At its limit a controller's voltage is still a sine; an amplifier that is asked for too much cuts it.
    flat = [(abs(moved.voltage[20000:, i]) > 0.499).mean() for i in (1, 2)]
    assert flat[0] > 0.3 and flat[1] < 0.1


def test_a_step_too_long_for_the_coil_is_refused():
    with pytest.raises(ValueError, match="step = 5e-05 s is too long for the drive's coil; expected 2 L/R = 2e-05 s"):
        RigSpace([RIG], 5e-5, "rest", [ShakerDrive(inductance=3e-5)])
    stiff = ShakerDrive(force_factor=200.0, resistance=1.0, inductance=1e-4)
    with pytest.raises(ValueError, match="step = 0.0001 s is unstable with this drive; expected below 2/omega = 3"):
        RigSpace([RIG], 1e-4, "rest", [stiff])
    limit = 2 / np.sqrt(stiff.force_factor**2 / stiff.inductance / RIG.ms)
    moved = run([RIG], [stiff], cosine(step=0.95 * limit), 20000, 0.95 * limit)
    assert abs(moved.shaker).max() < 1e-3


def test_settings_are_checked_and_shown_with_their_units():
    for name, value in (("mode", "power"), ("resistance", 0.0), ("inductance", np.nan), ("force_factor", -1.0),
                        ("bandwidth", 100.0), ("compression", 0.0), ("max_voltage", np.inf)):  # fmt: skip
        with pytest.raises(ValueError, match=f"{name} = .* is not allowed; expected"):
            ShakerDrive(**{name: value})
    with pytest.raises(ValueError, match="field of ShakerDrive"):
        VOLTAGE.replace(resistence=3)
    assert VOLTAGE.replace(resistance=5).damping == 20.0 and ShakerDrive("current").damping == 0.0
    table = VOLTAGE.table()
    assert table.loc["Bl^2/R", "value"] == pytest.approx(100 / 3) and table.loc["Bl^2/R", "unit"] == "N s/m"
    assert "constant voltage" in repr(VOLTAGE)
    with pytest.raises(ValueError, match="ms = 0.001 kg is lighter than the coil makes it"):
        VOLTAGE.equivalent(RIG.replace(ms=1e-3), 1.0)


def with_stinger(stiffness, armature, frequency, drive, p):
    """xs and z of the linear rig whose ms is an armature and a frame with a stinger between; 1 N, or R/Bl V."""
    frame, omega = p.ms - armature, 2 * np.pi * frequency
    rod = np.array([[1, -1, 0], [-1, 1, 0], [0, 0, 0]])
    between = np.array([[0, 0, 0], [0, 1, -1], [0, -1, 1]])
    dynamic = stiffness * rod + (p.k1 + 1j * omega * p.c) * between
    dynamic = dynamic - omega**2 * np.diag([armature, frame, p.m]) + (p.ks + 1j * omega * p.cs) * np.diag([1, 0, 0])
    force = 1.0
    if drive is not None:
        impedance = drive.resistance + 1j * omega * drive.inductance
        dynamic[0, 0] += 1j * omega * drive.force_factor**2 / impedance
        force = drive.resistance / impedance
    _, xs, x = np.linalg.solve(dynamic, [force, 0, 0])
    return np.array([xs, xs - x])


@pytest.mark.parametrize("drive", [None, VOLTAGE])
def test_a_stinger_of_steel_changes_what_identified_values_hold_and_a_soft_one_more(drive):
    p, armature, steel = RIG.oscillator, 0.02, 2.0e11 * np.pi * 0.75e-3**2 / 0.05
    reduced = armature * (p.ms - armature) / p.ms
    assert np.sqrt(steel / reduced) / 2 / np.pi == pytest.approx(3200, rel=0.01) and steel > 300 * p.ks
    frequency = np.linspace(5, 80, 151)

    def off(stiffness, changed=p):
        pairs = [
            [with_stinger(k, armature, f, drive, of) for f in frequency] for k, of in ((stiffness, p), (1e13, changed))
        ]
        return abs(np.array(pairs[0]) / np.array(pairs[1]) - 1).max()

    identified = p.replace(ms=1.000662 * p.ms, ks=0.998658 * p.ks, cs=0.997615 * p.cs)
    assert off(steel) < 0.012 and off(32 * p.ks) > (0.1 if drive is None else 0.02)
    if drive is None:
        assert off(steel, identified) < 0.0015 < 0.01 < off(steel)
