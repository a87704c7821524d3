"""Makes ``environment.lock`` from the pins: ``python tests/lock.py``, or with ``--check`` only audits it.

Needs uv and pip-audit, which are not part of the environment (``pip install uv pip-audit``). uv looks at every
platform and every Python that pyproject.toml allows, and writes the hashes of all files that a version has. What it
finds that is not pinned yet is pinned by hand: packages of the four commands in environment.txt, others in
pyproject.toml.
"""

import re
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LOCK = ROOT / "environment.lock"
EXTRAS = ("test", "browser", "formats")  # those that the commands ask for
HEAD = """\
# The packages that are pinned in environment.txt, and in pyproject.toml for the parts below, with the SHA-256 of every
# file of theirs: what the commands install, and nothing else. Made by tests/lock.py.
"""


def name_of(pin):
    """Name and version of a pin, as every spelling of it has them."""
    name, _, version = re.split(r"[\s;\\]", pin.strip(), maxsplit=1)[0].partition("==")
    return re.sub(r"[-_.]+", "-", name).lower(), version


def pins():
    """What is pinned, by the part that needs it, "base" first."""
    lines = (line.partition("#")[0].strip() for line in (ROOT / "environment.txt").read_text("utf-8").splitlines())
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    base = [line for line in lines if line and not line.startswith("-e")]
    have = {name_of(pin) for pin in base}
    extras = project["optional-dependencies"]
    return {"base": base, **{part: [pin for pin in extras[part] if name_of(pin) not in have] for part in EXTRAS}}


def resolve(wanted):
    """Every package that the pins (str) lead to, on any platform: name and version to requirement with hashes."""
    with tempfile.TemporaryDirectory() as folder:
        asked, locked = Path(folder, "asked.txt"), Path(folder, "locked.txt")
        asked.write_text("\n".join(wanted), "utf-8")
        oldest = re.search(r'requires-python = ">=([\d.]+)"', (ROOT / "pyproject.toml").read_text("utf-8"))[1]
        options = ["--universal", "--python-version", oldest, "--generate-hashes", "--no-annotate", "--no-header"]
        run("uv", "pip", "compile", "--quiet", *options, str(asked), "-o", str(locked))
        text = locked.read_text("utf-8")
    return {name_of(item): item.strip() for item in re.split(r"\n(?=\S)", text) if "==" in item}


def run(*command):
    """Run a tool that is installed beside this Python, or on the path."""
    beside = Path(sys.executable).parent / command[0]
    try:
        return subprocess.run([str(beside) if beside.exists() else command[0], *command[1:]], check=True)
    except FileNotFoundError:
        sys.exit(f"rigsim: {command[0]} is not installed; pip install {command[0]}")
    except subprocess.CalledProcessError as error:
        sys.exit(f"rigsim: {command[0]} failed with status {error.returncode}; see above")


def write():
    """Write the lock, or say what is not pinned."""
    parts = pins()
    found = resolve([pin for part in parts.values() for pin in part])
    asked = {name_of(pin) for part in parts.values() for pin in part}
    if found.keys() - asked:
        missing = ", ".join(found[key].splitlines()[0].rstrip("\\ ") for key in sorted(found.keys() - asked))
        sys.exit(f"rigsim: not pinned: {missing}")
    text = HEAD
    for part, some in parts.items():
        text += f"\n# part: {part}\n" + "".join(found[name_of(pin)] + "\n" for pin in some)
    LOCK.write_text(text, "utf-8")
    print(f"rigsim: {len(asked)} packages, {text.count('--hash')} hashes")


def audit():
    """Ask for known advisories; return the exit status."""
    command = [sys.executable, "-m", "pip_audit", "--require-hashes", "--disable-pip", "--progress-spinner", "off"]
    done = subprocess.run([*command, "-r", str(LOCK)], capture_output=True, text=True)
    unknown = done.stdout.count("could not be audited")
    if unknown or "Error" in done.stderr:
        print(
            f"rigsim: advisories not checked, {unknown or 'all'} packages unknown to the database or it is out of reach"
        )
        return 1
    print(done.stdout or done.stderr)
    return done.returncode


if __name__ == "__main__":
    if sys.argv[1:] != ["--check"]:
        write()
    sys.exit(audit())
