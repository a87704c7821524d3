"""The page of a record: what `identify` makes of a user's own file, as one HTML file that needs no other."""

import errno
import os
import time
import warnings
from html import escape
from itertools import compress
from operator import not_
from pathlib import Path

from ... import checks
from ...blas import one_blas_thread
from ...design.charts import existence_chart
from ...design.count import KINDS
from ...design.probability import curve_probability
from ...experiment.record import Record
from ...identification.identify import identify
from ...identification.layout import layout_of
from ...parameters import OscillatorParameters
from ..figures import curve_probability_figure
from .build import make_folder, write
from .document import Document
from .pages import rendered
from .self_contained import seal

_WHAT_NO_RECORD_TELLS = (
    "No record can tell a sensitivity that is wrong by one factor for all motions, or a wrong unit of all of them: "
    "masses and stiffnesses are then wrong by that factor, so hold them against what is weighed. Nor can it tell noise "
    "on the recorded force from a force that was not recorded."
)
_ON_A_BASE = (
    "The motion on a base tells parameters only as shares of the first mass, which is 1 here: multiply the others by "
    "what it weighs."
)


def identify_file(path, out=None, force=None, *, load=None, progress=True, **settings):
    """Read a record, identify its rig and write its page.

    Parameters
    ----------
    path : str or path, or sequence of them
        A file that `Record.load` reads, or several: tests of one rig.
    out : path, optional
        The page; by default NAME_identified.html, of the first file's name, in the current folder.
    force : float, optional
        Amplitude (N) at which detached curves are asked for.
    load, settings
        Options of `Record.load` (a dict; a column's number may be text, where none is called so) and of `identify`.
    progress : bool
        Whether a bar is shown.

    Returns
    -------
    Identification, tuple of str, pathlib.Path
        What was found, what was guessed about the file, and the page.

    Raises
    ------
    ValueError
        If the file cannot be read as a record, or the record or a setting is not allowed.
    OSError
        If the page cannot be written, as is found before anything else is done.
    """
    path = checks.one_or_many("path", path, (str, os.PathLike), "the name of a file, or several")
    path = [Path(checks.path("path", each)) for each in path]
    if not path:
        raise ValueError("path = [] is not allowed; expected the name of a file, or several")
    force = None if force is None else checks.positive("force", force, "N")
    out = Path(f"{path[0].stem}_identified.html") if out is None else Path(out)
    if out.exists() and any(each.exists() and out.samefile(each) for each in path):
        raise ValueError(f"out = {str(out)!r} is the record itself; expected another name for its page")
    make_folder(out.parent)
    if out.is_dir() or not os.access(out.parent, os.W_OK):
        raise OSError(errno.EACCES, "a folder is there, or its folder may not be written to", str(out))
    begun = time.perf_counter()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", UserWarning)
        record = Record.joined([Record.load(each, **_loadable(each, **(load or {}))) for each in path])
    guessed = tuple(str(warning.message) for warning in caught if issubclass(warning.category, UserWarning))
    found = identify(record, progress=progress, **settings)
    names = [each.name for each in path]
    page = identified_page(found, record, names, guessed, force, settings, lambda: time.perf_counter() - begun)
    return found, guessed, write(out, page)


def _loadable(path, channels=None, **options):
    """Options of `Record.load`: columns by name, or by number where a text is one and no column's name."""
    if not channels:
        return options
    names = {row[1] for row in Record.inspect(path).rows} if any(map(str.isdecimal, channels.values())) else ()
    number = lambda text: int(text) if text.isdecimal() and text not in names else text  # noqa: E731
    return options | {"channels": {name: number(text) for name, text in channels.items()}}


@one_blas_thread
def identified_page(found, record, names, guessed=(), force=None, settings=None, seconds=lambda: 0.0):
    """The whole page (str) of an `Identification` of a record that was read from a file, or files, of those ``names``.

    ``guessed`` are sentences, ``force`` (N) is one at which detached curves are asked for, ``settings`` are those of
    `identify`, and ``seconds`` tells how long all took.
    """
    page = _Page(Document(Path()))
    _verdict(page, found)
    _record(page, record, guessed)
    _troubles(page, found)
    _parameters(page, found)
    if found.modelled is not None:
        _residuals(page, found)
    _linear(page, found)
    if found.errors is not None and isinstance(found.parameters, OscillatorParameters) and not record.base:
        _curves(page, found, force)
    if settings:
        page.section("Settings")
        told = settings | ({"band": "{:g} to {:g} Hz".format(*settings["band"])} if "band" in settings else {})
        page.text("Other than usual: " + ", ".join(f"{key} = {value}" for key, value in told.items()) + ".")
    return page.sealed([names] if isinstance(names, str) else names, seconds())


