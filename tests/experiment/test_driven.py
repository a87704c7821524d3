"""Tests with a shaker's drive: against the closed form, the linear system, each other, and what records say."""

import numpy as np
import pytest
import scipy.signal

from rigsim import (
    Record,
    RigParameters,
    Tap,
    compare_tests,
    identify,
    overlay,
    periodic_orbits,
    ramp_test,
    random_test,
    simulate,
    sine_test,
    stepped_test,
    swept_test,
    tapped_test,
)
from rigsim.experiment.protocols.bench import replay
from rigsim.model.oscillator import matrices
from rigsim.model.shaker import MODES, ShakerDrive
from rigsim.results import Status

RIG = RigParameters()
LINEAR = RIG.replace(k=RIG.k1 / 4, d0=RIG.d / 2, gravity=0, c=0.1)
FREQUENCY = np.array([5.0, 11.7, 20.0, 33.3, 55.65, 80.0])
VOLTAGE = ShakerDrive()


def closed_form(rig, drive, frequency, asked):
    """Lines of xs, x (m), force (N) and voltage (V) of a linear rig: mechanics and circuit solved as one system."""
    omega = 2 * np.pi * frequency
    M, C, K = matrices(rig)
    B, Z = drive.force_factor, drive.resistance + 1j * omega * drive.inductance
    whole = np.zeros((4, 4), dtype=complex)  # xs, x, i, u
    whole[:2, :2], whole[0, 2] = K + 1j * omega * C - omega**2 * M, -B
    whole[2] = 1j * omega * B, 0, Z, -1
    last = {"current": [0, 0, B, 0], "voltage": [0, 0, 0, B / drive.resistance], "force": [0, 0, B, 0],
            "acceleration": [-(omega**2) * rig.ms, 0, 0, 0]}  # fmt: skip
    whole[3] = last[drive.mode]
    xs, x, current, voltage = np.linalg.solve(whole, [0, 0, 0, asked])
    return xs, x, B * current, voltage


@pytest.mark.parametrize("mode", MODES)
def test_a_linear_rig_has_the_closed_form_s_response(mode):
    drive = ShakerDrive(mode)
    test = sine_test(LINEAR, 0.05, FREQUENCY, duration=6, drive=drive)
    assert list(test.status) == [Status.SETTLED] * 6 and not test.driven.limited.any()
    sent = test.driven
    for i, f in enumerate(FREQUENCY):
        wanted = np.array(closed_form(LINEAR, drive, f, 0.05))
        found = np.array([test.shaker[i], test.mass[i], sent.force[i], sent.voltage[i]])
        assert (abs(found / wanted - 1) < 4e-4).all(), (f, abs(found / wanted - 1))
        # and the equivalent rig under a constant force
        equivalent, force = drive.equivalent(LINEAR, 0.05, f)
        M, C, K = matrices(equivalent)
        omega = 2 * np.pi * f
        xs = np.linalg.solve(K + 1j * omega * C - omega**2 * M, [force, 0])[0]
        assert abs(xs / wanted[0] - 1) < (2e-3 if mode == "acceleration" and f == 5 else 1e-4)
    assert (sent.distortion < 1e-4).all()
    if mode == "voltage":  # at the shaker's resonance cs is all there is against the coil's damping
        assert abs(sent.force[4]) / 0.05 == pytest.approx(LINEAR.cs / (LINEAR.cs + drive.damping), rel=0.02)


@pytest.fixture(scope="module")
def every_drive():
    """The high branch at 40 Hz, without a drive and with each."""
    drives = [None, *map(ShakerDrive, MODES)]
    return sine_test(RIG, 3.18, 40.0, Tap(), duration=6, drive=drives)


def test_without_a_drive_and_with_constant_current_nothing_changes(every_drive):
    alone = sine_test(RIG, 3.18, 40.0, Tap(), duration=6)
    assert alone.driven is None and "drive" not in alone.table()
    for i in (0, 1):
        np.testing.assert_array_equal(every_drive.traces[i], alone.traces[0])
        assert every_drive.relative[i] == alone.relative[0] and every_drive.message[i] == alone.message[0]
    np.testing.assert_array_equal(every_drive.record(0).force, alone.record(0).force)
    assert every_drive.record(0).voltage is None


