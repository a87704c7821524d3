"""The ledger: every number and claim of the paper, printed against computed, with the cause where they differ."""

import itertools
from dataclasses import dataclass
from decimal import Decimal
from html import escape

from .. import checks
from ..parameters import RigParameters, rig_of
from ..results import Result, ResultSequence, frame
from .evidence import Evidence
from .rows import ROWS

_CLOSE = 1e-3  # relative difference still called close, beyond the printed digits
# The rows' causes are those of the paper's rig.
_PAPER_RIG, _OTHER_RIG = RigParameters(), "computed on a rig that is not the paper's"
_KEY = (
    "A number agrees (yes) where it rounds to the printed digits, and is close within 0.1 %. A claim holds, holds "
    "partly, or does not. Where theory has three solutions, they are called low, middle and high by the size of z."
)
_NUMERIC = ' class="number"'
_HEADS = {  # of columns, and their widths (%)
    "number": {"quantity": 22, "printed": 11, "computed": 13, "difference": 13, "%": 10, "agrees": 9, "cause": 22},
    "claim": {"claim": 29, "what is found": 35, "holds": 8, "remark": 28},
}
_STYLE = (
    ".rigsim-ledger table{width:100%;min-width:46em;table-layout:fixed;margin:0 0 1em}"
    ".rigsim-ledger caption{text-align:left;font-weight:600;padding:.6em 0 .2em}"
    ".rigsim-ledger th,.rigsim-ledger td{text-align:left;vertical-align:top;white-space:normal;padding:.3em .5em}"
    ".rigsim-ledger .number{text-align:right;white-space:nowrap;font-variant-numeric:tabular-nums}"
    ".rigsim-ledger tbody th{font-weight:400}.rigsim-ledger .no td:nth-last-child(2){font-weight:700}"
)


@dataclass(frozen=True)
class LedgerRow:
    """One line of the ledger.

    Attributes
    ----------
    section, item : str
        Where it stands in the paper; the quantity, or the claim in words.
    printed, unit : str
        As the paper prints it; empty for a claim.
    computed : float or str
        The number, or what was found.
    agrees : {"yes", "close", "partly", "no"}
        A number: "yes" where it rounds to the printed digits, "close" within 0.1 %. A claim: whether it holds.
    cause : str
        Why it does not agree; empty where it does.
    """

    section: str
    item: str
    printed: str
    unit: str
    computed: float | str
    agrees: str
    cause: str

    @property
    def kind(self):
        """Either "number" or "claim"."""
        return "number" if self.printed else "claim"

    @property
    def difference(self):
        """Computed less printed, or None."""
        return None if isinstance(self.computed, str) else self.computed - float(self.printed)

    @property
    def percent(self):
        """The difference relative to what is printed (%), or None."""
        return None if isinstance(self.computed, str) else 100 * (self.computed / float(self.printed) - 1)

    @property
    def shown(self):
        """The computed number with one digit more than the printed one, or the text."""
        if isinstance(self.computed, str):
            return self.computed
        printed = Decimal(self.printed).as_tuple()
        if "e" in self.printed:
            return f"{self.computed:.{len(printed.digits)}e}".replace("e+0", "e").replace("e-0", "e-")
        return f"{self.computed:.{max(0, -printed.exponent) + 1}f}"


@dataclass(frozen=True, eq=False, repr=False)
class Ledger(ResultSequence):
    """Every number and claim of the paper beside what the companion computes from the `Evidence`."""

    members: tuple
    evidence: Evidence

    __repr__ = Result.__repr__  # a table of a hundred sentences is for a page

    def count(self, kind, agrees):
        """How many rows of a kind ("number", "claim") agree so."""
        kind = checks.one_of("kind", kind, ("number", "claim"))
        agrees = checks.one_of("agrees", agrees, ("yes", "close", "partly", "no"))
        return sum(row.kind == kind and row.agrees == agrees for row in self)

    def summary(self):
        """One line: how many rows agree."""
        numbers = ", ".join(f"{self.count('number', word)} {told}" for word, told in (
            ("yes", "to the printed digits"), ("close", "within 0.1 %"), ("no", "not"),
        ))  # fmt: skip
        claims = ", ".join(f"{self.count('claim', word)} {word}" for word in ("yes", "partly", "no"))
        return f"Ledger of {len(self)} rows. Numbers that agree: {numbers}. Claims that hold: {claims}."

    def only(self, *sections):
        """The `Ledger` of these sections alone; `ValueError` if there is no such section."""
        known = tuple(dict.fromkeys(row.section for row in self))
        sections = [checks.one_of("section", section, known) for section in sections]
        return Ledger(tuple(row for row in self if row.section in sections), self.evidence)

    def row(self, section, item):
        """The one row of this section and item; `ValueError` if there is none."""
        section, item = checks.text("section", section), checks.text("item", item)
        found = [row for row in self if (row.section, row.item) == (section, item)]
        if not found:
            given = checks.shown((section, item))
            raise ValueError(f"row {given} is not in the ledger; expected a section and an item of ledger.table()")
        return found[0]

    def table(self):
        """`pandas.DataFrame` with a row per row."""
        columns = ["section", "item", "kind", "unit", "printed", "computed", "difference", "percent", "agrees", "cause"]
        rows = [[getattr(row, name) for name in columns] for row in self]
        return frame(rows, columns).rename(columns={"percent": "difference [%]"})

    def _repr_html_(self):
        parts = itertools.product(dict.fromkeys(row.section for row in self), ("number", "claim"))
        tables = "".join(_table([row for row in self if (row.section, row.kind) == part], *part) for part in parts)
        words = f"<p>{escape(self.summary())}</p><p>{_KEY}</p>" if len(self) == len(ROWS) else ""
        return f'<div class="rigsim-ledger"><style>{_STYLE}</style>{words}{tables}</div>'


