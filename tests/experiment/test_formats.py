"""Files as other people's programs write them: read as what they mean, or refused with the place and what to say."""

import os
import resource
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

from rigsim.experiment import formats
from rigsim.experiment.formats.units import bare, plain, role_of, unit_of
from rigsim.experiment.reading import GuessWarning
from rigsim.experiment.record import Record
from tests.experiment import other_files
from tests.experiment.other_files import RATE, SAMPLES, rows

TRUE = other_files.channels()
F, S, M = TRUE.values()
T = np.arange(SAMPLES) / RATE
TIMED = [T, F, S, M]
NAMES = "time,force,shaker,mass\n"
HEAD = '# {"sample_rate": 2000, "hold": "zero"}\n'


def written(path, content):
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def read(path, content=None, **options):
    """The record, and what was told of guesses."""
    if content is not None:
        written(path, content)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        record = Record.load(path, **{"hold": "zero"} | options)
    assert all(one.category is GuessWarning and one.filename == __file__ for one in told) and len(told) <= 1
    text = "".join(str(one.message) for one in told)
    assert "\n" not in text
    return record, text


def same(record, rtol=1e-6, rate=RATE):
    assert record.sample_rate == pytest.approx(rate, rel=1e-9)
    for name, values in TRUE.items():
        np.testing.assert_allclose(getattr(record, name), values, rtol=rtol, atol=1e-12)


def refused(path, content, message, **options):
    """One line with the file's name."""
    with pytest.raises(ValueError, match=message) as caught:
        read(path, content, **options)
    assert "\n" not in str(caught.value) and path.name in str(caught.value)


# Text


def stamped(form, start="2026-03-02 10:00:00.5", separator=",", decimal="."):
    import pandas as pd

    stamps = pd.date_range(start, periods=SAMPLES, freq="500us").strftime(form)
    lines = rows(separator, decimal, [F, S, M]).splitlines()
    return "".join(f"{stamp}{separator}{line}\n" for stamp, line in zip(stamps, lines, strict=True))


def quoted(text):
    return "".join('"' + line.replace(",", '","') + '"\n' for line in text.splitlines())