def test_a_back_emf_puts_harmonics_into_a_held_force_but_not_into_its_fundamental(every_drive):
    sent = every_drive.driven
    assert list(every_drive.status) == [Status.SETTLED] * 5
    assert sent.force[3] == pytest.approx(3.18, rel=1e-4) and abs(sent.force[2]) < 0.6 * 3.18
    assert (sent.distortion[:2] < 1e-9).all() and 0.02 < sent.distortion[3] < sent.distortion[2]
    assert abs(every_drive.relative[3]) == pytest.approx(abs(every_drive.relative[1]), rel=1e-3)
    omega = 2 * np.pi * 40
    # The third harmonic of the force is the coil's: Bl^2 3 i omega Xs3 over R + 3 i omega L, nothing else drives it.
    record = every_drive.record(3)
    turns = np.exp(-6j * np.pi * 40 * (every_drive.time[0] + record.time[1:]))
    force, xs, volts = (2 * np.mean(one[1:] * turns) for one in (record.force, record.shaker, record.voltage))
    coil = VOLTAGE.resistance + 3j * omega * VOLTAGE.inductance
    assert force == pytest.approx(10 * (volts - 30j * omega * xs) / coil, rel=1e-3) and abs(volts) < 1e-3
    assert abs(force) / 3.18 == pytest.approx(sent.distortion[3], rel=1e-3)


def test_the_table_and_the_record_say_what_the_shaker_gave(every_drive):
    table = every_drive.table()
    assert list(table["drive"]) == ["none", *MODES]
    np.testing.assert_allclose(table["current [A]"][1:], abs(every_drive.driven.force[1:]) / 10)
    assert np.isnan(table["voltage [V]"][0]) and table["voltage [V]"][2] == pytest.approx(0.954, rel=1e-3)
    record = every_drive.record(2)
    assert record.units["voltage"] == "V" and "voltage" in record.table().index
    np.testing.assert_array_equal([record.force, record.voltage], every_drive.driven.traces[2])


def test_a_driven_test_is_kept_as_a_file_with_what_the_shaker_gave(every_drive, tmp_path):
    import xarray as xr

    every_drive.save(tmp_path / "driven.nc")
    with xr.open_dataset(tmp_path / "driven.nc") as kept:
        acted = kept["acted_real"].to_numpy() + 1j * kept["acted_imaginary"].to_numpy()
        np.testing.assert_array_equal(acted, every_drive.driven.force)
        assert kept["acted_real"].attrs["units"] == "N" and "voltage_real" in kept
    points = stepped_test(RIG, 3.18, [30.0], dwell=1.0, drive=VOLTAGE)
    points.save(tmp_path / "points.csv")
    assert "resistance" in (tmp_path / "points.csv").read_text(encoding="utf-8").splitlines()[0]


def test_neighbours_and_executors_change_no_bit(every_drive, tmp_path):
    for i in range(1, 5):
        one = sine_test(
            RIG, 3.18, 40.0, Tap(), duration=6, drive=every_drive.driven.drive[i], checkpoint=tmp_path / "a"
        )
        np.testing.assert_array_equal(one.traces[0], every_drive.traces[i])
        assert one.driven.force[0] == every_drive.driven.force[i]
        (tmp_path / "a").unlink()


def linear_system(rig, drive):
    """State space of a linear rig with a voltage amplifier: u R/Bl to xs, x and the force."""
    M, C, K = matrices(rig)
    inverse, B, R, L = np.linalg.inv(M), drive.force_factor, drive.resistance, drive.inductance
    A = np.zeros((5, 5))
    A[:2, 2:4], A[2:4, :2], A[2:4, 2:4] = np.eye(2), -inverse @ K, -inverse @ C
    A[2, 4], A[4, 2], A[4, 4] = B / rig.ms, -B / L, -R / L
    out = np.zeros((3, 5))
    out[0, 0], out[1, 1], out[2, 4] = 1, 1, B
    return A, np.array([[0, 0, 0, 0, R / B / L]]).T, out, np.zeros((3, 1))


