"""A checkpoint is shared, outlives what befalls it, and lets nothing in."""

import contextlib
import json
import os
import shutil
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from rigsim.campaign import checkpoint, owner
from rigsim.campaign.checkpoint import Checkpoint
from rigsim.campaign.packing import Damaged, pack, unpack
from tests.campaign import campaigns

ROOT = Path(__file__).parents[2]
posix = pytest.mark.skipif(os.name != "posix", reason="needs signals")


def begun(file, count=6):
    """A checkpoint that holds ``count`` chunks."""
    with Checkpoint(file, "key", "code") as store:
        for number in range(count):
            store.save(number, campaigns.slow((number, 0.0, None)))
    return file


def rows(file, query="SELECT number FROM chunk"):
    with contextlib.closing(sqlite3.connect(file)) as database:
        return database.execute(query).fetchall()


def change(file, *statements):
    with contextlib.closing(sqlite3.connect(file)) as database, database:
        for statement in statements:
            database.execute(*statement) if isinstance(statement, tuple) else database.execute(statement)


def loaded(file, warning=None, count=6):
    """What is found in the file, with the one warning that its damage is told by, or none."""
    with contextlib.ExitStack() as stack:
        said = stack.enter_context(pytest.warns(RuntimeWarning, match=warning)) if warning else []
        with Checkpoint(file, "key", "code") as store:
            found = store.load(range(count))
    assert len(said) <= 1 and all("\n" not in str(one.message) and str(file) in str(one.message) for one in said)
    return found


@pytest.mark.parametrize(
    "array",
    [
        np.arange(6.0).reshape(2, 3).T,
        np.array(3 + 4j),
        np.zeros((0, 5), bool),
        np.array(["low", "high"]),
        np.array([b"a"]),
        np.arange(4, dtype=">i2"),
        np.array([1, np.datetime64("NaT")], "M8[s]"),
    ],
    ids=lambda array: f"{array.dtype.str}{array.shape}",
)
def test_arrays_are_kept_bit_for_bit(array):
    again = unpack(*pack({"a": array, "b": array}))
    for one in again.values():
        assert one.dtype == array.dtype and one.shape == array.shape and one.tobytes() == array.tobytes()
        assert one.flags.writeable


@pytest.mark.parametrize(
    "array", [np.array([{}]), np.zeros(2, [("x", float)]), np.array(["a"], object)], ids=["object", "record", "text"]
)
def test_what_numpy_would_pickle_or_name_is_refused(array):
    with pytest.raises(ValueError, match=r"a has the type .*; Objects and records"):
        pack({"a": array})


@pytest.mark.parametrize(
    "arrays",
    [
        [["a", "<f8", [1 << 60]]],
        [["a", "<f8", [-1, -2]]],
        [["a", "<f8", [1]]],
        [["a", "<f8", [3]]],
        [["a", "|O", [2]]],
        [["a", "|V8", [2]]],
        [["a", "<f8", [0, 1 << 62]], ["b", "<f8", [2]], ["c"]],
        [["a", "no type", [2]]],
        [["a", "<f8", 2]],
        [["a", "<f8", ["2"]]],
        7,
    ],
    ids=str,
)
def test_a_form_that_the_content_does_not_fit_is_damage(arrays):
    form, content = pack({"a": np.ones(2)})
    with pytest.raises(Damaged):
        unpack(json.dumps({**json.loads(form), checkpoint.MARK: arrays}), content)
    for broken in ("", "null", "[]", "{}", "[" * 100000, None, b"\xff", 3):
        with pytest.raises(Damaged):
            unpack(broken, content)


