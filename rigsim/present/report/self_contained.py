"""A report is one file that needs no other: what a page would load is found and refused, by us and by the browser."""

import base64
import hashlib
import re
from html.parser import HTMLParser

from .run import ReportError


class _Loads(HTMLParser):
    """Collects what a page would load from elsewhere, links that a reader may follow not among it, and its scripts."""

    def __init__(self):
        super().__init__()
        self.found, self.scripts = [], []
        self._in_style = self._in_script = False

    def handle_starttag(self, tag, attrs):
        self._in_style, self._in_script = tag == "style", tag == "script"
        if self._in_script:
            self.scripts.append("")
        if tag == "meta" and "http-equiv" in dict(attrs):  # a refresh leads away, and no policy keeps it
            self.found.append(dict(attrs).get("content") or "")
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
        if self._in_script:
            self.scripts[-1] += data

    def handle_endtag(self, tag):
        self._in_style = self._in_script = False

    def _style(self, text):
        self.found += re.findall(r"@import[^;]*", text)
        self.found += re.findall(r"url\(\s*[\"']?(?!data:|#)([^)\"']+)", text)


def check_self_contained(page, name):
    """Raise a `ReportError` if a page (str) would load anything; return the scripts (list of str) that are in it."""
    parser = _Loads()
    parser.feed(page)
    if parser.found:
        raise ReportError(f"{name}: the page would load {parser.found[0]!r}; a report is one file that needs no other")
    return parser.scripts


def seal(page, name):
    """The page (str) with a policy that lets a browser load nothing, and run no script but those that stand in it.

    Raises
    ------
    ReportError
        If it would load anything.
    """
    page = page.replace("\r\n", "\n").replace("\r", "\n")  # as browsers read it before they hash a script
    digests = {
        hashlib.sha256(script.encode("utf-8", "replace")).digest() for script in check_self_contained(page, name)
    }
    scripts = " ".join(sorted(f"'sha256-{base64.b64encode(digest).decode()}'" for digest in digests)) or "'none'"
    # Styles stand in attributes of every Matplotlib figure; they can load nothing either.
    policy = f"default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src {scripts}; "
    policy += "base-uri 'none'; form-action 'none'"
    return page.replace(
        '<meta charset="utf-8">',
        f'<meta charset="utf-8">\n<meta http-equiv="Content-Security-Policy" content="{policy}">',
        1,
    )