@pytest.mark.parametrize("hold", ["zero", "linear"])
def test_a_sampled_voltage_moves_a_linear_rig_as_the_linear_system(hold):
    rate = 500.0
    asked = np.random.default_rng(1).normal(0, 0.1, 1000)
    record = simulate(LINEAR, asked, rate, hold, drive=VOLTAGE)
    time = np.arange(1000) / rate
    _, wanted, _ = scipy.signal.lsim(linear_system(LINEAR, VOLTAGE), asked, time, interp=hold == "linear")
    for name, one in zip(("shaker", "mass", "force"), wanted.T, strict=True):
        assert abs(getattr(record, name) - one).max() < 2e-3 * abs(one).max(), name
    np.testing.assert_allclose(record.voltage, asked * 0.3)
    assert record.hold == "band-limited"


def test_a_constant_current_leaves_a_random_test_as_it_was():
    one, other = (random_test(RIG, duration=0.5, drive=drive) for drive in (None, ShakerDrive("current")))
    for name in ("force", "shaker", "mass", "tilt"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert one.voltage is None and other.voltage.any() and other.hold == "zero"


def test_the_measured_force_of_a_voltage_driven_record_identifies_the_rig_without_the_coil(tmp_path):
    """A voltage without jumps, the force as measured: cs comes back without Bl^2/R, 33 N s/m."""
    record = random_test(RIG, rms=3.0, duration=20, drive=VOLTAGE, hold="linear")
    found = identify(record, order=4)
    assert found.status == Status.IDENTIFIED
    for name in ("ms", "ks", "cs", "m", "c", "k1", "k3"):
        assert getattr(found.parameters, name) == pytest.approx(getattr(RIG.oscillator, name), rel=4e-3), name
    record.save(tmp_path / "driven.csv")
    again = Record.load(tmp_path / "driven.csv")
    np.testing.assert_array_equal(again.voltage, record.voltage)
    both = Record.joined([record, record])
    assert both.voltage.size == 2 * record.voltage.size and both.tests[1].voltage.size == record.voltage.size
    short = record.realigned(delay={"mass": 0.01})
    assert short.voltage.size == short.force.size < record.force.size


@pytest.mark.parametrize("mode", MODES[1:])
def test_protocols_settle_on_what_a_long_sine_test_finds(mode):
    drive = ShakerDrive(mode)
    points = stepped_test(RIG, 3.18, [26.0, 30.0], dwell=4.0, drive=drive)
    alone = sine_test(RIG, 3.18, [26.0, 30.0], duration=8, drive=drive)
    np.testing.assert_allclose(points.relative, alone.relative, rtol=3e-3)
    given = points.column("given")
    np.testing.assert_allclose(given[:, 0], alone.driven.force, rtol=2e-3)
    np.testing.assert_allclose(given[:, 2].real, alone.driven.distortion, atol=2e-4)
    record = points.to_record(0, 4000.0)
    last = slice(round(points[0].time * 4000) - 4000, round(points[0].time * 4000))
    turns = np.exp(-2j * np.pi * 26.0 * np.arange(4000) / 4000)
    assert abs(2 * np.mean(record.force[last] * turns)) == pytest.approx(abs(given[0, 0]), rel=2e-3)
    assert abs(2 * np.mean(record.voltage[last] * turns)) == pytest.approx(abs(given[0, 1]), rel=2e-3)


def test_a_voltage_that_jumps_from_point_to_point_keeps_the_second_order():
    motions = []
    for k in (1, 2, 4):
        test = ramp_test(RIG, [1.0, 3.0], 20.0, dwell=1.25, start="equilibrium", step=1e-4 / k, drive=VOLTAGE)
        found = replay(RIG, test.drives[0], "equilibrium", test.step, 10 * k, VOLTAGE)
        motions.append(found[1500:2400, [0, 1, 3]])
    coarse, fine = (abs(one - other).max(axis=0) for one, other in zip(motions, motions[1:], strict=False))
    np.testing.assert_allclose(coarse / fine, 4, rtol=0.1)


def test_benches_with_and_without_a_drive_stand_side_by_side():
    drives = [None, VOLTAGE, ShakerDrive("force")]
    test = stepped_test(RIG, 3.18, [30.0, 33.0], dwell=1.0, drive=drives)
    for i, drive in enumerate(drives):
        alone = stepped_test(RIG, 3.18, [30.0, 33.0], dwell=1.0, drive=drive)
        np.testing.assert_array_equal(test.runs[i].relative, alone.relative)
        np.testing.assert_array_equal(test.runs[i].column("given"), alone.column("given"))
    assert "|f| [N]" in test.table() and "|f| [N]" not in test.runs[0].table()
    assert test.runs[1].shakers == (VOLTAGE,)
    tapped = tapped_test(RIG, 3.18, [40.0], drive=VOLTAGE)
    assert abs(tapped[1].relative) > 3 * abs(tapped[0].relative) and tapped[1].given[2].real > 0.03


def test_a_sweep_shows_the_force_fall_at_resonance_and_a_controller_keep_it():
    free, held = (swept_test(RIG, 3.18, (45, 60), 2.0, drive=ShakerDrive(mode)) for mode in ("voltage", "force"))
    sizes = abs(free.column("given")[:, 0])
    assert 54 < free.frequency[sizes.argmin()] < 58 and sizes.min() < 0.25 * 3.18
    assert (abs(abs(held.column("given")[4:, 0]) / 3.18 - 1) < 0.12).all()  # the jump near 53 Hz is not outrun
    ramp = ramp_test(RIG, [1.0, 3.0], 30.0, 0.5, drive=ShakerDrive("force"))
    np.testing.assert_allclose(abs(ramp.column("given")[4:, 0]), ramp.force[4:], rtol=0.03)


@pytest.mark.parametrize(
    ("call", "changes", "named"),
    [
        (sine_test, {"drive": "voltage"}, "drive = 'voltage' is not allowed; expected a ShakerDrive or None"),
        (sine_test, {"drive": [VOLTAGE] * 2, "frequency": [20.0] * 3}, "drive has 2 elements; expected 1 or 3"),
        (sine_test, {"drive": ShakerDrive(inductance=3e-5)}, "step = 5e-05 s is too long for the drive's coil"),
        (stepped_test, {"drive": 3.0}, "drive = 3.0 is not allowed; expected a ShakerDrive or None"),
        (stepped_test, {"drive": ShakerDrive(inductance=3e-5)}, "step = 5e-05 s is too long for the drive's coil"),
    ],
)
def test_bad_input_is_named(call, changes, named):
    with pytest.raises(ValueError, match=named):
        call(**{"parameters": RIG, "force": 3.18, "frequency": 20.0} | changes)


def test_what_needs_a_constant_force_refuses_others(every_drive):
    driven = sine_test(RIG, 3.18, 40.0, duration=1, drive=VOLTAGE)
    named = "with a drive of constant voltage is not allowed; expected none, or constant current"
    with pytest.raises(ValueError, match=f"test {named}, since"):
        driven.out_of_plane()
    with pytest.raises(ValueError, match=f"tests {named} or force"):
        overlay(RIG, driven)
    orbits = periodic_orbits(RIG, 3.18, (35, 45), 1, search="seeds")
    for test in (driven, stepped_test(RIG, 3.18, [40.0], dwell=1.0, drive=VOLTAGE)):
        with pytest.raises(ValueError, match=f"tests {named} or force"):
            compare_tests(orbits, test)
    held = compare_tests(orbits, sine_test(RIG, 3.18, 40.0, Tap(), duration=6, drive=ShakerDrive("force")))
    assert (held.on[0] >= 0).all()
    assert every_drive.shakers == every_drive.driven.drive and every_drive.shakers[0] is None


def test_a_sampled_force_has_no_controller():
    with pytest.raises(ValueError, match="drive of constant force needs a sine; expected one of constant current or"):
        simulate(RIG, [0.0, 1.0], 2000, drive=ShakerDrive("force"))
    with pytest.raises(ValueError, match="drive = 1 is not allowed"):
        random_test(RIG, drive=1)


def test_the_force_of_a_coil_is_not_held():
    """Its current follows a voltage that is: told to be held, the record gives ms 3 % too small."""
    record = random_test(RIG, rms=3.0, duration=20, drive=VOLTAGE)
    found = identify(record.replace(hold="linear"))
    assert found.status == Status.DOUBTFUL
    assert "the force of a coil that was given a voltage is not held" in found.message
