"""Records with the troubles that people report: named, mended where there is one cure, and never confidently wrong."""

import numpy as np
import pytest
from scipy import signal

from rigsim.experiment.record import Record
from rigsim.identification.identify import identify
from rigsim.identification.physical import NAMES
from rigsim.identification.simulate import Run, Structure, simulate
from rigsim.identification.terms import CUBIC, LINEAR, Friction, Gap, Power, Term
from rigsim.parameters import RigParameters
from rigsim.results import Status
from tests.identification.cubic import cubic_record

P = RigParameters().oscillator
TRUE = np.array([getattr(P, name) for name in NAMES])
RATE = 2000.0
FORCE = np.random.default_rng(11).normal(scale=1.115, size=60_000)
FINE = 10


def moved(force=FORCE, rate=RATE, terms=(), sizes=(), driven=(1.0, 0.0), steps=8):
    """Shaker and mass of the paper's rig, with more terms of those sizes."""
    rig = Structure(("ms", "m"), (*LINEAR, CUBIC, *terms), ((0, "displacement"), (1, "displacement")), driven)
    values = np.array([P.ms, P.m, P.ks, P.cs, P.c, P.k1, P.k3, *sizes])
    reach = np.array([1e-3] * 5 + [0.1 if term.of == "velocity" else 1e-3 for term in terms])
    return simulate(rig, values, Run(force, rate, "zero"), np.zeros((1, 4)), reach, finer=steps)[0].T


@pytest.fixture(scope="module")
def clean():
    return Record(FORCE, *moved(), RATE)


@pytest.fixture(scope="module")
def fine():
    """The same motion ten times as fine."""
    return moved(np.repeat(FORCE, FINE), RATE * FINE, steps=1)


def noisy(record, share=0.002):
    rng = np.random.default_rng(3)
    given = {name: getattr(record, name) for name in ("shaker", "mass")}
    return record.replace(**{name: c + share * c.std() * rng.normal(size=c.size) for name, c in given.items()})


def wrong(found):
    """Largest error of the seven parameters in half-widths, of which none should be far outside."""
    return np.abs((found.errors.value[:7] - TRUE) / (found.errors.half_width[:7] + 1e-4 * TRUE)).max()


def right(found, within=0.05):
    return np.abs(found.errors.value[:7] / TRUE - 1).max() < within


def test_a_clean_record_has_none(clean):
    found = identify(clean)
    assert found.status == Status.IDENTIFIED and not found.message and not found.mended
    assert right(found, 1e-6)


@pytest.mark.parametrize(
    ("late", "who"),
    [
        (0.25, ("shaker", "mass")),
        (3.0, ("shaker", "mass")),
        (-2.0, ("shaker", "mass")),
        (0.6, ("mass",)),
        (3.0, ("mass",)),
    ],
)
def test_a_delay_is_named_and_mended(fine, late, who):
    at = np.arange(10, FORCE.size - 10)
    read = lambda name, place: fine[place][FINE * at - round(FINE * late) * (name in who)]  # noqa: E731
    record = noisy(Record(FORCE[at], read("shaker", 0), read("mass", 1), RATE))
    found = identify(record)
    assert right(found) and wrong(found) < 1.5
    verb = "are" if len(who) > 1 else "is"
    assert f"{' and '.join(who)} {verb} " in found.message and ("late" if late > 0 else "early") in found.message


@pytest.mark.parametrize("ppm", [30.0, -200.0])
def test_another_clock_is_named_and_mended(fine, ppm):
    at = np.arange(FORCE.size - 200) * (1 + 1e-6 * ppm)
    read = [np.interp(FINE * at, np.arange(channel.size), channel) for channel in fine]
    found = identify(noisy(Record(FORCE[: at.size], *read, RATE)))
    assert "clock of shaker and mass" in found.message and ("fast" if ppm > 0 else "slow") in found.message
    assert right(found) and wrong(found) < 1.5


def test_a_clock_within_a_part_in_a_million_is_in_the_interval(fine):
    at = np.arange(FORCE.size - 200) * (1 + 1e-6)
    read = [np.interp(FINE * at, np.arange(channel.size), channel) for channel in fine]
    assert wrong(identify(noisy(Record(FORCE[: at.size], *read, RATE)))) < 1.5


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"shaker": "mass", "mass": "shaker"}, "shaker and mass are exchanged"),
        ({"mass": "-mass"}, "the sensor of the mass is reversed"),
        ({"shaker": "-shaker"}, "the sensor of the shaker is reversed"),
        ({"shaker": "-shaker", "mass": "-mass"}, "the force is reversed, or both sensors are"),
    ],
)
def test_exchanged_and_reversed_sensors_are_named_and_mended(clean, change, words):
    take = lambda name: -getattr(clean, name[1:]) if name[0] == "-" else getattr(clean, name)  # noqa: E731
    found = identify(clean.replace(**{name: take(source) for name, source in change.items()}))
    assert f"mended: {words}" in found.message and right(found, 1e-5)


