"""Makes the environment of ``environment.lock`` and moves the running command into it.

A new environment is made beside the old one and takes its place when it is whole (`rigsim.places`), so no trouble
takes away what works. Standard library only, and written so that an old Python can at least read it and say that it is
too old.
"""

import ast
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

from . import places, stopping

OLDEST = (3, 11)
ROOT = Path(__file__).resolve().parent.parent
VARIABLE = "RIGSIM_ENVIRONMENT"

# What pip's log says when the package index cannot be reached; an index that is there lists versions.
_NO_NETWORK = ("NewConnectionError", "ConnectTimeout", "Connection refused", "ProxyError", "(from versions: none)")
_ROOM = 1_000_000  # bytes without which nothing can be made
_HEARTBEAT = 10.0  # seconds between signs of life
# Of pip's settings, those that say how to reach an index; the others could send packages elsewhere, or take other ones.
_REACH = (
    "index-url", "extra-index-url", "find-links", "no-index", "trusted-host", "proxy", "cert", "client-cert",
    "timeout", "default-timeout", "retries", "cache-dir", "no-cache-dir", "keyring-provider",
)  # fmt: skip


class SetupError(Exception):
    """The environment cannot be made; the message is one line for the user."""


def enter(extras=(), root=ROOT):
    """Return inside an environment that has everything, starting this command again in one if need be.

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
    if os.pathsep in str(root):
        raise SetupError(f"{root} has {os.pathsep!r} in its name, which no Python path can hold; rename that folder")
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
    if Path(sys.prefix).resolve() != Path(python).parent.parent:
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
    """Have an environment below ``root`` with the packages of the lock, and those of extras; return its Python (str).

    What is there already is left as it is unless the new one is whole.
    """
    wanted = {"base", *extras}
    try:
        place, parts = places.current(root)
        if not wanted <= parts:
            with places.lock(root):
                place, parts = places.current(root)  # perhaps made by another process while this one waited
                if not wanted <= parts:
                    place = _set_up(root, place, parts, wanted)
                places.link(root, place)
                places.clear(root, place)
    except OSError as error:
        raise SetupError(f"{root} cannot be written ({error}); the commands make their environment there") from None
    return str(places.python_of(place))


def _set_up(root, place, parts, wanted):
    """Make an environment, or add what extras need to one; return its folder."""
    begun = time.monotonic()

    def say(text):
        print(f"rigsim: {text} ({time.monotonic() - begun:.0f} s)", file=sys.stderr, flush=True)

    lock = _read_lock(root)
    (root / ".venv.log").write_bytes(b"")
    missing = sorted(wanted - parts)
    unknown = [part for part in missing if part not in lock]
    if unknown:
        raise SetupError(f"environment.lock has no part {unknown[0]}; take the file from the repository again")
    requirements = [line for part in missing for line in lock[part]]
    kept = ""
    try:
        if parts:
            kept = "; .venv stays as it was"
            say(f"adding what {' and '.join(missing)} needs to .venv")
            _install(root, place, requirements, say)
            places.stamp(root, place, wanted | parts)
        else:
            kept = "; the .venv of before stays as it was" if (root / ".venv").exists() else ""
            say("making .venv, which takes a minute or two the first time")
            place = _make(root, requirements, wanted, say)
            if (root / "rigsim" / "first_use.py").is_file():
                _compile(root, place, say)
    except SetupError as error:
        raise SetupError(f"{error}{kept}") from None
    except KeyboardInterrupt as stop:
        stop.add_note(f"what pip has fetched is kept{kept}")
        raise
    say("the environment is ready")
    return place


def _make(root, requirements, parts, say):
    lacking = [name for name in ("ensurepip", "venv") if importlib.util.find_spec(name) is None]
    if lacking:
        raise SetupError(
            f"this Python has no {lacking[0]}, which is needed to make .venv; on Debian or Ubuntu run "
            "'sudo apt install python3-venv', elsewhere use a complete Python, then give the same command again"
        )
    place = places.begin(root)
    try:
        # The base interpreter, since this one may be in the environment that is being replaced.
        base = getattr(sys, "_base_executable", None) or sys.executable
        _run([base, "-m", "venv", str(place)], root, say)
        say("installing the packages of environment.lock")
        _install(root, place, requirements, say)
        if "-e ." in _pins(root):  # rigsim itself, as it lies here
            _pip(root, place, ["--no-deps", "--no-build-isolation", "-e", "."], say)
        places.stamp(root, place, parts)
    except BaseException:
        places.give_up(place)
        raise
    return place


def _install(root, place, requirements, say):
    """Exactly these packages, with the hashes they must have; what an attempt that was stopped left is written over."""
    path = place / "requirements.txt"
    path.write_text("\n".join(requirements) + "\n", encoding="utf-8")
    exact = ["--require-hashes", "--only-binary", ":all:", "--no-deps", "--ignore-installed"]
    _pip(root, place, [*exact, "-r", str(path)], say)


def _compile(root, place, say):
    say("compiling what the notebooks use")
    try:
        _run([str(places.python_of(place)), "-m", "rigsim.first_use"], root, say)
    except SetupError as error:
        say(f"not all was compiled ahead, so first uses will: {error}")


def _read_lock(root):
    """Requirements with hashes by the part that needs them, all those of environment.txt among them."""
    for name in places.PINNED:
        if not (root / name).is_file():
            raise SetupError(f"{root} has no {name}; take the file from the repository again")
    try:
        text = (root / "environment.lock").read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        raise SetupError(f"environment.lock cannot be read ({error}); take it from the repository again") from None
    pieces = re.split(r"^# part: (\w+)\n", text, flags=re.MULTILINE)
    lock = {part: lines.splitlines() for part, lines in zip(pieces[1::2], pieces[2::2], strict=True)}
    locked = {_name(line) for line in lock.get("base", [])}
    for pin in _pins(root):
        if pin != "-e ." and _name(pin) not in locked:
            raise SetupError(
                f"environment.txt has {pin!r}, which environment.lock has not; a pin is name==version, and after a "
                "change 'python tests/lock.py' makes the lock again"
            )
    return lock


def _pins(root):
    lines = (root / "environment.txt").read_text(encoding="utf-8", errors="replace").splitlines()
    return [pin for pin in (line.partition("#")[0].strip() for line in lines) if pin]


def _name(pin):
    """Name and version of a pin, as every spelling of it has them."""
    name, _, version = re.split(r"[\s;\\]", pin.strip(), maxsplit=1)[0].partition("==")
    return re.sub(r"[-_.]+", "-", name).lower(), version


def _pip(root, place, arguments, say):
    """Run pip's install, its scratch below ``place``, by no setting of the user's but how to reach an index."""
    scratch = place / "scratch"
    shutil.rmtree(str(scratch), ignore_errors=True)
    scratch.mkdir()
    settings = {name: value for name, value in _clean().items() if not name.startswith("PIP_")}
    settings.update(dict.fromkeys(("TMPDIR", "TMP", "TEMP"), str(scratch)), PIP_CONFIG_FILE=os.devnull, **_reach(place))
    # Without --compile only what is imported gets compiled, which saves a quarter of the time.
    command = [
        str(places.python_of(place)),
        "-m",
        "pip",
        "install",
        "--no-input",
        "--no-compile",
        "--disable-pip-version-check",
    ]
    _run([*command, *arguments], root, say, settings)
    shutil.rmtree(str(scratch), ignore_errors=True)


def _clean():
    return {name: value for name, value in os.environ.items() if name != "PYTHONHOME"}


def _reach(place):
    """Settings, from pip's files and the environment, that say how to reach an index, as environment variables."""
    command = [str(places.python_of(place)), "-m", "pip", "config", "list"]
    done = subprocess.run(command, env=_clean(), stdin=subprocess.DEVNULL, capture_output=True)
    if done.returncode:
        raise SetupError(_why(done.stderr.decode("utf-8", "replace"), "pip config list"))
    found = {}
    for section in ("global.", "install.", ":env:."):  # the later wins
        for line in done.stdout.decode("utf-8", "replace").splitlines():
            name, _, value = line.partition("=")
            if name.startswith(section) and name[len(section) :] in _REACH:
                found["PIP_" + name[len(section) :].upper().replace("-", "_")] = ast.literal_eval(value)
    return found


