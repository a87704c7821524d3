"""Every refused input is told in one line: its name, its value, and what is allowed; and what is checked is used."""

import ast
import datetime
import os
import warnings
from concurrent.futures import ThreadPoolExecutor
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import rigsim
from rigsim import checks

PACKAGE = Path(rigsim.__file__).parent


def refused(message, function, *arguments, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ValueError) as caught:
            function(*arguments, **options)
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 500


def test_values_inside_the_range_come_back_as_floats():
    assert checks.real("c", np.int64(3), low=3, high=3) == 3.0
    assert type(checks.real("c", np.float32(0.5))) is float
    assert checks.positive("m", 5e-324) > 0
    assert checks.integer("order", 4.0, low=2) == 4
    assert type(checks.integer("order", np.float64(4), low=2)) is int
    assert checks.one_of("hold", "zero", ("zero", "linear")) == "zero"


@pytest.mark.parametrize(
    ("value", "options", "message"),
    [
        (-1, {"low": 0}, "c = -1 N s/m is not allowed; expected a finite number of at least 0 N s/m"),
        (0, {"low": 0, "low_open": True}, "c = 0 N s/m is not allowed; expected a finite number above 0 N s/m"),
        (np.nan, {"low": 0}, "c = nan N s/m is not allowed; expected a finite number of at least 0 N s/m"),
        (np.inf, {}, "c = inf N s/m is not allowed; expected a finite number (in N s/m)"),
        ("a lot", {}, "c = 'a lot' is not a number; expected a finite number (in N s/m)"),
        (None, {}, "c = None is not a number; expected a finite number"),
        ([1, 2], {}, "c = [1, 2] is not a number; expected a finite number"),
        (1j, {}, "c = 1j is not a number; expected a finite number"),
        (
            1e300,
            {},
            "c = 1e+300 N s/m is not allowed; expected a finite number (in N s/m), as a rig may have it: at most",
        ),
    ],
)
def test_refused_number(value, options, message):
    refused(message, checks.real, "c", value, "N s/m", **options)


@pytest.mark.parametrize("value", [3, -0.1, np.nan])
def test_refused_outside_a_closed_range_names_both_ends(value):
    with pytest.raises(ValueError, match=r"s = .* m is not allowed; expected .*0.*2"):
        checks.real("s", value, "m", low=0, high=2)


# What a number may come as, all worth three, and what looks like one.
THREES = (
    3, 3.0, np.float32(3), np.int8(3), np.uint64(3), np.array(3), np.array(3.0), Decimal(3), Fraction(6, 2),
    xr.DataArray(3.0), xr.DataArray(3.0, attrs={"units": "N"}),
)  # fmt: skip
NO_NUMBERS = (
    "3.18", b"3", "a\nb", True, np.False_, 1j, np.complex128(3), None, np.ma.masked, np.ma.array(1.0, mask=True),
    np.array(1.0, dtype=object), np.array("3"), datetime.date(2020, 1, 1), np.datetime64("2020"), pd.NA,
    np.timedelta64(3, "s"), pd.Timestamp("2020"), {3.0}, [3.0], np.array([3.0]), {}, 10**5000, Decimal("sNaN"),
    Ellipsis, int, pd.Series([3.0]), range(3), np.zeros((300, 3)), xr.DataArray(3.0, attrs={"units": "mN"}),
)  # fmt: skip


@pytest.mark.parametrize("value", THREES, ids=repr)
def test_a_number_of_any_kind_is_converted(value):
    assert checks.real("force", value, "N") == 3.0 and type(checks.real("force", value, "N")) is float
    assert checks.integer("n", value, low=0) == 3 and type(checks.integer("n", value, low=0)) is int
    np.testing.assert_array_equal(checks.array("force", value, "N"), [3.0])


@pytest.mark.parametrize("value", NO_NUMBERS, ids=lambda value: " ".join(checks.shown(value).split())[:40])
def test_what_is_no_number_is_refused_in_one_line(value):
    refused("force", checks.real, "force", value, "N")
    if not isinstance(value, (int, xr.DataArray)) or isinstance(value, bool):
        refused("n = ", checks.integer, "n", value, low=0)
    if not isinstance(value, (xr.DataArray, pd.Series, list)) and not (
        isinstance(value, np.ndarray) and value.size == 1
    ):
        refused("force", checks.array, "force", [1.0, value], "N")
    refused("hold = ", checks.one_of, "hold", value, ("zero", 1))


