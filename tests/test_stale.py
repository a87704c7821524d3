"""Nothing stale: nothing that ruff finds, no import that leads nowhere, no module, name or dependency unused."""

import ast
import importlib
import json
import re
import subprocess
import sys
import tomllib
from functools import cache
from importlib.metadata import packages_distributions
from importlib.util import find_spec
from pathlib import Path

import pytest

import rigsim

ROOT = Path(rigsim.__file__).parents[1]
PACKAGE = ROOT / "rigsim"
MODULES = sorted(path.relative_to(ROOT) for path in PACKAGE.rglob("*.py"))
TESTS = sorted(path.relative_to(ROOT) for path in (ROOT / "tests").rglob("*.py"))
RUN = (
    "__init__.py",
    "__main__.py",
    "first_use.py",
    *(path.name for path in (PACKAGE / "experiment/formats/child").glob("*.py")),
)  # started by name
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]

# What DESIGN promises to users; any other public name is there because a notebook or the README uses it.
PROMISED = {
    "OscillatorParameters", "RigParameters", "Status", "frequency_response", "FrequencyResponse", "folds", "Fold",
    "jump_frequencies", "detached_curves", "DetachedCurve", "force_scenario", "ForceEvent", "response_sheet",
    "periodic_orbits", "OrbitBranch", "SpecialPoint", "continue_orbit", "attractors", "tolerance_study", "basins",
    "tap_map", "simulate", "Record", "random_test", "sine_test", "SineTest", "Tap", "identify", "Identification",
}  # fmt: skip
# Needed without an import of ours, and by what.
SILENT = {
    "jupyterlab": "python3 -m rigsim lab starts it",
    "h5netcdf": "xarray's engine, by name",
    "pytest": "runs the tests",
    "pytest-xdist": "runs them side by side",
    "nbval": "runs the notebooks as tests",
    "ruff": "reads the code",
    "execnet": "pytest-xdist's, pinned for the lock",
    "sortedcontainers": "hypothesis's, likewise",
    "greenlet": "playwright's, likewise",
}
FOR_USERS = {"Gap"}  # a law of `identification.terms` that rigsim itself tries on no record
PEERS = {
    "contique",
    "exudyn",
    "llsi",
    "pyHarm",
    "sippy_unipi",
}  # of tests/benchmarks/peers, in an environment of their own


@pytest.mark.parametrize("how", [("check", "--quiet", "--output-format=concise"), ("format", "--diff", "--quiet")])
def test_ruff_finds_nothing(how):
    """Style, unused code, complexity, docstrings; see pyproject.toml."""
    command = [sys.executable, "-m", "ruff", how[0], "--no-cache", *how[1:], "."]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


@cache
def tree(path):
    return ast.parse((ROOT / path).read_text(encoding="utf-8"))


@cache
def told():
    """Code that shows how rigsim is used: the notebooks' cells and the README's blocks."""
    texts = re.findall(r"(?s)```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"))
    for path in sorted((ROOT / "notebooks").glob("*.ipynb")):
        cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
        texts += ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    return [ast.parse(re.sub(r"(?m)^\s*[%!].*$", "", text)) for text in texts]


def module_name(path):
    return ".".join(path.with_suffix("").parts).removesuffix(".__init__")


