"""Every refused input is told in one line: its name, its value, and what is allowed."""

import numpy as np
import pytest

from rigsim import checks


def refused(message, function, *arguments, **options):
    with pytest.raises(ValueError) as caught:
        function(*arguments, **options)
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)


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
    ],
)
def test_refused_number(value, options, message):
    refused(message, checks.real, "c", value, "N s/m", **options)


@pytest.mark.parametrize("value", [3, -0.1, np.nan])
def test_refused_outside_a_closed_range_names_both_ends(value):
    with pytest.raises(ValueError, match=r"s = .* m is not allowed; expected .*0.*2"):
        checks.real("s", value, "m", low=0, high=2)


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
    refused("f is not an array of real numbers", checks.array, "f", ["x"])
    refused("f is not an array of real numbers", checks.array, "f", [[1], [1, 2]])
    refused("H[1, 0] = inf is not allowed; expected a finite number", checks.array, "H", [[0, 0], [np.inf, 0]], ndim=2)


def test_complex_arrays_do_not_lose_their_imaginary_part():
    refused("z is not an array of real numbers", checks.array, "z", [1 + 1j])
