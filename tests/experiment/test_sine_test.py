"""Sine tests: amplitude and phase against the linear theory, one rig a point, and the same bits however it is run."""

from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

from rigsim.experiment.sine_test import SineTest, sine_test
from rigsim.model.excitation import Tap
from rigsim.model.oscillator import matrices
from rigsim.parameters import RigParameters
from rigsim.results import Status

RIG = RigParameters()
FORCE = 3.18
# The same k1 from long, soft wires: k3 falls by four orders of magnitude, and without gravity the rig is linear.
LINEAR = RIG.replace(k=RIG.k1 / 4, d0=RIG.d / 2, gravity=0, c=0.1)
ARRAYS = ("shaker", "mass", "relative", "tilt", "distortion", "subharmonic", "drift", "status", "time", "traces")


def assert_same(one, two, points=slice(None)):
    for name in ARRAYS:
        part = slice(None) if name == "time" else points
        np.testing.assert_array_equal(getattr(one, name)[part], getattr(two, name), err_msg=name)


@pytest.fixture(scope="module")
def branches():
    """50 Hz from rest and after a tap: low and high branch."""
    return sine_test(RIG, FORCE, 50.0, tap=[None, Tap()])


def test_a_linear_rig_has_the_receptance_of_the_theory():
    frequency = np.array([2.0, 5.0, 11.7, 20.0, 33.3, 55.65, 80.0])
    test = sine_test(LINEAR, 0.05, frequency, duration=4)
    assert list(test.status) == [Status.SETTLED] * 7
    mass, damping, stiffness = matrices(LINEAR)
    for i, omega in enumerate(2 * np.pi * frequency):
        expected = np.linalg.solve(stiffness + 1j * omega * damping - omega**2 * mass, [0.05, 0])
        found = np.array([test.shaker[i], test.mass[i]])
        assert (abs(found - expected) < 1e-3 * abs(expected)).all()  # complex: the phase against cos is held too
        assert test.relative[i] == pytest.approx(found[0] - found[1], rel=1e-9)
    assert (test.tilt < 1e-12).all()


def test_below_resonance_the_rig_follows_the_force_and_above_it_opposes():
    test = sine_test(LINEAR.replace(cs=0.1), 0.05, [2.0, 150.0], duration=8)
    assert abs(np.angle(test.shaker[0])) < 0.05
    assert abs(np.angle(-test.shaker[1])) < 0.05


def test_a_tap_across_a_block_s_border_is_whole():
    """A linear rig answers a later tap as it does an earlier one, later: blocks end every 0.125 s."""
    taps = [None, Tap(time=0.94), Tap(time=0.999), Tap(time=0.9985, duration=0.002)]
    test = sine_test(LINEAR, 0.05, 20.0, tap=taps, duration=1.5)
    answer = test.traces[:, 1] - test.traces[0, 1]
    begin = np.array([np.searchsorted(test.time, tap.time - 1e-9) for tap in taps[1:]])
    first, *others = (answer[i + 1, at : at + 400] for i, at in enumerate(begin))
    assert abs(first).max() > 1e-4
    for other in others:
        np.testing.assert_allclose(other, first, atol=1e-3 * abs(first).max())


def test_a_tap_reaches_the_high_branch(branches):
    assert list(branches.status) == [Status.SETTLED] * 2
    low, high = abs(branches.relative)
    assert high > 2 * low
    assert branches.message[0].startswith("z drifts by")


def test_the_record_of_a_point_is_its_window(branches):
    record = branches.record(1)
    np.testing.assert_array_equal([record.shaker, record.mass, record.tilt], branches.traces[1])
    assert record.sample_rate == pytest.approx(4000)
    assert record.hold == "band-limited" and record.parameters == RIG
    t = branches.time
    assert t[-1] == branches.duration == pytest.approx(3.0) and t[-1] - t[0] == pytest.approx(1.0)
    np.testing.assert_allclose(record.force, FORCE * np.cos(2 * np.pi * 50 * t), atol=1e-9)
    # The lines are those of the trace: a projection over the 50 whole periods.
    U = 2 * np.mean(record.relative[1:] * np.exp(-2j * np.pi * 50 * t[1:]))
    assert pytest.approx(branches.relative[1], rel=1e-6) == U
    assert branches.tilt[1] == abs(record.tilt).max()
    for i in (-1, 2, 0.5):
        with pytest.raises(ValueError, match="i = "):
            branches.record(i)


