"""Input checks shared by every room: one line that names quantity, value and range.

Each check returns the value that is to be used. Converting is part of the check, so that nothing passes in one form and
is computed with in another; a test holds that no check's result is thrown away.
"""

import math
import operator
import os
import reprlib
from datetime import date, timedelta
from decimal import Decimal
from fractions import Fraction
from numbers import Real

import numpy as np

_EXACT = 2**53  # whole floats beyond it may have lost digits
_LARGEST = 2**1024  # of a decimal that becomes an int: "1e999999999" would fill the memory
# What no rig has and no bench can do, by unit: the least of what must be above zero, and the most. Between them nothing
# overflows.
_PHYSICAL = {
    "kg": (1e-20, 1e9), "m": (1e-20, 1e6), "s": (1e-15, 1e9), "N": (1e-20, 1e12), "Hz": (1e-12, 1e9), "rad": (0.0, 1e6),
    "m/s": (0.0, 1e6), "m/s^2": (0.0, 1e12), "N/m": (1e-20, 1e20), "N/m^3": (0.0, 1e40), "N s/m": (0.0, 1e15),
    "N m s/rad": (0.0, 1e15), "V": (0.0, 1e9),
}  # fmt: skip
_FEW = 6  # values of an array that are shown
_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = _SHORT.maxlong = 80
# Of no order, or gone once looked at: no sequence of values.
_NO_SEQUENCE = (str, bytes, bytearray, set, frozenset, dict)


def real(name, value, unit="", *, low=-math.inf, high=math.inf, low_open=False):
    """Return ``value`` as a float inside [low, high], or (low, high] if ``low_open``.

    Allowed are real numbers of Python's and NumPy's kinds, decimals and fractions, and arrays of no dimension. Text,
    truth values, complex and masked numbers and dates are none.

    Raises
    ------
    ValueError
        If the value is no finite real number, or lies outside the range, or says that it is in another unit.
    """
    wanted = _range(low, high, low_open, unit)
    _same_unit(name, value, unit)
    if not _is_real(value):
        raise ValueError(f"{name} = {shown(value)} is not a number; expected {wanted}")
    try:
        with np.errstate(over="ignore"):
            number = float(value)
    except (OverflowError, TypeError, ValueError):
        raise ValueError(f"{name} = {shown(value)} is not allowed; expected {wanted}") from None
    below = number <= low if low_open else number < low
    if not math.isfinite(number) or below or number > high:
        raise ValueError(f"{name} = {digits(number)}{_space(unit)} is not allowed; expected {wanted}")
    _physical(name, number, number, unit, low_open and low == 0, wanted)
    return number


def positive(name, value, unit=""):
    """Return ``value`` as a finite float above zero; see `real`."""
    return real(name, value, unit, low=0.0, low_open=True)


def integer(name, value, *, low, high=math.inf):
    """Return ``value`` as an int inside [low, high], every digit of it, or raise `ValueError`.

    Whole numbers of other kinds are allowed, floats among them up to 2^53, from where on they may have lost digits.
    """
    wanted = f"a whole number {f'of at least {low}' if high == math.inf else f'from {low} to {high}'}"
    if not _is_real(value):
        raise ValueError(f"{name} = {shown(value)} is not a number; expected {wanted}")
    try:
        number = operator.index(value)
    except TypeError:
        number = _whole(value)
    if number is None or not low <= number <= high:
        raise ValueError(f"{name} = {shown(value)} is not allowed; expected {wanted}")
    return number


def _whole(value):
    """The int that a real number which is none equals, or None."""
    try:
        value, most = (value, _LARGEST) if isinstance(value, (Decimal, Fraction)) else (float(value), _EXACT)
        number = int(value) if abs(value) <= most else None
    except (ArithmeticError, ValueError):  # NaN
        return None
    return number if number == value else None


def seed(name, value, generator=False):
    """Return a seed, an int of up to 128 bits, or where ``generator`` says so a `numpy.random.Generator`."""
    if generator and isinstance(value, np.random.Generator):
        return value
    return integer(name, value, low=0, high=2**128 - 1)


def flag(name, value):
    """Return ``value`` as a bool if it is one, else raise `ValueError`."""
    return one_of(name, value, (False, True))


