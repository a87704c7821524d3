"""The same chunks give the same bits, whoever runs them, interrupted or not."""

import contextlib
import json
import os
import random
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import rigsim
from rigsim import OscillatorParameters, RigParameters
from rigsim.campaign import code
from rigsim.campaign.checkpoint import fingerprint
from rigsim.campaign.progress import reporting
from rigsim.campaign.run import join, run_chunks, split
from tests.campaign import campaigns

POINTS = np.linspace(0.1, 3.0, 37)
CHUNKS = [POINTS[part] for part in split(POINTS.size, 5)]


def work(points):
    """Something whose last bits depend on how points are grouped."""
    return {
        "sum": np.full(points.size, np.sin(points).sum()),
        "phase": np.exp(1j * points),
        "few": points.size * [True],
    }


def same_bits(first, second):
    return first.keys() == second.keys() and all(
        first[name].tobytes() == second[name].tobytes() and first[name].dtype == second[name].dtype for name in first
    )


class Interrupted:
    """Work that fails, as Ctrl-C would, after some chunks."""

    def __init__(self, chunks):
        self.left = chunks
        self.__module__, self.__qualname__ = work.__module__, work.__qualname__

    def __call__(self, points):
        if self.left == 0:
            raise KeyboardInterrupt
        self.left -= 1
        return work(points)


@pytest.mark.parametrize(("count", "size"), [(1, 5), (5, 5), (6, 5), (37, 5), (142, 71), (7, 1)])
def test_split_covers_every_point_once(count, size):
    parts = split(count, size)
    assert [index for part in parts for index in range(count)[part]] == list(range(count))
    lengths = [part.stop - part.start for part in parts]
    assert max(lengths) <= size and max(lengths) - min(lengths) <= 1


def test_split_refuses_no_points_and_empty_chunks():
    with pytest.raises(ValueError, match="count = 0"):
        split(0, 3)
    with pytest.raises(ValueError, match="size = 0"):
        split(3, 0)


@pytest.mark.parametrize("pool", [ThreadPoolExecutor, ProcessPoolExecutor])
def test_same_bits_with_any_executor(pool):
    here = join(run_chunks(work, CHUNKS))
    with pool(2) as executor:
        assert same_bits(here, join(run_chunks(work, CHUNKS, executor=executor)))
    np.testing.assert_array_equal(here["phase"], np.exp(1j * POINTS))


def test_resumes_where_it_stopped(tmp_path):
    file = tmp_path / "campaign.sqlite"
    with pytest.raises(KeyboardInterrupt):
        run_chunks(Interrupted(3), CHUNKS, checkpoint=file)
    seen = []
    rest = run_chunks(work, CHUNKS, checkpoint=file, progress=lambda done, total: seen.append((done, total)))
    assert seen == [(done, len(CHUNKS)) for done in range(3, len(CHUNKS) + 1)]
    assert same_bits(join(rest), join(run_chunks(work, CHUNKS)))
    # A finished campaign is read back without any work.
    assert same_bits(join(run_chunks(Interrupted(0), CHUNKS, checkpoint=file)), join(rest))


def test_error_in_a_pool_is_raised_and_finished_chunks_stay(tmp_path):
    file = tmp_path / "campaign.sqlite"
    with ThreadPoolExecutor(1) as executor, pytest.raises(KeyboardInterrupt):
        run_chunks(Interrupted(2), CHUNKS, checkpoint=file, executor=executor)
    with sqlite3.connect(file) as database:
        assert database.execute("SELECT count(*) FROM chunk").fetchone() == (2,)
    database.close()


@pytest.mark.parametrize("change", ["chunks", "description", "work"])
def test_refuses_the_checkpoint_of_another_problem(tmp_path, change):
    file = tmp_path / "campaign.sqlite"
    run_chunks(work, CHUNKS, description={"force": 3.18}, checkpoint=file)
    other = {"work": work, "chunks": CHUNKS, "description": {"force": 3.18}}
    other |= {
        "chunks": {"chunks": [*CHUNKS[:-1], CHUNKS[-1] + 1e-15]},
        "description": {"description": {"force": 3.19}},
    }.get(change, {"work": same_bits})
    with pytest.raises(ValueError, match="belongs to another problem"):
        run_chunks(other["work"], other["chunks"], description=other["description"], checkpoint=file)


