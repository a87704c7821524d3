"""Files that are damaged or mean harm, and a program that reads them one after the other and says what they did.

``hostile_files.py KIND FIRST LAST FOLDER PATIENCE`` has processes make and read the files of those numbers, the same
every time, and says in a line of JSON what came of it, and at which files it lost a process.
"""

import codecs
import contextlib
import ctypes
import importlib
import io
import json
import logging
import os
import resource
import select
import signal
import sqlite3
import sys
import warnings
from collections import Counter
from pathlib import Path

import h5py
import numpy as np

from rigsim.campaign.checkpoint import Checkpoint
from rigsim.experiment.formats import binary
from rigsim.experiment.formats.child import __main__ as child
from rigsim.experiment.reading import GuessWarning
from rigsim.experiment.record import Record
from rigsim.parameters import RigParameters
from tests.experiment import other_files

SAMPLES = 150
KINDS = {
    "csv": ".csv", "netcdf": ".nc", "checkpoint": ".sqlite", "table": ".txt", "zipped": ".csv.gz", "hdf5": ".h5",
    "matlab": ".mat", "npz": ".npz", "uff": ".uff", "tdms": ".tdms",
}  # fmt: skip
BINARY = {"netcdf": "hdf5", "hdf5": "hdf5", "matlab": "matlab", "npz": "npz", "uff": "uff", "tdms": "tdms"}


def record():
    rng = np.random.default_rng(5)
    return Record(*rng.normal(size=(3, SAMPLES)), 2000.0, tilt=np.zeros(SAMPLES), seed=3, parameters=RigParameters())


# Healthy files, by kind


def healthy(kind, folder):
    """Contents of whole files of a kind, of every form there is."""
    path = folder / f"healthy{KINDS[kind]}"
    made = {"csv": _csv_files, "netcdf": _netcdf_files, "checkpoint": _checkpoint_files}
    return (made | other_files.MADE)[kind](path)


def _csv_files(path):
    record().save(path)
    saved = path.read_bytes()
    rows = "".join(f"{index / 2000!r},{index},{index / 3!r},1e-5\r\n" for index in range(SAMPLES))
    mine = '\ufeff# {"hold": "linear"}\r\n"time", "force",shaker,mass\r\n' + rows
    return [saved, mine.encode(), b'# {"sample_rate": 5, "hold": "zero"}\nmass,shaker,force\n1,2,3\n4,5,6']


def _netcdf_files(path):
    record().save(path)
    forms = [path.read_bytes()]
    for options in (
        {"chunks": (40,), "compression": "gzip", "shuffle": True, "fletcher32": True},
        {"chunks": (SAMPLES,), "compression": "lzf"},
        {"dtype": "f4"},
        {"maxshape": (None,), "chunks": (7,)},
    ):
        forms += [hdf5(path, libver=version, **options) for version in ("earliest", "latest")]
    return forms


def hdf5(path, change=None, libver="earliest", **options):
    """A record made with h5py: ``change`` gets the open file; bytes."""
    with h5py.File(path, "w", libver=libver) as file:
        file.attrs["rigsim_record"] = '{"sample_rate": 2000.0, "hold": "zero"}'
        for name in ("force", "shaker", "mass"):
            file.create_dataset(name, data=getattr(record(), name), **options).attrs["units"] = {"force": "N"}.get(
                name, "m"
            )
        if change:
            change(file)
    return path.read_bytes()


CHUNKS = {
    number: {"a": np.random.default_rng(number).normal(size=size), "b": np.arange(number)}
    for number, size in enumerate((3, 200, 2000, 0, 50))
}


def _checkpoint_files(path):
    forms = []
    for numbers in ((), (0, 1, 3), CHUNKS):
        path.unlink(missing_ok=True)
        with Checkpoint(path, "key", "code") as store:
            for number in numbers:
                store.save(number, CHUNKS[number])
            store.claim(CHUNKS, 1)
            forms.append(path.read_bytes())
    with contextlib.closing(sqlite3.connect(path)) as database:
        database.execute("PRAGMA journal_mode = WAL")
    return [*forms, path.read_bytes()]


# Damage


WORDS = [
    b"", b",", b'"', b"\n", b"\r", b"\0", b"\xff", b"nan", b"inf", b"1e400", b"-1e308", b"1_000", b"0x1p3", b"1.0D-03",
    b"1+2j", b"True", b"None", b"#", b"{", b"}", b"[", b"]" * 9, b"null", b"NaN", b"-Infinity", b'"sample_rate": 7,',
    b'"hold": "zero",', b"9" * 400, b"9" * 5000, b"[" * 3000, b"\xef\xbb\xbf", b"\\ud800", b";", b"\t", b"force,", b"e",
    b"1e-320", b"x" * 70000, b"1," * 40000, b'"parameters": {"kind": "RigParameters", "k": "many"},', b'"seed": -1,',
]  # fmt: skip
SIZES = [0, 1, 0xFF, 0xFFFF, 0x7FFFFFFF, 0xFFFFFFFF, 1 << 40, (1 << 63) - 1, (1 << 64) - 1, 4096, 1 << 20]