def one_of(name, value, allowed):
    """Return that one of ``allowed`` which ``value`` equals, else raise `ValueError`. True is not 1, nor "1"."""
    for one in allowed:
        if one is value or (_kind(value) is not None and _kind(value) is _kind(one) and one == value):
            return one
    raise ValueError(f"{name} = {shown(value)} is not allowed; expected one of {', '.join(map(repr, allowed))}")


def _kind(value):
    """Among what kind of values another one may be equal to it; None where that is not asked."""
    # A time is an integer to NumPy, which it warns of comparing with one.
    kinds = {np.timedelta64: None, str: str, (bool, np.bool_): bool, (int, float, np.integer, np.floating): float}
    return next((kind for known, kind in kinds.items() if isinstance(value, known)), None)


def harmonics(value):
    """Return a number of harmonics, 1 to 200, or "auto"."""
    if isinstance(value, str):
        return one_of("harmonics", value, ("auto",))
    return integer("harmonics", value, low=1, high=200)


def motion(value, name="motion"):
    """Return what names a motion, its number (an int of at least 0) or its name; if there is one is known later."""
    return value if isinstance(value, str) else integer(name, value, low=0)


def text(name, value):
    """Return ``value`` if it is text, else raise `ValueError`."""
    return instance(name, value, str, "text")


def instance(name, value, kinds, expected):
    """Return ``value`` if it is an instance of ``kinds``, else a `ValueError` that says what is ``expected``."""
    if not isinstance(value, kinds):
        raise ValueError(f"{name} = {shown(value)} is not allowed; expected {expected}")
    return value


def names(name, value, allowed, each=None):
    """Return ``value`` as a tuple of at least one of ``allowed``; ``each`` is what an error calls one of them."""
    if not _is_sequence(value):
        told = f"{name} = {shown(value)} is not allowed"
        raise ValueError(f"{told}; expected a sequence of {', '.join(map(repr, allowed))}")
    if not len(value):
        raise ValueError(f"{name} is empty; expected at least one name")
    return tuple(one_of(each or name, one, allowed) for one in value)


def integers(name, value, *, low, high=math.inf, size=None):
    """Return ``value`` as a tuple of `integer`; where ``size`` is not given, one or more, or one alone."""
    alone = size is None and _is_real(value)
    if not alone and not _is_sequence(value):
        wanted = f"{size or 'one or more'} whole numbers of at least {low}"
        raise ValueError(f"{name} = {shown(value)} is not allowed; expected {wanted}")
    members = (value,) if alone else tuple(value)
    if len(members) != (size or max(len(members), 1)):
        raise ValueError(f"{name} has {len(members)} elements; expected {size or 'at least 1'}")
    return tuple(integer(name, one, low=low, high=high) for one in members)


def _is_sequence(value):
    several = np.iterable(value) and hasattr(value, "__len__") and getattr(value, "ndim", 1) == 1
    return several and not isinstance(value, (*_NO_SEQUENCE, type))


def one_or_many(name, value, kinds, expected):
    """List of the instances of ``kinds`` in a sequence of them, or of the one given; see `instance`."""
    members = value if _is_sequence(value) and not isinstance(value, kinds) else [value]
    return [instance(name, member, kinds, expected) for member in members]


def broadcast(**given):
    """The number of elements that sequences by name have, each of them 1 or the longest's; `ValueError` if not."""
    n = max(map(len, given.values()))
    for name, values in given.items():
        if len(values) not in (1, n):
            longest = f" or {n}, the longest of the arguments" if n > 1 else ""
            raise ValueError(f"{name} has {len(values)} elements; expected 1{longest}")
    return n


