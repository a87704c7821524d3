"""Folders that hold environments: which is the current one, who uses one, and what may go.

Each is below the source tree, is called ``.venv-...`` and never moves; ``.venv`` is a link to the current one. Standard
library only, and readable by an old Python, like `rigsim.environment`.
"""

import hashlib
import json
import os
import shutil
import sys
import time
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None

PINNED = ("environment.txt", "environment.lock", "pyproject.toml")  # what an environment is made of
_STAMP, _NEW, _USED = "rigsim-stamp.json", "rigsim-not-linked", "rigsim-used"
_held = {}  # open files that say which environments this process uses


def begin(root):
    """Return an empty folder for a new environment, in use by this process."""
    place = root / f".venv-{time.time_ns() // 1000:x}"
    place.mkdir()
    for name in (_USED, _NEW):
        (place / name).touch()
    _hold(place)
    return place


def give_up(place):
    """Remove a folder that did not become an environment."""
    _let_go(place)
    shutil.rmtree(str(place), ignore_errors=True)


def stamp(root, place, parts):
    """Say what a folder holds: written last, so whatever stops the making, the next call starts afresh."""
    contents = {"key": _key(root), "parts": sorted(parts), "files": _packages(place)}
    new = place / (_STAMP + ".new")
    new.write_text(json.dumps(contents), encoding="utf-8")
    os.replace(str(new), str(place / _STAMP))


def current(root):
    """Folder and parts ("base" and extras) of a whole and current environment; no parts if there is none."""
    link = root / ".venv"
    for place in [Path(os.path.realpath(str(link))), *sorted(found.parent for found in root.glob(f".venv-*/{_NEW}"))]:
        _hold(place)
        parts = _installed(root, place)
        if parts:
            return place, parts
        _let_go(place)
    return link, set()


def _installed(root, place):
    """Parts of an environment; empty if it is not the one that is wanted, or not whole."""
    try:
        stamp = json.loads((place / _STAMP).read_text(encoding="utf-8"))
        if stamp["key"] != _key(root) or not python_of(place).exists():
            return set()
        found = _packages(place, count=Path(sys.prefix).resolve() != place)  # whoever is inside has been counted
        whole = all(name in found and found[name] in (None, size) for name, size in stamp["files"].items())
        return set(stamp["parts"]) if whole else set()
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return set()


def _key(root):
    """What an environment depends on: its pins, the project file, the Python and the place (it cannot move)."""
    parts = [(root / name).read_bytes() for name in PINNED]
    parts += [sys.version.encode(), str(root).encode("utf-8", "surrogateescape")]
    return hashlib.sha256(b"\0".join(parts)).hexdigest()


def python_of(place):
    """Path of the interpreter of an environment."""
    return place / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def _packages(place, count=True):
    """What stands in site-packages, and of each the number of files and bytes, or None if they are not counted."""
    found = [place / "Lib" / "site-packages"] if os.name == "nt" else sorted(place.glob("lib/python3*/site-packages"))
    entries = [entry for folder in found for entry in os.scandir(str(folder)) if entry.name != "__pycache__"]
    return {entry.name: _size(entry) if count else None for entry in entries}


def _size(entry):
    if not entry.is_dir():
        return [1, entry.stat().st_size]
    sizes = [_size(inner) for inner in os.scandir(entry.path) if inner.name != "__pycache__"]
    return [sum(column) for column in zip(*sizes, strict=True)] or [0, 0]


def link(root, place):
    """Let ``.venv`` lead to an environment; what it was before is put aside, and removed only if it was ours."""
    path, new = root / ".venv", root / (place.name + ".link")
    if path.is_symlink() and Path(os.path.realpath(str(path))) == place and not (place / _NEW).exists():
        return
    try:
        if not path.is_symlink() and path.exists():
            if _is_run(path):  # by a command of an earlier version, which needs it where it is
                return
            aside = root / f".venv-before-{time.time_ns() // 1000:x}"
            os.rename(str(path), str(aside))
            if not _is_ours(aside):
                print(f"rigsim: .venv was not made by rigsim; it is {aside.name} now", file=sys.stderr, flush=True)
        os.symlink(place.name, str(new))
        os.replace(str(new), str(path))
        (place / _NEW).unlink()
    except OSError:  # nobody needs the link: a place that is marked as new is found without
        pass


def _is_ours(place):
    return any((place / name).exists() for name in (_STAMP, _USED, "setup.log"))


def _is_run(folder):
    """Whether a process was started as a program below the folder, where that can be told (Linux)."""
    begin = str(folder).encode("utf-8", "surrogateescape") + b"/"
    for found in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            if found.read_bytes().startswith(begin):
                return True
        except OSError:  # gone, or another's
            pass
    return False


def clear(root, current):
    """Remove environments that were replaced, or half made, and that no command uses."""
    for place in root.glob(".venv-*"):
        if place.is_symlink() and place.suffix == ".link":  # one that was not finished
            place.unlink()
        elif place != current and _is_ours(place) and not _in_use(place):
            give_up(place)


def _hold(place):
    """Say that this process, and what it starts, uses an environment, for as long as they run."""
    try:
        file = os.open(str(place / _USED), os.O_RDWR if os.access(str(place / _USED), os.W_OK) else os.O_RDONLY)
    except OSError:  # not one of ours
        return
    try:
        if fcntl:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        os.set_inheritable(file, True)
        _held.setdefault(place, []).append(file)
    except OSError:  # it is being removed, or locks are unknown here
        os.close(file)


def _let_go(place):
    for file in _held.pop(place, []):
        os.close(file)


def _in_use(place):
    """Whether a command uses an environment; if not, it is ours alone until the file is gone with its folder."""
    try:
        if not fcntl:
            (place / _USED).unlink()  # refused while anyone has it open
            return False
        file = os.open(str(place / _USED), os.O_RDWR | os.O_CREAT, 0o644)
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            os.close(file)
            raise
        _held.setdefault(place, []).append(file)
        return False
    except FileNotFoundError:
        return False
    except OSError:
        return True


class lock:
    """Keeps two setups of one tree apart; let go by the operating system however the process ends."""

    def __init__(self, root):
        self.path = root / ".venv.lock"

    def __enter__(self):
        try:
            self.file = os.open(str(self.path), os.O_RDWR | os.O_CREAT, 0o644)
        except OSError:
            self.file = os.open(str(self.path), os.O_RDONLY)  # whatever it is, it can be locked
        waiting = False
        while not self._taken():
            if not waiting:
                print("rigsim: another process is making .venv; waiting for it", file=sys.stderr, flush=True)
                waiting = True
            time.sleep(1)
        return self

    def _taken(self):
        try:
            if fcntl:
                fcntl.flock(self.file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            else:
                import msvcrt

                msvcrt.locking(self.file, msvcrt.LK_NBLCK, 1)
            return True
        except (BlockingIOError, PermissionError):
            return False

    def __exit__(self, *_):
        os.close(self.file)