def test_summary_and_table(branches):
    assert branches.summary() == repr(branches) == "SineTest of 2 rigs, 50 Hz, 3.18 N: 2 settled"
    table = branches.table()
    assert len(table) == 2
    np.testing.assert_array_equal(table["tap [m/s]"], [np.nan, 0.5])
    np.testing.assert_allclose(table["|z| [mm]"], 1e3 * abs(branches.relative))
    assert list(table["status"]) == [Status.SETTLED, Status.SETTLED]
    assert "<table" in branches._repr_html_()


def test_a_tap_may_come_at_any_instant_of_the_test():
    taps = [Tap(time=0.0), Tap(time=1.0 - 2e-3)]
    test = sine_test(LINEAR, 0.05, 20.0, tap=taps, duration=1)
    assert abs(test.traces[1, 1, -1] - test.traces[0, 1, -1]) > 1e-4 and test.tap == tuple(taps)
    with pytest.raises(ValueError, match="tap time = 0.9981 s"):
        sine_test(LINEAR, 0.05, 20.0, tap=Tap(time=0.9981), duration=1)


def test_parameters_force_frequency_and_tap_broadcast():
    rigs, taps = [RIG, RIG.single_set()], [None, Tap(time=0.1)]
    together = sine_test(rigs, [1.0, 2.0], [20.0, 30.0], taps, duration=1)
    assert isinstance(together, SineTest)
    assert together.parameters == tuple(rigs) and together.tap == tuple(taps)
    for i in range(2):
        alone = sine_test(rigs[i], 1.0 + i, 20.0 + 10 * i, taps[i], duration=1)
        assert_same(together, alone, slice(i, i + 1))
    one_force = sine_test(RIG, 1.0, [20.0, 30.0, 40.0], duration=1)
    assert one_force.force.tolist() == [1.0] * 3 and one_force.tap == (None,) * 3


@pytest.fixture(scope="module")
def campaign():
    """300 rigs, nine chunks."""
    rng = np.random.default_rng(4)
    settings = {
        "parameters": [RIG if i % 3 else RIG.replace(m=0.004 + 1e-5 * i) for i in range(300)],
        "force": rng.uniform(0.5, 5, 300),
        "frequency": rng.uniform(10, 80, 300),
        "tap": [Tap(time=0.1) if i % 2 else None for i in range(300)],
        "duration": 1,
        "step": 1e-4,
    }
    return settings, sine_test(**settings)


def some(settings, points):
    return {name: [values[i] for i in points] if np.iterable(values) else values for name, values in settings.items()}


def test_a_point_of_a_campaign_is_the_point_alone(campaign):
    settings, whole = campaign
    points = [0, 32, 33, 149, 299]
    for i in points:
        assert_same(whole, sine_test(**some(settings, [i])), slice(i, i + 1))
    assert_same(whole, sine_test(**some(settings, points)), points)


def test_one_thread_or_many_and_a_checkpoint_give_the_same_bits(campaign, tmp_path):
    settings, whole = campaign
    seen = []
    with ThreadPoolExecutor(1) as executor:
        run = sine_test(**settings, executor=executor, checkpoint=tmp_path / "a", progress=lambda *n: seen.append(n))
    assert_same(whole, run)
    assert seen[-1] == (9, 9)
    again = sine_test(**settings, checkpoint=tmp_path / "a", progress=lambda *n: seen.append(n))
    assert_same(whole, again)
    assert seen[-1] == (9, 9) and (0, 9) not in seen[seen.index((9, 9)) + 1 :]  # nothing was run again
    with pytest.raises(ValueError):
        sine_test(**settings | {"duration": 1.1}, checkpoint=tmp_path / "a")


@pytest.mark.full
def test_processes_give_the_same_bits(campaign):
    settings, whole = campaign
    with ProcessPoolExecutor(2) as executor:
        assert_same(whole, sine_test(**settings, executor=executor))


