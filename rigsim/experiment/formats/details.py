"""Details of a record as JSON text: parsed strictly, since what one program guesses another does not."""

import json
import math
import reprlib
from collections import Counter

LONGEST = 1 << 16  # characters; the details of a rig take some 500


def parse(text, place):
    """Details (a dict) from an object of JSON; `ValueError` names the ``place`` it stands at."""
    if len(text) > LONGEST:
        raise ValueError(f"{place} is longer than {LONGEST} characters")
    try:
        details = json.loads(
            text,
            object_pairs_hook=_each_once,
            parse_constant=_number,
            parse_float=_number,
            parse_int=lambda digits: int(digits) if math.isfinite(_number(digits)) else None,
        )
    except RecursionError:
        raise ValueError(f"{place} is nested too deeply") from None
    except json.JSONDecodeError as error:
        raise ValueError(
            f"{place}, character {error.pos + 1}: {error.msg}; expected details such as {EXAMPLE}"
        ) from None
    except ValueError as error:
        raise ValueError(f"{place}: {error}") from None
    if not isinstance(details, dict):
        raise ValueError(
            f"{place} is not a record's details: {reprlib.repr(details)}; expected details such as {EXAMPLE}"
        )
    return details


EXAMPLE = '{"sample_rate": 2000, "hold": "zero"}'


def _number(text):
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(f"{reprlib.repr(text)} is not allowed; expected a finite number")
    return number


def _each_once(pairs):
    name, times = Counter(name for name, _ in pairs).most_common(1)[0] if pairs else ("", 1)
    if times > 1:
        raise ValueError(f"{reprlib.repr(name)} stands there {times} times; expected each once")
    return dict(pairs)
