"""Cells as HTML: maths, links, headings and tables."""

import re
from pathlib import Path

import pandas as pd
import pytest
from bs4 import BeautifulSoup

from rigsim.present.report.document import Document, preformatted


def test_dollars_that_are_not_maths_are_left_alone():
    page = Document(Path("x.ipynb")).markdown("A price of \\$5 and \\$6, `$x$`, `$$y$$`, and\n\n```\n$$ z $$\n```\n")
    assert "<math" not in page
    for text in ("$5 and $6", "<code>$x$</code>", "<code>$$y$$</code>", "$$ z $$"):
        assert text in page


@pytest.mark.parametrize(
    ("url", "wanted"),
    [
        ("01_modelling.ipynb", "01_modelling.html"),
        ("./01_modelling.ipynb#The-rig", "./01_modelling.html#The-rig"),
        ("https://example.org/a.ipynb", "https://example.org/a.ipynb"),
        ("#Here", "#Here"),
    ],
)
def test_links_lead_to_reports(url, wanted):
    assert f'href="{wanted}"' in Document(Path("x.ipynb")).markdown(f"[text]({url})")


def test_headings_are_remembered_and_apart():
    document = Document(Path("x.ipynb"))
    page = document.markdown("# Title\n\n## What is $k_1$?\n\n## Same\n\n## Same\n")
    assert document.title == "Title" and len(document.headings) == 3
    names = [name for name, _ in document.headings]
    assert len(set(names)) == 3 and all(f'id="{name}"' in page for name in names)


def test_tables_name_their_headers_and_align_numbers():
    table = "<table><thead><tr><th></th><th>k</th><th>cause</th></tr></thead><tbody>"
    table += (
        "<tr><th>a</th><td>-1.5e-3</td><td>rounded</td></tr><tr><th>b</th><td>2 %</td><td></td></tr></tbody></table>"
    )
    soup = BeautifulSoup(Document(Path("x.ipynb")).accessible_tables(table), "html.parser")
    assert [(cell.text, cell["scope"]) for cell in soup.find_all("th")] == [
        ("k", "col"), ("cause", "col"), ("a", "row"), ("b", "row"),
    ]  # fmt: skip
    assert [cell.text for cell in soup.find_all(class_="number")] == ["k", "-1.5e-3", "2 %"]
    box = soup.find("div")
    assert box["role"] == "region" and box["aria-label"] == "Table 1"


def test_pandas_heads_stand_as_their_columns_do():
    table = pd.DataFrame({"kind": ["inner"], "low [Hz]": [20.5]})._repr_html_()
    assert "text-align: right" in re.search(r"(?s)<style scoped.*?</style>", table)[0]
    assert "<style" not in Document(Path("x.ipynb")).accessible_tables(table)


def test_printed_text_is_what_a_terminal_would_leave():
    assert ">50 &lt; 100</pre>" in preformatted("10%\r50 < 100\r\n")
    assert preformatted("\n") == ""
