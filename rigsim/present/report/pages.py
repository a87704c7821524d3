"""Whole pages: a notebook's, and the index of all."""

import os
import re
import sys
from datetime import datetime
from importlib.metadata import version
from urllib.parse import quote

import jinja2
from bs4 import BeautifulSoup
from nbconvert.filters.highlight import Highlight2HTML

from .document import WIDGET_NOTE, Document
from .run import ReportError, read_notebook
from .self_contained import seal

_PACKAGES = ("rigsim", "numpy", "scipy", "pymunk", "numba", "matplotlib", "ipywidgets", "jupyterlab")


def notebook_page(notebook, path, every, seconds):
    """The whole page (str) of an executed notebook."""
    document = Document(path)
    highlight = Highlight2HTML(pygments_lexer="python3")
    cells = []
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            cells.append({"kind": "markdown", "html": document.markdown(cell.source, cell.get("attachments"))})
        elif cell.cell_type == "code" and cell.source.strip():
            outputs = [html for html in map(document.output, cell.outputs) if html]
            # A panel of several widgets is one note.
            outputs = [html for i, html in enumerate(outputs) if html != WIDGET_NOTE or html not in outputs[:i]]
            cells.append({"kind": "code", "html": highlight(cell.source), "outputs": outputs})
    place = every.index(path)
    page = rendered(
        "page.html.j2", title=document.title or path.stem, headings=document.headings, cells=cells, home="index.html",
        before=_neighbour(every, place - 1), after=_neighbour(every, place + 1), seconds=seconds,
    )  # fmt: skip
    return seal(page, path.name)


def _neighbour(every, place):
    if not 0 <= place < len(every):
        return None
    return {"href": _href(f"{every[place].stem}.html"), "title": _heading(every[place])[0]}


def _href(name):
    return quote(os.fsencode(name))


def index_page(every, output, failures):
    """The page (str) that leads to every notebook's."""
    rows = []
    for path in every:
        title, question = _heading(path)
        page = output / f"{path.stem}.html"
        rows.append(
            {
                "name": path.stem,
                "href": _href(page.name) if page.exists() else None,
                "title": title,
                "question": question,
                "made": _minute(datetime.fromtimestamp(page.stat().st_mtime)) if page.exists() else "",
                "failure": failures.get(path),
            }
        )
    return seal(rendered("index.html.j2", rows=rows), "index.html")


def _heading(path):
    """Title and question (HTML) of a notebook: its first heading, and the first sentence below."""
    try:
        cells = read_notebook(path).cells
    except ReportError:
        return path.stem, ""
    source = next((cell.source for cell in cells if cell.cell_type == "markdown"), "")
    document = Document(path)
    soup = BeautifulSoup(document.markdown(source), "html.parser")
    paragraph = soup.find("p")
    inner = "" if paragraph is None else " ".join(paragraph.decode_contents().split())
    # The shortest run of whole sentences in which every opened element is closed again.
    for end in re.finditer(r"[.?!](?:</\w+>)*(?=\s|$)", inner):
        sentence = inner[: end.end()]
        if str(BeautifulSoup(sentence, "html.parser")) == sentence:
            return document.title or path.stem, sentence
    return document.title or path.stem, inner


def rendered(template, **values):
    """A template (its name) filled in, with when and by which versions it was made; text is escaped (str)."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader(__package__, "templates"), trim_blocks=True, lstrip_blocks=True, autoescape=True
    )
    return environment.get_template(template).render(**values, **_made())


def _made():
    versions = [("Python", ".".join(map(str, sys.version_info[:3])))]
    return {"made": _minute(datetime.now()), "versions": versions + [(name, version(name)) for name in _PACKAGES]}


def _minute(moment):
    return moment.strftime("%Y-%m-%d %H:%M")
