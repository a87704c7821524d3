"""Offline reports: run the numbered notebooks and write each as one HTML file that needs nothing else.

The only door to nbclient and nbconvert. What nbconvert's own HTML would load from elsewhere is done here at export:
maths becomes MathML, figures stay inline SVG, style and scripts are part of the page.
"""

import itertools
import os
import re
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field
from datetime import datetime
from html import escape
from html.parser import HTMLParser
from importlib.metadata import version
from pathlib import Path

import jinja2
import nbformat
from bs4 import BeautifulSoup
from jupyter_client.kernelspec import KernelSpec
from jupyter_client.manager import AsyncKernelManager
from latex2mathml.converter import convert as _latex_to_mathml
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError, CellTimeoutError, DeadKernelError
from nbconvert.filters.ansi import strip_ansi
from nbconvert.filters.highlight import Highlight2HTML
from nbconvert.filters.markdown_mistune import IPythonRenderer, MarkdownWithMath, MathBlockParser
from tqdm.auto import tqdm

from ..svg import unique_ids

_WORKERS = 2
_CELL_TIMEOUT = 900  # s; a cell that takes longer hangs
_NUMBER = re.compile(r"(?:nan|[-+\u2212]?inf|[-+\u2212]?[\d.][\d.,e+\u2212-]*(?:\s*%|j)?)?", re.IGNORECASE)
_SHORT = 24  # characters that a table's cell keeps on one line
_TALL = 100  # rows beyond which a table scrolls in a box of its own
_PACKAGES = ("rigsim", "numpy", "scipy", "pymunk", "numba", "matplotlib", "ipywidgets", "jupyterlab")
_WIDGET = "application/vnd.jupyter.widget-view+json"
_WIDGET_NOTE = '<p class="note">An interactive panel stands here when the notebook is open: live in JupyterLab.</p>'


class ReportError(RuntimeError):
    """One or more notebooks failed; one line for each names the notebook, the cell and what was raised."""


def build_reports(names=None, notebooks="notebooks", output="reports", progress=True):
    """Run notebooks, two at a time, and write one self-contained page for each and an index.

    Parameters
    ----------
    names : sequence of str, optional
        Which notebooks: "03_detached_curves", "03_detached_curves.ipynb" or just "03". All numbered ones by default.
    notebooks, output : path
        The folder that holds ``NN_name.ipynb``, which is also where they run, and the one to write to.
    progress : bool
        Say on standard error which notebook is finished, and after how many seconds.

    Returns
    -------
    tuple of pathlib.Path
        The pages written, in the notebooks' order, the index last.

    Raises
    ------
    ValueError
        If the folder holds no numbered notebook, or none by a name given.
    ReportError
        If a notebook fails or its page would need another file. The others are written all the same, and a page of
        the failed one from an earlier run stays as it was.

    Examples
    --------
    >>> build_reports(["03"], output="reports")  # doctest: +SKIP
    (PosixPath('reports/03_detached_curves.html'), PosixPath('reports/index.html'))
    """
    every = sorted(Path(notebooks).glob("[0-9][0-9]_*.ipynb"))
    if not every:
        raise ValueError(f"notebooks = {str(notebooks)!r} holds no numbered notebook; expected NN_name.ipynb")
    chosen = every if not names else sorted({_find(name, every) for name in names})
    output = Path(output)
    output.mkdir(parents=True, exist_ok=True)
    written, failures = {}, {}
    with tqdm(desc="cells", unit="cell", disable=not progress or None, file=sys.stderr, leave=False) as bar:

        def build(path):
            begun = time.perf_counter()
            notebook = _read(path)
            bar.total = (bar.total or 0) + sum(cell.cell_type == "code" for cell in notebook.cells)
            _run(notebook, path, bar)
            seconds = time.perf_counter() - begun
            return _write(output / f"{path.stem}.html", _page(notebook, path, every, seconds)), seconds

        with ThreadPoolExecutor(_WORKERS) as executor:
            futures = {executor.submit(build, path): path for path in chosen}
            try:
                for future in as_completed(futures):
                    path = futures[future]
                    try:
                        written[path], seconds = future.result()
                        line = f"{path.stem}: {seconds:.0f} s, {written[path]}"
                    except ReportError as error:
                        failures[path] = str(error)
                        line = f"{path.stem}: failed"
                    if progress:
                        tqdm.write(line, file=sys.stderr)
            except BaseException:
                executor.shutdown(wait=False, cancel_futures=True)
                raise
    index = _write(output / "index.html", _index(every, output, failures))
    if failures:
        raise ReportError("\n".join(failures[path] for path in sorted(failures)))
    return (*(written[path] for path in chosen), index)


