"""Makes ``.venv`` from ``environment.txt`` and moves the running command into it.

Standard library only, and written so that an old Python can at least read it and say that it is too old.
"""

import hashlib
import importlib.util
import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

OLDEST = (3, 11)
ROOT = Path(__file__).resolve().parent.parent
VARIABLE = "RIGSIM_ENVIRONMENT"

# What pip's log says when the package index cannot be reached; an index that is there lists versions.
_NO_NETWORK = ("NewConnectionError", "ConnectTimeout", "Connection refused", "ProxyError", "(from versions: none)")
_HEARTBEAT = 10.0  # seconds between signs of life


class SetupError(Exception):
    """The environment cannot be made; the message is one line for the user."""


def enter(extras=(), root=ROOT):
    """Return inside an environment that has everything, starting this command again in ``.venv`` if need be.

    Parameters
    ----------
    extras : sequence of str
        Optional dependencies of pyproject.toml that are needed too.
    root : pathlib.Path
        The source tree.

    Raises
    ------
    SetupError
        If this Python is too old, the environment cannot be made, or another rigsim stands before this tree's.
    """
    if sys.version_info < OLDEST:
        raise SetupError(_too_old())
    # For this tree's rigsim in all that is started from here, whatever else is installed or in the way.
    others = [place for place in os.environ.get("PYTHONPATH", "").split(os.pathsep) if place not in ("", str(root))]
    os.environ["PYTHONPATH"] = os.pathsep.join([str(root), *others])
    if os.environ.get(VARIABLE, "") == "current":
        _refuse_others(root)
        return
    if os.environ.get(VARIABLE, ""):
        raise SetupError(f"{VARIABLE}={os.environ[VARIABLE]} is not allowed; leave it unset, or set it to 'current'")
    if not (root / "environment.txt").is_file():
        raise SetupError(
            f"{root} has no environment.txt; the commands need rigsim's source tree (a clone), not an installed copy"
        )
    python = prepare(root, extras)
    if Path(sys.prefix).resolve() != (root / ".venv").resolve():
        _start_again(python)
    _refuse_others(root)


def _refuse_others(root):
    """Raise a `SetupError` if what is started in notebooks/ would import another rigsim than the tree's."""
    code = "import importlib.util as u; print(u.find_spec('rigsim').origin)"
    folder = root / "notebooks" if (root / "notebooks").is_dir() else root
    found = subprocess.run([sys.executable, "-c", code], cwd=str(folder), stdout=subprocess.PIPE, text=True).stdout
    if Path(found.strip()).resolve() != (root / "rigsim" / "__init__.py").resolve():
        raise SetupError(f"{found.strip()} hides the rigsim of {root} from the notebooks; move or rename it")


def prepare(root, extras=()):
    """Make ``.venv`` below ``root`` if it is missing, stale or half made; return its Python (str).

    The stamp is written last, so whatever stops the making, the next call starts afresh.
    """
    venv = root / ".venv"
    python = str(venv / ("Scripts/python.exe" if os.name == "nt" else "bin/python"))
    wanted = {"base", *extras}
    if wanted <= _installed(root, python):
        return python
    with _lock(root):
        installed = _installed(root, python)  # perhaps made by another process while this one waited
        if not wanted <= installed:
            _make(root, python, installed, wanted)
    return python


def _make(root, python, installed, wanted):
    venv, begun = root / ".venv", time.monotonic()

    def say(text):
        print(f"rigsim: {text} ({time.monotonic() - begun:.0f} s)", file=sys.stderr, flush=True)

    missing = sorted(wanted - installed)
    requirements = _requirements(root, missing)
    if installed:  # only extras are missing
        (venv / "rigsim-stamp.json").unlink()
        say(f"adding what {' and '.join(missing)} needs to .venv")
    else:
        lacking = [name for name in ("ensurepip", "venv") if importlib.util.find_spec(name) is None]
        if lacking:
            raise SetupError(
                f"this Python has no {lacking[0]}, which is needed to make .venv; on Debian or Ubuntu run "
                "'sudo apt install python3-venv', elsewhere use a complete Python, then give the same command again"
            )
        say("making .venv, which takes a minute or two the first time")
        _remove(venv)
        venv.mkdir()
        # The base interpreter, since this one may be the .venv that is being replaced.
        base = getattr(sys, "_base_executable", None) or sys.executable
        _run([base, "-m", "venv", str(venv)], root, venv / "setup.log", say)
        requirements = ["-r", "environment.txt", *requirements]
        say("installing the packages of environment.txt")
    # Without --compile only what is imported gets compiled, which saves a quarter of the time.
    command = [python, "-m", "pip", "install", "--no-input", "--no-compile", "--disable-pip-version-check"]
    _run([*command, *requirements], root, venv / "setup.log", say)
    stamp = {
        "key": _key(root),
        "parts": sorted(wanted | installed),
        "files": sorted(_site_packages(python)),
    }
    (venv / "rigsim-stamp.new").write_text(json.dumps(stamp), encoding="utf-8")
    os.replace(str(venv / "rigsim-stamp.new"), str(venv / "rigsim-stamp.json"))
    if not installed and (root / "rigsim" / "first_use.py").is_file():
        say("compiling what the notebooks use")
        try:
            _run([python, "-m", "rigsim.first_use"], root, venv / "setup.log", say)
        except SetupError as error:
            say(f"not all was compiled ahead, so first uses will: {error}")
    say("the environment is ready")