_SWEEP = """
import sys, rigsim
try:
    rigsim.sine_test(rigsim.RigParameters(), 3.18, 20.0, duration=1, checkpoint=sys.argv[1])
except ValueError as error:
    print(error)
"""


def test_refuses_the_checkpoint_of_other_code(tmp_path):
    """Only what a sweep can reach counts: figures may change between its parts, its rooms may not."""
    package = shutil.copytree(Path(rigsim.__file__).parent, tmp_path / "rigsim")
    command = [sys.executable, "-c", _SWEEP, str(tmp_path / "sweep.sqlite")]
    settings = {**os.environ, "PYTHONPATH": str(tmp_path)}

    def said():
        return subprocess.run(command, env=settings, cwd=tmp_path, capture_output=True, text=True, check=True).stdout

    assert said() == ""
    (package / "campaign" / "progress.py").write_bytes((package / "campaign" / "progress.py").read_bytes())
    with (package / "present" / "svg.py").open("a") as text:
        text.write("# changed\n")
    assert said() == ""
    with (package / "checks.py").open("a") as text:
        text.write("# changed\n")
    assert "was begun by other code" in said() and len(said().splitlines()) == 1


def test_refuses_a_checkpoint_where_files_have_changed_under_the_running_code(tmp_path, monkeypatch):
    monkeypatch.setattr(code, "_LOADED", 0.0)
    with pytest.raises(ValueError, match="has changed since this Python started"):
        run_chunks(work, CHUNKS, checkpoint=tmp_path / "campaign.sqlite")


def test_refuses_other_files_and_leaves_them_alone(tmp_path):
    text = tmp_path / "notes.txt"
    text.write_text("not a database " * 100)
    with pytest.raises(ValueError, match="cannot be used as a checkpoint"):
        run_chunks(work, CHUNKS, checkpoint=text)
    assert text.read_text() == "not a database " * 100

    foreign = tmp_path / "foreign.sqlite"
    with sqlite3.connect(foreign) as database:
        database.execute("CREATE TABLE chunk (a)")
    database.close()
    before = foreign.read_bytes()
    with pytest.raises(ValueError, match="another program"):
        run_chunks(work, CHUNKS, checkpoint=foreign)
    assert foreign.read_bytes() == before

    with pytest.raises(ValueError, match="cannot be used as a checkpoint"):
        run_chunks(work, CHUNKS, checkpoint=tmp_path / "no such folder" / "file")


def test_checkpoint_holds_no_pickles(tmp_path):
    file = tmp_path / "campaign.sqlite"
    with pytest.raises(ValueError, match="[Oo]bject"):
        run_chunks(lambda chunk: {"x": np.array([{}])}, [0], checkpoint=file)
    with pytest.raises(TypeError, match="no content that could be compared"):
        run_chunks(work, [object()], checkpoint=file)


def test_fingerprint_tells_contents_apart():
    rig = RigParameters()
    values = [
        None, True, 1, 1.0, "1", [1], [[1]], [], "", {"a": 1}, ["a", 1], slice(1), range(1),
        np.ones(2), np.ones((2, 1)), np.ones(2, dtype=np.float32),
        ["ab", "c"], ["a", "bc"], rig, rig.replace(c=0.027), rig.oscillator,
        OscillatorParameters(1, 1, 0, 1, 0, 0, 0),
    ]  # fmt: skip
    assert len({fingerprint(value) for value in values}) == len(values)
    assert fingerprint(rig, np.float64(0.5)) == fingerprint(RigParameters(), 0.5)
    assert fingerprint({"a": 1, "b": 2}) == fingerprint({"b": 2, "a": 1})


