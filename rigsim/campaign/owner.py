"""Who works at a chunk, and whether that process still lives."""

import json
import os
import socket
import time
from pathlib import Path
from uuid import uuid4

STALE = 60.0  # s without a beat after which an owner counts as gone, wherever it is


def myself():
    """Text that tells this process from every other, also from one of the same number later."""
    me = {"host": socket.gethostname(), "pid": os.getpid(), "since": _since(os.getpid()), "name": uuid4().hex}
    return json.dumps(me)


class Watch:
    """Which owners live: those of this machine are looked for, of others and of stuck ones a beat must be seen."""

    def __init__(self):
        self._seen = {}

    def alive(self, owner, beat):
        """Whether an ``owner`` (text) whose last ``beat`` is that may still be at work."""
        try:
            one = json.loads(owner)
            here, pid, since = one["host"] == socket.gethostname(), int(one["pid"]), one["since"]
        except (ValueError, TypeError, KeyError, OverflowError):
            return False
        if here and not _runs(pid, since):
            return False
        now = time.monotonic()
        if self._seen.get(owner, (None, now))[0] != beat:
            self._seen[owner] = beat, now
        return now - self._seen[owner][1] < STALE


def _runs(pid, since):
    if (began := _since(pid)) is not None:
        return began == since
    if os.name == "nt":  # a signal would end it there
        return True
    try:
        os.kill(pid, 0)
    except PermissionError:
        return True
    except (OSError, OverflowError):
        return False
    return True


def _since(pid):
    """When a process began, in ticks since the machine did, -1 if it has ended; None where that is not told."""
    try:
        text = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return None
    state, *numbers = text.rpartition(")")[2].split()
    return -1 if state in "ZX" else int(numbers[18])
