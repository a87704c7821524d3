"""The ``checkpoint=`` keyword of long work: finished chunks in one file, kept whole or not at all."""

import dataclasses
import hashlib
import itertools
import mmap
import os
import re
import sqlite3
import threading
import time
import warnings
from contextlib import closing, contextmanager, suppress
from pathlib import Path

import numpy as np

from .owner import Watch, myself
from .packing import MARK, Damaged, digest, pack, unpack
from .stop import SLICE, look

_APPLICATION_ID = 0x52494753  # marks the file as ours in SQLite's header ("RIGS")
_MAGIC = b"SQLite format 3\0"
_VERSION = 2
_TABLES = [
    f"CREATE TABLE problem (key TEXT, code TEXT, digest TEXT /* {MARK} {_VERSION} */)",
    "CREATE TABLE chunk (number INTEGER PRIMARY KEY, form TEXT, arrays BLOB, digest TEXT)",
    "CREATE TABLE claim (number INTEGER PRIMARY KEY, owner TEXT, beat INTEGER)",
]
_FIRST_VERSION = "CREATE TABLE problem (key TEXT, code TEXT)"
_BEAT, _PATIENCE = 5.0, 30.0  # s between signs of life; s to wait for another program that writes
_BUSY = {sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED}
# What SQLite says of a file whose content is not as it left it; all else is the disk's, or another program's doing.
_DAMAGE = {sqlite3.SQLITE_ERROR, sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB, sqlite3.SQLITE_FORMAT}
_DAMAGE |= {sqlite3.SQLITE_SCHEMA, sqlite3.SQLITE_MISMATCH, sqlite3.SQLITE_TOOBIG, sqlite3.SQLITE_INTERRUPT}


