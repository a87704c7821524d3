"""The house keeps its order: a light front door, one-way imports, documented arguments."""

import ast
import importlib
import inspect
import re
import subprocess
import sys
from pathlib import Path

import pytest

import rigsim

PACKAGE = Path(rigsim.__file__).parent

# Rooms from left to right; a room may import itself and what stands before it. Rooms on one line do not see each other.
ROOMS = [
    {"blas", "compiled"},
    {"checks"},
    {"results"},
    {"parameters"},
    {"campaign"},
    {"model"},
    {"theory", "experiment"},
    {"attraction", "identification"},
    {"orbits"},
    {"design"},
    {"paper"},
    {"present"},
]
RANK = {room: rank for rank, rooms in enumerate(ROOMS) for room in rooms}
# results.Result.plot forwards to present: the one arrow against the flow.
EXCEPTIONS = {("results", "present")}
FRONT = {"__init__.py", "__main__.py", "environment.py", "first_use.py", "places.py", "stopping.py"}


def modules():
    return sorted(
        path.relative_to(PACKAGE) for path in PACKAGE.rglob("*.py") if path.name not in FRONT or path.parent != PACKAGE
    )


def imported_rooms(path):
    """Rooms of rigsim that a module imports, wherever in the file."""
    parts = ("rigsim", *path.parts)
    for node in ast.walk(ast.parse((PACKAGE / path).read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(parts[: len(parts) - node.level]) if node.level else ""
            module = ".".join(filter(None, [base, node.module]))
            names = [f"{module}.{alias.name}" for alias in node.names]
        else:
            continue
        for name in names:
            if name.startswith("rigsim."):
                yield name.split(".")[1]


@pytest.mark.parametrize("path", modules(), ids=str)
def test_imports_flow_one_way(path):
    room = path.parts[0].removesuffix(".py")
    assert room in RANK, f"the room {room} has no place in the order"
    for other in imported_rooms(path):
        allowed = other == room or (room, other) in EXCEPTIONS or other.startswith("__") or RANK[other] < RANK[room]
        assert allowed, f"{path} imports {other}, which does not stand to its left"


def test_import_check_sees_every_form(tmp_path, monkeypatch):
    (tmp_path / "model").mkdir()
    for text in (
        "from ..present import figures",
        "from .. import present",
        "import rigsim.present.figures",
        "def f():\n    from rigsim.present.figures import x",
    ):
        (tmp_path / "model" / "x.py").write_text(text)
        monkeypatch.setattr(sys.modules[__name__], "PACKAGE", tmp_path)
        assert list(imported_rooms(Path("model/x.py"))) == ["present"]


def loaded_by(statement):
    """Top-level names in sys.modules of a fresh Python after the statement."""
    code = f"import sys\n{statement}\nprint(*{{name.partition('.')[0] for name in sys.modules}})"
    done = subprocess.run([sys.executable, "-c", code], cwd=PACKAGE.parent, capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_front_door_is_light():
    third_party = loaded_by("import rigsim, rigsim.environment") - set(sys.stdlib_module_names) - {"rigsim"}
    assert not {name for name in third_party if not name.startswith("_")} - loaded_by("pass")


def test_core_loads_without_plotting():
    rooms = [room for rooms in ROOMS[:-1] for room in rooms]
    homes = {name: re.split("[.:]", home)[0] for name, home in rigsim._HOME.items()}
    statement = "import rigsim\n" + "".join(f"rigsim.{name}\n" for name, home in homes.items() if home in rooms)
    assert not loaded_by(statement) & {"matplotlib", "ipywidgets", "IPython", "nbconvert"}


@pytest.mark.parametrize("name", rigsim.__all__)
def test_public_name_loads(name):
    value, home = getattr(rigsim, name), f"rigsim.{rigsim._HOME[name].replace(':', '.')}"
    if inspect.ismodule(value):
        assert value.__name__ == home
    else:
        assert value.__name__ == name
        assert value.__module__ == home, "the table should name the module the thing is defined in"
    assert name in dir(rigsim)


def test_no_public_name_hides_a_room():
    """`import rigsim.x` sets the attribute x of rigsim: a thing of that name would be gone."""
    assert not {path.parts[0].removesuffix(".py") for path in modules()} & set(rigsim.__all__)
    assert len(rigsim.__all__) <= 60, "the front door is small: calls, and the few results that others write about"


@pytest.mark.parametrize(
    "room", sorted(path.parent for path in PACKAGE.rglob("__init__.py")), ids=lambda room: room.name
)
def test_every_room_says_what_belongs_there(room):
    assert ast.get_docstring(ast.parse((room / "__init__.py").read_text(encoding="utf-8")))


def test_files_hold_one_idea():
    long = {str(path) for path in modules() if len((PACKAGE / path).read_text(encoding="utf-8").splitlines()) > 420}
    assert not long


def test_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no_such_thing"):
        _ = rigsim.no_such_thing


def test_version_is_the_projects():
    tomllib = importlib.import_module("tomllib")
    project = tomllib.loads((PACKAGE.parent / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert rigsim.__version__ == project["version"]


def undocumented(function, text):
    """Arguments of a function that the Parameters section of its numpydoc text does not name."""
    section = re.search(r"^Parameters\n-{3,}\n(.*?)(?=^\w+\n-{3,}\n|\Z)", text, re.M | re.S)
    entries = re.findall(r"^(\S.*?)(?: *:.*)?$", section[1] if section else "", re.M)
    named = {name.strip().lstrip("*") for entry in entries for name in entry.split(",")}
    return [name for name in inspect.signature(function).parameters if name not in named]


def public_things():
    """Names that users reach, and what they are; those of a module that the front door hands on, too."""
    for name in rigsim.__all__:
        value = getattr(rigsim, name)
        yield name, value
        if inspect.ismodule(value):
            yield from ((f"{name}.{inner}", getattr(value, inner)) for inner in value.__all__)


@pytest.mark.parametrize(("name", "public"), list(public_things()))
def test_every_argument_is_documented(name, public):
    assert inspect.getdoc(public), f"{name} has no docstring"
    if inspect.isfunction(public):
        assert not undocumented(public, inspect.getdoc(public))
        return
    for key, method in vars(public).items():
        if inspect.isfunction(method) and not key.startswith("_"):
            assert inspect.getdoc(method), f"{name}.{key} has no docstring"


def test_undocumented_argument_is_seen():
    def sample(a, b, c, *rest, d=1, e=2, f=3, **more):
        """Sum of a, b and f : int.

        Parameters
        ----------
        a, b : float
            Summands, with c : in the text.
        *rest
            More.
        d, e
            See `other`.

        Returns
        -------
        f : float
        """

    assert undocumented(sample, inspect.getdoc(sample)) == ["c", "f", "more"]
    assert undocumented(lambda x: x, "No section.") == ["x"]
