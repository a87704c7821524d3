"""Set-ups that went wrong: each ends in one line, or is mended unasked, and the next run works."""

import hashlib
import os
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.test_commands import one_line, run, small_tree

pytestmark = [pytest.mark.full, pytest.mark.skipif(os.name == "nt", reason="its troubles are POSIX ones")]


@pytest.fixture(scope="module")
def shelf(tmp_path_factory):
    """A folder of wheels that stands for the package index: one small package."""
    folder = tmp_path_factory.mktemp("shelf")
    metadata = "Metadata-Version: 2.1\nName: small\nVersion: 1.0\n"
    with zipfile.ZipFile(folder / "small-1.0-py3-none-any.whl", "w") as wheel:
        wheel.writestr("small.py", "")
        wheel.writestr("small-1.0.dist-info/METADATA", metadata)
        wheel.writestr("small-1.0.dist-info/WHEEL", "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n")
        wheel.writestr("small-1.0.dist-info/RECORD", "small.py,,\n")
    return folder


@pytest.fixture
def tree(tmp_path, shelf):
    """A source tree with one package to install."""
    return filled(small_tree(tmp_path / "tree"), shelf)


def filled(root, shelf, digest=None):
    (wheel,) = shelf.glob("*.whl")
    digest = digest or hashlib.sha256(wheel.read_bytes()).hexdigest()
    (root / "environment.txt").write_text("small==1.0\n")
    (root / "environment.lock").write_text(
        f"# part: base\nsmall==1.0 --hash=sha256:{digest}\n# part: test\n# part: browser\n# part: formats\n"
    )
    return root


@pytest.fixture
def command(shelf):
    """`python3 -m rigsim bench` in a tree, with these settings besides."""

    def call(root, **settings):
        return run(root, "bench", **{"PIP_NO_INDEX": "1", "PIP_FIND_LINKS": str(shelf)} | settings)

    return call


def works(done, root):
    assert done.returncode == 0, done.stderr
    assert done.stdout.split()[:2] == ["ran", "with"]
    place = Path(done.stdout.split("ran with ")[1].strip())
    assert place == (root / ".venv").resolve() and list(place.glob("lib/python*/site-packages/small.py"))


BEFORE = "the .venv of before stays as it was"
# What is broken in a tree that has an environment, and the words of the line that says so.
REFUSED = {
    "wrong hash": (lambda root, shelf: filled(root, shelf, "0" * 64), ("small", "another hash", BEFORE)),
    "no lock": (lambda root, shelf: (root / "environment.lock").unlink(), ("has no environment.lock",)),
    "lock of other bytes": (lambda root, shelf: (root / "environment.lock").write_bytes(b"\xff\xfe\0"), ("lock",)),
    "pins that mean nothing": (
        lambda root, shelf: (root / "environment.txt").write_text("small = 1.0 ???\n"), ("small = 1.0 ???",),
    ),
    "no project": (lambda root, shelf: (root / "pyproject.toml").unlink(), ("has no pyproject.toml",)),
    "package nowhere": (
        lambda root, shelf: [
            path.write_text(path.read_text().replace("1.0", "2.0"))
            for path in (root / "environment.txt", root / "environment.lock")
        ],
        ("small==2.0", BEFORE),
    ),
}  # fmt: skip


def test_what_cannot_be_made_is_one_line_and_keeps_what_works(tree, shelf, command):
    works(command(tree), tree)
    before = (tree / ".venv").resolve()
    kept = {path: path.read_bytes() for path in tree.iterdir() if path.is_file() and path.suffix in (".txt", ".lock")}
    kept[tree / "pyproject.toml"] = (tree / "pyproject.toml").read_bytes()
    for damage, words in REFUSED.values():
        damage(tree, shelf)
        one_line(command(tree), *words)
        assert (tree / ".venv").resolve() == before and list(before.glob("lib/python*/site-packages/small.py"))
        for path, content in kept.items():
            path.write_bytes(content)
        works(command(tree), tree)
        assert (tree / ".venv").resolve() == before, "nothing had to be made again"


def site_packages(root):
    return next((root / ".venv").resolve().glob("lib/python*/site-packages"))


def relink(root, target):
    (root / ".venv").unlink()
    (root / ".venv").symlink_to(target)