def array(
    name, values, unit="", *, low=-math.inf, high=math.inf, low_open=False, ndim=1, min_size=1, size=None, physical=True
):
    """Return ``values`` as a float array of ``ndim`` dimensions and ``min_size`` elements or more, all as `real` wants.

    A scalar is widened to one dimension, and ``ndim`` None allows any shape; ``size`` is the number of elements where
    only one will do. Arrays, sequences and `pandas.Series` are allowed; sets, generators and what holds masked or
    complex numbers, truth values or text are not. ``physical`` False allows numbers that no rig has. `ValueError` names
    the first element that is not allowed. An array of floats is not copied.
    """
    wanted = _range(low, high, low_open, unit)
    result = _floats(name, values, unit, wanted)
    if result.ndim == 0 and ndim == 1:
        result = result.reshape(1)
    if ndim is not None and result.ndim != ndim:
        raise ValueError(f"{name} has {result.ndim} dimensions; expected {ndim}")
    if result.size < min_size or (size is not None and result.size != size):
        least = f"at least {min_size}" if size is None else f"{size}"
        raise ValueError(f"{name} has {result.size} elements; expected {least}")
    if result.size and not _inside(result, low, high, low_open):
        below = result <= low if low_open else result < low
        first = tuple(int(i) for i in np.argwhere(~np.isfinite(result) | below | (result > high))[0])
        place = ", ".join(map(str, first))
        raise ValueError(f"{name}[{place}] = {digits(result[first])}{_space(unit)} is not allowed; expected {wanted}")
    if physical and result.size:
        _physical(name, result.min(), result.max(), unit, low_open and low == 0, wanted)
    return result


def _physical(name, least, most, unit, above_zero, wanted):
    """Refuse numbers from ``least`` to ``most`` if one of them is beyond all rigs, by its unit."""
    smallest, largest = _PHYSICAL.get(unit, (0.0, math.inf))
    for number in (least, most):
        if abs(number) > largest or (above_zero and number < smallest):
            reach = f"{digits(smallest)} to {digits(largest)}" if above_zero else f"at most {digits(largest)}"
            told = f"{name} = {digits(number)} {unit} is not allowed; expected {wanted}"
            raise ValueError(f"{told}, as a rig may have it: {reach} {unit}")


def _inside(values, low, high, low_open):
    """Whether all values are finite and in the range: by the extremes, so that a long record costs no memory."""
    least, most = values.min(), values.max()  # NaN if any is
    return math.isfinite(least) and math.isfinite(most) and most <= high and (least > low if low_open else least >= low)


def _floats(name, values, unit, wanted):
    _same_unit(name, values, unit)
    if isinstance(values, (Decimal, Fraction)):
        return np.array(real(name, values, unit))
    result = _as_array(values)
    if result is not None and result.dtype.kind == "O" and result.ndim == 1:  # decimals, or None among numbers
        return np.array([real(f"{name}[{i}]", value, unit) for i, value in enumerate(result)])
    if result is None or result.dtype.kind not in "iuf" or np.ma.is_masked(values):
        told = f"{name} is not an array of real numbers but {shown(values)}"
        raise ValueError(f"{told}; expected {wanted}, one or an array of them")
    with np.errstate(over="ignore"):
        return np.asarray(result, dtype=float)


def _as_array(values):
    """The array that values are, None where they are none: ragged, or an object of its own that has no values."""
    try:
        return np.asarray(values) if _may_be_array(values) else None
    except Exception:
        return None


def _may_be_array(values):
    if values is None or isinstance(values, _NO_SEQUENCE) or (np.iterable(values) and not hasattr(values, "__len__")):
        return False
    return _plain(values) if isinstance(values, (list, tuple)) else True


def _plain(values):
    """Whether a list holds nothing that NumPy would take for a number and that is none."""
    kinds = set(map(type, values))
    if kinds & {bool, np.bool_, np.ma.core.MaskedConstant}:
        return False
    return all(_plain(row) for row in values if isinstance(row, (list, tuple))) if kinds & {list, tuple} else True


def lines(name, values, unit="", *, finite=True):
    """Return complex amplitudes, an array of one dimension, both parts as `array` wants; NaN too unless ``finite``."""
    found = _as_array(values)
    if found is None or found.dtype.kind not in "iufc" or np.ma.is_masked(values):
        return array(name, values, unit).astype(complex)
    found = np.atleast_1d(found)
    lost = np.isnan(found) & (not finite)
    parts = [array(name, np.where(lost, 0.0, part), unit) for part in (found.real, found.imag)]
    return np.where(lost, np.nan, parts[0] + 1j * parts[1])