MM = [T, F, 1e3 * S, 1e3 * M]
LVM = (
    "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t,\nX_Columns\tOne\nDate\t2026/03/02\n"
    "***End_of_Header***\t\n\t\nChannels\t3\t\t\t\nSamples\t150\t150\t150\t\nY_Unit_Label\tN\tmm\tmm\t\n"
    "X_Dimension\tTime\tTime\tTime\t\nX0\t0,0E+0\t0,0E+0\t0,0E+0\t\nDelta_X\t0,0005\t0,0005\t0,0005\t\n"
    "***End_of_Header***\t\t\t\t\nX_Value\tForce\tShaker\tMass\tComment\n"
)
MULTI = LVM.replace("Label\tN\tmm\tmm", "Label\tN\t\tmm\t\tmm").replace(
    "\tShaker\tMass", "\tX_Value\tShaker\tX_Value\tMass"
)
TEXTS = {
    "LabVIEW": LVM + rows("\t", ",", MM),
    "LabVIEW without time": LVM + "\t" + rows("\t", ",", MM[1:]).replace("\n", "\n\t")[:-1],
    "LabVIEW, a time for each": MULTI + rows("\t", ",", [T, F, T, 1e3 * S, T, 1e3 * M]),
    "names in the first line": NAMES + rows(columns=TIMED),
    "catman": "HBM catman\nSample rate:\t2000 Hz\n\nTime\tForce\tShaker\tMass\ns\tN\tmm\tmm\n" + rows("\t", ",", MM),
    "catman's own time": "Zeit  1 - Messrate [s]\tKraft [N]\tShaker [mm]\tMass [mm]\n" + rows("\t", ",", MM),
    "labels before names": "Title;run\nChannel;1;2;3;4\nName;Time;Force;Shaker;Mass\nUnit;s;N;mm;mm\n"
    + rows(";", ",", MM),
    "units in brackets below": "Time\tForce\tShaker\tMass\n[ s ]\t[ N ]\t[ mm ]\t[ mm ]\n" + rows("\t", ".", MM),
    "an oscilloscope": "Model,MSO54\nSample Interval,5e-4\nRecord Length,150\n\n" + NAMES.upper() + rows(columns=TIMED),
    "pandas": "," + NAMES + "".join(f"{i},{line}\n" for i, line in enumerate(rows(columns=TIMED).splitlines())),
    "R": NAMES.replace(",", " ")
    + "".join(f'"{i}" {line}\n' for i, line in enumerate(rows(" ", columns=TIMED).splitlines(), 1)),
    "quoted": quoted(NAMES + rows(columns=TIMED)),
    "quoted, with decimal commas": quoted(NAMES) + "".join(
        ",".join(f'"{cell}"' for cell in line.split(";")) + "\n" for line in rows(";", ",", TIMED).splitlines()),
    "columns of blanks": "   Time (s)   Force (N)  Shaker (mm)    Mass (mm)\n" + rows("   ", columns=MM),
    "NumPy": "# time force shaker mass\n" + rows(" ", columns=TIMED),
    "bars": NAMES.replace(",", "|") + rows("|", columns=TIMED),
    "a spreadsheet's hint": "sep=;\n" + NAMES.replace(",", ";") + rows(";", ",", TIMED),
    "blank rows at the end": NAMES.replace(",", ";") + rows(";", ",", TIMED) + ";;;\n;;;\n\n",
    "trailing separators": NAMES[:-1] + ",\n" + rows(columns=TIMED, end=",\n"),
    "carriage returns": (NAMES + rows(columns=TIMED)).replace("\n", "\r"),
    "Fortran": NAMES + rows(columns=TIMED, form="%.12e").replace("e", "D"),
    "UTF-16": (NAMES + rows(columns=TIMED)).encode("utf-16"),
    "UTF-16 without a mark": (NAMES + rows(columns=TIMED)).encode("utf-16-le"),
    "a byte order mark": (NAMES + rows(columns=TIMED)).encode("utf-8-sig"),
    "Latin": ("time;Kraft [N];Shaker [\xb5m];Mass [\xb5m]\nGer\xe4t: M\xfcller\n"
              + rows(";", ",", [T, F, 1e6 * S, 1e6 * M])).encode("latin-1"),
    "milliseconds": "Time [ms],force,shaker,mass\n" + rows(columns=[1e3 * T, F, S, M]),
    "units behind names": "time_ms,force [kN],shaker in \xb5m,mass_um\n"
    + rows(columns=[1e3 * T, F / 1e3, 1e6 * S, 1e6 * M]),
    "inches and pounds": "time,Force (lbf),Shaker (in),Mass (mil)\n"
    + rows(columns=[T, F / 4.4482216152605, S / 0.0254, M / 25.4e-6], form="%.12g"),
    "dates": "timestamp,force,shaker,mass\n" + stamped("%Y-%m-%dT%H:%M:%S.%fZ"),
    "German dates": "Zeit;force;shaker;mass\n" + stamped("%d.%m.%Y %H:%M:%S,%f", separator=";", decimal=","),
    "American dates": NAMES + stamped("%m/%d/%Y %I:%M:%S.%f %p"),
    "times of day, over midnight": NAMES + stamped("%H:%M:%S.%f", "2026-03-02 23:59:59.98"),
    "a column of dates, one of times": "Date,Time,force,shaker,mass\n" + stamped("%Y-%m-%d,%H:%M:%S.%f"),
    "a rate in words, no time": "Sampling frequency = 2 kHz\nforce,shaker,mass\n" + rows(),
    "an interval in words, no time": "dt: 0.5 ms\nforce,shaker,mass\n" + rows(),
    "other channels": "force,volt,shaker,mass,remark\n" + rows(columns=[F, F, S, M]).replace("\n", ",\n"),
}  # fmt: skip