def _find(name, every):
    stem = Path(name).stem
    for path in every:
        if stem == path.stem or stem == path.stem[:2]:
            return path
    raise ValueError(f"names has {name!r}; expected one of {', '.join(path.stem for path in every)}")


def _read(path):
    try:
        return nbformat.read(path, as_version=4)
    except Exception as error:  # nbformat lets through whatever its JSON and schema libraries raise
        raise ReportError(f"{path.name} is no notebook: {str(error).splitlines()[0]}") from None


# Running


class _OwnKernel(AsyncKernelManager):
    """Any notebook runs on this interpreter, whatever kernels the machine has installed."""

    @property
    def kernel_spec(self):
        quiet = ["--log-level=ERROR", "--HistoryManager.enabled=False"]
        argv = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}", *quiet]
        return KernelSpec(argv=argv, display_name="Python", language="python")


def _run(notebook, path, bar):
    """Execute the notebook in place; raise a `ReportError` of one line if a cell fails."""
    at = {}
    client = NotebookClient(
        notebook,
        kernel_manager_class=_OwnKernel,
        kernel_name="python3",
        timeout=_CELL_TIMEOUT,
        store_widget_state=False,
        resources={"metadata": {"path": str(path.parent)}},
        on_cell_start=lambda cell, cell_index: at.update(index=cell_index),
        on_cell_executed=lambda cell, cell_index, execute_reply: bar.update(),
    )
    # The kernels share the cores; without a word each would claim them all.
    threads = str(max(1, (os.cpu_count() or 1) // _WORKERS))
    defaults = {name: threads for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}
    try:
        client.execute(env={**defaults, **os.environ})
    except (CellExecutionError, CellTimeoutError, DeadKernelError) as error:
        if isinstance(error, CellExecutionError):
            what = f"{error.ename}: {error.evalue}"
        elif isinstance(error, CellTimeoutError):
            what = f"no end after {_CELL_TIMEOUT} s"
        else:
            what = "the kernel died"
        number = sum(cell.cell_type == "code" for cell in notebook.cells[: at.get("index", 0) + 1])
        line = strip_ansi(what).strip().replace("\n", " ")
        raise ReportError(f"{path.name}, code cell {number}: {line}") from None


# Markdown and maths


def mathml(latex, display=False):
    """LaTeX maths as a MathML element, or, where it cannot be converted, as its source in a ``<code>`` element.

    Parameters
    ----------
    latex : str
        Without dollar signs. Environments of several lines and ``\\tag`` are understood.
    display : bool
        On a line of its own.

    Returns
    -------
    str
    """
    text = re.sub(r"\\(label|notag|nonumber)\b(\{[^}]*\})?", "", latex).strip()
    text = re.sub(r"\\(begin|end)\{(equation|displaymath)\*?\}", "", text)
    # The converter knows one environment of several lines that carries no running numbers: split.
    text = re.sub(r"\\(begin|end)\{(align|aligned|gather|gathered|eqnarray|multline)\*?\}", r"\\\1{split}", text)
    text = re.sub(r"\\\\\s*\[[^\]]*\]", r"\\\\", text)
    tags = re.findall(r"\\tag\*?\{([^}]*)\}", text)
    several = r"\begin{split}" in text
    if several:
        text = re.sub(r"\\tag\*?\{([^}]*)\}", r"& \\qquad\\text{(\1)}", text)
    else:
        text = re.sub(r"\\tag\*?\{[^}]*\}", "", text)
    try:
        result = _latex_to_mathml(text, display="block" if display else "inline")
    except Exception:  # whatever the converter stumbles over, the reader still gets the source
        result = ""
    # Commands it does not know come through as their own names, stray alignment marks unescaped.
    if not result or re.search(r">\\[A-Za-z]|>&<", result):
        return f'<code class="tex">{escape(latex.strip())}</code>'
    # One upright letter comes as a character reference that has lost its uprightness; those of a longer word belong
    # together in one element. A bar is a fence, not an operator with space around it.
    upright = '<mi mathvariant="normal">'
    result = re.sub(r"<mi>(&#x000[4-7][0-9A-F];)</mi>", rf"{upright}\1</mi>", result)
    word = rf"(?:{upright}\w</mi>){{2,}}"
    result = re.sub(word, lambda run: f"<mi>{re.sub('<[^>]*>', '', run[0])}</mi>", result)
    result = result.replace('<mo stretchy="false">&#x0007C;', '<mo stretchy="false" lspace="0" rspace="0">&#x0007C;')
    if display:
        tag = f'<span class="tag">({escape(", ".join(tags))})</span>' if tags and not several else ""
        return f'<span class="maths">{result}{tag}</span>'
    return result


class _Blocks(MathBlockParser):
    # Only at the start of a line: dollar signs inside a code span are text.
    SPECIFICATION = {
        **MathBlockParser.SPECIFICATION,
        "multiline_math": rf"^ {{0,3}}(?:{MathBlockParser.MULTILINE_MATH})",
    }


@dataclass
class _Document:
    """What has been seen of a page while its cells are written: headings and ids in use."""

    path: Path
    title: str = ""
    question: str = ""
    headings: list = field(default_factory=list)
    names: set = field(default_factory=set)
    tables: int = 0
    figures: int = 0

    def markdown(self, source, attachments=None):
        html = MarkdownWithMath(_Renderer(self, attachments), block=_Blocks()).render(source)
        return self.accessible_tables(html)

    def accessible_tables(self, html):
        """Name the scope of header cells, and let a wide table scroll in a box of its own.

        Columns of numbers are marked, to be set flush right, and short words, to be kept on one line. A table of very
        many rows is marked to scroll, too.
        """
        if "<table" not in html:
            return html
        soup = BeautifulSoup(html, "html.parser")
        for sheet in soup.find_all("style", attrs={"scoped": True}):
            sheet.decompose()  # pandas': it would set every head flush right, over text too
        for table in soup.find_all("table"):
            self.tables += 1
            for cell in table.find_all("th"):
                if cell.get_text(strip=True):
                    cell["scope"] = "col" if cell.find_parent("thead") else "row"
                else:
                    cell.name = "td"
            rows = [row.find_all(["th", "td"])[::-1] for row in table.find_all("tr")]
            for column in itertools.zip_longest(*rows):
                cells = [cell for cell in column if cell is not None]
                body = [cell.get_text(strip=True) for cell in cells if cell.name == "td"]
                if all(map(_NUMBER.fullmatch, body)) and any(body):
                    for cell in cells:
                        cell["class"] = "number"
            for cell in table.find_all(["th", "td"], class_=False):
                if len(cell.get_text(strip=True)) <= _SHORT:
                    cell["class"] = "short"
            table.attrs.pop("border", None)
            box = soup.new_tag("div", attrs={"class": "table tall" if len(rows) > _TALL else "table", "role": "region"})
            box["aria-label"] = f"Table {self.tables}"
            table.wrap(box)
        return str(soup)

    def svg(self, html):
        """Inline SVG with ids of its own on this page."""
        if "<svg" not in html:
            return html
        self.figures += 1
        return unique_ids(html[html.index("<svg") :] if html.startswith("<?xml") else html, f"f{self.figures}-")

    def output(self, output):
        """One output of a code cell as HTML, or "" if it is not part of the report."""
        if output.output_type == "stream":
            # Progress bars and warnings go to stderr: of use while running, not in a report.
            return _preformatted(output.text) if output.name == "stdout" else ""
        if output.output_type == "error":
            return _preformatted(f"{output.ename}: {output.evalue}")
        data, text = output.data, output.data.get("text/plain", "")
        if _WIDGET in data:
            return "" if re.search(r"\d+%\||\d+it \[", text) else _WIDGET_NOTE
        if "text/html" in data:
            return f'<div class="html">{self.svg(self.accessible_tables(data["text/html"]))}</div>'
        if "image/svg+xml" in data:
            return f'<div class="figure">{self.svg(data["image/svg+xml"])}</div>'
        for kind in ("image/png", "image/jpeg"):
            if kind in data:
                image = output.get("metadata", {}).get(kind, {})
                alt = escape(image.get("alt", ""), quote=True)
                return f'<div class="figure"><img src="data:{kind};base64,{data[kind].strip()}" alt="{alt}"></div>'
        if "text/markdown" in data:
            return self.markdown(data["text/markdown"])
        if "text/latex" in data:
            return f"<p>{mathml(data['text/latex'].strip().strip('$'), display=True)}</p>"
        return _preformatted(text)


class _Renderer(IPythonRenderer):
    """Markdown to HTML with MathML, links among reports, and headings that are remembered."""

    def __init__(self, document, attachments=None):
        super().__init__(
            escape=False,
            embed_images=True,
            exclude_anchor_links=True,
            path=str(document.path.parent),
            attachments=attachments or {},
        )
        self.document = document

    def block_math(self, body):
        return mathml(body, display=True)

    def inline_math(self, body):
        return mathml(body)

    def latex_environment(self, name, body):
        return mathml(f"\\begin{{{name}}}{body}\\end{{{name}}}", display=True)

    def link(self, text, url, title=None):
        if not re.match(r"[a-z][a-z0-9+.-]*:|//", url, re.IGNORECASE):
            url = re.sub(r"\.ipynb(?=$|[#?])", ".html", url)
        return super().link(text, url, title)

    def heading(self, text, level, **attrs):
        plain = BeautifulSoup(text, "html.parser").get_text()
        # JupyterLab's own names of headings, so that links inside a notebook work in both.
        name = base = plain.replace(" ", "-")
        number = 1
        while name in self.document.names:
            number += 1
            name = f"{base}-{number}"
        self.document.names.add(name)
        if level == 1 and not self.document.title:
            self.document.title = plain
        elif level == 2:
            self.document.headings.append((name, text))
        return f'<h{level} id="{escape(name, quote=True)}">{text}</h{level}>\n'


def _preformatted(text):
    """Printed text as a terminal would leave it: only what follows the last carriage return of a line."""
    lines = [line.rstrip("\r").rsplit("\r", 1)[-1] for line in strip_ansi(text).split("\n")]
    text = "\n".join(lines).strip("\n")
    return f'<pre class="output">{escape(text, quote=False)}</pre>' if text else ""


# Pages


def _page(notebook, path, every, seconds):
    """The whole page (str) of an executed notebook."""
    document = _Document(path)
    highlight = Highlight2HTML(pygments_lexer="python3")
    cells = []
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            cells.append({"kind": "markdown", "html": document.markdown(cell.source, cell.get("attachments"))})
        elif cell.cell_type == "code" and cell.source.strip():
            outputs = [html for html in map(document.output, cell.outputs) if html]
            # A panel of several widgets is one note.
            outputs = [html for i, html in enumerate(outputs) if html != _WIDGET_NOTE or html not in outputs[:i]]
            cells.append({"kind": "code", "html": highlight(cell.source), "outputs": outputs})
    place = every.index(path)
    page = (
        _templates()
        .get_template("page.html.j2")
        .render(
            title=document.title or path.stem,
            headings=document.headings,
            cells=cells,
            before=_neighbour(every, place - 1),
            after=_neighbour(every, place + 1),
            seconds=seconds,
            **_made(),
        )
    )
    _check_self_contained(page, path.name)
    return page


def _neighbour(every, place):
    if not 0 <= place < len(every):
        return None
    return {"href": f"{every[place].stem}.html", "title": _heading(every[place])[0]}


def _index(every, output, failures):
    rows = []
    for path in every:
        title, question = _heading(path)
        page = output / f"{path.stem}.html"
        rows.append(
            {
                "name": path.stem,
                "href": page.name if page.exists() else None,
                "title": title,
                "question": question,
                "made": _minute(datetime.fromtimestamp(page.stat().st_mtime)) if page.exists() else "",
                "failure": failures.get(path),
            }
        )
    page = _templates().get_template("index.html.j2").render(rows=rows, **_made())
    _check_self_contained(page, "index.html")
    return page


def _heading(path):
    """Title and question (HTML) of a notebook: its first heading, and the first sentence below."""
    try:
        cells = _read(path).cells
    except ReportError:
        return path.stem, ""
    source = next((cell.source for cell in cells if cell.cell_type == "markdown"), "")
    document = _Document(path)
    soup = BeautifulSoup(document.markdown(source), "html.parser")
    paragraph = soup.find("p")
    inner = "" if paragraph is None else " ".join(paragraph.decode_contents().split())
    # The shortest run of whole sentences in which every opened element is closed again.
    for end in re.finditer(r"[.?!](?:</\w+>)*(?=\s|$)", inner):
        sentence = inner[: end.end()]
        if str(BeautifulSoup(sentence, "html.parser")) == sentence:
            return document.title or path.stem, sentence
    return document.title or path.stem, inner


def _made():
    versions = [("Python", ".".join(map(str, sys.version_info[:3])))]
    return {"made": _minute(datetime.now()), "versions": versions + [(name, version(name)) for name in _PACKAGES]}


def _minute(moment):
    return moment.strftime("%Y-%m-%d %H:%M")


def _templates():
    return jinja2.Environment(
        loader=jinja2.PackageLoader(__package__, "templates"), trim_blocks=True, lstrip_blocks=True, autoescape=False
    )


class _Loads(HTMLParser):
    """Collects what a page would load from elsewhere; links that a reader may follow are not among it."""

    def __init__(self):
        super().__init__()
        self.found = []
        self._in_style = False

    def handle_starttag(self, tag, attrs):
        self._in_style = tag == "style"
        for name, value in attrs:
            loads = name in ("src", "srcset", "poster", "data", "background", "action") or (
                name in ("href", "xlink:href") and tag not in ("a", "area")
            )
            if loads and value and not value.startswith(("data:", "#")):
                self.found.append(value)
            elif name == "style":
                self._style(value or "")

    def handle_data(self, data):
        if self._in_style:
            self._style(data)

    def handle_endtag(self, tag):
        self._in_style = False

    def _style(self, text):
        self.found += re.findall(r"@import[^;]*", text)
        self.found += re.findall(r"url\(\s*[\"']?(?!data:|#)([^)\"']+)", text)


def _check_self_contained(page, name):
    parser = _Loads()
    parser.feed(page)
    if parser.found:
        raise ReportError(f"{name}: the page would load {parser.found[0]!r}; a report is one file that needs no other")


def _write(path, text):
    """Write the file whole or not at all."""
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}-", suffix=".part")
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except BaseException:
        os.unlink(temporary)
        raise
    return path
