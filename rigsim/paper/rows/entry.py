"""What a row of the ledger is made of: a printed number or a claim, and the function that computes ours."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from ...parameters import OscillatorParameters
from ..printed import PRINTED, printed


@dataclass(frozen=True)
class Entry:
    """A claim in words, or a printed number; ``cause``, text or a function of the evidence, says why it does not hold.

    ``compute(evidence)`` gives a claim's verdict (whether it holds, or "partly") and what was found, or our number.
    """

    section: str
    item: str
    compute: Callable
    cause: str | Callable = ""
    printed: str = ""
    unit: str = ""


def numbers(section, compute, names=None, causes=None):
    """An `Entry` for each symbol of a printed table; ``compute(evidence, symbol)``."""
    names, causes = names or {}, causes or {}
    return [
        number(section, symbol, names.get(symbol, symbol), partial(compute, symbol=symbol), causes.get(symbol, ""))
        for symbol in PRINTED[section]
    ]


def number(section, symbol, item, compute, cause=""):
    """An `Entry` for a printed number under a name of its own."""
    return Entry(section, item, compute, cause, *PRINTED[section][symbol])


def percent(value, digits=2):
    """A share in words, to so many digits."""
    return f"{100 * value:.{digits}g} %"


def printed_oscillator(e):
    """Table 4's values as printed, with the computed k3: what the paper's own next steps started from."""
    values = {symbol: printed("Table 4", symbol) for symbol in PRINTED["Table 4"]}
    return OscillatorParameters(**values, k3=e.theory.k3)