@pytest.mark.parametrize("case", TEXTS)
def test_text_is_read_as_people_mean_it(tmp_path, case):
    rate = {"sample_rate": 2000} if case == "other channels" else {}
    record, told = read(tmp_path / "mine.csv", TEXTS[case], **rate)
    same(record)
    assert set(record.kinds.values()) == {"displacement"}
    assert case.startswith("other") <= ("without 'volt', 'remark'" in told)


def test_what_is_guessed_is_told_and_what_is_said_is_not(tmp_path):
    path = tmp_path / "mine.csv"
    told = read(path, NAMES.replace(",", ";") + rows(";", ",", TIMED))[1]
    for words in ("semicolons between cells and decimal commas", "force in N, shaker in m, mass in m", "guessed"):
        assert words in told
    assert read(path, HEAD + "force,shaker,mass\n" + rows(), hold=None)[1] == ""
    assert read(path, HEAD + "force,shaker,mass\nN,mm,mm\n" + rows(columns=[F, 1e3 * S, 1e3 * M]))[1] == ""
    lost = "# buffer overrun, 250 samples lost\n" + NAMES + rows(columns=TIMED)
    assert "250 samples lost' stands above the samples" in read(path, lost)[1]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (rows(), r"no channel force by that name; it holds 0: unnamed, 1: unnamed, 2: unnamed; expected channels="),
        ("time,a,b\n" + rows(columns=[T, F, S]), "holds 0: 'time', 1: 'a', 2: 'b'; expected channels="),
        (NAMES + rows(columns=[T, F, np.where(T == T[70], np.nan, S), M]), r"line 72, column 3 \('shaker'\): 'nan'"),
        (NAMES + "0,OVLD,OVLD,1\n" + rows(columns=TIMED), r"line 2, column 2 \('force'\): 'OVLD'"),
        (NAMES + rows(columns=TIMED) + "1,,3,4\n", r"line 152, column 2 \('force'\): .* the cell is blank"),
        (NAMES + "0,1,2,3\n1,2,3,4\n# 250 samples lost\n" + rows(columns=TIMED), "line 4, 1 columns; .*250 samples"),
        (NAMES + rows(columns=TIMED) + "0.1,0.2,0.3\n" + rows(columns=TIMED), "line 152, 3 columns; expected 4"),
        (NAMES + rows(columns=TIMED) + NAMES, r"line 152, column 1 \('time'\): 'time' is not a number"),
        (NAMES + rows(columns=TIMED) + ",,,\n" + rows(columns=TIMED), "line 152, all cells are blank"),
        ("Sample rate: 1000 Hz\n" + NAMES + rows(columns=TIMED), "1000 Hz is not allowed; its time gives 2000 Hz"),
        ("fs: 1000\ndt: 0.0005 s\n" + NAMES + rows(columns=TIMED), "says two sample rates, 1000 and 2000 Hz"),
        ("Number of samples: 151\n" + NAMES + rows(columns=TIMED), "150 samples; expected 151, as the file"),
        ("time,Force [N],force,Force,mass\n" + rows(columns=[*TIMED, M]), "no channel shaker"),
        ("time,Force [N],Force (N),shaker,mass\n" + rows(columns=[T, F, F, S, M]), "names the channel force 2 times"),
        ("time,force [V],shaker,mass\n" + rows(columns=TIMED), r"unit of force in .* = 'V' .*expected N.*units=\{"),
        ("time,force,shaker,mass [kg]\n" + rows(columns=TIMED), "unit of mass in .* = 'kg'"),
        ("time,force,acc_shaker [mm],mass\n" + rows(columns=TIMED), r"unit of shaker in .* = 'mm' .* expected m/s\^2"),
        ("time,force,shaker [mm],mass\ns,N,m,m\n" + rows(columns=TIMED), "'m', but the name 'shaker .mm.' says 'mm'"),
        (NAMES + rows(columns=[1e3 * T, F, S, M]), "gives 2 Hz if it is in s, 2000 Hz if it is in ms; expected units="),
        (NAMES + rows(columns=[np.floor(1e3 * T) / 1e3, F, S, M]), "rounded to 0.001 s, .* expected sample_rate="),
        (NAMES + rows(columns=[T + (T > T[70]), F, S, M]), "as if 2000 samples were lost; line 73, column 1"),
        (NAMES + rows(columns=[np.insert(T, 50, T[50])[:-1], F, S, M]), "an instant that stands twice; line 53"),
        ("force,shaker,mass\n" + rows(), "has no sample rate; expected sample_rate=, a column time"),
        (b"PK\x03\x04 what a spreadsheet saves", "it is a zip archive such as .xlsx or .npz"),
    ],
    ids=lambda value: repr(value)[-40:],
)  # fmt: skip
def test_text_that_cannot_be_trusted_is_refused_with_its_place(tmp_path, content, message):
    refused(tmp_path / "mine.csv", content, message)


