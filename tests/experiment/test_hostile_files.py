"""Whatever a file is or does, reading it soon ends in a record or in one line that names it, and touches no other."""

import importlib.util
import json
import os
import resource
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest

from rigsim.experiment.formats import binary
from rigsim.experiment.record import Record
from tests.experiment import hostile_files, other_files

pytestmark = pytest.mark.skipif(os.name != "posix", reason="counts signals and limits memory")
ROOT = Path(__file__).parents[2]
SECRET = np.full(hostile_files.SAMPLES, 12345.0)


@pytest.fixture
def folder(tmp_path):
    """In memory where there is such a place: thousands of files are written, and synchronised."""
    if not os.access("/dev/shm", os.W_OK):
        yield tmp_path
        return
    made = Path("/dev/shm") / f"rigsim-{os.getpid()}-{tmp_path.name}"
    made.mkdir()
    yield made
    subprocess.run(["rm", "-rf", made], check=True)


def refused(path, message, limit=10):
    """Loading says one line with the file's name, and within the limit (s)."""
    begun = time.perf_counter()
    with pytest.raises((ValueError, OSError), match=message) as caught:
        Record.load(path)
    assert time.perf_counter() - begun < limit
    assert "\n" not in str(caught.value) and path.name in str(caught.value)


# CSV


HEAD, NAMES, ROWS = '# {"sample_rate": 5, "hold": "zero"}\n', "force,shaker,mass\n", "1,2,3\n4,5,6\n"
PLAIN = HEAD + NAMES + ROWS