def test_no_digit_of_a_whole_number_is_lost():
    for value in (2**53 + 1, 2**64 + 1, np.uint64(2**63 + 1), Decimal(2**70 + 1), Fraction(2**70 + 1)):
        assert checks.integer("seed", value, low=0) == int(value)
    assert checks.integer("seed", 2.0**53, low=0) == 2**53
    refused("seed = 1.8014398509481984e+16 is not allowed", checks.integer, "seed", 2.0**54, low=0)
    refused("seed = Decimal('1E+999999') is not allowed", checks.integer, "seed", Decimal("1e999999"), low=0)
    assert checks.seed("seed", 2**128 - 1) == 2**128 - 1
    refused("seed = ", checks.seed, "seed", 2**128)
    generator = np.random.default_rng(1)
    assert checks.seed("seed", generator, generator=True) is generator
    refused("seed = ", checks.seed, "seed", generator)


def test_refused_whole_number_and_choice():
    refused("order = 2.5 is not allowed; expected a whole number", checks.integer, "order", 2.5, low=1)
    refused(
        "hold = 'first' is not allowed; expected one of 'zero', 'linear'",
        checks.one_of,
        "hold",
        "first",
        ("zero", "linear"),
    )
    with pytest.raises(ValueError, match="order = 0 .*at least 1"):
        checks.integer("order", 0, low=1)
    refused("period = True is not allowed; expected one of 1, 2", checks.one_of, "period", True, (1, 2))
    assert checks.one_of("period", np.float32(2), (1, 2)) == 2 and checks.flag("on", np.True_) is True
    refused("on = 1 is not allowed; expected one of False, True", checks.flag, "on", 1)


def test_arrays():
    assert checks.array("f", 3).shape == (1,)
    assert checks.array("f", [1, 2]).dtype == float
    assert checks.array("H", np.eye(2), ndim=2).shape == (2, 2)
    given = np.ones(3)
    assert checks.array("f", given) is given, "a large record is not copied"
    refused(
        "f[1] = 0 Hz is not allowed; expected a finite number above 0 Hz",
        checks.array, "f", [1, 0, -1], "Hz", low=0, low_open=True,
    )  # fmt: skip
    refused("z[2] = nan m is not allowed; expected a finite number", checks.array, "z", [0, 1, np.nan], "m")
    refused("f has 2 dimensions; expected 1", checks.array, "f", np.eye(2))
    refused("f has 0 elements; expected at least 1", checks.array, "f", [])
    refused("f has 3 elements; expected at least 9", checks.array, "f", [1, 2, 3], min_size=9)
    refused("f has 3 elements; expected 2", checks.array, "f", [1, 2, 3], size=2)
    refused("f is not an array of real numbers", checks.array, "f", ["x"])
    refused("f is not an array of real numbers", checks.array, "f", [[1], [1, 2]])
    refused("H[1, 0] = inf is not allowed; expected a finite number", checks.array, "H", [[0, 0], [np.inf, 0]], ndim=2)
    refused("f = 1e+300 Hz is not allowed", checks.array, "f", [1, 1e300], "Hz")
    assert checks.array("f", [1, 1e300], "Hz", physical=False)[1] == 1e300


def test_complex_arrays_do_not_lose_their_imaginary_part():
    refused("z is not an array of real numbers", checks.array, "z", [1 + 1j])
    np.testing.assert_array_equal(checks.lines("z", [1 + 1j, 2]), [1 + 1j, 2])
    np.testing.assert_array_equal(checks.lines("z", 3), [3 + 0j])
    refused("z[0] = nan is not allowed", checks.lines, "z", [np.nan + 1j])
    assert np.isnan(checks.lines("z", [np.nan, 1j], finite=False)).tolist() == [True, False]
    refused("z is not an array of real numbers", checks.lines, "z", [1j, "2"])


@pytest.mark.parametrize(
    "values", [(1, 2), range(1, 3), np.arange(1, 3, dtype="i1"), pd.Series([1, 2]), pd.Series([1, 2], dtype="Int64"),
               [Decimal(1), Fraction(2)], np.float16([1, 2]), np.ma.array([1.0, 2.0], mask=[0, 0]),
               xr.DataArray([1.0, 2.0], attrs={"units": "Hz"})], ids=lambda values: type(values).__name__,
)  # fmt: skip
def test_an_array_of_any_kind_is_converted(values):
    found = checks.array("f", values, "Hz")
    assert found.dtype == float and found.tolist() == [1.0, 2.0]


@pytest.mark.parametrize(
    "values", [{1.0, 2.0}, (i for i in (1, 2)), {"a": 1}, None, "12", [True, 1.0], np.array([True]), [1j, 1], [1, "2"],
               np.ma.array([1.0, 2.0], mask=[0, 1]), [1.0, np.ma.masked], np.array([object()]), np.zeros(2, "M8[s]"),
               np.zeros(2, [("a", float)]), pd.Series([1, None], dtype="Int64"), pd.Series(["a", "b"]), 1j,
               xr.DataArray([1.0, 2.0], attrs={"units": "kHz"})], ids=lambda values: type(values).__name__,
)  # fmt: skip
def test_an_array_of_something_else_is_refused(values):
    refused("f", checks.array, "f", values, "Hz")