def test_without_a_hold_it_is_asked_for(tmp_path):
    refused(tmp_path / "mine.csv", NAMES + rows(columns=TIMED), "expected hold in its first line or", hold=None)


def test_a_reader_says_which_column_is_which_and_in_what_unit(tmp_path):
    path = written(tmp_path / "mine.txt", "t0,Ch1 [N],Ch2,Ch3 (V)\n" + rows(columns=[1e3 * T, F, 1e3 * S, M]))
    options = {"channels": {"force": "Ch1 [N]", "shaker": "ch2", "mass": 3, "time": 0}, "units": {"shaker": "mm"}}
    options["units"] |= {"mass": "m", "time": "ms"}
    record, told = read(path, **options)
    same(record)
    assert told.count(";") == 0, "what was said is not told again"
    one = read(path, channels={"force": 1, "shaker": "Ch2"}, sample_rate=2000, units={"shaker": "g"})[0]
    assert one.mass is None and one.kinds == {"shaker": "acceleration"}
    np.testing.assert_allclose(one.shaker, 1e3 * 9.80665 * S)
    for changes, message in (
        (
            {"channels": {"force": "Ch9"}},
            r"channels\['force'\] = 'Ch9' is not in .*; expected one of 't0', 'Ch1 \[N\]'",
        ),
        ({"channels": {"force": 4}}, "expected a column of .* from 0 to 3"),
        ({"channels": {"force": 1, "shaker": 1}, "sample_rate": 1}, "column 'Ch1 .N.' as (force|shaker) and"),
        ({"channels": {"power": 1}}, "channel of channels = 'power'"),
        ({"channels": {"force": 1.0}}, r'channels\["force"\] = 1.0'),
        ({"channels": "Ch1"}, "channels = 'Ch1' is not allowed; expected a dict"),
        ({"units": {"mass": 3}}, r'units\["mass"\] = 3 is not allowed; expected a text'),
        (options | {"units": {"force": "kN", "mass": "m"}}, "'N', but units= says 'kN'"),
        (options | {"sample_rate": 2002}, "its time gives 2000 Hz"),
        ({"sample_rate": 0}, "sample_rate = 0 Hz"),
    ):
        with pytest.raises(ValueError, match=message):
            read(path, **changes)


def test_accelerations_and_velocities_are_told_by_unit_or_name(tmp_path):
    text = "time (s),Force (N),Acc Shaker (g),Mass velocity [mm/s]\n" + rows(columns=[T, F, S / 9.80665, 1e3 * M])
    record, told = read(tmp_path / "mine.csv", text)
    same(record)
    assert record.kinds == {"shaker": "acceleration", "mass": "velocity"}
    assert "shaker as acceleration, by its unit g" in told
    assert read(tmp_path / "mine.csv", NAMES.replace("mass", "acc_mass") + rows(columns=TIMED))[0].kinds["mass"] == (
        "acceleration"
    )