def pair(name, values, unit="", *, low=0.0, high=math.inf, low_open=True):
    """Return two numbers, the lower one first, as floats; see `array`."""
    found = array(name, values, unit, low=low, high=high, low_open=low_open)
    if found.size != 2 or not found[0] < found[1]:
        given = f"({', '.join(map(digits, found))})" if found.size <= _FEW else f"{found.size} numbers"
        raise ValueError(
            f"{name} = {given}{_space(unit)} is not allowed; expected two numbers, ascending, low below high"
        )
    return float(found[0]), float(found[1])


def progress(value):
    """Return what ``progress=`` may be: True, False or a callable(done, total)."""
    if callable(value) and not isinstance(value, type):
        return value
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    raise ValueError(f"progress = {shown(value)} is not allowed; expected True, False or a callable(done, total)")


def executor(value):
    """Return what ``executor=`` may be: None, or what takes work as a `concurrent.futures.Executor` does."""
    if value is not None and (isinstance(value, type) or not callable(getattr(value, "submit", None))):
        raise ValueError(
            f"executor = {shown(value)} is not allowed; expected None or an object with submit(), such as a "
            "concurrent.futures.ThreadPoolExecutor"
        )
    return value


def checkpoint(value):
    """Return what ``checkpoint=`` may be: None, or the name (str) of a file in a folder that is there."""
    wanted = "None or the name of a file"
    if value is None:
        return None
    name = path("checkpoint", value, wanted)
    if os.path.isdir(name):
        raise ValueError(f"checkpoint = {shown(name)} is a folder; expected {wanted}")
    if not os.path.isdir(os.path.dirname(name) or "."):
        raise ValueError(f"checkpoint = {shown(name)} lies in no folder that is there; expected {wanted}")
    return name


def path(name, value, wanted="the name of a file"):
    """Return a file's name as text that is not empty."""
    told = os.fspath(value) if isinstance(value, (str, os.PathLike)) else None
    if not isinstance(told, str) or not told or "\0" in told:
        raise ValueError(f"{name} = {shown(value)} is not allowed; expected {wanted}")
    return told


def running(told, workers, kept):
    """What `progress`, `executor` and `checkpoint` return, of the three keywords of long work."""
    return progress(told), executor(workers), checkpoint(kept)


def digits(value):
    """A number as text, with every digit that tells it from a limit close by."""
    return f"{value:.15g}"


def shown(value):
    """Any object as a few words on one line, whatever its own text is like."""
    if isinstance(value, (np.generic, np.ndarray)) and value.size <= _FEW and not np.ma.isMaskedArray(value):
        value = value.tolist()
    elif isinstance(getattr(value, "shape", None), tuple) and np.prod(value.shape) > _FEW:
        return f"<{type(value).__name__} of shape {value.shape}>"
    try:
        words = " ".join((repr(value) if isinstance(value, int) else _SHORT.repr(value)).split())
    except Exception:  # an int of too many digits, or an object without a text of its own
        words = f"<{type(value).__name__}>"
    return words if len(words) <= 160 else f"{words[:150]}..."


def _is_real(value):
    """Whether a value is one real number: no truth value, nothing masked, text or date."""
    if isinstance(value, np.ndarray):
        return value.ndim == 0 and value.dtype.kind in "iuf" and not np.ma.is_masked(value)
    if isinstance(value, (bool, np.bool_, np.timedelta64)):
        return False
    return isinstance(value, (Real, Decimal)) or _of_no_dimension(value)


def _of_no_dimension(value):
    """Whether it is another library's array of one number."""
    dtype = getattr(value, "dtype", None)
    return getattr(value, "shape", None) == () and getattr(dtype, "kind", "") in tuple("iuf")


def _same_unit(name, value, unit):
    """Refuse what says that it is in another unit than ``unit``, as arrays of several libraries do."""
    kind, said = type(value), None
    if issubclass(kind, (date, timedelta)):  # whose unit is that of their clock; they are refused for what they are
        return
    if hasattr(kind, "units") or hasattr(kind, "unit"):  # of the class: a table may have a column of that name
        said = getattr(value, "units", None) or getattr(value, "unit", None)
    elif isinstance(attributes := getattr(value, "attrs", None), dict):
        said = attributes.get("units", attributes.get("unit"))
    if said is not None and str(said) != unit:
        wanted = f"numbers in {unit}" if unit else "plain numbers"
        raise ValueError(f"{name} is in {str(said)!r}; expected {wanted}")


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