@pytest.mark.parametrize(
    "statement",
    [
        "UPDATE chunk SET arrays = zeroblob(length(arrays)) WHERE number = 3",
        "UPDATE chunk SET arrays = NULL WHERE number = 3",
        "UPDATE chunk SET arrays = 'text' WHERE number = 3",
        "UPDATE chunk SET arrays = (SELECT arrays FROM chunk WHERE number = 4) WHERE number = 3",
        "UPDATE chunk SET form = '{}' WHERE number = 3",
        "UPDATE chunk SET form = 3.5 WHERE number = 3",
        "UPDATE chunk SET digest = upper(digest) WHERE number = 3",
        "UPDATE chunk SET digest = NULL WHERE number = 3",
    ],
)
def test_a_damaged_chunk_alone_is_computed_again(tmp_path, statement):
    file = begun(tmp_path / "a.sqlite")
    change(file, statement)
    assert loaded(file, r"chunk 3 is computed again").keys() == {0, 1, 2, 4, 5}
    assert loaded(file).keys() == {0, 1, 2, 4, 5} and os.listdir(tmp_path) == ["a.sqlite"]


def test_a_chunk_under_another_number_is_not_believed(tmp_path):
    file = begun(tmp_path / "a.sqlite")
    change(file, "DELETE FROM chunk WHERE number = 5", "UPDATE chunk SET number = 5 WHERE number = 2")
    assert loaded(file, "chunk 5 is").keys() == {0, 1, 3, 4}


def flipped(file, *places):
    content = bytearray(file.read_bytes())
    for place in places:
        content[place] ^= 0xFF
    file.write_bytes(content)


@pytest.mark.parametrize(
    "damage",
    [
        lambda file: flipped(file, 3),
        lambda file: flipped(file, *range(100)),
        lambda file: flipped(file, 100),
        lambda file: flipped(file, *range(16, 400)),
        lambda file: flipped(file, 68),
        lambda file: file.write_bytes(file.read_bytes()[:50]),
        lambda file: file.write_bytes(file.read_bytes()[:1000]),
        lambda file: file.write_bytes(file.read_bytes()[:9000]),
        lambda file: file.write_bytes(bytes(file.stat().st_size)),
        lambda file: file.write_bytes(bytes(4096) + file.read_bytes()[4096:]),
        lambda file: file.write_bytes(file.read_bytes()[4096:]),
        lambda file: change(file, "DELETE FROM problem"),
        lambda file: change(file, "UPDATE problem SET key = 'kez'"),
        lambda file: change(file, "UPDATE problem SET key = x'ff00', code = 3"),
        lambda file: change(file, "DROP TABLE claim"),
        lambda file: change(file, "CREATE TRIGGER t AFTER INSERT ON chunk BEGIN DELETE FROM chunk; END"),
        lambda file: change(file, "DROP TABLE claim", "CREATE VIEW claim AS SELECT number, '', 0 FROM chunk"),
        lambda file: change(
            file, "DROP TABLE chunk", "CREATE TABLE chunk (number INTEGER PRIMARY KEY, a AS (zeroblob(1000000000)))"
        ),
    ],
)
def test_a_damaged_file_is_set_aside_and_the_work_goes_on(tmp_path, damage):
    file = begun(tmp_path / "a.sqlite")
    damage(file)
    content = file.read_bytes()
    assert loaded(file, r"is damaged \(.*\): it was renamed to 'a.sqlite.damaged-1'") == {}
    assert (tmp_path / "a.sqlite.damaged-1").read_bytes() == content
    begun(file)
    assert len(loaded(file)) == 6
    flipped(file, *range(100))
    assert loaded(file, "'a.sqlite.damaged-2'") == {}
    assert sorted(os.listdir(tmp_path)) == ["a.sqlite", "a.sqlite.damaged-1", "a.sqlite.damaged-2"]


def test_damage_while_running_loses_nothing(tmp_path):
    file = tmp_path / "a.sqlite"
    with Checkpoint(file, "key", "code") as store:
        for number in range(6):
            store.save(number, campaigns.slow((number, 0.0, None)))
        content = bytearray(file.read_bytes())
        content[100:] = bytes(len(content) - 100)
        content[24:28] = b"\xff" * 4  # another change counter: what SQLite remembers of the file counts no more
        file.write_bytes(content)
        with pytest.warns(RuntimeWarning, match="is damaged"):
            store.save(6, campaigns.slow((6, 0.0, None)))
    assert loaded(file, count=7).keys() == set(range(7))


