"""Machine code follows the source it came from: no edit leaves old numbers, and nothing is compiled twice."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import rigsim
from rigsim import compiled

PACKAGE = Path(rigsim.__file__).parent
SINE = "rigsim.sine_test(rigsim.RigParameters(), 3.18, 20.0, duration=1).tilt[0]"
STATICS = "rigsim.static_equilibrium(rigsim.RigParameters()).coordinates[1]"
CUBIC = "rigsim.frequency_response(rigsim.RigParameters(), 3.18, [20.0]).relative[0, 0]"


def run(folder, code, **settings):
    """What a new Python in the folder prints, and its lines on standard error."""
    environment = {**os.environ, "PYTHONPATH": str(folder), **settings}
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=folder, env=environment, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.split(), done.stderr.splitlines()


@pytest.fixture
def house(tmp_path):
    """A copy of the package, with the machine code that stands beside it."""
    return Path(shutil.copytree(PACKAGE, tmp_path / "rigsim"))


def number(house, expression):
    """A number from a copy of the package, and whether it had to be compiled."""
    code = f"import numpy, rigsim\nprint(rigsim.__file__, repr(complex({expression})))"
    (place, value), errors = run(house.parent, code)
    assert Path(place).parent == house
    return complex(value), bool(errors)


def edit(path, old, new):
    text = path.read_text(encoding="utf-8")
    assert text.count(old) == 1
    path.write_text(text.replace(old, new), encoding="utf-8")


@pytest.mark.parametrize(
    ("expression", "edits"),
    [
        (SINE, [("model/planar.py", "-wire.k * stretch", "-1.5 * wire.k * stretch"),
                ("model/planar.py", "-rig.m * rig.gravity", "-0.5 * rig.m * rig.gravity")]),
        (CUBIC, [("theory/cubic.py", "4.0 * zeta_s * zeta_s * X", "5.0 * zeta_s * zeta_s * X")]),
    ],
    ids=["rig", "cubic"],
)  # fmt: skip
def test_every_edit_moves_the_numbers_of_warm_code(house, expression, edits):
    first, _ = number(house, expression)
    assert number(house, expression) == (first, False)
    shutil.copytree(house, house.parent / "elsewhere" / "rigsim")
    assert number(house.parent / "elsewhere" / "rigsim", expression) == (first, False)  # copied, not compiled again
    kept = names(house)
    for file, old, new in edits:
        before = (house / file).read_text(encoding="utf-8")
        edit(house / file, old, new)
        second, compiling = number(house, expression)
        assert compiling and abs(second - first) > 1e-4 * abs(first)
        assert number(house, expression) == (second, False)
        assert len(names(house)) <= len(kept)  # old code makes room for new
        (house / file).write_text(before, encoding="utf-8")
    assert number(house, expression) == (first, True)
    assert names(house) <= kept


def names(house):
    return {path.name for path in (house / "__pycache__" / "compiled").iterdir()}


def test_numba_is_imported_by_what_needs_it_only():
    code = "import sys, rigsim.compiled, rigsim.theory.cubic, rigsim.model.planar\nprint('numba' in sys.modules)"
    assert run(PACKAGE.parent, code) == (["False"], [])


def test_without_a_place_to_keep_it_code_is_compiled_and_one_line_says_so(house):
    shutil.rmtree(house / "__pycache__")
    (house / "__pycache__").write_text("no folder, as an installed rigsim may have none to write to")
    code = f"import rigsim\nprint(repr({STATICS}))"
    settings = {"HOME": os.devnull, "XDG_CACHE_HOME": "", "NUMBA_CACHE_DIR": ""}
    for _ in range(2):
        value, errors = run(house.parent, code, **settings)
        assert len(value) == 1 and len(errors) == 1
        assert errors[0].startswith("rigsim: compiling") and "every time" in errors[0]


# A small package of compiled functions, whose numbers follow each kind of thing that compiled code can use.
SMALL = {
    "numbers.py": "STEP = 1.0\ndef plain(x):\n    return x + 1.0\n",
    "code.py": """\
import math
import numpy as np
from rigsim.compiled import compiled, inlinable
from . import numbers
FACTOR = 2.0
TABLE = np.array([1.0, 2.0])

@inlinable
def scaled(x):
    return FACTOR * x

@inlinable
def twice(x):
    return scaled(scaled(x))

@compiled
def inner(x):
    return twice(x) + TABLE[1] + numbers.STEP

@compiled(nogil=True)
def outer(x):
    \"\"\"What it does.\"\"\"
    return math.sqrt(inner(x)) + 1.0
