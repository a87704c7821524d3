"""Several tests as one record: joined, taken apart, saved, realigned; and the acceleration of a base for a force."""

import numpy as np
import pytest

from rigsim.experiment.reading import GuessWarning
from rigsim.experiment.record import Record

RNG = np.random.default_rng(1)


def test_of(n, **options):
    channels = RNG.normal(size=(3, n))
    return Record(*channels, 100.0, hold="linear", **options)


test_of.__test__ = False


def test_tests_are_joined_and_taken_apart():
    one, two, three = (test_of(n) for n in (10, 20, 30))
    both = Record.joined([Record.joined([one, two]), three])
    assert both.joints == (0, 10, 30) and "in 3 tests" in both.summary()
    for before, after in zip((one, two, three), both.tests, strict=True):
        for name, channel in before.channels.items():
            np.testing.assert_array_equal(getattr(after, name), channel)
        assert after.joints == (0,)
    assert Record.joined(one) is one


@pytest.mark.parametrize("suffix", [".csv", ".nc"])
def test_a_file_keeps_where_tests_begin_and_what_the_input_is(tmp_path, suffix):
    record = Record.joined([test_of(10, base=True), test_of(12, base=True)])
    record.save(tmp_path / f"tests{suffix}")
    again = Record.load(tmp_path / f"tests{suffix}")
    assert again.joints == (0, 10) and again.base and again.units["force"] == "m/s^2"
    np.testing.assert_array_equal(again.force, record.force)


def test_a_force_in_metres_per_second_squared_is_the_acceleration_of_a_base(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("time [s],base [g],top [m]\n" + "".join(f"{k / 100},{k % 3},{k % 5}\n" for k in range(40)))
    with pytest.warns(GuessWarning, match="acceleration of a base"):
        record = Record.load(path, "linear", channels={"force": "base [g]", "shaker": "top [m]"})
    assert record.base and record.mass is None
    assert record.force[1] == pytest.approx(9.80665)


def test_each_test_is_realigned_by_itself():
    one, two = test_of(50), test_of(60)
    both = Record.joined([one, two]).realigned(delay={"mass": 0.02})
    assert both.joints == (0, 48) and both.force.size == 106
    alone = [test.realigned(delay={"mass": 0.02}).mass for test in (one, two)]
    np.testing.assert_allclose(both.mass, np.concatenate(alone), atol=1e-12)


@pytest.mark.parametrize(
    ("tests", "message"),
    [
        ([], "expected a Record or several"),
        ([test_of(10), test_of(10, kinds={"mass": "velocity"})], "kinds of the records"),
        ([test_of(10), test_of(10, base=True)], "base of the records = False and True"),
        (["x"], "expected a Record"),
    ],
)
def test_what_cannot_be_joined(tests, message):
    with pytest.raises(ValueError, match=message):
        Record.joined(tests)


@pytest.mark.parametrize("joints", [(1,), (0, 1), (0, 9), (), (0, 5, 4)])
def test_joints_are_first_samples(joints):
    with pytest.raises(ValueError, match="joints"):
        test_of(10, joints=joints)