def _run(command, root, say, settings=None):
    """Run a step of the setup, its output in ``.venv.log``, with a sign of life now and then."""
    log = root / ".venv.log"
    with log.open("ab") as output:
        start = output.tell()
        # It inherits that the folder is in use: should this process be killed, nobody removes it under the other.
        process = subprocess.Popen(
            command, cwd=str(root), env=dict(settings or _clean(), PYTHONUNBUFFERED="1"), stdin=subprocess.DEVNULL,
            stdout=output, stderr=subprocess.STDOUT, start_new_session=True, close_fds=False,
        )  # fmt: skip
        try:
            while True:
                try:
                    process.wait(_HEARTBEAT)
                    break
                except subprocess.TimeoutExpired:
                    say(f"  {_stage(log, start)}")
        finally:
            if process.poll() is None:
                stopping.end_group(process)
    if process.returncode:
        if shutil.disk_usage(str(root)).free < _ROOM:  # which may have kept the log from saying so
            raise SetupError(f"the disk of {root} is full; make room (about 1 GB), then give the same command again")
        with log.open("rb") as text:
            text.seek(start)
            raise SetupError(_why(text.read().decode("utf-8", "replace"), log))


def _stage(log, start):
    """How far pip, or what compiles after it, has come, by its log."""
    text = log.read_bytes()[start:].decode("utf-8", "replace")
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
    if any("DO NOT MATCH THE HASHES" in line for line in lines):
        wrong = next((line.rstrip(":") for line in lines if " from http" in line or " from file" in line), "a package")
        return (
            f"{wrong.split(' from ')[0]} has another hash than environment.lock says, and was not installed; take that "
            f"file from the repository again, or ask who serves your package index (log: {log})"
        )
    errors = [line for line in lines if "Error" in line or line.startswith("ERROR:")] or lines or ["no output"]
    return f"setting up .venv failed, {errors[-1][:200]}; mend that, then give the same command again (log: {log})"


def _start_again(python):
    """Run the same command with ``python`` in this process's place."""
    command = [python, "-m", "rigsim", *sys.argv[1:]]
    sys.stdout.flush()
    if os.name == "nt":  # where exec would return to the prompt at once
        sys.exit(subprocess.call(command, env=_clean(), close_fds=False))
    os.execve(python, command, _clean())


def _too_old():
    names = [f"python3.{minor}" for minor in range(14, OLDEST[1] - 1, -1)]
    newer = next((name for name in names if shutil.which(name)), None)
    advice = f"this machine has {newer}: use that" if newer else "install a newer Python"
    version = ".".join(map(str, sys.version_info[:3]))
    return f"Python {OLDEST[0]}.{OLDEST[1]} or newer is needed, and {sys.executable} is {version}; {advice}"