def test_progress_forms(capsys):
    with reporting(True, 3, "points") as report:
        report(1)
        report(3)
    said = capsys.readouterr().err
    assert "points" in said and " 3/3 " in said
    with reporting(False, 3) as report:
        report(3)
    assert capsys.readouterr() == ("", "")
    with pytest.raises(ValueError, match="progress = 'yes'"), reporting("yes", 3):
        pass


def mortal(chunk):
    """Work that ends its process: at chunk 3, for good or, where a file is named, once."""
    number, mark = chunk
    if number == 3 and not (mark and os.path.exists(mark)):
        if mark:
            Path(mark).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return {"value": np.random.default_rng(number).normal(size=50)}


@pytest.mark.skipif(sys.platform == "win32", reason="needs SIGKILL")
@pytest.mark.parametrize("checkpoint", [None, "campaign.sqlite"])
def test_a_killed_worker_loses_nothing(tmp_path, checkpoint):
    chunks, file = [(number, str(tmp_path / "mark")) for number in range(12)], checkpoint and tmp_path / checkpoint
    with ProcessPoolExecutor(2) as executor:
        results = run_chunks(mortal, chunks, executor=executor, checkpoint=file)
    assert (tmp_path / "mark").exists(), "nobody was killed"
    assert [result["value"].tobytes() for result in results] == [
        np.random.default_rng(number).normal(size=50).tobytes() for number in range(12)
    ]


@pytest.mark.skipif(sys.platform == "win32", reason="needs SIGKILL")
def test_a_chunk_that_ends_every_process_is_named_and_the_rest_is_kept(tmp_path):
    chunks, file = [(number, None) for number in range(8)], tmp_path / "campaign.sqlite"
    with ProcessPoolExecutor(2) as executor, pytest.raises(RuntimeError, match=r"chunk 3 \(of 8\) ends the process"):
        run_chunks(mortal, chunks, executor=executor, checkpoint=file)
    with contextlib.closing(sqlite3.connect(file)) as database:
        assert {0, 1, 2} <= {number for (number,) in database.execute("SELECT number FROM chunk")}


_DAY = [sys.executable, str(Path(campaigns.__file__)), "run"]


@pytest.mark.full
@pytest.mark.skipif(sys.platform == "win32", reason="needs SIGKILL")
def test_a_cluster_with_a_killed_worker_gives_the_same_bits(tmp_path):
    pytest.importorskip("distributed")
    settings = {**os.environ, "PYTHONPATH": os.pathsep.join([str(Path(__file__).parents[2]), *sys.path])}
    command = [*_DAY, str(tmp_path / "a.sqlite"), "0.1", "", "60", "cluster"]
    done = subprocess.run(command, env=settings, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout.splitlines()[-1]) == {"right": True}


@pytest.mark.soak
@pytest.mark.skipif(sys.platform == "win32", reason="needs SIGKILL")
def test_a_day_of_campaign_in_small(tmp_path, tell):
    """10 000 chunks in a pool, ten kills and one damaged chunk: the bits of a campaign that was left alone."""
    file, chance, kept = tmp_path / "day.sqlite", random.Random(7), 0
    command = [*_DAY, str(file), "0.002", "", "10000", "processes"]
    settings = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    for _ in range(10):
        process = subprocess.Popen(command, env=settings, start_new_session=True)
        deadline = time.monotonic() + 60
        while len(campaigns.kept(file)) < kept + 50 and time.monotonic() < deadline:
            time.sleep(0.2)
        time.sleep(chance.uniform(0, 0.5))
        os.killpg(process.pid, signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL
        assert len(campaigns.kept(file)) > kept
        kept = len(campaigns.kept(file))
    with contextlib.closing(sqlite3.connect(file)) as database, database:
        database.execute("UPDATE chunk SET arrays = zeroblob(length(arrays)) WHERE number = 17")
    done = subprocess.run(command, env=settings, capture_output=True, text=True, check=True)
    assert json.loads(done.stdout) == {"right": True}
    assert done.stderr.count("is damaged: chunk 17 is computed again") == 1
    assert campaigns.kept(file) == set(range(10000))
    tell(f"10 000 chunks with ten kills ({kept} were kept by then) and one damaged chunk: the same bits")