def imports(path):
    """(module, name or None) of each import, wherever in the file."""
    parts = module_name(path).split(".") + ["*"] * (path.name == "__init__.py")
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Import):
            yield from ((alias.name, None) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(parts[: len(parts) - node.level]) if node.level else ""
            yield from ((".".join(filter(None, [base, node.module])), alias.name) for alias in node.names)


def leads_somewhere(module, name):
    try:
        found = importlib.import_module(module)
        return name is None or hasattr(found, name) or find_spec(f"{module}.{name}") is not None
    except ImportError:
        return False


@pytest.mark.parametrize("path", MODULES + TESTS, ids=str)
def test_every_import_leads_somewhere(path):
    """Those inside functions too, which nothing else would try."""
    own = [one for one in imports(path) if one[0].split(".")[0] in ("rigsim", "tests")]
    nowhere = [one for one in own if not leads_somewhere(*one)]
    assert not nowhere


def test_stale_imports_are_seen():
    assert leads_somewhere("rigsim.paper", "printed") and leads_somewhere("rigsim", "folds")
    assert not leads_somewhere("rigsim.paper", "present") and not leads_somewhere("rigsim.nothing", None)


def test_every_module_is_imported_by_another():
    wanted = {f"rigsim.{home.replace(':', '.')}" for home in rigsim._HOME.values()}
    for path in MODULES:
        for module, name in imports(path):
            wanted |= {module, f"{module}.{name}"}
    alone = {module_name(path) for path in MODULES if path.name not in RUN} - wanted
    assert not alone


def spoken(node):
    """Names that a piece of code reads, calls, imports, or writes as a word (as `plots` and getattr do)."""
    if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
        yield node.id
    elif isinstance(node, ast.Attribute):
        yield node.attr
    elif isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.isidentifier():
        yield node.value


def passes_on(path, node):
    """Whether this is only a door: ``__all__``, or the import of a name that an ``__init__`` hands on."""
    door = path.name == "__init__.py"
    listed = isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") in ("__all__", "_HOME")
    return door and (listed or isinstance(node, ast.ImportFrom))


@cache
def used():
    """Every name that the package, what times it, the notebooks or the README make use of."""
    paths = MODULES + [path for path in TESTS if "benchmarks" in path.parts]
    bodies = [node for path in paths for node in tree(path).body if not passes_on(path, node)] + told()
    return {name for body in bodies for node in ast.walk(body) for name in spoken(node)}


def defined(path):
    """Functions, classes and constants of a module, and the private methods of its classes."""
    for node in tree(path).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield node.name
            inner = node.body if isinstance(node, ast.ClassDef) else []
            names = [one.name for one in inner if isinstance(one, ast.FunctionDef)]
            yield from (name for name in names if name.startswith("_"))
        elif isinstance(node, ast.Assign):
            names = [one.id for target in node.targets for one in ast.walk(target) if isinstance(one, ast.Name)]
            yield from names


@pytest.mark.parametrize("path", MODULES, ids=str)
def test_every_name_is_used(path):
    """A test alone keeps nothing alive."""
    ours = {name for name in defined(path) if not re.fullmatch(r"__\w+__|_repr_\w+_|_HOME", name)}
    unused = ours - used() - set(rigsim.__all__) - FOR_USERS
    assert not unused


def test_every_public_name_is_promised_or_used():
    shown = {name for body in told() for node in ast.walk(body) for name in spoken(node)}
    shown |= {alias.name for body in told() for node in ast.walk(body) if isinstance(node, ast.ImportFrom)
              for alias in node.names}  # fmt: skip
    lost, needless = PROMISED - set(rigsim.__all__), set(rigsim.__all__) - PROMISED - shown
    assert not lost and not needless


def distribution(requirement):
    return re.match(r"[\w.-]+", requirement)[0].lower().replace("_", "-")


def third_party(paths):
    """Distributions that the imports of these files need."""
    known = packages_distributions()
    names = {module.split(".")[0] for path in paths for module, _ in imports(path)}
    names -= {*sys.stdlib_module_names, "rigsim", "tests", *PEERS, *(path.stem for path in paths)}
    return {distribution(one) for name in names for one in known.get(name, [name])}


def test_dependencies_are_those_imported():
    declared = {distribution(one) for one in PROJECT["dependencies"]}
    extra = {distribution(one) for many in PROJECT["optional-dependencies"].values() for one in many}
    ours, theirs = third_party(MODULES), third_party(TESTS)
    formats = {distribution(one) for one in PROJECT["optional-dependencies"]["formats"]}  # asked for when they are used
    undeclared, idle = ours - declared - formats, declared - ours - set(SILENT)
    assert not undeclared and not idle
    undeclared, idle = theirs - declared - extra, extra - theirs - set(SILENT)
    assert not undeclared and not idle
    assert set(SILENT) <= declared | extra


def test_environment_pins_what_is_declared():
    lines = (ROOT / "environment.txt").read_text(encoding="utf-8").splitlines()
    pins = {distribution(line) for line in lines if "==" in line}
    assert {distribution(one) for one in PROJECT["dependencies"]} <= pins