def header(details):
    return f"# {details}\n{NAMES}{ROWS}"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no rows of numbers, as many in each, are found .it is empty."),
        ("\n" * 1000, "no rows of numbers"),
        (header("[" * 60000), "has no sample rate"),
        (header('{"a":' * 10000), "line 1 is nested too deeply"),
        (header("x" * 70000), "line 1, longer than 65536 characters"),
        (header('{"sample_rate": 5, "hold": "zero", "sample_rate": 6}'), "'sample_rate' stands there 2 times"),
        (header('{"sample_rate": NaN}'), "'NaN' is not allowed; expected a finite number"),
        (header('{"sample_rate": -Infinity}'), "'-Infinity' is not allowed"),
        (header('{"sample_rate": 1e400}'), "'1e400' is not allowed"),
        (header('{"sample_rate": %s}' % ("9" * 400)), "is not allowed; expected a finite number"),
        (header('{"sample_rate": %s}' % ("9" * 5000)), "is not allowed; expected a finite number"),
        (header('{"sample_rate": 5, }'), "line 1, character 2[02]: "),
        (header("7"), "has no sample rate"),
        (header("null"), "has no sample rate"),
        (header('{"sample_rate": "2000 Hz"}'), r"sample_rate in .* = '2000 Hz' is not allowed; expected a number"),
        (header('{"sample_rate": [2000]}'), r"sample_rate in .* = \[2000\]"),
        (header('{"sample_rate": true}'), r"sample_rate in .* = True"),
        (header('{"sample_rate": null}'), r"sample_rate in .* = None"),
        (header('{"sample_rate": 0, "hold": "zero"}'), "sample_rate in .* = 0 Hz"),
        (header('{"sample_rate": 5, "hold": 3}'), "hold in .* = 3 is not allowed; expected a text"),
        (header('{"sample_rate": 5, "hold": ["zero"]}'), "hold in "),
        (
            header('{"sample_rate": 5, "hold": "zero", "seed": {}}'),
            r"seed in .* = \{\} is not allowed; expected a number",
        ),
        (header('{"sample_rate": 5, "hold": "zero", "start": 1}'), "start in "),
        (header('{"sample_rate": 5, "hold": "zero", "step": "fine"}'), "step in "),
        (header('{"sample_rate": 5, "hold": "zero", "parameters": null}'), "expected an object"),
        (header('{"sample_rate": 5, "hold": "zero", "samples": 3}'), "force in .* has 2 samples; expected 3"),
        (header('{"sample_rate": 5, "hold": "zero", "samples": 2}')[:-1], "line 4, the file is cut off here"),
        (HEAD + NAMES, "no rows of numbers"),
        (HEAD + NAMES + "\n\n \n", "no rows of numbers"),
        (HEAD + "force\n1\n2\n", "has no channel shaker by that name; it holds 0: 'force'"),
        (
            HEAD + ",".join(f"c{index}" for index in range(3000)) + "\n" + "1," * 3000 + "\n",
            "3001 columns; expected at most 512",
        ),
        (HEAD + "force,shaker,ma\udcffss\n" + ROWS, "no channel mass by that name; it holds .*'ma\xffss'"),
        (HEAD + "force,shaker,mass\n1,2,3,4\n4,5,6,7\n", "line 3, 4 columns below 3 names; expected as many"),
        (PLAIN + "1_000,2,3\n", r"line 5, column 1 \('force'\): '1_000' is not a number"),
        (PLAIN + "1,0x1p3,3\n", r"line 5, column 2 \('shaker'\): '0x1p3'"),
        (PLAIN + "1,2,1.0D\n", r"line 5, column 3 \('mass'\): '1.0D'"),
        (PLAIN + "1+2j,2,3\n", r"line 5, column 1 .* '1\+2j'"),
        (PLAIN + "1,,3\n", r"line 5, column 2 .* ''"),
        (PLAIN + "1,OVLD,3\n", r"line 5, column 2 .* 'OVLD'"),
        (PLAIN + "\n\n1,True,3\n", r"line 7, column 2 .* 'True'"),
        (PLAIN + "1,\0,3\n", r"line 5, column 2 .* '\\x00'"),
        (PLAIN + "1,\udcff,3\n", r"line 5, column 2 .* '\xff'"),
        (PLAIN + "1,\u0664,3\n", r"line 5, column 2 "),
        (PLAIN + "1;2;3\n", "line 5, 1 columns; expected 3"),
        (PLAIN + "# 250 samples lost\n1,2,3\n", "line 5, 1 columns; expected 3"),
        (PLAIN + '1,"2,3\n', "line 5, a quote is not closed"),
        (PLAIN + "1," * 40000 + "\n", "line 5, longer than 65536 characters"),
        (PLAIN + "nan,2,3\n", r"line 5, column 1 \('force'\): 'nan' is not a number"),
        (PLAIN + "1,-inf,3\n", r"line 5, column 2 \('shaker'\): '-inf'"),
        (PLAIN + "1,2,1e400\n", r"line 5, column 3 \('mass'\): '1e400'"),
        ('# {"hold": "zero"}\ntime,' + NAMES + "-1e308,1,2,3\n1e308,1,2,3\n", "not evenly spaced"),
        ('# {"hold": "zero"}\ntime,' + NAMES + "0,1,2,3\n5e-324,1,2,3\n", "sample_rate = inf Hz"),
        (PLAIN.replace("zero", "zero\\ud800"), r"hold = 'zero\\ud800' is not allowed"),
    ],
    ids=lambda value: repr(value)[:40],
)
def test_text_that_is_no_record_is_told_with_its_place(tmp_path, text, message):
    path = tmp_path / "mine.csv"
    path.write_bytes(text.encode("utf-8", "surrogateescape"))
    with np.errstate(all="raise"):
        refused(path, message, 5)


@pytest.mark.parametrize("encoding", ["utf-16", "utf-32"])
def test_other_encodings_are_read(tmp_path, encoding):
    path = tmp_path / "mine.csv"
    path.write_bytes(PLAIN.encode(encoding))
    np.testing.assert_array_equal(Record.load(path).mass, [3, 6])
    path.write_bytes(PLAIN.encode(encoding)[:-1])
    refused(path, "truncated data")