def test_a_rig_that_flies_apart_says_so_and_leaves_its_neighbours_alone():
    test = sine_test(RIG, [FORCE, 1e9, FORCE], [20.0, 20.0, 60.0], duration=1)
    assert test.status[1] == Status.FLEW_APART and "t = " in test.message[1]
    assert np.isnan(test.relative[1]) and np.isnan(test.distortion[1]).all()
    assert "1 flew apart" in test.summary()
    pair = sine_test(RIG, FORCE, [20.0, 60.0], duration=1)
    assert_same(test, pair, [0, 2])
    test.record(1)  # what it did until then can be looked at


def test_one_set_that_tilts_past_its_wires_reach_says_so():
    heavy = RIG.single_set().replace(m=0.5, k=200.0)
    test = sine_test([RIG.single_set(), heavy], 0.1, 20.0, duration=1)
    assert test.status[1] == Status.FLEW_APART != test.status[0]
    assert "wires' reach" in test.message[1]


def test_a_short_test_is_not_settled():
    assert sine_test(RIG, FORCE, 20.0, duration=1).status[0] == Status.STILL_DRIFTING


@pytest.mark.parametrize("step", [5e-5, 7e-5, 1.3e-5])
def test_the_window_holds_the_last_second_at_any_step(step):
    test = sine_test(RIG, FORCE, [2.0, 100.0], duration=1.0, step=step)
    assert 1 <= test.time[-1] - test.time[0] < 1 + 2.5e-4 + step
    assert test.time[0] >= 0 and 1 <= test.time[-1] < 1 + 2.5e-4 + step
    assert np.isfinite(test.drift).all()


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"frequency": 0}, r"frequency\[0\] = 0 Hz is not allowed; expected a number from 2 to 500 Hz"),
        ({"frequency": [20.0, np.nan]}, r"frequency\[1\] = nan Hz"),
        ({"frequency": 600}, r"frequency\[0\] = 600 Hz"),
        ({"force": -1}, r"force\[0\] = -1 N"),
        ({"force": []}, "force has 0 elements"),
        (
            {"step": 1e-3, "frequency": 40},
            r"step = 0.001 s is unstable; expected above 0 and below 2/omega = 0.000178 s",
        ),
        ({"step": 0}, "step = 0 s"),
        ({"duration": 0.5}, "duration = 0.5 s .*of at least 1 s"),
        ({"start": "still"}, "start = 'still'"),
        ({"tap": 0.5}, "tap = 0.5 is not allowed; expected a Tap or None"),
        ({"tap": [None, "hard"]}, "tap = 'hard'"),
        ({"tap": Tap(duration=1e-6)}, "tap duration = 1e-06 s is not allowed; expected .* 0.0002 s"),
        ({"tap": Tap(time=5.0)}, "tap time = 5 s is not allowed; expected a number from 0 to 2.998 s"),
        ({"parameters": RIG.oscillator}, "the multi-body rig expects RigParameters"),
        ({"parameters": []}, "parameters has 0 elements"),
        ({"force": [1.0, 2.0], "frequency": [20.0, 30.0, 40.0]}, "force has 2 elements; expected 1 or 3"),
        ({"parameters": []}, "parameters has 0 elements; expected 1$"),
        ({"parameters": RIG.single_set().replace(m=500), "start": "equilibrium"}, "past its wires' reach"),
    ],
)
def test_bad_input_is_named(changes, named):
    with pytest.raises(ValueError, match=named):
        sine_test(**{"parameters": RIG, "force": FORCE, "frequency": 20.0} | changes)


def test_a_fast_neighbour_changes_no_bit():
    """300 Hz is sampled five times as often as 30 Hz: what is read, and recorded, at 30 Hz is what it is alone."""
    together = sine_test(RIG, FORCE, [30.0, 300.0], duration=1)
    for i, f in enumerate((30.0, 300.0)):
        alone = sine_test(RIG, FORCE, f, duration=1)
        for name in ARRAYS[:-2]:
            np.testing.assert_array_equal(getattr(together, name)[i], getattr(alone, name)[0], err_msg=name)
        one, other = together.record(i), alone.record(0)
        assert one.sample_rate == other.sample_rate and one.force.size == other.force.size
        for name, channel in one.channels.items():
            np.testing.assert_array_equal(channel, getattr(other, name), err_msg=name)