""",
}


@pytest.fixture
def small(tmp_path):
    (tmp_path / "small").mkdir()
    (tmp_path / "small" / "__init__.py").touch()
    for name, text in SMALL.items():
        (tmp_path / "small" / name).write_text(text)
    return tmp_path


def small_numbers(small):
    code = "import sys\nfrom small import code\n"
    code += "print(code.twice(3.0), 'numba' in sys.modules, code.outer(3.0), code.twice(3.0))"
    (one, numba, two, again), errors = run(
        small, code, PYTHONPATH=f"{small}{os.pathsep}{PACKAGE.parent}", NUMBA_CACHE_DIR=str(small / "cache")
    )
    assert one == again and numba == "False"
    return float(one), float(two), bool(errors)


def test_whatever_compiled_code_uses_it_is_compiled_anew_when_that_changes(small):
    assert small_numbers(small) == (12.0, 15**0.5 + 1, True)
    assert small_numbers(small) == (12.0, 15**0.5 + 1, False)
    edit(small / "small" / "numbers.py", "x + 1.0", "x + 2.0")  # which no compiled code uses
    assert small_numbers(small) == (12.0, 15**0.5 + 1, False)
    for file, old, new, expected in (
        ("code.py", "FACTOR = 2.0", "FACTOR = 3.0", (27.0, 30**0.5 + 1)),
        ("code.py", "[1.0, 2.0]", "[1.0, 6.0]", (12.0, 19**0.5 + 1)),
        ("code.py", "FACTOR * x", "FACTOR * x - 1.0", (9.0, 12**0.5 + 1)),
        ("code.py", "TABLE[1]", "TABLE[0]", (12.0, 14**0.5 + 1)),
        ("numbers.py", "STEP = 1.0", "STEP = 4.0", (12.0, 18**0.5 + 1)),
    ):
        edit(small / "small" / file, old, new)
        assert small_numbers(small) == (*expected, True), new
        edit(small / "small" / file, new, old)


def cut(data):
    return data[:100]


def flipped(data):
    middle = len(data) // 2
    return data[:middle] + bytes([data[middle] ^ 1]) + data[middle + 1 :]


@pytest.mark.parametrize("damage", [cut, flipped, lambda data: b""], ids=["cut", "one bit flipped", "emptied"])
def test_a_damaged_file_is_compiled_again(small, damage):
    small_numbers(small)
    for path in next((small / "cache").iterdir()).iterdir():
        path.write_bytes(damage(path.read_bytes()))
    assert small_numbers(small) == (12.0, 15**0.5 + 1, True)


def test_code_of_functions_that_are_no_more_is_dropped(house):
    folder = house / "__pycache__" / "compiled"
    folder.mkdir(parents=True, exist_ok=True)
    (house / "theory" / "__pycache__").mkdir(exist_ok=True)
    stale = [
        folder / "theory.gone.solve-0-0",
        folder / "model.planar.gone-0-0",
        folder / "model.planar.conservative_forces-0-0",
        house / "theory" / "__pycache__" / "cubic.solve-106.py311.1.nbc",
    ]
    for path in stale:
        path.touch()
    edit(house / "model" / "planar.py", "-wire.k * stretch", "-1.5 * wire.k * stretch")
    number(house, STATICS)
    assert not [path for path in stale if path.exists()]


def test_a_compiled_function_is_documented_and_travels_by_name():
    from rigsim.model.planar import conservative_forces

    assert isinstance(conservative_forces, compiled.Compiled)
    assert conservative_forces.__name__ == "conservative_forces"
    assert conservative_forces.__doc__.startswith("Generalised forces")
    code = "import pickle\nfrom rigsim.model.planar import conservative_forces as f\n"
    assert run(PACKAGE.parent, code + "print(pickle.loads(pickle.dumps(f)) is f)") == (["True"], [])


def test_ctrl_c_waits_while_numba_calls_python_and_comes_right_after():
    """Raised there it would crash numba's wrapping code, or be lost."""

    def called_by_machine_code(number):
        signal.raise_signal(signal.SIGINT)
        reached.append(number)
        return number + 1

    reached, usual = [], signal.getsignal(signal.SIGINT)
    function = compiled.Compiled(called_by_machine_code, {})
    function._dispatcher = called_by_machine_code
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        assert function(1) == 2 and reached == [1]
        with pytest.raises(KeyboardInterrupt):
            time.sleep(5)
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        assert function(1) == 2 and signal.getsignal(signal.SIGINT) == signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, usual)
