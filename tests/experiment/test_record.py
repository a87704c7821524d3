"""`Record`: checks at construction, and files that give back the same bits."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rigsim.experiment.record import Record
from rigsim.parameters import OscillatorParameters, RigParameters

HEADER = '# {"sample_rate": 5, "hold": "zero", "parameters": %s}\n'
ROWS = "force,shaker,mass\n1,2,3\n4,5,6\n"


def small(**changes):
    rng = np.random.default_rng(1)
    force, shaker, mass, tilt = rng.normal(size=(4, 50)) * [[1.0], [1e-4], [1e-4], [1e-6]]
    options = {"force": force, "shaker": shaker, "mass": mass, "sample_rate": 2000, "tilt": tilt} | changes
    return Record(**options)


def test_channels_time_and_summary():
    record = small()
    assert record.duration == 0.025
    np.testing.assert_array_equal(record.time, np.arange(50) / 2000)
    np.testing.assert_array_equal(record.relative, record.shaker - record.mass)
    assert "50 samples" in record.summary() and "\n" not in record.summary()
    assert list(record.table().index) == ["force", "shaker", "mass", "tilt", "relative"]


def test_a_record_is_frozen_and_keeps_its_own_copy():
    force = np.ones(50)
    record = small(force=force)
    force[0] = 7
    assert record.force[0] == 1
    with pytest.raises(ValueError, match="read-only"):
        record.force[0] = 2
    with pytest.raises(AttributeError):
        record.sample_rate = 1.0


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"mass": np.r_[np.zeros(17), np.nan, np.zeros(32)]}, r"mass\[17\] = nan m"),
        ({"shaker": np.zeros(49)}, "shaker has 49 samples; expected 50"),
        ({"tilt": np.zeros(51)}, "tilt has 51 samples"),
        ({"force": [1.0]}, "force has 1 elements; expected at least 2"),
        ({"force": np.zeros((5, 10))}, "force has 2 dimensions"),
        ({"sample_rate": 0}, "sample_rate = 0 Hz"),
        ({"sample_rate": -1}, "sample_rate = -1 Hz"),
        ({"hold": "cubic"}, "hold = 'cubic'"),
        ({"start": "somewhere"}, "start = 'somewhere'"),
        ({"seed": -3}, "seed = -3"),
        ({"step": 0.0}, "step = 0 s"),
        ({"parameters": 3}, "parameters = 3"),
    ],
)
def test_bad_input_is_named(changes, message):
    with pytest.raises(ValueError, match=message):
        small(**changes)


@pytest.mark.parametrize("suffix", [".csv", ".nc"])
@pytest.mark.parametrize(
    "details",
    [
        {},
        {"tilt": None, "hold": "band-limited"},
        {"seed": 2014, "start": "rest", "step": 5e-5, "parameters": RigParameters(k=[1e4, 2e4] * 4)},
        {"parameters": OscillatorParameters(0.154, 1.88e4, 9.86, 0.0052, 0.026, 28.235, 1.38e8), "hold": "linear"},
    ],
)
def test_files_give_back_every_bit(tmp_path, suffix, details):
    record = small(**details)
    path = tmp_path / f"record{suffix}"
    record.save(str(path))
    again = Record.load(str(path))
    assert again.channels.keys() == record.channels.keys()
    for name, values in record.channels.items():
        np.testing.assert_array_equal(getattr(again, name), values)
    for name in ("sample_rate", "hold", "seed", "start", "parameters", "step"):
        assert getattr(again, name) == getattr(record, name)
    assert os.listdir(tmp_path) == [path.name]


@given(arrays(float, (3, 4), elements=st.floats(allow_nan=False, allow_infinity=False)))
def test_any_finite_numbers_survive_a_csv(tmp_path_factory, values):
    path = tmp_path_factory.mktemp("csv") / "record.csv"
    Record(*values, sample_rate=0.1).save(path)
    again = Record.load(path)
    np.testing.assert_array_equal([again.force, again.shaker, again.mass], values)


def test_a_user_can_write_the_least_csv(tmp_path):
    path = tmp_path / "mine.csv"
    path.write_text('# {"sample_rate": 500, "hold": "linear"}\nmass, force, shaker\n1,2,3\n4,5,6\n')
    record = Record.load(path)
    assert record.sample_rate == 500 and record.hold == "linear"
    np.testing.assert_array_equal(record.force, [2, 5])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("mass,force,shaker\n1,2,3\n", "has no sample rate; expected sample_rate="),
        ('# {"sample_rate": 5}\nforce,shaker\n1,2\n3,4\n', "no channel mass"),
        ('# {"hold": "zero"}\nforce,shaker,mass\n1,2,3\n4,5,6\n', "no sample rate"),
        ('# {"sample_rate": 5, "colour": 1}\nforce,shaker,mass\n1,2,3\n4,5,6\n', "colour"),
        (
            '# {"sample_rate": 5, "hold": "zero"}\nforce,shaker,mass\n1,2,3\n4,nan,6\n',
            r"line 4, column 2 \('shaker'\): 'nan' is not a number",
        ),
        ('# {"sample_rate": 5}\nforce,shaker,mass\n1,2,3\n4,six,6\n', "cannot be read as a record"),
        ('# {"sample_rate": 5}\nforce,shaker,mass\n1,2,3,4\n', "as many columns"),
        (
            '# {"sample_rate": 5}\nforce,shaker,mass\n1,2,3\n4,5,6\n',
            "hold in its first line or as an argument, one of 'zero'",
        ),
        ('# {"sample_rate": 5}\nforce,force,shaker,mass\n1,2,3,4\n4,5,6,7\n', "names the channel force 2 times"),
        ("# []\nforce,shaker,mass\n1,2,3\n", "has no sample rate"),
        (HEADER % "[1, 2]" + ROWS, r"parameters in .* = \[1, 2\] is not allowed"),
        (HEADER % '{"kind": "RigParameters", "colour": 1}' + ROWS, "parameter in .* = 'colour'"),
        (HEADER % '{"kind": "OscillatorParameters", "ms": 1, "ks": 1}' + ROWS, "lack cs, m, c, k1, k3"),
        (HEADER % '{"kind": ["os"]}' + ROWS, "kind of parameters"),
        ('# {"hold": "zero"}\ntime,force,shaker,mass\n0,1,2,3\n1,4,5,6\n3,4,5,6\n4,1,1,1\n', "not evenly spaced"),
        ('# {"hold": "zero"}\ntime,force,shaker,mass\n0,1,2,3\n0,4,5,6\n', "not evenly spaced"),
        ('# {"hold": "zero", "sample_rate": 5}\ntime,force,shaker,mass\n0,1,2,3\n1,4,5,6\n', "its time gives 1 Hz"),
        (
            '# {"sample_rate": 5, "hold": "zero", "parameters": {"kind": "os"}}\nforce,shaker,mass\n1,2,3\n4,5,6\n',
            "'os'",
        ),
    ],
)
def test_bad_files_are_named(tmp_path, text, message):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(ValueError, match=message):
        Record.load(path)


def test_a_spreadsheet_s_csv_with_time_is_read(tmp_path):
    path = tmp_path / "mine.csv"
    text = '# {"hold": "zero"}\r\n"time", "force","shaker","mass"\r\n0,1,2,3\r\n0.002,4,5,6\r\n0.004,7,8,9\r\n'
    path.write_bytes(text.encode("utf-8-sig"))
    record = Record.load(path)
    assert record.sample_rate == pytest.approx(500)
    np.testing.assert_array_equal(record.mass, [3, 6, 9])


def test_the_hold_may_be_told_at_loading_but_not_twice(tmp_path):
    path = tmp_path / "mine.csv"
    path.write_text('# {"sample_rate": 5}\n' + ROWS)
    assert Record.load(path, hold="band-limited").hold == "band-limited"
    with pytest.raises(ValueError, match="hold = 'cubic'"):
        Record.load(path, hold="cubic")
    small(hold="linear").save(path)
    assert Record.load(path, hold="linear").hold == "linear"
    with pytest.raises(ValueError, match="says 'linear'"):
        Record.load(path, hold="zero")


def with_times(path, time, said=""):
    """A file with a column of instants (s), and with a sample rate if one is said."""
    path.write_text(f'# {{"hold": "zero"{said}}}\ntime,force,shaker,mass\n')
    with path.open("a") as file:
        np.savetxt(file, np.column_stack([time, np.ones((len(time), 3))]), delimiter=",", fmt="%.12g")
    return path


EVEN = np.arange(2000) / 2000


@pytest.mark.parametrize(
    ("time", "allowed"),
    [
        (EVEN, True),
        (EVEN + 7.0, True),
        (EVEN + 0.20 / 2000 * (-1.0) ** np.arange(2000), True),  # written with few digits: steps of 0.6 and 1.4
        (EVEN + 0.24 / 2000 * (-1.0) ** np.arange(2000), False),
        (np.delete(EVEN, 120), False),  # a lost sample
        (EVEN + 0.8 / 2000 * np.sin(np.pi * np.arange(2000) / 1999), True),  # a clock that gains less than a sample
        (EVEN + 1.2 / 2000 * np.sin(np.pi * np.arange(2000) / 1999), False),  # or more, though no step shows it
        (EVEN - 1.2 / 2000 * np.sin(np.pi * np.arange(2000) / 1999), False),
        (EVEN[::-1], False),
        (0 * EVEN, False),
    ],
)
def test_a_time_column_may_be_rounded_but_neither_jumps_nor_drifts(tmp_path, time, allowed):
    path = with_times(tmp_path / "mine.csv", time)
    if allowed:
        assert Record.load(path).sample_rate == pytest.approx(2000, rel=0.003)
    else:
        with pytest.raises(ValueError, match="not evenly spaced; expected rising steps"):
            Record.load(path)


def test_a_sample_rate_that_is_said_must_be_that_of_the_time_to_a_thousandth(tmp_path):
    assert Record.load(with_times(tmp_path / "near.csv", EVEN, ', "sample_rate": 2001.6')).sample_rate == 2001.6
    for said in (2002.4, 1997.6):
        with pytest.raises(ValueError, match="its time gives 2000 Hz"):
            Record.load(with_times(tmp_path / "far.csv", EVEN, f', "sample_rate": {said}'))


def test_a_broken_netcdf_is_named(tmp_path):
    path = tmp_path / "broken.nc"
    path.write_bytes(b"no netCDF at all")
    with pytest.raises(ValueError, match="broken.nc cannot be read as a record") as caught:
        Record.load(path)
    assert "\n" not in str(caught.value)
    with pytest.raises(FileNotFoundError):
        Record.load(tmp_path / "none.nc")


def test_unknown_suffix(tmp_path):
    with pytest.raises(ValueError, match="suffix of record.pkl"):
        small().save(tmp_path / "record.pkl")
    with pytest.raises(ValueError, match="suffix"):
        Record.load(tmp_path / "record.npy")


@pytest.mark.parametrize("suffix", [".csv", ".nc"])
def test_a_failed_write_leaves_the_old_file(tmp_path, monkeypatch, suffix):
    path = tmp_path / f"record{suffix}"
    small().save(path)
    before = path.read_bytes()

    def broken(self, *args, **options):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "a name that nobody gave")

    monkeypatch.setattr(os, "replace", broken)
    with pytest.raises(OSError, match=rf"the record cannot be written: No space left on device: '{path}'"):
        small(sample_rate=1).save(path)
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == [path.name]


_FULL_DISK = """
import resource, signal, sys
import numpy as np
from rigsim import Record
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
try:
    Record(*np.ones((3, 5000)), 2000.0).save(sys.argv[1])