@pytest.mark.parametrize("end", ["\r", "\r\n"])
def test_line_ends_of_other_systems_are_read(tmp_path, end):
    path = tmp_path / "mine.csv"
    path.write_bytes(PLAIN.replace("\n", end).encode())
    np.testing.assert_array_equal(Record.load(path).shaker, [2, 5])


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ('{"kind": "RigParameters", "k": {"a": 1}}', "parameters in .*: "),
        ('{"kind": "RigParameters", "ms": [1, 2]}', "parameters in .*: ms = "),
        ('{"kind": "RigParameters", "wire_sets": 1e300}', "parameters in .*: wire_sets"),
        ('{"kind": "RigParameters", "gravity": null}', "parameters in .*: gravity"),
        ('{"kind": "RigParameters", "ms": -1}', "parameters in .*: ms = -1"),
        ('{"kind": {}}', "kind of parameters in "),
        ('{"kind": "RigParameters", "": 1}', "parameter in .* = ''"),
    ],
)
def test_parameters_of_any_kind_are_told(tmp_path, parameters, message):
    path = tmp_path / "mine.csv"
    path.write_text(header(f'{{"sample_rate": 5, "hold": "zero", "parameters": {parameters}}}'))
    refused(path, message)


# netCDF


def replaced(name, make):
    """What puts something else in place of a channel."""

    def change(file):
        del file[name]
        make(file, name)

    return change


def external(file, name):
    where = Path(file.filename).parent / "secrets" / "raw"
    SECRET.tofile(where)
    file.create_dataset(name, shape=SECRET.shape, dtype="f8", external=[(str(where), 0, h5py.h5f.UNLIMITED)])


def virtual(file, name):
    where = Path(file.filename).parent / "secrets" / "other.h5"
    with h5py.File(where, "w") as other:
        other[name] = SECRET
    layout = h5py.VirtualLayout(SECRET.shape, "f8")
    layout[:] = h5py.VirtualSource(str(where), name, SECRET.shape)
    file.create_virtual_dataset(name, layout)


def outside(file, name):
    where = Path(file.filename).parent / "secrets" / "other.h5"
    with h5py.File(where, "w") as other:
        other[name] = SECRET
    file[name] = h5py.ExternalLink(str(where), f"/{name}")


def inside(file, name):
    file["elsewhere"] = SECRET
    file[name] = h5py.SoftLink("/elsewhere")


def dataset(**options):
    return lambda file, name: file.create_dataset(name, **options)


def bare(type_id, space=None):
    def make(file, name):
        h5py.h5d.create(file.id, name.encode(), type_id, space or h5py.h5s.create_simple((hostile_files.SAMPLES,)))

    return make


def deep(file, name):
    group = file.create_group(name)
    for _ in range(1500):
        group = group.create_group("g")


def late_chunks(file, name):
    file.create_dataset(name, shape=SECRET.shape, dtype="f8", chunks=(10,))[:20] = 1.0


def many(file):
    for index in range(600):
        file[f"v{index}"] = [1.0]


def attribute(name, value, owner="force", **options):
    return lambda file: (file if owner == "/" else file[owner]).attrs.create(name, value, **options)


