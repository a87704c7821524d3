"""A report is one file that needs no other: what a page would load is found and refused."""

import re
from html.parser import HTMLParser

from .run import ReportError


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


def check_self_contained(page, name):
    """Raise a `ReportError` if a page (str) would load anything."""
    parser = _Loads()
    parser.feed(page)
    if parser.found:
        raise ReportError(f"{name}: the page would load {parser.found[0]!r}; a report is one file that needs no other")