def damaged(content, others, rng):
    """The bytes with one to four troubles."""
    content = bytearray(content)
    for _ in range(rng.integers(1, 5)):
        content = bytearray(_TROUBLES[rng.integers(len(_TROUBLES))](content, others, rng))
    return bytes(content)


def _place(content, rng):
    """A place, at the beginning rather than at the end: there files say how they go on."""
    size = max(len(content), 1)
    return int(rng.integers(size) if rng.random() < 0.5 else min(rng.exponential(size / 12), size - 1))


def _cut(content, others, rng):
    return content[: _place(content, rng) if rng.random() < 0.7 else len(content) - int(rng.integers(1, 40))]


def _flip(content, others, rng):
    for _ in range(rng.integers(1, 20)):
        if content:
            content[_place(content, rng)] ^= 1 << int(rng.integers(8))
    return content


def _blank(content, others, rng):
    at, size = _place(content, rng), int(2 ** rng.uniform(0, 13))
    fill = (b"\0", b"\xff", bytes([int(rng.integers(256))]))[rng.integers(3)]
    content[at : at + size] = fill * len(content[at : at + size])
    return content


def _double(content, others, rng):
    at, to, size = _place(content, rng), _place(content, rng), int(2 ** rng.uniform(0, 13))
    content[to : to + (size if rng.random() < 0.5 else 0)] = content[at : at + size]
    return content


def _swap(content, others, rng):
    page = int(rng.choice([8, 64, 512, 4096]))
    parts = [content[at : at + page] for at in range(0, len(content), page)]
    if len(parts) > 1:
        one, two = rng.integers(len(parts), size=2)
        parts[one], parts[two] = parts[two], parts[one]
    return b"".join(parts)


def _splice(content, others, rng):
    other = others[rng.integers(len(others))]
    at = _place(content, rng)
    return bytes(content[:at]) + other[at if rng.random() < 0.7 else _place(other, rng) :]


def _inflate(content, others, rng):
    size, order = int(rng.choice([1, 2, 4, 8])), ("little", "big")[rng.integers(2)]
    number = SIZES[rng.integers(len(SIZES))] & ((1 << 8 * size) - 1)
    at = _place(content, rng) // size * size
    content[at : at + size] = number.to_bytes(size, order)
    return content


def _word(content, others, rng):
    at = _place(content, rng)
    content[at : at + int(rng.integers(4))] = WORDS[rng.integers(len(WORDS))]
    return content


_TROUBLES = [_cut, _flip, _flip, _blank, _double, _swap, _splice, _inflate, _inflate, _word]


# What is read, and what may come of it


class Alarms:
    """What happens in this process while a file is read: other files opened, code run."""

    WATCHED = (
        "exec", "compile", "subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "pickle.find_class",
        "marshal.loads", "ctypes.dlopen", "socket.connect", "sqlite3.enable_load_extension",
    )  # fmt: skip

    def __init__(self, kind):
        self.on, self.allowed, self.seen = False, "", []
        # NumPy parses what an array's header says, as a literal, which runs nothing.
        self.watched = set(self.WATCHED) - ({"compile"} if kind == "npz" else set())
        sys.addaudithook(self._heard)

    def _heard(self, event, arguments):
        if self.on and (event in self.watched or (event == "open" and not self._may(arguments[0]))):
            self.seen.append(f"{event} {arguments[0]!r}"[:200])

    def _may(self, path):
        own = isinstance(path, int) or os.fsdecode(path).startswith((self.allowed, sys.prefix, sys.base_prefix))
        return own or os.fsdecode(path).startswith("/proc/")


class Opened:
    """Whether the system saw one of the files in a folder opened, whoever did; Linux only, else never."""

    def __init__(self, folder):
        self._handle = None
        with contextlib.suppress(AttributeError, OSError):
            libc = ctypes.CDLL(None, use_errno=True)
            self._handle = libc.inotify_init1(os.O_NONBLOCK)
            libc.inotify_add_watch(self._handle, os.fsencode(folder), 0x20 | 0x1)  # opened, read

    def seen(self):
        try:
            return self._handle is not None and bool(os.read(self._handle, 4096))
        except BlockingIOError:
            return False


@contextlib.contextmanager
def _here(path, file, size, reader):
    """In place of the process that reads: the same reading, in this one."""
    out, module = io.BytesIO(), importlib.import_module(f"rigsim.experiment.formats.child.{reader}")
    file.seek(0)
    child.answer(module, child.Whole(io.FileIO(file.fileno(), closefd=False)), out, binary.allowed(size))
    out.seek(0)
    yield out