DETAILS = '{"sample_rate": 2000.0, "hold": "zero"}'
HDF5 = {
    "a link to another file": (replaced("force", outside), "'force' is a link to another file"),
    "a soft link": (replaced("force", inside), "'force' is a soft link"),
    "external samples": (replaced("force", external), "'force' is external: its samples are in other files"),
    "virtual samples": (replaced("force", virtual), "'force' is virtual: its samples are in other files"),
    "a group": (replaced("force", lambda file, name: file.create_group(name)), "no channel force"),
    "deep groups": (replaced("force", deep), "no channel force"),
    "a named type": (replaced("force", lambda file, name: file.__setitem__(name, np.dtype("f8"))), "a group or a type"),
    "samples never written": (replaced("force", dataset(shape=(150,), dtype="f8")), "150 samples, which are not in"),
    "chunks never written": (replaced("force", late_chunks), "150 samples, which are not in the file"),
    "more than there is": (replaced("force", dataset(shape=(1 << 40,), dtype="f8")), "which are not in the file"),
    "chunks of more": (
        replaced("force", dataset(shape=(1 << 40,), dtype="f8", chunks=(1 << 26,))), "which are not in the file",
    ),
    "a bomb": (
        replaced("force", dataset(data=np.zeros(5_000_000), chunks=(5_000_000,), compression="gzip")),
        "declares|not in the file",
    ),
    "a bomb of many chunks": (
        replaced("force", dataset(data=np.zeros(5_000_000), chunks=(50_000,), compression="gzip")), "it declares 4000",
    ),
    "nothing": (replaced("force", dataset(shape=(0,), dtype="f8")), "has 150 samples; expected 0"),
    "three dimensions": (replaced("force", dataset(data=np.ones((150, 1, 2)))), "has not one dimension"),
    "a matrix": (replaced("force", dataset(data=np.ones((150, 2)))), "no channel force"),
    "a number": (replaced("force", dataset(data=1.0)), "no channel force"),
    "no space": (replaced("force", dataset(data=h5py.Empty("f8"))), "has not one dimension"),
    "records": (replaced("force", dataset(data=np.zeros(150, "f8,i4"))), "holds no real numbers"),
    "complex": (replaced("force", dataset(data=np.zeros(150, complex))), "holds no real numbers"),
    "text": (replaced("force", dataset(data=[b"a"] * 150)), "holds no real numbers"),
    "text of any length": (replaced("force", dataset(data=["a"] * 150, dtype=h5py.string_dtype())), "no real numbers"),
    "lists": (replaced("force", dataset(shape=(150,), dtype=h5py.vlen_dtype(float))), "holds no real numbers"),
    "references": (replaced("force", dataset(shape=(150,), dtype=h5py.ref_dtype)), "holds no real numbers"),
    "yes and no": (replaced("force", dataset(data=np.ones(150, bool))), "holds no real numbers"),
    "opaque": (replaced("force", bare(h5py.h5t.create(h5py.h5t.OPAQUE, 8))), "holds no real numbers"),
    "bits": (replaced("force", bare(h5py.h5t.STD_B64LE)), "holds no real numbers"),
    "long numbers": (replaced("force", dataset(data=np.ones(150, np.longdouble))), "of at most 8 bytes"),
    "fewer": (replaced("mass", dataset(data=np.ones(149))), "mass in .* has 149 samples; expected 150"),
    "too many": (many, "more than 512 variables"),
    "kilograms": (attribute("units", "kg", "mass"), "unit of mass in .* = 'kg' is not allowed; expected m, m/s"),
    "millimetres of force": (attribute("units", "mm"), "unit of force in .* = 'mm' is not allowed; expected N"),
    "a unit that is a number": (attribute("units", 3.0), "attribute units holds something else than a text"),
    "units": (attribute("units", ["N", "N"]), "attribute units holds something else than a text"),
    "a long unit": (attribute("units", np.bytes_(b"N" * 60000)), "unit of force in "),
    "no details": (lambda file: file.attrs.pop("rigsim_record"), "has no sample rate"),
    "details that are a number": (attribute("rigsim_record", 5, "/"), "attribute rigsim_record holds something else"),
    "details twice": (attribute("rigsim_record", [DETAILS] * 2, "/"), "attribute rigsim_record holds something else"),
    "deep details": (attribute("rigsim_record", "[" * 60000, "/"), "rigsim_record in .* is nested too deeply"),
    "long details": (attribute("rigsim_record", "[" * 70000, "/"), "longer than 65536 characters"),
    "other details": (attribute("rigsim_record", '{"sample_rate": "fast"}', "/"), "sample_rate in .* = 'fast'"),
    "a mask": (attribute("_FillValue", hostile_files.record().force[7]), r"force\[7\] = nan N"),
    "masks": (attribute("missing_value", hostile_files.record().force[[7, 9]]), r"force\[7\] = nan N"),
    "a range": (attribute("valid_range", [-1e-9, 1e9]), r"force\[\d\] = nan N"),
    "a least": (attribute("valid_min", 0.0), r"force\[\d\] = nan N"),
    "a mask that is text": (attribute("_FillValue", "none"), "attribute _FillValue holds something else than numbers"),
    "many masks": (attribute("missing_value", np.ones(5000)), "attribute missing_value holds something else"),
    "a scale of two": (attribute("scale_factor", [1.0, 2.0]), "attribute scale_factor holds something else"),
    "a scale without end": (attribute("scale_factor", np.inf), r"force\[0\] = -?inf N"),
    "no sign": (attribute("_Unsigned", "true"), "attribute _Unsigned|has the attribute _Unsigned"),
    "never written, as netCDF has it": (
        replaced("force", dataset(data=np.r_[np.zeros(149), 9.969209968386869e36])), r"force\[149\] = nan N",
    ),
    "uneven time": (lambda file: file.__setitem__("time", np.arange(150.0) ** 2), "time in .* is not evenly spaced"),
    "time of another rate": (lambda file: file.__setitem__("time", np.arange(150.0)), "its time gives 1 Hz"),
    "a time that is missing": (lambda file: file.__setitem__("time", np.full(150, np.nan)), r"time\[0\] = nan"),
}  # fmt: skip