def test_files_of_others_are_refused_and_left(tmp_path):
    foreign = tmp_path / "foreign.sqlite"
    change(foreign, "CREATE TABLE problem (key TEXT)", "CREATE TABLE chunk (number INTEGER PRIMARY KEY)")
    older = tmp_path / "older.sqlite"
    change(
        older,
        "PRAGMA application_id = 0x52494753",
        "CREATE TABLE problem (key TEXT, code TEXT)",
        "CREATE TABLE chunk (number INTEGER PRIMARY KEY, arrays BLOB)",
    )
    broken = tmp_path / "broken.sqlite"
    broken.write_bytes(foreign.read_bytes()[:5000])
    text = tmp_path / "notes.txt"
    text.write_text("# my script\n" * 20)
    short = tmp_path / "short.txt"
    short.write_text("hi")
    cases = {
        foreign: "a database of another program", older: "written by another version", text: "cannot be used as",
        short: "cannot be used as", broken: "cannot be used as",
    }  # fmt: skip
    for file, message in cases.items():
        before = file.read_bytes()
        with pytest.raises(ValueError, match=message) as caught:
            Checkpoint(file, "key", "code")
        assert "\n" not in str(caught.value) and file.read_bytes() == before
    assert len(os.listdir(tmp_path)) == len(cases)


@posix
def test_what_is_no_file_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path, tmp_path / "pipe", "/dev/null", "/dev/zero"):
        with pytest.raises(ValueError, match="is no regular file"):
            Checkpoint(path, "key", "code")