class Checkpoint:
    """Finished chunks of one problem in a SQLite file, shared by all who work at it; a context manager.

    Each chunk is committed by itself, so a killed process loses only the chunk it was at. Arrays are kept bit for bit,
    with a checksum and without pickles. ``path`` is continued, or begun if it does not exist; ``key`` is the
    `fingerprint` of the problem and ``code`` the `code.code_fingerprint` of what computes the chunks.

    A chunk is claimed before it is computed, so that processes share the work; the claim of one that has ended, or has
    given no sign of life for a minute, counts no more. A damaged file is set aside, under a name that a warning tells,
    and begun anew; of damaged chunks only they.

    `ValueError` if the file belongs to another problem or to other code, is no checkpoint, or cannot be opened;
    `OSError` if it cannot be read or written: what was finished before is kept then.
    """

    def __init__(self, path, key, code):
        self.path, self._file = os.fspath(path), os.path.abspath(path)
        self._key, self._code = key, code
        self._me, self._watch, self._ended, self._beating = myself(), Watch(), threading.Event(), None
        self._kept = {}  # what the file should hold, if it has to be begun again
        self._database, self._which = None, None
        self._safely(lambda: None)

    def load(self, numbers):
        """Finished chunks among ``numbers`` as a dict of number to dict of arrays."""
        found, bad = self._safely(self._load, set(numbers))
        if bad:
            which = f"chunk {bad[0]} is" if len(bad) == 1 else f"chunks {', '.join(map(str, bad))} are"
            warnings.warn(
                f"checkpoint = {self.path!r} is damaged: {which} computed again", RuntimeWarning, stacklevel=2
            )
        self._kept.update(found)
        return found

    def save(self, number, arrays):
        """Keep chunk ``number``, a dict of arrays."""
        self._safely(self._save, number, arrays)
        self._kept[number] = arrays

    def claim(self, numbers, most):
        """Numbers of at most ``most`` chunks that are now this process's to compute, and of those that are finished.

        Only ``numbers`` are looked at, in order, until there are enough.
        """
        mine, finished = self._safely(self._claim, numbers, most)
        if mine and self._beating is None:
            self._beating = threading.Thread(target=self._beat, daemon=True)
            self._beating.start()
        return mine, finished

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._ended.set()
        with suppress(sqlite3.Error):  # a claim that stays is found to be nobody's
            self._database.execute("DELETE FROM claim WHERE owner = ?", (self._me,))
        self._database.close()

    def _load(self, numbers):
        found, bad = {}, []
        # Row by row, since nobody can write while a long query reads.
        here = {number for (number,) in self._database.execute("SELECT number FROM chunk").fetchall()}
        for number in sorted(here & numbers):
            query = "SELECT form, arrays, digest FROM chunk WHERE number = ?"
            row = self._database.execute(query, (number,)).fetchone()
            if row is None:
                continue
            try:
                if row[2] != digest(self._key, self._code, number, *row[:2]):
                    raise Damaged("its checksum is another")
                found[number] = unpack(*row[:2])
            except Damaged:
                bad.append(number)
        if bad:
            with self._transaction():
                self._database.executemany("DELETE FROM chunk WHERE number = ?", [(number,) for number in bad])
        return found, bad

    def _save(self, number, arrays):
        with self._transaction():
            self._put(number, arrays)
            self._database.execute("DELETE FROM claim WHERE number = ?", (number,))

    def _put(self, number, arrays):
        form, content = pack(arrays)
        row = number, form, content, digest(self._key, self._code, number, form, content)
        self._database.execute("INSERT OR REPLACE INTO chunk VALUES (?, ?, ?, ?)", row)

    def _claim(self, numbers, most):
        mine, finished = [], []
        with self._transaction():
            claims = {number: (owner, beat) for number, owner, beat in self._database.execute("SELECT * FROM claim")}
            for number in numbers:
                if len(mine) == most:
                    break
                if self._database.execute("SELECT 1 FROM chunk WHERE number = ?", (number,)).fetchone():
                    finished.append(number)
                elif number not in claims or not self._watch.alive(*claims[number]):
                    mine.append(number)
            rows = [(number, self._me) for number in mine]
            self._database.executemany("INSERT OR REPLACE INTO claim VALUES (?, ?, 0)", rows)
        return mine, finished

    def _beat(self):
        """Show that this process is at work, until it ends."""
        while not self._ended.wait(_BEAT):
            # Whatever is wrong with the file, who computes meets it too, and says so.
            with suppress(sqlite3.Error), closing(self._connect("rw")) as database:
                database.execute("UPDATE claim SET beat = beat + 1 WHERE owner = ?", (self._me,))

    def _safely(self, call, *arguments):
        """The call's result: tried again while others write, and with a new file where this one is damaged."""
        patience, mended = time.monotonic() + _PATIENCE, 0
        while True:
            try:
                if self._database is None:
                    self._open()
                return call(*arguments)
            except (sqlite3.Error, Damaged, MemoryError, UnicodeDecodeError) as error:
                code = getattr(error, "sqlite_errorcode", sqlite3.SQLITE_CORRUPT)
                if code & 0xFF in _BUSY and time.monotonic() < patience:
                    look()
                elif (code & 0xFF in _DAMAGE or code == sqlite3.SQLITE_IOERR_SHORT_READ) and mended < 2:
                    self._set_aside(error)
                    mended += 1
                elif self._database is None and code & 0xFF in {*_DAMAGE, sqlite3.SQLITE_CANTOPEN}:
                    raise self._refused(f"cannot be used as a checkpoint file: {error}") from None
                else:
                    said = f"checkpoint = {self.path!r} cannot be read or written: {error}"
                    raise OSError(f"{said}; what was finished before is kept in it") from None

    def _refused(self, why):
        return ValueError(f"checkpoint = {self.path!r} {why}")

    def _open(self):
        """Connect to the file, begun if there is none, and hold it against what it should be."""
        exists = os.path.exists(self._file)
        if exists and not os.path.isfile(self._file):
            raise self._refused("is no regular file; expected a new file name")
        self._which = _identity(self._file)
        database = self._connect("rw" if exists else "rwc")
        # No content makes this last: a tree whose branches meet again would be walked for ever.
        timer = threading.Timer(8 + (os.path.getsize(self._file) if exists else 0) / 20e6, database.interrupt)
        timer.start()
        try:
            self._database = database
            with self._transaction():
                tables = [sql for (sql,) in database.execute("SELECT sql FROM sqlite_master ORDER BY rowid")]
                self._hold(tables) if tables else self._begin()
        except BaseException:
            database.close()
            self._database = None
            raise
        finally:
            timer.cancel()
        self._which = _identity(self._file)

    def _connect(self, mode):
        place = f"{Path(self._file).as_uri()}?mode={mode}"
        database = sqlite3.connect(place, uri=True, timeout=SLICE, isolation_level=None)
        database.execute("PRAGMA trusted_schema = OFF")
        database.execute("PRAGMA cell_size_check = ON")
        return database

    def _begin(self):
        self._database.execute(f"PRAGMA application_id = {_APPLICATION_ID}")
        for table in _TABLES:
            self._database.execute(table)
        row = self._key, self._code, digest(self._key, self._code)
        self._database.execute("INSERT INTO problem VALUES (?, ?, ?)", row)
        for number, arrays in self._kept.items():
            self._put(number, arrays)

    def _hold(self, tables):
        """Raise `Damaged`, or `ValueError` if the file is whole but another's."""
        (mark,) = self._database.execute("PRAGMA application_id").fetchone()
        if mark != _APPLICATION_ID and not any(MARK in str(sql) for sql in tables):
            raise self._refused("is a database of another program; expected a new file name")
        versions = re.findall(rf"{MARK} (\d+)", str(tables[0]))
        if mark == _APPLICATION_ID and (_FIRST_VERSION in tables or versions not in ([], [str(_VERSION)])):
            raise self._refused("was written by another version of rigsim; expected a new file name")
        if mark != _APPLICATION_ID or tables != _TABLES:
            raise Damaged("its tables are not those of a checkpoint")
        (found,) = self._database.execute("PRAGMA quick_check(1)").fetchone()
        if found != "ok":
            raise Damaged(" ".join(str(found).split()))
        rows = self._database.execute("SELECT key, code, digest FROM problem").fetchall()
        if len(rows) != 1 or rows[0][2] != digest(*rows[0][:2]):
            raise Damaged("it does not say whose it is")
        key, code, _ = rows[0]
        if key != self._key:
            raise self._refused(
                "belongs to another problem; expected the arguments it was begun with, or a new file name"
            )
        if code != self._code:
            raise self._refused(
                "was begun by other code, or on other packages, than compute now; expected those it was begun with, "
                "or a new file name"
            )

    @contextmanager
    def _transaction(self):
        """All that the block does in the file, or nothing; nobody else writes meanwhile."""
        self._database.execute("BEGIN IMMEDIATE")
        try:
            yield
            self._database.execute("COMMIT")
        except BaseException:
            with suppress(sqlite3.Error):
                self._database.execute("ROLLBACK")
            raise

    def _set_aside(self, reason):
        """Rename the damaged file, if it is ours and nobody else did so before; `ValueError` if it is not ours."""
        if self._database is not None:
            self._database.close()
            self._database = None
        if not os.path.exists(self._file) or _identity(self._file) != self._which:
            return
        reason = " ".join(str(reason).split()) or "it asks for too much memory"
        if not _is_ours(self._file):
            raise self._refused(f"cannot be used as a checkpoint file: {reason}") from None
        aside = next(
            name for name in (f"{self._file}.damaged-{n}" for n in itertools.count(1)) if not os.path.exists(name)
        )
        os.rename(self._file, aside)
        for suffix in ("-journal", "-wal", "-shm"):
            with suppress(FileNotFoundError):
                os.rename(self._file + suffix, aside + suffix)
        warnings.warn(
            f"checkpoint = {self.path!r} is damaged ({reason}): it was renamed to {os.path.basename(aside)!r}, and the "
            "work goes on without it",
            RuntimeWarning,
            stacklevel=2,
        )