@pytest.mark.parametrize("power", [1, 2])
def test_velocities_and_accelerations_are_named(clean, power):
    channels = {name: getattr(clean, name) for name in ("shaker", "mass")}
    for _ in range(power):
        channels = {name: np.gradient(channel, 1 / RATE) for name, channel in channels.items()}
    found = identify(clean.replace(**channels))
    assert found.status == Status.DOUBTFUL
    assert f"look like {('velocities', 'accelerations')[power - 1]}, not displacements" in found.message


def test_the_acceleration_of_a_base_is_named():
    base = FORCE * 6
    found = identify(Record(base, *moved(base, driven=(-P.ms, -P.m)), RATE))
    assert found.status == Status.DOUBTFUL and "acceleration of a base" in found.message


@pytest.mark.parametrize("lost", [3, 250])
def test_lost_samples_are_found_where_they_are(clean, lost):
    kept = np.r_[0:25_000, 25_000 + lost : FORCE.size]
    given = {name: getattr(clean, name)[kept] for name in ("force", "shaker", "mass")}
    found = identify(clean.replace(**given))
    assert "begins anew at 12.5 s" in found.message
    assert right(found) and wrong(found) < 1.5


def test_runs_put_end_to_end_are_parted(clean):
    both = [
        np.concatenate([clean.channels[name][:20_000], clean.channels[name][25_000:50_000]]) for name in clean.channels
    ]
    found = identify(Record(*both, RATE))
    assert "begins anew at 10 s" in found.message.replace("9.999", "10") and right(found) and wrong(found) < 1.5


def test_samples_lost_from_one_channel_are_named(clean):
    mass = np.delete(clean.mass, np.arange(1000, FORCE.size, 4000))
    n = mass.size
    found = identify(Record(clean.force[:n], clean.shaker[:n], mass, RATE))
    assert found.status == Status.DOUBTFUL or (right(found) and "clock of mass" in found.message)


def test_outliers_are_named_and_left_out(clean):
    mass = clean.mass.copy()
    mass[[700, 20_000, 40_000]] += np.array([5, -8, 20]) * mass.std()
    found = identify(clean.replace(mass=mass))
    assert "3 of mass, the first at 0.35 s" in found.message and right(found, 1e-3)


@pytest.mark.parametrize(
    ("term", "size", "words"),
    [
        (Term("k5", (0, 1), Power(5)), 3e15, "a quintic spring between shaker and mass"),
        (Term("k2", (0, 1), Power(2)), 5e4, "a quadratic spring between shaker and mass"),
        (Term("mu", (0, 1), Friction(1e-3), "velocity"), 1e-4, "dry friction between shaker and mass"),
        (Term("k3m", (1,), Power(3)), 1.4e8, "a cubic spring from the mass to the ground"),
        (Term("k3s", (0,), Power(3)), 2e11, "a cubic spring from the shaker to the ground"),
    ],
)
def test_a_missing_term_is_named_and_then_found(term, size, words):
    record = Record(FORCE, *moved(terms=[term], sizes=[size]), RATE)
    found = identify(record)
    assert found.status == Status.DOUBTFUL and words in found.message
    with_it = identify(record, terms=(term,))
    assert with_it.errors.names[7] == term.name
    assert with_it.errors.value[7] == pytest.approx(size, rel=0.01) and right(with_it, 0.01)


def test_three_terms_at_once_are_recovered_and_a_fourth_is_not_there():
    terms = (
        Term("k5", (0, 1), Power(5)),
        Term("mu", (0, 1), Friction(1e-3), "velocity"),
        Term("c3", (0,), Power(3), "velocity"),
    )
    sizes = (3e15, 3e-5, 300.0)
    asked = (*terms, Term("k3m", (1,), Power(3)))
    found = identify(noisy(Record(FORCE, *moved(terms=terms, sizes=sizes), RATE), 1e-4), terms=asked)
    np.testing.assert_allclose(found.errors.value[7:10], sizes, rtol=0.01)
    assert abs(found.errors.value[10]) < 2 * found.errors.half_width[10]


def test_a_stop_is_no_cubic():
    stop = Term("stop", (0, 1), Gap(1e-4))
    rig = Structure(("ms", "m"), (*LINEAR, stop), ((0, "displacement"), (1, "displacement")), (1.0, 0.0))
    values, reach = np.array([P.ms, P.m, P.ks, P.cs, P.c, P.k1, 200.0]), np.full(5, 1e-3)
    outputs = simulate(rig, values, Run(FORCE, RATE, "zero"), np.zeros((1, 4)), reach, finer=4)[0].T
    assert identify(Record(FORCE, *outputs, RATE)).status == Status.DOUBTFUL


@pytest.mark.parametrize("hertz", [0.05, 0.5])
def test_an_ac_coupled_force_is_named(clean, hertz):
    coupled = signal.sosfilt(signal.butter(1, hertz, "high", fs=RATE, output="sos"), clean.force)
    found = identify(clean.replace(force=coupled))
    assert wrong(found) < 1.5 or (found.status == Status.DOUBTFUL and "AC coupled" in found.message)


def test_a_force_that_leaks_into_a_sensor_is_named(clean):
    found = identify(clean.replace(shaker=clean.shaker + 4e-7 * clean.force))
    assert "the force leaks into shaker (4e-07 m/N)" in found.message and wrong(found) < 1.5


