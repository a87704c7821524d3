"""Stopping long work from outside, within a second or two: whoever computes looks up now and then.

Ctrl-C reaches only a process's main thread, and only between two steps of the interpreter. So compiled loops are
called in slices, and between these work in other threads and processes asks here whether it is still wanted.
"""

import os
import signal
import tempfile
import threading
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

SLICE = 0.2  # s that a compiled call should take at most, so that nobody waits long
_heeded = ContextVar("stop", default=None)


class Stopped(BaseException):
    """Long work was asked to end by another thread. No `Exception`, for it is no failure to be dealt with."""


class Stop:
    """Whether some long work shall end. `ask` it, from any thread; what runs under `heeded` then raises `Stopped`.

    Within work that heeds another stop, that one counts too.
    """

    def __init__(self):
        self._event, self._outer = threading.Event(), _heeded.get()

    def ask(self):
        """Have all work under this stop end at its next look."""
        self._event.set()

    @property
    def asked(self):
        """Whether anybody asked this stop, or one around it."""
        return self._event.is_set() or (self._outer is not None and self._outer.asked)

    @contextmanager
    def heeded(self):
        """What this thread does inside ends where the stop is asked."""
        with _heeding(self):
            yield self


@contextmanager
def undisturbed():
    """Ctrl-C waits for what is done inside, which is to be short: a pool that starts processes would leave some."""
    usual, came = signal.getsignal(signal.SIGINT), []
    if threading.current_thread() is not threading.main_thread() or not callable(usual):
        yield
        return
    signal.signal(signal.SIGINT, lambda *_: came.append(True))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, usual)
        if came:
            signal.raise_signal(signal.SIGINT)


class Lease:
    """A stop for other processes of this machine: a file that they look for, in a folder that says where to look."""

    def __init__(self):
        self._folder = tempfile.TemporaryDirectory(prefix="rigsim-lease-")
        self.path = os.path.join(self._folder.name, "lease")
        os.close(os.open(self.path, os.O_CREAT | os.O_WRONLY))

    def ask(self):
        """Have all work under this lease end at its next look."""
        Path(self.path).unlink(missing_ok=True)

    def close(self):
        """Leave nothing behind; to be called when nobody works under this lease any more."""
        self._folder.cleanup()


class Leased:
    """Work for another process, which ends it when the lease of whoever ordered it is gone.

    A process that cannot see the lease's folder is on another machine, and is not stopped.
    """

    def __init__(self, work, lease):
        self.work, self.lease = work, lease.path

    def __call__(self, chunk):
        """What the work makes of a chunk."""
        with _heeding(self if os.path.isdir(os.path.dirname(self.lease)) else None):
            look()
            return self.work(chunk)

    @property
    def asked(self):
        """Whether the lease is gone."""
        return not os.path.exists(self.lease)


def sliced(count, size):
    """Slices of at most ``size`` that cover ``count`` elements, in order, with a look before each."""
    for first in range(0, count, size):
        look()
        yield slice(first, min(first + size, count))


def look():
    """Raise `Stopped` if the work that this thread does was asked to end."""
    stop = _heeded.get()
    if stop is not None and stop.asked:
        raise Stopped("stopped, as was asked")


@contextmanager
def _heeding(stop):
    token = _heeded.set(stop)
    try:
        yield
    finally:
        _heeded.reset(token)
