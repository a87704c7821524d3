"""What cells say and show, as HTML that needs nothing else."""

import itertools
import re
from dataclasses import dataclass, field
from html import escape
from pathlib import Path

from bs4 import BeautifulSoup
from nbconvert.filters.ansi import strip_ansi
from nbconvert.filters.markdown_mistune import IPythonRenderer, MarkdownWithMath, MathBlockParser

from ..figures.svg import unique_ids
from .mathml import mathml

_NUMBER = re.compile(r"(?:nan|[-+\u2212]?inf|[-+\u2212]?[\d.][\d.,e+\u2212-]*(?:\s*%|j)?)?", re.IGNORECASE)
_SHORT = 24  # characters that a table's cell keeps on one line
_TALL = 100  # rows beyond which a table scrolls in a box of its own
_WIDGET = "application/vnd.jupyter.widget-view+json"
WIDGET_NOTE = '<p class="note">An interactive panel stands here when the notebook is open: live in JupyterLab.</p>'


class _Blocks(MathBlockParser):
    # Only at the start of a line: dollar signs inside a code span are text.
    SPECIFICATION = {
        **MathBlockParser.SPECIFICATION,
        "multiline_math": rf"^ {{0,3}}(?:{MathBlockParser.MULTILINE_MATH})",
    }


@dataclass
class Document:
    """What has been seen of a page while its cells are written: headings and ids in use."""

    path: Path
    title: str = ""
    headings: list = field(default_factory=list)
    names: set = field(default_factory=set)
    tables: int = 0
    figures: int = 0

    def markdown(self, source, attachments=None):
        """A cell's text as HTML."""
        html = MarkdownWithMath(_Renderer(self, attachments), block=_Blocks()).render(source)
        return self.accessible_tables(_without_scripts(html))

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
            return preformatted(output.text) if output.name == "stdout" else ""
        if output.output_type == "error":
            return preformatted(f"{output.ename}: {output.evalue}")
        data, text = output.data, output.data.get("text/plain", "")
        if _WIDGET in data:
            return "" if re.search(r"\d+%\||\d+it \[", text) else WIDGET_NOTE
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
        return preformatted(text)


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
            self.document.headings.append((name, _without_scripts(text)))
        return f'<h{level} id="{escape(name, quote=True)}">{text}</h{level}>\n'


def _without_scripts(html):
    """Text runs nothing, as in JupyterLab: only what code has shown may."""
    return re.sub(r"<(?=/?script\b)", "&lt;", html, flags=re.IGNORECASE)


def preformatted(text):
    """Printed text as a terminal would leave it: only what follows the last carriage return of a line."""
    lines = [line.rstrip("\r").rsplit("\r", 1)[-1] for line in strip_ansi(text).split("\n")]
    text = "\n".join(lines).strip("\n")
    return f'<pre class="output">{escape(text, quote=False)}</pre>' if text else ""