except OSError as error:
    print(error)
"""


@pytest.mark.skipif(os.name != "posix", reason="limits the size of files")
@pytest.mark.parametrize("suffix", [".csv", ".nc"])
def test_a_full_disk_leaves_nothing(tmp_path, suffix):
    command = [sys.executable, "-c", _FULL_DISK, str(tmp_path / f"record{suffix}")]
    done = subprocess.run(command, capture_output=True, text=True, cwd=Path(__file__).parents[2])
    assert done.returncode == 0, done.stderr
    assert f"record{suffix}" in done.stdout and done.stdout.count("\n") == 1
    assert os.listdir(tmp_path) == []


def test_where_nothing_can_be_written_is_one_line(tmp_path):
    (tmp_path / "folder.csv").mkdir()
    for path, message in (
        (tmp_path / "folder.csv", "folder.csv cannot be replaced"),
        (tmp_path / "none" / "record.csv", r"the record cannot be written: No such file or directory: '.*none.*csv'"),
    ):
        with pytest.raises(OSError, match=message) as caught:
            small().save(path)
        assert "\n" not in str(caught.value)
    assert os.listdir(tmp_path) == ["folder.csv"]


@pytest.mark.skipif(os.name != "posix", reason="needs links and permissions")
def test_links_and_permissions_stay(tmp_path):
    target, link, long = tmp_path / "target.csv", tmp_path / "link.csv", tmp_path / f"{'a' * 246}.csv"
    link.symlink_to(target)
    small().save(link)
    target.chmod(0o640)
    small(seed=4).save(link)
    assert link.is_symlink() and Record.load(target).seed == 4 and target.stat().st_mode & 0o777 == 0o640
    small().save(long)
    assert sorted(os.listdir(tmp_path)) == sorted([target.name, link.name, long.name])
    os.mkfifo(tmp_path / "pipe.csv")
    with pytest.raises(OSError, match="pipe.csv cannot be replaced"):
        small().save(tmp_path / "pipe.csv")


@pytest.mark.parametrize("lines", [1, 7, 25])
def test_a_cut_csv_is_noticed(tmp_path, lines):
    path = tmp_path / "record.csv"
    small().save(path)
    whole = path.read_text()
    for cut in ("".join(whole.splitlines(keepends=True)[:-lines]), whole[: -1 - lines], whole[:-1]):
        path.write_text(cut)
        with pytest.raises(ValueError, match="expected 50, as the file|cut off|columns|cannot be read as a record"):
            Record.load(path)


def test_spectrum_gives_lines_their_heights():
    time = np.arange(4001) / 4000
    for f in (30.0, 17.0):
        signal = 3 + 2 * np.cos(2 * np.pi * f * time + 1) + 0.5 * np.sin(2 * np.pi * f / 3 * time)
        frequency, amplitude = Record(signal, signal, 0 * signal, 4000.0).spectrum("relative", f)
        for line, height in ((f, 2), (f / 3, 0.5)):
            nearest = abs(frequency - line).argmin()
            assert frequency[nearest] == pytest.approx(line, rel=1e-3)
            assert amplitude[nearest] == pytest.approx(height, rel=0.002)
        assert amplitude[abs(frequency - f / 2).argmin()] < 1e-3
        assert amplitude[0] < 1e-3, "the mean is no line"


@pytest.mark.parametrize(
    ("samples", "six", "taken"), [(200, 180.4, 6), (200, 200.4, 6), (200, 200.75, 5), (400, 200.2, 12), (400, 200.4, 6)]
)
def test_spectrum_takes_as_many_periods_as_a_record_holds_to_half_a_sample(samples, six, taken):
    """``six`` periods of the force last so many samples; lines are as far apart as the window ``taken`` is long."""
    signal = np.sin(2 * np.pi * 6 / six * np.arange(samples))
    frequency, _ = Record(signal, signal, 0 * signal, 1000.0).spectrum("relative", 6000 / six)
    assert frequency[1] == pytest.approx(1000 / round(taken * six / 6), rel=1e-12)


def test_strongest_line_of_a_channel():
    time = np.arange(2000) / 1000
    record = Record(time, 3 * np.cos(2 * np.pi * 20.3 * time), 2 * np.cos(2 * np.pi * 20.3 * time), 1000.0)
    assert record.strongest_line("relative", (5, 60)) == pytest.approx((20.3, 1.0), rel=1e-3)
    assert record.strongest_line("mass", (5, 60))[1] == pytest.approx(2.0, rel=1e-3)
    with pytest.raises(ValueError, match="channel = 'tilt'"):
        record.strongest_line("tilt", (5, 60))
    with pytest.raises(ValueError, match="frequency = 0.1 Hz"):
        record.spectrum("mass", 0.1)


@pytest.mark.parametrize("suffix", [".csv", ".nc"])
def test_outputs_may_be_of_any_kind_and_one_alone(tmp_path, suffix):
    one = small(mass=None, tilt=None)
    mixed = small(kinds={"shaker": "acceleration"})
    equal = small(kinds={"shaker": "velocity", "mass": "velocity"})
    assert one.kinds == {"shaker": "displacement"} and one.units == {"force": "N", "shaker": "m"}
    assert mixed.units["shaker"] == "m/s^2" and mixed.units["mass"] == "m"
    np.testing.assert_array_equal(equal.relative, equal.shaker - equal.mass)
    for number, record in enumerate((one, mixed, equal)):
        assert "\n" not in record.summary() and list(record.table().unit) and "z" not in record.channels
        record.save(path := tmp_path / f"{number}{suffix}")
        again = Record.load(path)
        assert again.kinds == record.kinds and again.channels.keys() == record.channels.keys()
        np.testing.assert_array_equal(again.shaker, record.shaker)
    for record in (one, mixed):
        assert "relative" not in record.table().index
        with pytest.raises(ValueError, match="z = xs - x is expected of two channels of one kind"):
            _ = record.relative
    assert mixed.realigned(swap=True).kinds == {"shaker": "displacement", "mass": "acceleration"}
    assert one.realigned(delay={"shaker": 1e-3}).mass is None
    for kinds, message in (
        ("acceleration", "kinds = 'acceleration' is not allowed"),
        ({"force": "velocity"}, "channel of kinds = 'force'"),
        ({"mass": "jerk"}, "kind of mass = 'jerk'"),
    ):
        with pytest.raises(ValueError, match=message):
            small(kinds=kinds)


def test_an_array_that_nobody_can_write_to_is_not_copied():
    force = np.ones(50)
    force.flags.writeable = False
    assert small(force=force).force is force
    assert small(force=force[:50]).force is not force, "it is a part of one that could be written to"
