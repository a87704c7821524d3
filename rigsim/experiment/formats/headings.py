"""What words around samples say of all of them: how fast, how many, and whether some are missing."""

import re

from .units import unit_of

_VALUE = r"\W*?[:=;,\t ]+\s*\"?([+-]?\d[\d.,]*(?:[eE][+-]?\d+)?)\"?\s*[;,\t ]*[\[(]?\s*([^\W\d_][\w/]*)?"
_RATE = re.compile(
    r"^\W*(?:sampl\w*[ _-]*(?:rate|freq\w*)|fs|f_s|f_sample|sr|rate|freq|frequency_sampling|abtastrate|messrate|"
    r"abtastfrequenz|scan[ _-]*rate|samples[ _-]*per[ _-]*second)\b" + _VALUE,
    re.IGNORECASE,
)
_STEP = re.compile(
    r"^\W*(?:sampl\w*[ _-]*(?:interval|period|time|step)|delta[ _-]?[xt]|dt|d_t|ts|t_s|x?[ _-]?increment|wf_increment|"
    r"time[ _-]*step|abtastintervall|schrittweite|horizontal[ _-]*interval)\b" + _VALUE,
    re.IGNORECASE,
)
_COUNT = re.compile(
    r"^\W*(?:(?:number|no|nr|count)[ _.-]*(?:of)?[ _.-]*(?:samples|points|rows|values|scans)|record[ _-]*length|"
    r"samples|num[ _-]*samples|n_samples|anzahl[ _-]*(?:werte|messwerte))\b" + _VALUE,
    re.IGNORECASE,
)
_HOLD = re.compile(r"^\W*hold\b\W+(zero|linear|band-limited)\b", re.IGNORECASE)
_LOST = re.compile(
    r"\b(lost|loss|overrun|overflow|dropped|dropout|overload\w*|ovld|missing|skipped|gap)\b", re.IGNORECASE
)
_LONGEST = 300  # characters of a line that may say something
_NONE = re.compile(r"\b(0|no|none|false|off|ok)\b", re.IGNORECASE)


def said_in(lines, place):
    """Details (a dict) that lines above samples say, and what is worth a word (a list)."""
    said, notes = {}, []
    for line in (line[:_LONGEST] for line in lines):
        if found := _RATE.match(line):
            _agree(
                said,
                "sample_rate",
                _number(found[1]) * {"khz": 1e3, "ks": 1e3, "mhz": 1e6}.get(_word(found), 1.0),
                place,
            )
        elif (found := _STEP.match(line)) and _number(found[1]) > 0:
            known = unit_of(found[2] or "s")
            factor = known[1] if known and known[0] == "time" else 1.0
            _agree(said, "sample_rate", 1 / (_number(found[1]) * factor), place)
        elif found := _COUNT.match(line):
            said.setdefault("samples", int(_number(found[1])))
        elif found := _HOLD.match(line):
            said.setdefault("hold", found[1].lower())
        if _LOST.search(line) and not _NONE.search(line):
            notes.append(f"{' '.join(line.split())[:80]!r} stands above the samples")
    return said, notes


def _word(found):
    return (found[2] or "").casefold().partition("/")[0]


def _number(text):
    """A number as it is written: a comma before three digits parts thousands, another one the whole from its parts."""
    if text.count(",") == 1 and "." not in text and not re.search(r",\d{3}$", text):
        text = text.replace(",", ".")
    try:
        return float(text.replace(",", "").rstrip("."))
    except ValueError:
        return 0.0


def _agree(said, name, value, place):
    if not value > 0:
        return
    before = said.setdefault(name, value)
    if abs(before / value - 1) > 1e-4:
        raise ValueError(f"{place} says two sample rates, {before:g} and {value:g} Hz; expected one")
