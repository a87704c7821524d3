"""Input checks shared by every room: one line that names quantity, value and range."""

import math

import numpy as np


def real(name, value, unit="", *, low=-math.inf, high=math.inf, low_open=False):
    """Return ``value`` as a float inside [low, high], or (low, high] if ``low_open``.

    Raises
    ------
    ValueError
        If the value is no finite real number, or lies outside the range.
    """
    wanted = _range(low, high, low_open, unit)
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{name} = {value!r} is not a number; expected {wanted}") from None
    below = number <= low if low_open else number < low
    if not math.isfinite(number) or below or number > high:
        raise ValueError(f"{name} = {digits(number)}{_space(unit)} is not allowed; expected {wanted}")
    return number


def positive(name, value, unit=""):
    """Return ``value`` as a finite float above zero; see `real`."""
    return real(name, value, unit, low=0.0, low_open=True)


def integer(name, value, *, low, high=math.inf):
    """Return ``value`` as an int inside [low, high], or raise `ValueError`."""
    number = real(name, value, low=low, high=high)
    if number != int(number):
        raise ValueError(f"{name} = {digits(number)} is not allowed; expected a whole number")
    return int(number)


def one_of(name, value, allowed):
    """Return ``value`` if it is one of ``allowed``, else raise `ValueError`."""
    if value not in allowed:
        raise ValueError(f"{name} = {value!r} is not allowed; expected one of {', '.join(map(repr, allowed))}")
    return value


def array(name, values, unit="", *, low=-math.inf, high=math.inf, low_open=False, ndim=1, min_size=1):
    """Return ``values`` as a float array of ``ndim`` dimensions and ``min_size`` elements or more, all as `real` wants.

    A scalar is widened to one dimension. `ValueError` names the first element that is not allowed.
    """
    try:
        result = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"{name} is not an array of real numbers") from None
    if result.ndim == 0 and ndim == 1:
        result = result.reshape(1)
    if result.ndim != ndim:
        raise ValueError(f"{name} has {result.ndim} dimensions; expected {ndim}")
    if result.size < min_size:
        raise ValueError(f"{name} has {result.size} elements; expected at least {min_size}")
    with np.errstate(invalid="ignore"):
        below = result <= low if low_open else result < low
        bad = ~np.isfinite(result) | below | (result > high)
    if bad.any():
        first = tuple(int(i) for i in np.argwhere(bad)[0])
        place = ", ".join(map(str, first))
        raise ValueError(
            f"{name}[{place}] = {digits(result[first])}{_space(unit)} is not allowed; "
            f"expected {_range(low, high, low_open, unit)}"
        )
    return result


def digits(value):
    """A number as text, with every digit that tells it from a limit close by."""
    return f"{value:.15g}"


def _space(unit):
    return f" {unit}" if unit else ""


def _range(low, high, low_open, unit):
    if low == -math.inf and high == math.inf:
        return "a finite number" + (f" (in {unit})" if unit else "")
    if high == math.inf:
        text = f"a finite number {'above' if low_open else 'of at least'} {digits(low)}"
    elif low == -math.inf:
        text = f"a finite number of at most {digits(high)}"
    else:
        between = ("above", "and at most") if low_open else ("from", "to")
        text = f"a number {between[0]} {digits(low)} {between[1]} {digits(high)}"
    return text + _space(unit)
