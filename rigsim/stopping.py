"""Being stopped: what Ctrl-C, SIGTERM and SIGHUP do to a command and to all that it has started, within 2 s.

Standard library only until something has to be swept up, and readable by an old Python, like `rigsim.environment`.
"""

import contextlib
import os
import signal
import subprocess
import sys
import threading
import uuid

MARK = "RIGSIM_COMMAND"  # in the environment of what a command starts: who has it belongs to that command
_ASKED, _TOLD, _LIMIT = 0.6, 0.4, 1.5  # s that what is stopped has to end by itself, when told, and in all
_SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]


class Stopped(KeyboardInterrupt):
    """A signal stopped the command; ``status`` is what it exits with."""

    def __init__(self, number):
        super().__init__()
        self.number = number
        self.status = 1 if number == signal.SIGINT else 128 + number


class listening:
    """While this lasts, the first signal raises `Stopped` and the process ends soon, whatever it is busy with."""

    def __enter__(self):
        self.stopped = None
        self.mark, self.outer = uuid.uuid4().hex, os.environ.get(MARK)
        os.environ[MARK] = " ".join(filter(None, [self.outer, self.mark]))  # a command in a command is both's
        self.before = {number: signal.getsignal(number) for number in _SIGNALS}
        for number, handler in self.before.items():
            if handler != signal.SIG_IGN:  # as under nohup
                signal.signal(number, self._stop)
        return self

    def __exit__(self, *_):
        for number, handler in self.before.items():
            signal.signal(number, handler)
        if self.stopped is not None:  # all is said: no time for what else a long-lived interpreter would take down
            self._end()
        del os.environ[MARK]
        if self.outer:
            os.environ[MARK] = self.outer

    def _stop(self, number, _):
        self.stopped = Stopped(number)
        for other in _SIGNALS:
            signal.signal(other, signal.SIG_IGN)  # what follows takes no longer for being asked twice
        last = threading.Timer(_LIMIT, self._end)
        last.daemon = True
        last.start()
        raise self.stopped

    def _end(self):
        sweep(self.mark, spare=True)
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(OSError, ValueError, AttributeError):  # where the terminal is gone
                stream.flush()
        os._exit(self.stopped.status)


def call(command, folder, defaults=None, spare=False):
    """Run a command to its end and return its exit status; it and all that it started end when this is stopped.

    Parameters
    ----------
    command : sequence of str
    folder : path
    defaults : dict, optional
        Environment variables for what does not set them itself.
    spare : bool
        Spare what the command started in another program than this Python, such as the user's browser.
    """
    variables, mark = dict(defaults or {}, **os.environ), uuid.uuid4().hex
    variables[MARK] = " ".join(filter(None, [os.environ.get(MARK), mark]))
    # What may be inherited is: so the environment counts as used as long as the command runs (`environment`).
    process = subprocess.Popen(command, cwd=str(folder), env=variables, close_fds=False)
    try:
        return process.wait()
    except BaseException as stop:
        if getattr(stop, "number", signal.SIGINT) != signal.SIGINT or not _ends(process, _ASKED):
            process.terminate()  # where a terminal has told it of Ctrl-C, that was not enough
            _ends(process, _TOLD)
        sweep(mark, spare)
        process.kill()
        process.wait()
        raise


def end_group(process):
    """End a process that leads a session of its own, and all in it."""
    for force in (False, True):
        try:
            if os.name == "nt":
                process.kill()
            else:
                os.killpg(process.pid, signal.SIGKILL if force else signal.SIGTERM)
        except OSError:  # none is left
            break
        _ends(process, _TOLD)
    process.wait()


def _ends(process, seconds):
    try:
        process.wait(seconds)
    except subprocess.TimeoutExpired:
        return False
    return True


def sweep(mark, spare=False):
    """Kill every process that has the mark, but this one."""
    try:
        import psutil
    except ImportError:  # before there is an environment, nothing runs that leaves its group
        return
    left = []
    for process in psutil.process_iter():
        try:
            if process.pid == os.getpid() or mark not in process.environ().get(MARK, "").split():
                continue
            if not spare or os.path.samefile(process.exe(), sys.executable):
                process.kill()
                left.append(process)
        except (psutil.Error, OSError):  # another's, or gone
            continue
    psutil.wait_procs(left, timeout=0.3)