def _installed(root, python):
    """Parts of a complete and current ``.venv``: "base" and extras; empty if it must be made."""
    try:
        stamp = json.loads((root / ".venv" / "rigsim-stamp.json").read_text(encoding="utf-8"))
        whole = stamp["key"] == _key(root) and set(stamp["files"]) <= _site_packages(python)
        return set(stamp["parts"]) if whole and os.path.exists(python) else set()
    except (OSError, ValueError, KeyError, TypeError):
        return set()


def _key(root):
    """What the environment depends on: its pins, the project file, the Python and the place (it cannot move)."""
    parts = [(root / name).read_bytes() for name in ("environment.txt", "pyproject.toml")]
    parts += [sys.version.encode(), str(root).encode()]
    return hashlib.sha256(b"\0".join(parts)).hexdigest()


def _site_packages(python):
    prefix = Path(python).parent.parent
    found = [prefix / "Lib" / "site-packages"] if os.name == "nt" else list(prefix.glob("lib/python3*/site-packages"))
    return {name for folder in found for name in os.listdir(str(folder)) if name != "__pycache__"}


def _requirements(root, extras):
    import tomllib  # here, since a Python that is too old has none

    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return [item for extra in extras for item in project.get("optional-dependencies", {}).get(extra, [])]


def _run(command, root, log, say):
    """Run a step of the setup, its output in ``log``, with a sign of life now and then."""
    settings = {
        name: value for name, value in os.environ.items() if name not in ("PYTHONHOME", "PIP_TARGET", "PIP_PREFIX")
    }
    settings.update(PIP_USER="0", PYTHONUNBUFFERED="1")
    with log.open("ab") as output:
        start = output.tell()
        process = subprocess.Popen(
            command, cwd=str(root), env=settings, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT
        )
        try:
            while True:
                try:
                    process.wait(_HEARTBEAT)
                    break
                except subprocess.TimeoutExpired:
                    say(f"  {_stage(log)}")
        finally:
            if process.poll() is None:
                process.terminate()
                process.wait()
    if process.returncode:
        with log.open("rb") as text:
            text.seek(start)
            raise SetupError(_why(text.read().decode("utf-8", "replace"), log))


def _stage(log):
    """How far pip, or what compiles after it, has come, by its log."""
    text = log.read_bytes().decode("utf-8", "replace")
    last = text.rstrip().rpartition("\n")[2]
    if last.startswith("compiling "):  # as `rigsim.first_use` says
        return last
    if "Installing collected packages" in text:
        return "putting the packages in place"
    return f"fetching packages, {text.count('Collecting ')} so far"


def _why(text, log):
    if any(sign in text for sign in _NO_NETWORK):
        return (
            "the packages could not be fetched, no connection to the package index; check the network, the proxy and "
            f"pip's settings, then give the same command again (pip's log: {log})"
        )
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    errors = [line for line in lines if "Error" in line or line.startswith("ERROR:")] or lines or ["no output"]
    return f"setting up .venv failed, {errors[-1][:200]}; mend that, then give the same command again (log: {log})"


def _remove(venv):
    try:
        if venv.is_symlink() or venv.is_file():
            venv.unlink()
        elif venv.exists():
            shutil.rmtree(str(venv))
    except OSError as error:
        raise SetupError(
            f"{venv} is stale and could not be removed ({error.strerror}); delete it and try again"
        ) from None


class _lock:
    """Keeps two setups of one tree apart; let go by the operating system however the process ends."""

    def __init__(self, root):
        self.path = root / ".venv.lock"

    def __enter__(self):
        import sqlite3

        try:
            self.connection = sqlite3.connect(str(self.path), timeout=0, isolation_level=None)
            waiting = False
            while True:
                try:
                    self.connection.execute("BEGIN EXCLUSIVE")
                    return self
                except sqlite3.OperationalError as error:
                    if "locked" not in str(error):
                        raise
                if not waiting:
                    print("rigsim: another process is making .venv; waiting for it", file=sys.stderr, flush=True)
                    waiting = True
                time.sleep(1)
        except sqlite3.Error as error:
            raise SetupError(f"{self.path.parent} cannot be written ({error}); the commands make .venv there") from None

    def __exit__(self, *_):
        self.connection.close()


def _start_again(python):
    """Run the same command with ``python`` in this process's place."""
    command = [python, "-m", "rigsim", *sys.argv[1:]]
    sys.stdout.flush()
    settings = {name: value for name, value in os.environ.items() if name != "PYTHONHOME"}
    if os.name == "nt":  # where exec would return to the prompt at once
        sys.exit(subprocess.call(command, env=settings))
    os.execve(python, command, settings)


def _too_old():
    names = [f"python3.{minor}" for minor in range(14, OLDEST[1] - 1, -1)]
    newer = next((name for name in names if shutil.which(name)), None)
    advice = f"this machine has {newer}: use that" if newer else "install a newer Python"
    version = ".".join(map(str, sys.version_info[:3]))
    return f"Python {OLDEST[0]}.{OLDEST[1]} or newer is needed, and {sys.executable} is {version}; {advice}"