def test_a_folder_that_goes_while_running_is_one_line(tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()
    with Checkpoint(folder / "a.sqlite", "key", "code") as store:
        store.save(0, {"a": np.ones(3)})
        shutil.rmtree(folder)
        with pytest.raises(OSError, match="cannot be read or written: .*; what was finished before is kept") as caught:
            store.save(1, {"a": np.ones(3)})
    assert "\n" not in str(caught.value)


@posix
def test_a_full_disk_is_one_line_and_keeps_what_was_finished(tmp_path):
    code = (
        "import resource, signal, sys\nimport numpy as np\nfrom rigsim.campaign.checkpoint import Checkpoint\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "with Checkpoint(sys.argv[1], 'key', 'code') as store:\n"
        "    store.save(0, {'a': np.ones(300)})\n"
        "    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))\n"
        "    try:\n        store.save(1, {'a': np.ones(100_000)})\n"
        "    except OSError as error:\n        print(type(error).__name__, error)\n"
    )
    command = [sys.executable, "-c", code, str(tmp_path / "a.sqlite")]
    done = subprocess.run(
        command, capture_output=True, text=True, cwd=ROOT, env={**os.environ, "PYTHONPATH": str(ROOT)}
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("OSError checkpoint = ") and done.stdout.count("\n") == 1
    assert loaded(tmp_path / "a.sqlite").keys() == {0}


def test_another_program_s_lock_is_waited_for_and_then_one_line(tmp_path, monkeypatch):
    file = begun(tmp_path / "a.sqlite")
    with Checkpoint(file, "key", "code") as store, contextlib.closing(sqlite3.connect(file)) as other:
        other.execute("BEGIN EXCLUSIVE")
        monkeypatch.setattr(checkpoint, "_PATIENCE", 0.5)
        with pytest.raises(OSError, match="database is locked"):
            store.save(6, {"a": np.ones(3)})
        other.rollback()
        store.save(6, {"a": np.ones(3)})


def test_a_chunk_is_one_process_s_until_that_has_ended(tmp_path, monkeypatch):
    file = tmp_path / "a.sqlite"
    with Checkpoint(file, "key", "code") as one, Checkpoint(file, "key", "code") as two:
        assert one.claim(range(5), 2) == ([0, 1], [])
        assert two.claim(range(5), 2) == ([2, 3], [])
        one.save(0, {"a": np.ones(3)})
        assert two.claim([0, 1, 4], 2) == ([4], [0])
        assert one.claim(range(1, 5), 9) == ([], [])
        two.__exit__()
        assert one.claim(range(1, 5), 9) == ([2, 3, 4], [])
        # Nobody's: a process that has ended, another machine's that gives no sign, and words.
        gone = json.loads(owner.myself()) | {"pid": 2**22 + 1}
        reused = json.loads(owner.myself()) | {"since": -5}
        elsewhere = json.loads(owner.myself()) | {"host": "elsewhere"}
        for number, other in enumerate([json.dumps(gone), json.dumps(reused), json.dumps(elsewhere), "me", "[]"]):
            change(file, ("INSERT OR REPLACE INTO claim VALUES (?, ?, 0)", (10 + number, other)))
        expected = [10, 12, 13, 14] if not Path("/proc/self/stat").exists() else [10, 11, 13, 14]
        assert one.claim(range(10, 15), 9)[0] == expected
        monkeypatch.setattr(owner, "STALE", 0.0)
        assert 12 in one.claim(range(10, 15), 9)[0]


def test_signs_of_life_are_given(tmp_path, monkeypatch):
    monkeypatch.setattr(checkpoint, "_BEAT", 0.02)
    file = tmp_path / "a.sqlite"
    with Checkpoint(file, "key", "code") as store:
        store.claim(range(3), 1)
        deadline = time.monotonic() + 20
        while rows(file, "SELECT beat FROM claim")[0][0] < 3:
            assert time.monotonic() < deadline
            time.sleep(0.01)
    assert rows(file, "SELECT * FROM claim") == []


def campaign(*arguments, **options):
    command = [sys.executable, str(Path(campaigns.__file__)), *map(str, arguments)]
    settings = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=settings, cwd=ROOT, **options)


@pytest.mark.parametrize("pool", ["none", "processes"])
def test_two_processes_share_the_work(tmp_path, pool):
    log = tmp_path / "log"
    arguments = "run", tmp_path / "a.sqlite", 0.05, log, 40, pool
    both = [campaign(*arguments), campaign(*arguments)]
    for process in both:
        assert json.loads(process.communicate(timeout=60)[0]) == {"right": True}
    assert sorted(map(int, log.read_text().split())) == list(range(40))


@posix
def test_what_a_killed_process_had_in_hand_is_taken_over(tmp_path):
    log = tmp_path / "log"
    arguments = "run", tmp_path / "a.sqlite", 0.3, log, 12, "none"
    killed, other = campaign(*arguments), campaign(*arguments)
    deadline = time.monotonic() + 60
    while not log.exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    killed.kill()  # and not waited for: a zombie works at nothing
    assert json.loads(other.communicate(timeout=60)[0]) == {"right": True}
    killed.communicate()
    done = sorted(map(int, log.read_text().split()))
    assert set(done) == set(range(12)) and len(done) <= 13


@pytest.mark.full
@posix
def test_a_hundred_kills_and_a_hundred_cancels_lose_nothing(tmp_path, tell):
    said = []
    for how, times in (("SIGKILL", 50), ("SIGINT", 25), ("SIGTERM", 25)):
        for pool in ("none", "processes"):
            process = campaign("end", how, times, tmp_path / f"{how}-{pool}.sqlite", pool, 3)
            found = json.loads(process.communicate(timeout=120)[0])
            assert found["right"] and process.returncode == 0
            assert not found["left"], "processes are left"
            assert found["slowest"] < 3  # with a second signal where Python dropped the first
            assert found["kept"] >= times // 4, "too little was done to be lost"
            said.append(
                f"{times} by {how} ({pool}: {found['kept']} chunks kept, the slowest end {found['slowest']:.2f} s)"
            )
    tell(f"campaigns ended at random instants, nothing lost, same bits: {'; '.join(said)}")
    assert not [name for name in os.listdir(tmp_path) if not name.endswith(".sqlite")]