@pytest.fixture
def secrets(tmp_path):
    """A folder that nobody may look into."""
    (tmp_path / "secrets").mkdir()
    return tmp_path / "secrets"


@pytest.mark.parametrize("case", HDF5)
def test_hdf5_that_is_no_record_is_refused_with_the_reason(tmp_path, secrets, case):
    change, message = HDF5[case]
    path = tmp_path / "mine.nc"
    hostile_files.hdf5(path, change)
    opened = hostile_files.Opened(secrets)
    refused(path, message)
    assert not opened.seen()


def test_a_watch_sees_what_is_opened(secrets):
    opened = hostile_files.Opened(secrets)
    (secrets / "a").write_text("x")
    if sys.platform == "linux":
        assert opened.seen()


def patched(path, old, new):
    content = path.read_bytes()
    assert old in content
    path.write_bytes(content.replace(old, new))


def test_a_filter_that_would_have_to_be_loaded_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "mine.nc"
    hostile_files.hdf5(path, chunks=(50,), compression="gzip")
    patched(path, b"\x01\x00\x08\x00\x01\x00\x01\x00deflate\0", b"\x0f\x7d\x08\x00\x01\x00\x01\x00deflate\0")
    monkeypatch.setenv("HDF5_PLUGIN_PATH", str(tmp_path))
    refused(path, "needs the filter of number 32015; expected one of deflate, shuffle, fletcher32, lzf")


@pytest.mark.parametrize("number", [65, 200])
def test_links_of_a_kind_of_one_s_own_are_refused(tmp_path, secrets, number):
    path = tmp_path / "mine.nc"
    hostile_files.hdf5(path, replaced("force", outside))
    patched(path, b"\x40\x05force", bytes([number]) + b"\x05force")
    refused(path, "'force' is a user-defined link; expected its samples here")


def test_what_xarray_and_others_write_is_read(tmp_path):
    path = tmp_path / "mine.nc"
    true = hostile_files.record()
    for options in (
        {},
        {"dtype": ">f4"},
        {"chunks": (7,), "compression": "gzip", "shuffle": True},
        {"maxshape": (None,)},
    ):
        for version in ("earliest", "latest"):
            hostile_files.hdf5(path, libver=version, **options)
            np.testing.assert_allclose(Record.load(path).mass, true.mass, rtol=1e-6)
    import xarray as xr

    true.save(path)
    with xr.open_dataset(path, engine="h5netcdf", decode_times=False) as opened:
        held = opened.load()
    packed = {"dtype": "i2", "scale_factor": 1e-4, "add_offset": 0.5, "_FillValue": -32768}
    held.to_netcdf(path, engine="h5netcdf", encoding={"mass": packed})
    np.testing.assert_allclose(Record.load(path).mass, true.mass, atol=1e-4)
    held.drop_vars("time").to_netcdf(path, engine="h5netcdf")  # a dimension without values
    np.testing.assert_array_equal(Record.load(path).mass, true.mass)