def load_record(path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", GuessWarning)
        Record.load(path, hold=None if path.suffix in (".csv", ".nc") else "zero")


def use_checkpoint(path):
    """Continue a campaign: what is found is right to the last bit, and all is there afterwards."""
    warnings.simplefilter("ignore")
    with Checkpoint(path, "key", "code") as store:
        found = store.load(CHUNKS)
        _same(found)
        mine, finished = store.claim([number for number in CHUNKS if number not in found], 9)
        for number in mine:
            store.save(number, CHUNKS[number])
        again = store.load(CHUNKS)
        _same(again)
        assert again.keys() >= found.keys() | set(mine), "a chunk is gone"


def _same(found):
    for number, arrays in found.items():
        assert arrays.keys() == CHUNKS[number].keys(), f"chunk {number} has other arrays"
        for name, array in arrays.items():
            true = CHUNKS[number][name]
            assert array.dtype == true.dtype and array.tobytes() == true.tobytes(), f"chunk {number} is another"


def tried(path, read):
    """How reading ended, and what it said."""
    try:
        read(path)
    except (ValueError, OSError) as error:
        text = str(error)
        told = "\n" not in text and path.name in text and len(text) < 2000
        return "refused" if told else "told badly", text[:300]
    except BaseException as error:
        return type(error).__name__, str(error)[:300]
    return "read", ""


def work(kind, numbers, forms, folder, say):
    """Make and read the files of those numbers, with a word before and after each."""
    read, alarms, opened = (
        use_checkpoint if kind == "checkpoint" else load_record,
        Alarms(kind),
        Opened(folder / "secrets"),
    )
    if kind in BINARY and sys.platform == "linux":  # as the process that reads has it, and some for this one's own
        most = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize() + 400_000_000
        resource.setrlimit(resource.RLIMIT_AS, (most, most))
    for number in numbers:
        path = folder / f"{number}{KINDS[kind]}"
        path.write_bytes(content(kind, number, forms))
        say({"begun": number})
        alarms.allowed, alarms.on = str(path), True
        how, said = tried(path, read)
        alarms.on = False
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        seen = alarms.seen + ["a secret was opened"] * opened.seen()
        say({"ended": number, "how": how, "said": said, "peak": peak, "alarms": seen})
        alarms.seen = []
        for left in folder.glob(f"{number}.*"):
            left.unlink()


def content(kind, number, forms):
    """The file of that number."""
    rng = np.random.default_rng((list(KINDS).index(kind), number))
    base = forms[rng.integers(len(forms))]
    return forms[number] if number < len(forms) else damaged(base, forms, rng)


def lines(reader, patience):
    """Lines of JSON from a pipe, None when the next one takes too long."""
    rest = b""
    while True:
        if not select.select([reader], [], [], patience)[0]:
            yield None
        more = os.read(reader, 1 << 16)
        if not more:
            return
        *whole, rest = (rest + more).split(b"\n")
        yield from map(json.loads, whole)


def main(kind, first, last, folder, patience):
    """Have processes read the files, another one where one was lost; one line says what was found."""
    folder, first, last = Path(folder), int(first), int(last)
    (folder / "secrets").mkdir(parents=True, exist_ok=True)
    binary._child = _here
    logging.disable()
    for name in ("ascii", "cp1252", "latin-1", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32"):
        codecs.lookup(name)
    for name in {"hdf5", "netcdf3", BINARY.get(kind, "hdf5")}:
        importlib.import_module(f"rigsim.experiment.formats.child.{name}")
    forms = healthy(kind, folder)
    for text in (b"", b"no record", forms[0]):  # all that is loaded when it is first used
        (folder / f"first{KINDS[kind]}").write_bytes(text)
        tried(folder / f"first{KINDS[kind]}", use_checkpoint if kind == "checkpoint" else load_record)
    counts, bad, lost, peak = Counter(), [], [], 0
    while first < last:
        reader, writer = os.pipe()
        child = os.fork()
        if not child:
            os.close(reader)
            say = lambda word: os.write(writer, json.dumps(word).encode() + b"\n")  # noqa: B023, E731
            work(kind, range(first, last), forms, folder, say)
            os._exit(0)
        os.close(writer)
        for word in lines(reader, float(patience)):
            if word is None:
                lost.append([first, "hangs"])
                os.kill(child, signal.SIGKILL)
                first += 1
                break
            first = word.get("begun", word.get("ended", 0) + 1)
            if "ended" in word:
                counts[word["how"]] += 1
                peak = max(peak, word["peak"])
                if word["alarms"] or word["how"] not in ("read", "refused"):
                    bad.append(word)
        _, status = os.waitpid(child, 0)
        if status and not (lost and lost[-1] == [first - 1, "hangs"]):
            lost.append([first, f"ends with status {status}"])
            first += 1
        os.close(reader)
    print(json.dumps({"counts": counts, "bad": bad, "lost": lost, "peak": peak}), flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