def ledger(rig=None, *, evidence=None, progress=False):
    """Compute the ledger.

    Parameters
    ----------
    rig : RigParameters, optional
        By default the paper's, or that of the evidence.
    evidence : Evidence, optional
        The tests, where they were run before; by default they are run now, the sine tests every hertz.
    progress : bool or callable
        Of the random test and the sine tests, where ``evidence`` is not given.

    Returns
    -------
    Ledger

    Raises
    ------
    ValueError
        If the evidence is of another rig.
    """
    progress, rig = checks.progress(progress), None if rig is None else rig_of(rig, "rig")
    if evidence is None:
        evidence = Evidence(RigParameters() if rig is None else rig, progress=progress)
    evidence = checks.instance("evidence", evidence, Evidence, "Evidence")
    if rig is not None and rig != evidence.rig:
        raise ValueError(f"evidence is of {evidence.rig!r}; expected evidence of {rig!r}")
    return Ledger(tuple(_compute(entry, evidence) for entry in ROWS), evidence)


def _compute(entry, evidence):
    try:
        found = entry.compute(evidence)
    except ValueError as error:  # a rig of one's own may have no equilibrium, or fly apart
        agrees, computed = False, f"could not be computed: {error}"
    else:
        agrees, computed = (_agreement(entry.printed, found), float(found)) if entry.printed else found
    agrees = agrees if isinstance(agrees, str) else "yes" if agrees else "no"
    cause = entry.cause if evidence.rig == _PAPER_RIG else _OTHER_RIG
    cause = "" if agrees == "yes" else cause(evidence) if callable(cause) else cause
    return LedgerRow(entry.section, entry.item, entry.printed, entry.unit, computed, agrees, cause)


def _agreement(printed, computed):
    half = Decimal(printed).as_tuple().exponent
    if abs(computed - float(printed)) <= 0.5 * 10.0**half * (1 + 1e-9):
        return "yes"
    return "close" if abs(computed / float(printed) - 1) <= _CLOSE else "no"


def _table(rows, section, kind):
    if not rows:
        return ""
    heads = _HEADS[kind]
    widths = "".join(f'<col style="width:{share}%">' for share in heads.values())
    numeric = ("printed", "computed", "difference", "%")
    head = "".join(f'<th scope="col"{_NUMERIC if text in numeric else ""}>{text}</th>' for text in heads)
    body = "".join(_line(row) for row in rows)
    return (
        f"<table><caption>{escape(section)}: {kind}s</caption><colgroup>{widths}</colgroup>"
        f"<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
    )


def _line(row):
    unit = f" [{row.unit}]" if row.unit else ""
    cells = [f'<th scope="row">{escape(row.item + unit)}</th>']
    if row.kind == "number":
        texts = (row.printed, row.shown, *_difference(row))
        cells += [f"<td{_NUMERIC}>{escape(text)}</td>" for text in texts]
    else:
        cells.append(f"<td>{escape(row.shown)}</td>")
    cells += [f"<td>{row.agrees}</td>", f"<td>{escape(row.cause)}</td>"]
    return f'<tr class="{row.agrees}">{"".join(cells)}</tr>'


def _difference(row):
    """Absolute and relative difference as texts; 0 where it is only rounding."""
    if row.difference is None:
        return "", ""
    if abs(row.percent) < 1e-10:
        return "0", "0"
    percent = f"{row.percent:+.3f}" if abs(row.percent) >= 5e-4 else "0.000"
    return f"{row.difference:+.2g}", percent