class _Page:
    """Sections of a page; whatever text comes from a file is escaped."""

    def __init__(self, document):
        self._document, self._headings, self._sections = document, [], [[]]

    def section(self, heading):
        name = heading.replace(" ", "-")
        self._headings.append((name, escape(heading)))
        self._sections.append([f'<h2 id="{escape(name)}">{escape(heading)}</h2>'])

    def _add(self, html):
        self._sections[-1].append(str(html))

    def text(self, text, kind=None):
        self._add(f'<p class="{kind}">{escape(text)}</p>' if kind else f"<p>{escape(text)}</p>")

    def items(self, texts):
        self._add("<ul>" + "".join(f"<li>{escape(text)}</li>" for text in texts) + "</ul>")

    def table(self, table):
        html = table.rename_axis(None).to_html(float_format=lambda x: f"{x:.5g}", na_rep="")
        self._add(self._document.accessible_tables(html))

    def figure(self, figure):
        self._add(f'<div class="figure">{self._document.svg(figure.svg())}</div>')

    def sealed(self, names, seconds):
        says = "says of its" if len(names) == 1 else "say of their"
        title = f"What {' and '.join(names)} {says} rig"
        first, *others = ("\n".join(parts) for parts in self._sections)
        cells = [f"<h1>{escape(title)}</h1>\n{first}", *others]
        page = rendered(
            "page.html.j2", title=title, headings=self._headings, seconds=seconds,
            cells=[{"kind": "markdown", "html": html} for html in cells],
        )  # fmt: skip
        return seal(page, names[0])


def _verdict(page, found):
    page.text(found.summary())
    page.text(found.status.value, "note")


def _record(page, record, guessed):
    page.section("The record")
    page.text(record.summary() + ".")
    if guessed:
        page.text("How the file was read:")
        page.items(guessed)
    page.table(record.table())
    page.figure(record.plot())


def _troubles(page, found):
    page.section("Troubles")
    mended = [trouble.mend or trouble.name == "break" for trouble in found.mended]
    for troubles, heading in (
        (compress(found.mended, mended), "Found and mended, before all that follows:"),
        (compress(found.mended, map(not_, mended)), "Found, and not to be mended:"),
        (found.troubles, "Not mended; the intervals are wider by what these would move:"),
    ):
        texts = [trouble.message for trouble in troubles]
        if texts:
            page.text(heading)
            page.items(texts)
    if not found.mended and not found.troubles:
        page.text("None was found.")
    if not found.record.base:
        page.text(_WHAT_NO_RECORD_TELLS, "note")


def _parameters(page, found):
    page.section("Parameters")
    if found.record.base:
        page.text(_ON_A_BASE)
    table = found.table().drop(columns=["meaning", "standard error"], errors="ignore")
    page.table(table[sorted(table, key=lambda name: name in ("nominal", "error [%]"))])  # what is found first
    layout = layout_of(found.record)
    terms = () if found.errors is None else range(len(layout.names), len(found.errors.names))
    if terms:
        page.items(
            f"{found.errors.names[i]} = {found.errors.value[i]:.5g} ± {found.errors.half_width[i]:.2g}" for i in terms
        )
    if found.errors is None:
        page.table(found.modes.table())
        page.text("No rig of this kind repeats the record, so its parameters have no intervals.")
        return
    modes = layout.modes(found.errors.value)
    if modes is not None:
        widths = dict(zip(("± [Hz], 95 %", "± of damping, 95 %"), found.errors.mode_half_width.T, strict=True))
        page.table(modes.table().assign(**widths))
    page.text(
        "Intervals are of 95 %, from noise and from what parts of the record disagree about; the least possible ones "
        "are those of Cramér and Rao for white noise of the size found. H_E gives the parameters in a second way, "
        "which is less sure under noise."
    )
    page.figure(found.plot("parameters"))


def _residuals(page, found):
    page.section("Residuals")
    page.text(
        "What the simulated rig leaves of each output. Where the record holds nothing but the rig and white noise, it "
        "lies on the floor, and one lag in a hundred is outside the grey bands."
    )
    page.figure(found.plot("residuals"))
    page.section("Prediction")
    shaken = "the base's acceleration" if found.record.base else "the force"
    page.text(f"The whole motion is simulated from {shaken} alone; nothing is corrected on the way.")
    page.figure(found.plot("prediction"))


def _linear(page, found):
    page.section("Receptances")
    page.text("Of the underlying linear system, by nonlinear subspace identification.")
    page.figure(found.plot("receptances"))
    page.section("Nonlinear coefficient")
    page.text("For a cubic spring it is real and the same at all frequencies, up to the noise.")
    page.figure(found.plot("nonlinear coefficient"))
    page.section("Order")
    order = found.model_order()
    page.text(f"{order.summary()}.")
    page.text("Singular values: two a mode stand out, the rest is noise. Poles of the rig stay where the order grows.")
    page.figure(order.plot())


def _curves(page, found, force):
    page.section("Detached curves")
    result = curve_probability(found, force)
    for kind in KINDS:
        told = result.told(kind)
        page.text(f"{told[0].upper()}{told[1:]}.")
    if force is not None:
        inner, outer = (100 * share for share in result.at(force))
        page.text(f"At {force:g} N an inner detached curve exists with {inner:.0f} %, an outer one with {outer:.0f} %.")
    page.text(
        f"Shares of {result.samples} rigs that are drawn from the intervals and judged by single-term theory.", "note"
    )
    page.figure(curve_probability_figure(result, force=force))
    parameters = found.parameters
    if 0 in (parameters.k3, parameters.c, parameters.cs):
        return
    page.text("The rig and its damping's interval among rigs that differ by damping, over the force:")
    here = result.force[(result.inner + result.outer).argmax()] if force is None else force
    width = {"c": min(found.errors.half_width[found.errors.names.index("c")], parameters.c)}
    chart = existence_chart(
        parameters,
        here,
        ("c", 0.2 * parameters.c, 3 * parameters.c),
        ("force", result.force[0], result.force[-1]),
        width,
    )
    page.figure(chart.plot())