@pytest.mark.parametrize("size", [400, 40_000])
def test_rounded_instants_give_the_rate_within_a_ten_thousandth(tmp_path, size):
    path, k = tmp_path / "mine.csv", np.arange(size)
    for rate, time in (
        (80.0, np.round(k / 80, 3)), (2000.0, (1000 + k / 2000).astype("f4").astype(float)),
        (1024.0, np.round(k / 1024, 4)), (51.2e3, np.round(k / 51.2e3, 6)),
    ):  # fmt: skip
        text = NAMES + rows(columns=[time, *np.ones((3, size))], form="%.12g")
        assert read(path, text)[0].sample_rate == pytest.approx(rate, rel=1e-4)
    coarse = np.round(k / 2000, 3)
    assert read(path, NAMES + rows(columns=[coarse, *np.ones((3, size))]), sample_rate=2000)[0].sample_rate == 2000
    jump = coarse + 0.004 * (k > size // 2)
    refused(path, NAMES + rows(columns=[jump, *np.ones((3, size))]), "not evenly spaced", sample_rate=2000)


def test_few_digits_that_leave_the_rate_open_are_refused(tmp_path):
    time = np.arange(20) / 2000 + 1e-4 * (-1.0) ** np.arange(20)
    refused(
        tmp_path / "mine.csv",
        NAMES + rows(columns=[time, *np.ones((3, 20))]),
        "only within .* %; expected sample_rate=",
    )


def resaved(lines, separator, decimal):
    """What a spreadsheet makes of lines: cells, written back, padded to as many in each row, quoted where needed."""
    import csv
    import io

    table = [line.split(",") for line in lines]
    width = max(map(len, table))
    out = io.StringIO()
    body = [[cell.replace(".", decimal) for cell in row] if i else row for i, row in enumerate(table)]
    csv.writer(out, delimiter=separator).writerows(row + [""] * (width - len(row)) for row in body)
    return out.getvalue()


@pytest.mark.parametrize(("separator", "decimal"), [(",", "."), (";", ","), (";", "."), ("\t", ",")])
def test_a_saved_record_is_read_after_a_spreadsheet_saved_it(tmp_path, separator, decimal):
    from rigsim.parameters import RigParameters

    path = tmp_path / "mine.csv"
    record = Record(F, S, M, 2000.0, seed=3, parameters=RigParameters(k=[1e4, 2e4] * 4))
    record.save(path)
    text = resaved(path.read_text().splitlines(), separator, decimal)
    again = read(path, text, hold=None)[0]
    assert again.seed == 3 and again.parameters == record.parameters
    for name in ("force", "shaker", "mass"):
        np.testing.assert_array_equal(getattr(again, name), getattr(record, name))
    refused(path, "".join(text.splitlines(keepends=True)[:-1]), "149 samples; expected 150", hold=None)


def test_a_compressed_record_comes_back_bit_for_bit(tmp_path):
    path = tmp_path / "mine.csv.gz"
    record = Record(F, S, M, 2000.0)
    record.save(path)
    same(Record.load(path), rtol=0)
    whole = path.read_bytes()
    record.save(path)
    assert path.read_bytes() == whole, "no clock stands in it"
    for cut in (whole[: len(whole) // 2], whole[:-4], b"\x1f\x8b"):
        refused(path, cut, "cannot be read as a record")
    import gzip

    refused(path, gzip.compress(b"0,0,0\n" * 3_000_000), "holds much more text than its size|no channel force")


# Binary files


OTHERS = [kind for kind in other_files.MADE if kind not in ("table", "zipped")]


@pytest.mark.parametrize("kind", OTHERS)
def test_binary_files_of_other_programs_are_read(tmp_path, kind):
    if other_files.NEEDS[kind]:
        pytest.importorskip(other_files.NEEDS[kind])
    from tests.experiment.hostile_files import KINDS

    path = tmp_path / f"mine{KINDS[kind]}"
    for content in other_files.MADE[kind](path):
        record, told = read(path, content)
        same(record)
        assert ("force in N" in told) == (kind in ("matlab", "npz")), "the others say their units"
        listed = Record.inspect(path)
        assert "3 columns" in listed.summary() and sorted(listed.table()["read as"]) == ["force", "mass", "shaker"]
        assert set(listed.table()["samples"]) == {SAMPLES}


def test_matrices_are_columns_and_strangers_are_left_out(tmp_path):
    path, matrix = tmp_path / "mine.npz", np.column_stack([F, S, M])
    for shape in (matrix, matrix.T):
        np.savez(path, data=shape, fs=2000.0, label="a")
        assert list(Record.inspect(path).table().name) == ["data.0", "data.1", "data.2"]
        same(read(path, channels={"force": "data.0", "shaker": 1, "mass": 2})[0])
    np.savez(path, force=F, shaker=S, mass=M[:-1], fs=2000.0)
    refused(path, None, "mass in .* has 149 samples; expected 150")
    np.savez(path, force=F, shaker=S, mass=np.where(F > 1, np.nan, M), fs=2000.0)
    refused(path, None, r"mass\[\d+\] = nan m is not allowed; .*sample \d+ of 'mass'")
    np.savez(path, force=F, shaker=S, mass=np.array([{}], dtype=object), fs=2000.0)
    refused(path, None, "variable 'mass': Object arrays cannot be loaded")
    np.savez(path, force=np.fft.fft(F), shaker=S, mass=M, fs=2000.0)
    refused(path, None, "'force' holds no real numbers")
    dates = np.datetime64("2026-03-02") + (T * 1e9).astype("timedelta64[ns]")
    np.savez(path, force=F, shaker=S, mass=M, time=dates)
    same(read(path)[0])
    np.savez(path, force=F, shaker=S, mass=M)
    refused(path, None, "has no sample rate; expected sample_rate=")
    same(read(path, sample_rate=2000)[0])


def test_channels_that_disagree_about_their_rate_are_refused(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    path = tmp_path / "mine.tdms"
    for rates, samples, message in (
        ((2000, 2000, 500), SAMPLES, "sample_rate of .* = (500|2000) Hz, but the interval"),
        ((2000, 2000, 2000), 100, "mass in .* has 100 samples; expected 150"),
    ):
        channels = [
            other_files.tdms_channel(
                nptdms.ChannelObject, name, values[: samples if name == "mass" else SAMPLES], rate=rate
            )
            for (name, values), rate in zip(TRUE.items(), rates, strict=True)
        ]
        with nptdms.TdmsWriter(str(path)) as writer:
            writer.write_segment(channels)
        refused(path, None, message)


def test_universal_files_say_units_kinds_and_what_is_no_time_history(tmp_path):
    pyuff = pytest.importorskip("pyuff")
    path = tmp_path / "mine.uff"
    for changes, message in (
        ({}, None), ({"func_type": 4, "data": np.fft.fft(M)}, "no function of time"), ({"unit": "g"}, None),
        ({"unit": "V"}, "unit of mass in .* = 'V'"),
    ):  # fmt: skip
        path.unlink(missing_ok=True)
        made = pyuff.UFF(str(path))
        for name, values in TRUE.items():
            extra = changes if name == "mass" else {}
            made.write_sets(other_files.uff_set(name, values, **extra), "add")
        if message:
            refused(path, None, message)
        else:
            wanted = "acceleration" if changes else "displacement"
            assert read(path)[0].kinds == {"shaker": "displacement", "mass": wanted}


def test_other_people_s_netcdf_is_read(tmp_path):
    xr = pytest.importorskip("xarray")
    path = tmp_path / "mine.nc"
    units = {"force": "N", "shaker": "mm", "mass": "mm"}
    scaled = {"force": F, "shaker": 1e3 * S, "mass": 1e3 * M}
    data = xr.Dataset(
        {name: ("time", values, {"units": units[name]}) for name, values in scaled.items()},
        coords={"time": ("time", 1e3 * T, {"units": "milliseconds"})},
    )
    for options in ({"engine": "h5netcdf"}, {"engine": "scipy", "format": "NETCDF3_CLASSIC"}):
        data.to_netcdf(path, **options)
        same(read(path)[0])
    data.isel(time=np.r_[0:50, 80:150]).to_netcdf(path, engine="h5netcdf")
    refused(path, None, "as if 30 samples were lost; sample 50 of 'time'")


def test_a_missing_package_is_one_line_with_the_command(tmp_path, monkeypatch):
    monkeypatch.setattr(formats.importlib.util, "find_spec", lambda name: None)
    path = written(tmp_path / "mine.uff", "    -1\n    58\n")
    with pytest.raises(ModuleNotFoundError, match=r"pyuff is not installed.*pip install 'rigsim\[formats\]'"):
        Record.load(path, hold="zero")
    refused(tmp_path / "mine.tdms", b"something else", "it does not begin as TDMS does")


def test_what_is_no_record_s_file_is_told_what_can_be_read(tmp_path):
    for name in ("mine.xlsx", "mine", "mine.dxd"):
        refused(tmp_path / name, b"x", "suffix of .*expected one of '.csv'.*'.mat'.*'.tdms'")


# Inspection, units, saving


def test_inspection_lists_what_a_file_holds(tmp_path):
    path = written(tmp_path / "mine.csv", "Sample rate: 2000\nTime [s];Force [kN];Ch2;Mass\n" + rows(";", ",", TIMED))
    listed = Record.inspect(path)
    table = listed.table()
    assert list(table["read as"]) == ["time", "force", "-", "mass"] and list(table.unit) == ["s", "kN", "", ""]
    assert set(table.samples) == {SAMPLES} and "semicolons" in listed.summary() and "sample_rate 2000.0" in repr(listed)
    assert table["first values"][0] == "0, 0,0005, 0,001" and "<table" in listed._repr_html_()
    with pytest.raises(ValueError, match="suffix"):
        Record.inspect(tmp_path / "none.xlsx")


@pytest.mark.parametrize(
    ("text", "quantity", "factor"),
    [
        ("N", "force", 1), ("kN", "force", 1e3), ("Newton", "force", 1), ("lbf", "force", 4.4482216152605),
        ("lb", "force", 4.4482216152605), ("mm", "displacement", 1e-3), ("MM", "displacement", 1e-3),
        ("\xb5m", "displacement", 1e-6),
        ("\u03bcm", "displacement", 1e-6), ("um", "displacement", 1e-6), ("inch", "displacement", 0.0254),
        ("m/s", "velocity", 1), ("mm/s", "velocity", 1e-3), ("m s-1", "velocity", 1), ("in/s", "velocity", 0.0254),
        ("m/s2", "acceleration", 1), ("m/s^2", "acceleration", 1), ("m/s\xb2", "acceleration", 1), ("m/s**2",
        "acceleration", 1), ("m s-2", "acceleration", 1), ("m\xb7s\u207b\xb2", "acceleration", 1), ("(m/s^2)",
        "acceleration", 1),
        ("m/sec^2", "acceleration", 1), ("g", "acceleration", 9.80665), ("gn", "acceleration",
        9.80665), ("mm/s^2", "acceleration", 1e-3), ("ms", "time", 1e-3), ("sec", "time", 1), ("\xb5s", "time", 1e-6),
        ("seconds since 2026-03-02", "time", 1), ("deg", "angle", np.pi / 180), ("mN", "force", 1e-3),
        ("MN", "force", 1e6),
    ],
)  # fmt: skip
def test_units_as_people_write_them(text, quantity, factor):
    assert unit_of(text) == (quantity, pytest.approx(factor, rel=1e-12))


def test_what_is_no_unit_of_a_record_is_none():
    assert not any(map(unit_of, ("V", "counts", "", "Pa", "mn", "kg", "furlong", "m/s3", "1")))


@pytest.mark.parametrize(
    ("name", "role", "kind", "unit"),
    [
        ("force", "force", "", ""), ("Force [N]", "force", "", "N"), ("FORCE (kN)", "force", "", "kN"),
        ("shaker_mm", "shaker", "", "mm"), ("acc_mass / g", "mass", "acceleration", "g"), ("MassDisplacement", "mass",
        "displacement", ""), ("run/Force [N]", "force", "", "N"), ("X_Value", "time", "", ""), ("Time (ms)", "time", "",
        "ms"), ("force 2", "", "", ""), ("force, shaker tip", "", "", ""), ("Ch1 [N]", "", "", "N"),
        ("mass ratio", "", "", ""), ("data.0", "", "", ""), ("", "", "", ""), ("airmass", "", "", ""),
    ],
)  # fmt: skip
def test_names_that_can_mean_one_thing_only(name, role, kind, unit):
    assert role_of(plain(name)) == (role, kind) and bare(name)[1] == unit


@pytest.mark.skipif(os.name != "posix", reason="needs hard links")
def test_every_name_of_a_file_gets_the_record_that_is_saved(tmp_path):
    one, two = tmp_path / "one.csv", tmp_path / "two.csv"
    Record(F, S, M, 1000.0).save(one)
    one.chmod(0o640)
    os.link(one, two)
    Record(F[:20], S[:20], M[:20], 2000.0).save(two)
    assert one.samefile(two) and Record.load(one).force.size == 20 and one.stat().st_mode & 0o777 == 0o640
    assert sorted(os.listdir(tmp_path)) == ["one.csv", "two.csv"]


@pytest.mark.parametrize("suffix", [".csv", ".nc", ".csv.gz"])
def test_a_cut_file_is_known_in_every_format(tmp_path, suffix):
    path = tmp_path / f"mine{suffix}"
    Record(F, S, M, 2000.0).save(path)
    whole = path.read_bytes()
    for size in (len(whole) // 2, len(whole) - 20, len(whole) - 1):
        path.write_bytes(whole[:size])
        with pytest.raises(ValueError, match=path.name):
            Record.load(path)


_MEMORY = """
import resource, sys, warnings
warnings.simplefilter("ignore")
from rigsim import Record
Record
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
record = Record.load(sys.argv[1], hold="zero")
print(record.force.size, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="measures memory in kilobytes")
@pytest.mark.parametrize("suffix", [".csv", ".nc", ".npz"])
def test_a_long_record_takes_little_more_memory_than_its_arrays(tmp_path, suffix):
    path, n = tmp_path / f"mine{suffix}", 1_000_000
    channels = dict(zip(TRUE, np.random.default_rng(1).normal(size=(3, n)), strict=True))
    if suffix == ".npz":
        np.savez(path, fs=2000.0, **channels)
    elif suffix == ".nc":
        Record(**channels, sample_rate=2000.0).save(path)
    else:
        written(
            path, HEAD + "force,shaker,mass\n" + "".join(rows(columns=[one[:1000] for one in channels.values()]) * 1000)
        )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-c", _MEMORY, str(path)]
    root = Path(__file__).parents[2]
    done = subprocess.run(command, env=environment, cwd=root, capture_output=True, text=True, check=True)
    size, kilobytes = map(int, done.stdout.split())
    assert size == n and kilobytes < 3 * 8 * n / 1e3 + 60_000, "three arrays, one of instants and a piece"
    assert resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss > 0