def odd_lock(root):
    (root / ".venv.lock").unlink(missing_ok=True)
    (root / ".venv.lock").mkdir()
    (site_packages(root) / "small.py").unlink()


MENDED = {
    "package gone": lambda root: (site_packages(root) / "small.py").unlink(),
    "metadata gone": lambda root: shutil.rmtree(site_packages(root) / "small-1.0.dist-info"),
    "link to nowhere": lambda root: relink(root, "nowhere"),
    "link to itself": lambda root: relink(root, ".venv"),
    "python gone": lambda root: ((root / ".venv").resolve() / "bin" / "python").unlink(),
    "stamp of other bytes": lambda root: ((root / ".venv").resolve() / "rigsim-stamp.json").write_bytes(b"[\xff"),
    "a folder for a lock file": odd_lock,
}


def test_what_is_damaged_is_made_again_unasked(tree, command):
    works(command(tree), tree)
    for damage in MENDED.values():
        damage(tree)
        done = command(tree)
        works(done, tree)
        assert "Traceback" not in done.stderr


def test_settings_that_would_send_packages_elsewhere_do_not(tree, command, tmp_path):
    file = tmp_path / "pip.conf"
    file.write_text(f"[global]\nuser = true\n[install]\ntarget = {tmp_path / 'away'}\nno-binary = :all:\n")
    settings = {"PIP_CONFIG_FILE": str(file), "PIP_TARGET": str(tmp_path / "away"), "PIP_USER": "1"}
    works(command(tree, **settings, PIP_REQUIRE_VIRTUALENV="1", PIP_DRY_RUN="1"), tree)
    assert not (tmp_path / "away").exists()


def test_a_home_and_a_temporary_folder_that_are_not_there(tree, command, tmp_path):
    works(command(tree, HOME=str(tmp_path / "none"), TMPDIR=str(tmp_path / "nowhere")), tree)


@pytest.mark.parametrize("name", ["with space", "ümlaut %20#'é", '"quoted"'])
def test_odd_names_of_the_folder(tmp_path, shelf, command, name):
    root = filled(small_tree(tmp_path / name), shelf)
    works(command(root), root)


def test_a_name_that_no_python_path_can_hold(tmp_path, shelf, command):
    root = filled(small_tree(tmp_path / "a:b"), shelf)
    one_line(command(root), "rename that folder")
    root = root.rename(tmp_path / "ab")
    works(command(root), root)


def test_killed_while_it_is_made(tree, command):
    code = "import sys, runpy; sys.argv = ['rigsim', 'bench']; runpy.run_module('rigsim', run_name='__main__')"
    base = getattr(sys, "_base_executable", sys.executable)
    variables = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "RIGSIM_ENVIRONMENT")}
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    for seconds in (0.3, 1.2, 2.5):
        process = subprocess.Popen([base, "-c", code], cwd=tree, env=variables, **quiet)
        time.sleep(seconds)
        process.send_signal(signal.SIGKILL)
        process.wait()
    works(command(tree), tree)
    end = time.monotonic() + 20  # what a killed one had started may still write for a while
    while len(list(tree.glob(".venv-*"))) > 1 and time.monotonic() < end:
        time.sleep(0.5)
        (site_packages(tree) / "small.py").unlink()
        works(command(tree), tree)
    assert len(list(tree.glob(".venv-*"))) == 1


@contextmanager
def small_disk(folder, megabytes):
    folder.mkdir()
    options = ["-t", "tmpfs", "-o", f"size={megabytes}m", "tmpfs", str(folder)]
    if shutil.which("mount") is None or subprocess.run(["mount", *options], capture_output=True).returncode:
        pytest.skip("a small disk can be had by the administrator only")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)


def test_disk_full(tmp_path, shelf, command):
    with small_disk(tmp_path / "disk", 6) as disk:
        root = filled(small_tree(disk / "tree"), shelf)
        one_line(command(root), "full", "make room")
        assert not list(root.glob(".venv-*")), "nothing half made takes up the room"
        subprocess.run(["mount", "-o", "remount,size=200m", str(disk)], check=True)
        works(command(root), root)


def test_how_many(tell):
    alone = 8  # settings, home, four names, a kill, a full disk: tests of their own
    tell(f"{len(REFUSED) + len(MENDED) + alone} broken set-ups: one line each or mended, and all work at the next run")