@pytest.mark.parametrize("ending", ["crash", "hang", "memory", "lie", "silence", "start"])
def test_whatever_ends_the_process_that_reads_is_one_line(tmp_path, monkeypatch, ending):
    """As a fault of libhdf5 would, which no check foresees."""
    column = 'json.dumps({"said": {}, "columns": [[name, %s, "", None, ""] for name in ("force", "shaker", "mass")]})'
    endings = {
        "crash": 'print("ready", flush=True); os.kill(os.getpid(), 11)',
        "hang": 'print("ready", flush=True); time.sleep(60)',
        "memory": 'print("ready", flush=True); print(json.dumps({"error": "MemoryError"}))',
        "lie": f'print("ready", flush=True); print({column % "1 << 40"})',
        "silence": f'print("ready", flush=True); print({column % 9})',
        "start": "sys.exit(3)",
    }
    program = tmp_path / "child.py"
    program.write_text(f"import json, os, sys, time\n{endings[ending]}\n")
    monkeypatch.setattr(binary, "PROGRAM", [sys.executable, str(program)])
    monkeypatch.setattr(binary, "seconds", lambda size, reader: 0.3)
    path = tmp_path / "mine.nc"
    path.write_bytes(b"\x89HDF\r\n\x1a\nanything")
    expected = {
        "crash": "ended early", "hang": "takes longer than", "memory": "MemoryError", "lie": "more than it can hold",
        "silence": "ended early", "start": "does not start",
    }  # fmt: skip
    refused(path, expected[ending], 5)


# Any reader


@pytest.mark.parametrize("suffix", [".csv", ".nc"])
@pytest.mark.parametrize("kind", ["folder", "pipe", "zeros", "socket", "nothing"])
def test_what_is_no_file_is_refused_at_once(tmp_path, suffix, kind):
    path = tmp_path / f"mine{suffix}"
    if kind == "folder":
        path.mkdir()
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind == "zeros":
        path.symlink_to("/dev/zero")
    elif kind == "socket":
        import socket

        with socket.socket(socket.AF_UNIX) as one:
            one.bind(str(path)[-100:] if len(str(path)) < 100 else pytest.skip("its name is too long"))
    refused(path, "mine", 2)


@pytest.mark.parametrize("suffix", [".csv", ".nc"])
def test_a_file_of_nothing_but_size_takes_no_memory(tmp_path, suffix):
    path = tmp_path / f"mine{suffix}"
    path.write_bytes(PLAIN.encode() if suffix == ".csv" else b"\x89HDF\r\n\x1a\n")
    os.truncate(path, 3 << 30)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    refused(path, "mine")
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 200_000
    assert resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss < 1_000_000


@pytest.mark.parametrize("suffix", [".csv", ".nc"])
def test_a_file_that_changes_meanwhile_is_told_and_one_that_vanishes_is_read(tmp_path, monkeypatch, suffix):
    path = tmp_path / f"mine{suffix}"
    hostile_files.record().save(path)
    real = os.fstat
    calls = []

    def growing(handle):
        calls.append(handle)
        if len(calls) == 2:
            with path.open("ab") as file:
                file.write(b"1,2,3\n")
        return real(handle)

    monkeypatch.setattr("rigsim.experiment.formats.regular.os.fstat", growing)
    refused(path, "changed while it was read")
    monkeypatch.undo()
    hostile_files.record().save(path)
    monkeypatch.setattr(
        "rigsim.experiment.formats.regular.os.fstat", lambda handle: (path.unlink(missing_ok=True), real(handle))[1]
    )
    assert Record.load(path).force.size == hostile_files.SAMPLES