def _identity(file):
    """What tells a file from one that took its name, None where there is none."""
    try:
        state = os.stat(file)
    except OSError:
        return None
    return state.st_dev, state.st_ino


def _is_ours(file):
    """Whether a damaged file can only be a checkpoint: by its header, by a mark in a row, or since it is all zeros."""
    with open(file, "rb") as opened:
        head = opened.read(100)
        if head[:16] == _MAGIC[: len(head)] and (len(head) < 100 or int.from_bytes(head[68:72]) == _APPLICATION_ID):
            return True
        with mmap.mmap(opened.fileno(), 0, access=mmap.ACCESS_READ) as content:
            return content.find(MARK.encode()) >= 0 or not content[:].strip(b"\0")


def fingerprint(*parts):
    """SHA-256 (hexadecimal str) of the content of nested data.

    Parts are numbers, text, None, arrays, dataclasses, slices, ranges, and dicts, lists and tuples of these.
    `TypeError` if something else is among them, whose content is not known.
    """
    digest = hashlib.sha256()
    _feed(digest, parts)
    return digest.hexdigest()


def _feed(digest, value):
    """Every value as its kind, its length and its content, so that no two meanings give the same bytes."""
    if value is None or isinstance(value, (bool, int, str)):
        text = str(value).encode()
        digest.update(b"%b %d:%b" % (type(value).__name__.encode(), len(text), text))
    elif isinstance(value, (float, complex, np.ndarray, np.generic)):
        array = np.asarray(value)
        if array.dtype.hasobject:
            raise TypeError("an array of Python objects has no content that could be compared")
        digest.update(f"array {array.dtype.str}{array.shape}:".encode() + array.tobytes())
    elif isinstance(value, (list, tuple)):
        digest.update(b"list %d:" % len(value))
        for part in value:
            _feed(digest, part)
    elif isinstance(value, dict):
        digest.update(b"dict ")
        _feed(digest, [part for key in sorted(value) for part in (key, value[key])])
    elif isinstance(value, (slice, range)):
        _feed(digest, (type(value).__name__, value.start, value.stop, value.step))
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        _feed(digest, type(value).__qualname__)
        _feed(digest, {field.name: getattr(value, field.name) for field in dataclasses.fields(value)})
    else:
        raise TypeError(f"a {type(value).__name__} has no content that could be compared")
