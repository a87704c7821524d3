"""Tries rigsim with the oldest or newest packages that pyproject.toml allows: ``python tests/versions.py oldest``.

Needs uv, which is not part of the environment (``pip install uv``), and the interpreter that ``--python`` asks for. The
environment is made in a temporary folder, of wheels only, and gone afterwards. What runs there are quick
unit tests, which use every dependency but JupyterLab itself; others can be named.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

from lock import ROOT, name_of, run

RESOLUTION = {"oldest": "lowest-direct", "newest": "highest"}
TESTS = (
    "campaign/test_run.py", "experiment", "model", "present/explore/test_explore.py",
    "present/figures/test_identification.py", "present/figures/test_style.py", "present/report",
    "test_blas.py", "test_checks.py", "test_parameters.py", "test_results.py",
)  # fmt: skip


def make(folder, which, python):
    """An environment of pyproject.toml's packages and rigsim itself; return its Python (pathlib.Path)."""
    run("uv", "venv", "--quiet", "--no-python-downloads", "--python", python, str(folder))
    inside = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    install = ("uv", "pip", "install", "--quiet", "--python", str(inside))
    project = str(ROOT / "pyproject.toml")
    run(*install, "-r", project, "--extra", "test", "--only-binary", ":all:", "--resolution", RESOLUTION[which])
    run(*install, "--no-deps", "-e", str(ROOT))
    return inside


def found(inside):
    """Name and version of each dependency as it was installed (str)."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    names = [name_of(re.split(r"[=<>~! ]", one)[0])[0] for one in project["dependencies"]]
    code = "import sys, importlib.metadata as m; print(*(f'{n} {m.version(n)}' for n in sys.argv[1:]), sep=', ')"
    return subprocess.run([inside, "-c", code, *names], capture_output=True, text=True, check=True).stdout.strip()


def main():
    """Make the environment, run the tests in it, say what was found; return pytest's exit status."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("which", choices=RESOLUTION)
    parser.add_argument("--python", default=sys.executable, help="version or path (default: this one)")
    parser.add_argument("tests", nargs="*", help="only these (default: the quick unit tests)")
    args = parser.parse_intermixed_args()
    with tempfile.TemporaryDirectory(prefix="rigsim-versions-") as folder:
        inside = make(Path(folder, "environment"), args.which, args.python)
        print(f"rigsim: {args.which} versions: {found(inside)}", flush=True)
        settings = {
            "RIGSIM_ENVIRONMENT": "current", "PYTHONPATH": str(ROOT), "MPLBACKEND": "agg",
            "NUMBA_CACHE_DIR": str(Path(folder, "compiled")),  # compiled by what is tried, and kept for nobody
        }  # fmt: skip
        tests = args.tests or [str(ROOT / "tests" / name) for name in TESTS]
        command = [inside, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "no:xdist", *tests]
        return subprocess.run(command, cwd=ROOT, env={**os.environ, **settings}).returncode


if __name__ == "__main__":
    sys.exit(main())