def test_a_file_that_cannot_be_read_is_one_line(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"No such file or directory: '.*none.nc'"):
        Record.load(tmp_path / "none.nc")
    with pytest.raises(ValueError, match="mi.*ne.csv"):
        Record.load("mi\0ne.csv")


@pytest.mark.parametrize("suffix", [".csv", ".nc"])
def test_no_time_is_lost_on_healthy_files(tmp_path, suffix):
    """A limit on hanging, not a measure."""
    path = tmp_path / f"mine{suffix}"
    Record(*np.random.default_rng(1).normal(size=(3, 200_000)), 2000.0).save(path)
    begun = time.perf_counter()
    assert Record.load(path).force.size == 200_000
    assert time.perf_counter() - begun < 10


# Thousands


OTHERS = [kind for kind, module in other_files.NEEDS.items() if not module or importlib.util.find_spec(module)]


def thousands(kind, first, last, folder):
    """Have the files of those numbers read by other processes; what came of it."""
    command = [sys.executable, "-m", "tests.experiment.hostile_files", kind, first, last, folder, 1.5]
    settings = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(list(map(str, command)), cwd=ROOT, env=settings, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout.splitlines()[-1])
    assert sum(found["counts"].values()) + len(found["lost"]) == last - first
    assert not found["bad"]
    assert found["peak"] < 1000
    return found


def through(kind, numbers, folder):
    """Read files of those numbers as everybody does, in one line each: seconds of the slowest."""
    (folder / "secrets").mkdir(exist_ok=True)
    forms, slowest = hostile_files.healthy(kind, folder), 0.0
    opened = hostile_files.Opened(folder / "secrets")
    for number in numbers:
        path = folder / f"{number}{hostile_files.KINDS[kind]}"
        path.write_bytes(hostile_files.content(kind, number, forms))
        begun = time.perf_counter()
        how, said = hostile_files.tried(path, hostile_files.load_record)
        slowest = max(slowest, time.perf_counter() - begun)
        assert how in ("read", "refused"), said
    assert not opened.seen()
    return slowest


def everything(counts, folder, tell, alone, lost):
    """So many files of each kind; some of them, and some where a process was lost, by the way that everybody takes."""
    said = []
    for kind, (first, last) in counts.items():
        found = thousands(kind, first, last, folder / kind)
        said.append(f"{last - first} {kind} ({found['counts']}, {len(found['lost'])} processes lost)")
        if kind not in hostile_files.BINARY:
            assert not found["lost"]
            continue
        numbers = [*range(first, first + alone), *[number for number, _ in found["lost"]][:lost]]
        slowest = through(kind, numbers, folder)
        assert slowest < 10
        peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
        assert peak < 1000
        said.append(
            f"{len(numbers)} of them as users read them, the slowest in {slowest:.1f} s, none above {peak:.0f} MB"
        )
    tell(f"damaged and hostile files, none with a signal, another error, code run or a file opened: {'; '.join(said)}")


@pytest.mark.full
def test_ten_thousand_damaged_files(folder, tell):
    counts = {"csv": (0, 4500), "netcdf": (0, 2000), "checkpoint": (0, 3500)}
    everything(counts, folder, tell, alone=40, lost=3)
    everything(dict.fromkeys(OTHERS, (0, 1000)), folder, tell, alone=5, lost=2)


@pytest.mark.soak
def test_a_hundred_thousand_damaged_files(folder, tell):
    counts = {"csv": (4500, 40000), "netcdf": (2000, 30000), "checkpoint": (3500, 40000)}
    everything(counts, folder, tell, alone=1000, lost=100)
    everything(dict.fromkeys(OTHERS, (1000, 10000)), folder, tell, alone=100, lost=20)