def test_a_large_array_is_checked_without_copies():
    import tracemalloc

    values = np.ones(1_000_000)
    tracemalloc.start()
    try:
        checks.array("f", values, "Hz", low=0.0)
        assert tracemalloc.get_traced_memory()[1] < 1e5
    finally:
        tracemalloc.stop()


def test_pairs_and_several():
    assert checks.pair("band", np.array([5, 80]), "Hz") == (5.0, 80.0)
    for given in ([80, 5], [5, 5], [5], [1, 2, 3], range(1, 40)):
        refused("band = ", checks.pair, "band", given, "Hz")
    refused("band[0] = 0 Hz", checks.pair, "band", [0, 5], "Hz")
    assert checks.names("names", ["a", "b"], ("a", "b")) == ("a", "b")
    refused("names = 'a' is not allowed", checks.names, "names", "a", ("a", "b"))
    refused("names is empty", checks.names, "names", (), ("a", "b"))
    refused("name = 'c'", checks.names, "names", ("a", "c"), ("a", "b"), "name")
    assert checks.integers("n", 3, low=1) == (3,) and checks.integers("n", (3, 4.0), low=1, size=2) == (3, 4)
    refused("n has 3 elements; expected 2", checks.integers, "n", (1, 2, 3), low=1, size=2)
    refused("n = {1, 2}", checks.integers, "n", {1, 2}, low=1)
    assert checks.one_or_many("titles", "a", str, "text") == ["a"]
    assert checks.one_or_many("titles", ("a", "b"), str, "text") == ["a", "b"]
    refused("titles = 1 is not allowed; expected text", checks.one_or_many, "titles", ["a", 1], str, "text")


def test_the_keywords_of_long_work(tmp_path):
    told = []
    with ThreadPoolExecutor(1) as pool:
        running = checks.running(told.append, pool, tmp_path / "points.db")
    assert running == (told.append, pool, str(tmp_path / "points.db"))
    assert checks.running(np.True_, None, None) == (True, None, None)
    for value in ("yes", None, 1, 0, [], int):
        refused("progress = ", checks.progress, value)
    for value in (4, True, "threads", ThreadPoolExecutor, [], {}):
        refused("executor = ", checks.executor, value)
    for value in (
        True,
        "",
        3,
        b"x",
        tmp_path,
        str(tmp_path),
        tmp_path / "none" / "x.db",
        "a\0b",
        os.devnull + "/x",
        {},
    ):
        refused("checkpoint = ", checks.checkpoint, value)


def _is_check(node):
    function = getattr(node, "func", None)
    return (
        isinstance(function, ast.Attribute)
        and getattr(function.value, "id", "") == "checks"
        and function.attr not in ("shown", "digits")
    )


def _values(call):
    """What a call checks: all of `running`, the only argument, or the one after the name."""
    return call.args if call.func.attr == "running" or len(call.args) == 1 else call.args[1:2]


def thrown_away(tree):
    """(line, what) wherever a check's result is not used, or the raw argument is read after it was checked."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and _is_check(node.value):
            yield node.lineno, "a check's result is thrown away"
        if not isinstance(node, ast.FunctionDef):
            continue
        arguments = {a.arg for a in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs)}
        for statement in ast.walk(node):
            if not isinstance(statement, ast.Assign):
                continue
            calls = (call for call in ast.walk(statement.value) if _is_check(call))
            checked = {a.id for call in calls for a in _values(call) if isinstance(a, ast.Name)} & arguments
            kept = {name.id for target in statement.targets for name in ast.walk(target) if isinstance(name, ast.Name)}
            for name in ast.walk(node):
                raw = isinstance(name, ast.Name) and name.id in checked - kept and isinstance(name.ctx, ast.Load)
                if raw and name.lineno > statement.end_lineno:
                    yield name.lineno, f"{name.id} is used as it was given, though it was checked"


@pytest.mark.parametrize("path", sorted(PACKAGE.rglob("*.py")), ids=lambda path: str(path.relative_to(PACKAGE)))
def test_what_is_checked_is_what_is_used(path):
    assert list(thrown_away(ast.parse(path.read_text(encoding="utf-8")))) == []


def test_a_check_thrown_away_is_seen():
    found = thrown_away(ast.parse(
        "def f(a, b, c):\n checks.real('a', a)\n d = checks.array('b', b)\n c = checks.real('c', c)\n return a, b, c, d"
    ))  # fmt: skip
    assert sorted(line for line, _ in found) == [2, 5]
