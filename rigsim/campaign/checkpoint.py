"""The ``checkpoint=`` keyword of long work: finished chunks in one file, kept whole or not at all."""

import dataclasses
import hashlib
import io
import os
import sqlite3

import numpy as np

# Marks the file as ours in SQLite's header ("RIGS").
_APPLICATION_ID = 0x52494753


class Checkpoint:
    """Finished chunks of one problem in a SQLite file; a context manager.

    Each chunk is committed by itself, so a killed process loses only the chunk it was at. Arrays are kept in NumPy's
    own format, bit for bit and without pickles. ``path`` is continued, or begun if it does not exist; ``key`` is the
    `fingerprint` of the problem and ``code`` the `code.code_fingerprint` of what computes the chunks. `ValueError` if
    the file belongs to another problem or to other code, is no checkpoint, or cannot be opened.
    """

    def __init__(self, path, key, code):
        self.path = os.fspath(path)
        try:
            self._database = sqlite3.connect(self.path, timeout=30.0)
            try:
                self._open(key, code)
            except BaseException:
                self._database.close()
                raise
        except sqlite3.DatabaseError as error:
            raise ValueError(f"checkpoint = {self.path!r} cannot be used as a checkpoint file: {error}") from None

    def _open(self, key, code):
        with self._database:  # one transaction: two processes may begin at once
            self._database.execute("BEGIN IMMEDIATE")
            if not self._database.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]:
                self._database.execute(f"PRAGMA application_id = {_APPLICATION_ID}")
                self._database.execute("CREATE TABLE problem (key TEXT, code TEXT)")
                self._database.execute("CREATE TABLE chunk (number INTEGER PRIMARY KEY, arrays BLOB)")
                self._database.execute("INSERT INTO problem VALUES (?, ?)", (key, code))
            elif self._database.execute("PRAGMA application_id").fetchone()[0] != _APPLICATION_ID:
                raise ValueError(
                    f"checkpoint = {self.path!r} is a database of another program; expected a new file name"
                )
            elif self._database.execute("SELECT key FROM problem").fetchone()[0] != key:
                raise ValueError(
                    f"checkpoint = {self.path!r} belongs to another problem; expected the arguments it was begun with, "
                    "or a new file name"
                )
            elif self._database.execute("SELECT code FROM problem").fetchone()[0] != code:
                raise ValueError(
                    f"checkpoint = {self.path!r} was begun by other code, or on other packages, than compute now; "
                    "expected those it was begun with, or a new file name"
                )

    def load(self):
        """Finished chunks as a dict of number to dict of arrays."""
        return {number: _unpack(blob) for number, blob in self._database.execute("SELECT number, arrays FROM chunk")}

    def save(self, number, arrays):
        """Keep chunk ``number``, a dict of arrays."""
        with self._database:
            self._database.execute("INSERT OR REPLACE INTO chunk VALUES (?, ?)", (number, _pack(arrays)))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._database.close()


def _pack(arrays):
    buffer = io.BytesIO()
    np.savez(buffer, **arrays, allow_pickle=False)
    return buffer.getvalue()


def _unpack(blob):
    with np.load(io.BytesIO(blob), allow_pickle=False) as arrays:
        return dict(arrays)


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
