"""What a row of the ledger is made of: a printed number or a claim, and the function that computes ours."""

from collections.abc import Callable
from dataclasses import dataclass

from ...parameters import OscillatorParameters
from ..printed import PRINTED, printed


@dataclass(frozen=True)
class Number:
    """A printed number: ``compute(evidence)`` gives ours; ``cause``, text or a function too, says why they differ."""

    section: str
    item: str
    unit: str
    printed: str
    compute: Callable
    cause: str | Callable = ""


@dataclass(frozen=True)
class Claim:
    """A claim in words: ``compute(evidence)`` gives a verdict ("yes", "partly", "no") and what was found."""

    section: str
    claim: str
    compute: Callable
    cause: str | Callable = ""


def numbers(section, compute, names=None, causes=None):
    """A `Number` for each symbol of a printed table; ``compute(evidence, symbol)``."""
    return [
        Number(
            section, (names or {}).get(symbol, symbol), unit, text, lambda e, s=symbol: compute(e, s),
            (causes or {}).get(symbol, ""),
        )
        for symbol, (text, unit) in PRINTED[section].items()
    ]  # fmt: skip


def number(section, symbol, item, compute, cause=""):
    """A further way to compute a number that is printed once."""
    text, unit = PRINTED[section][symbol]
    return Number(section, item, unit, text, compute, cause)


def percent(value, digits=2):
    """A share in words, to so many digits."""
    return f"{100 * value:.{digits}g} %"


def printed_oscillator(e):
    """Table 4's values as printed, with the computed k3: what the paper's own next steps started from."""
    values = {symbol: printed("Table 4", symbol) for symbol in PRINTED["Table 4"]}
    return OscillatorParameters(**values, k3=e.theory.k3)