def test_a_force_that_was_read_before_its_filter_may_be_of_any_size():
    passed = signal.sosfilt(signal.butter(2, 400.0, fs=RATE, output="sos"), FORCE)
    found = identify(Record(FORCE, *moved(1.5 * passed), RATE))
    assert found.status == Status.DOUBTFUL and "before its amplifier or filter" in found.message


def test_the_sensitivity_of_one_sensor_is_noticed_against_the_other(clean):
    found = identify(clean.replace(mass=1.03 * clean.mass))
    assert "the sensitivity of mass is 3" in found.message and "larger" in found.message


def test_a_clipped_sensor_is_named(clean):
    most = 2 * clean.mass.std()
    found = identify(clean.replace(mass=np.clip(clean.mass, -most, most)))
    assert found.status == Status.DOUBTFUL and "it is clipped" in found.message


def test_samples_of_a_slower_recorder_are_named(clean):
    held = {name: np.repeat(getattr(clean, name)[::4], 4) for name in ("shaker", "mass")}
    found = identify(clean.replace(**held))
    assert "was sampled 4 times slower" in found.message


def test_one_line_of_force_is_too_little():
    force = 1.5 * np.sin(2 * np.pi * 20 * np.arange(40_000) / RATE)
    found = identify(Record(force, *moved(force), RATE))
    assert found.status == Status.DOUBTFUL and "too few to tell the parameters apart" in found.message


def test_little_motion_does_not_determine_the_cubic():
    weak = FORCE * 0.01
    found = identify(noisy(Record(weak, *moved(weak), RATE), 1e-3))
    assert "not determined by this record" in found.message and "k3" in found.message


def test_noise_on_the_force_widens_the_intervals(clean):
    disturbed = clean.force + 0.03 * clean.force.std() * np.random.default_rng(7).normal(size=clean.force.size)
    found = identify(clean.replace(force=disturbed))
    assert wrong(found) < 1.5


def test_a_band_without_a_resonance_is_told():
    record = cubic_record(duration=20, noise=0.01)
    found = identify(record, band=(100, 300))
    assert found.status == Status.DOUBTFUL and "no resonance lies in the band" in found.message


def test_a_negative_stiffness_is_doubted():
    force = 3 * FORCE
    rig = Structure(("ms", "m"), (*LINEAR, CUBIC), ((0, "displacement"), (1, "displacement")), (1.0, 0.0))
    values, reach = np.array([P.ms, P.m, P.ks, P.cs, P.c, -20.0, P.k3]), np.full(5, 2e-3)
    outputs = simulate(rig, values, Run(force, RATE, "zero"), np.zeros((1, 4)), reach, finer=4)[0].T
    assert identify(Record(force, *outputs, RATE)).status == Status.DOUBTFUL


def test_drift_and_hum_are_noticed_and_move_nothing(clean):
    time, size = clean.time, clean.shaker.std()
    hum = 0.01 * size * np.sin(2 * np.pi * 50.0 * time)
    found = identify(noisy(clean.replace(shaker=clean.shaker + hum)))
    assert found.status == Status.IDENTIFIED and "noticed: shaker holds hum of" in found.message
    assert "at 50 Hz" in found.message and wrong(found) < 1.5
    slow = 0.05 * clean.mass.std() * np.sin(2 * np.pi * 0.07 * time)
    found = identify(noisy(clean.replace(mass=clean.mass + slow)))
    assert "noticed: mass drifts, by" in found.message and wrong(found) < 1.5
    tone = 0.02 * size * np.cos(2 * np.pi * 33.3 * time)
    assert "shaker holds a tone of" in identify(noisy(clean.replace(shaker=clean.shaker + tone))).message


def test_lines_of_the_force_are_no_tones_of_the_sensors():
    n = FORCE.size
    lines = np.zeros(n // 2 + 1, dtype=complex)
    bright = np.arange(30, 2400, 30)
    lines[bright] = np.exp(2j * np.pi * np.random.default_rng(4).uniform(size=bright.size))
    force = np.fft.irfft(lines, n)
    force *= 1.115 / force.std()
    rubbed = Term("mu", (0, 1), Friction(0.01), "velocity", "N")
    found = identify(Record(force, *moved(force, terms=(rubbed,), sizes=(3e-5,)), RATE))
    assert "holds" not in found.message


def test_millimetres_for_metres_get_a_word(clean):
    found = identify(clean.replace(shaker=1e3 * clean.shaker, mass=1e3 * clean.mass))
    assert found.status == Status.DOUBTFUL and "times gravity" in found.message and "unit" in found.message


def test_peaks_that_a_sensor_bends_are_no_outliers(clean):
    end = 2.5 * clean.mass.std()
    bent = clean.mass - 0.05 * np.sign(clean.mass) * np.maximum(np.abs(clean.mass) - end, 0.0)
    found = identify(noisy(clean.replace(mass=bent), 1e-4))
    assert not any(trouble.name in ("spikes", "break") for trouble in found.mended)
    assert wrong(found) < 2 or found.status == Status.DOUBTFUL
