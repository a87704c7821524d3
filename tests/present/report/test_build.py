"""Reports: maths, links, tables and errors, without a browser."""

import html
import json
import os
import re
import sys
from pathlib import Path
from xml.etree import ElementTree

import pandas as pd
import pytest
from bs4 import BeautifulSoup
from nbformat.v4 import new_code_cell, new_markdown_cell

from rigsim.present.report.build import (
    ReportError,
    _check_self_contained,
    _Document,
    _preformatted,
    build_reports,
    mathml,
)
from tests.present.small_notebooks import FAILING, SECOND, write_notebook


def text_of(mathml_text):
    """What is written, in reading order, without the gaps."""
    return "".join(ElementTree.fromstring(mathml_text.replace("&nbsp;", " ")).itertext()).replace(" ", "")


@pytest.mark.parametrize(
    ("latex", "written"),
    [
        (r"\frac{9}{16}\gamma^2", "916γ2"),
        (r"\mathrm{N/m^3}", "N/m3"),
        (r"\operatorname{Re}(U e^{i \omega t})", "Re(Ueiωt)"),
        (r"x = 1 \tag{3a}", "x=1(3a)"),
        (r"\begin{align} a &= b \tag{1} \\[2pt] c &= d \label{eq:d} \end{align}", "a=b(1)c=d"),
        (r"\begin{aligned} a &= b \\ c &= d \end{aligned}", "a=bc=d"),
        (r"\begin{equation} x < 1 \end{equation}", "x<1"),
        (r"\begin{cases} 1 & x > 0 \\ 0 & \text{else} \end{cases}", "{1x>00else"),
        (r"\begin{bmatrix} a & b \\ c & d \end{bmatrix}", "[abcd]"),
    ],
)
def test_maths_becomes_mathml(latex, written):
    result = mathml(latex, display=True)
    assert "<math" in result
    assert text_of(result).replace("\u2003", "") == written


@pytest.mark.parametrize("latex", [r"\nosuchcommand{x}", r"a \begin{align} b", "x & y", r"\frac{a}{", "}", ""])
def test_maths_that_cannot_be_converted_stays_readable(latex):
    result = mathml(latex, display=True)
    ElementTree.fromstring(result)
    assert "<math" in result or html.escape(latex) in result


def test_units_stand_upright():
    assert "<mi>Hz</mi>" in mathml(r"3\,\mathrm{Hz}")
    assert '<mi mathvariant="normal">' in mathml(r"3\,\mathrm{N}")
    assert '<mi mathvariant="normal">' not in mathml("N")


def test_dollars_that_are_not_maths_are_left_alone():
    page = _Document(Path("x.ipynb")).markdown("A price of \\$5 and \\$6, `$x$`, `$$y$$`, and\n\n```\n$$ z $$\n```\n")
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
    assert f'href="{wanted}"' in _Document(Path("x.ipynb")).markdown(f"[text]({url})")


def test_headings_are_remembered_and_apart():
    document = _Document(Path("x.ipynb"))
    page = document.markdown("# Title\n\n## What is $k_1$?\n\n## Same\n\n## Same\n")
    assert document.title == "Title" and len(document.headings) == 3
    names = [name for name, _ in document.headings]
    assert len(set(names)) == 3 and all(f'id="{name}"' in page for name in names)


def test_tables_name_their_headers_and_align_numbers():
    table = "<table><thead><tr><th></th><th>k</th><th>cause</th></tr></thead><tbody>"
    table += (
        "<tr><th>a</th><td>-1.5e-3</td><td>rounded</td></tr><tr><th>b</th><td>2 %</td><td></td></tr></tbody></table>"
    )
    soup = BeautifulSoup(_Document(Path("x.ipynb")).accessible_tables(table), "html.parser")
    assert [(cell.text, cell["scope"]) for cell in soup.find_all("th")] == [
        ("k", "col"), ("cause", "col"), ("a", "row"), ("b", "row"),
    ]  # fmt: skip
    assert [cell.text for cell in soup.find_all(class_="number")] == ["k", "-1.5e-3", "2 %"]
    box = soup.find("div")
    assert box["role"] == "region" and box["aria-label"] == "Table 1"


def test_pandas_heads_stand_as_their_columns_do():
    table = pd.DataFrame({"kind": ["inner"], "low [Hz]": [20.5]})._repr_html_()
    assert "text-align: right" in re.search(r"(?s)<style scoped.*?</style>", table)[0]
    assert "<style" not in _Document(Path("x.ipynb")).accessible_tables(table)


def test_printed_text_is_what_a_terminal_would_leave():
    assert ">50 &lt; 100</pre>" in _preformatted("10%\r50 < 100\r\n")
    assert _preformatted("\n") == ""


def test_page_holds_what_it_should(small_reports):
    page = (small_reports / "01_first.html").read_text(encoding="utf-8")
    soup = BeautifulSoup(page, "html.parser")
    assert soup.h1.text == "Does the first page move?"
    assert [a.text for a in soup.select("nav.contents a")] == ["Equations", "Figures", "Motion", "Tables and panels"]
    assert soup.find("a", href="02_second.html#What-else") and soup.find("a", href="https://example.org/page.ipynb")
    assert [svg["aria-label"] for svg in soup.find_all("svg")][:2] == [
        "A straight line that rises",
        "Two lines that fall",
    ]
    assert all(svg["role"] == "img" for svg in soup.find_all("svg"))
    outputs = [pre.text for pre in soup.find_all("pre", class_="output")]
    assert outputs == ["printed"], "neither warnings nor progress bars"
    assert "Tension" not in re.sub(r"(?s)<details>.*?</details>", "", page) and page.count("live in JupyterLab") == 1
    ids = re.findall(r'\sid="([^"]*)"', page)
    assert len(ids) == len(set(ids)), "each id once, over all figures"
    referred = re.findall(r'url\(#([^)]*)\)|href="#([^"]*)"', page)
    assert {one or other for one, other in referred} <= set(ids)
    assert "code.tex" in page and '<code class="tex">' not in page


def test_index_names_each_page_and_its_question(small_reports):
    soup = BeautifulSoup((small_reports / "index.html").read_text(encoding="utf-8"), "html.parser")
    cards = soup.find_all("article")
    assert [card.a["href"] for card in cards] == ["01_first.html", "02_second.html"]
    assert "It does, at" in cards[0].p.text and "A second" not in cards[0].p.text
    assert cards[1].p.text == "What is left?"
    assert "numpy" in soup.footer.text


def test_kernel_is_this_interpreter_whatever_is_installed(tmp_path, monkeypatch):
    spec = tmp_path / "data" / "kernels" / "python3"
    spec.mkdir(parents=True)
    argv = ["/no/such/python", "-m", "ipykernel_launcher", "-f", "{connection_file}"]
    (spec / "kernel.json").write_text(json.dumps({"argv": argv, "display_name": "other", "language": "python"}))
    monkeypatch.setenv("JUPYTER_PATH", str(tmp_path / "data"))
    write_notebook(tmp_path / "02_second.ipynb", SECOND)
    page, _ = build_reports(notebooks=tmp_path, output=tmp_path / "out", progress=False)
    assert html.escape(repr(sys.executable), quote=False) in page.read_text(encoding="utf-8")


def test_failing_notebook_is_named_and_the_others_are_written(tmp_path, capfd):
    write_notebook(tmp_path / "02_second.ipynb", SECOND)
    write_notebook(tmp_path / "03_failing.ipynb", FAILING)
    write_notebook(
        tmp_path / "04_loads.ipynb", [new_code_cell("from IPython.display import HTML\nHTML('<img src=//x.y/z.png>')")]
    )
    (tmp_path / "05_broken.ipynb").write_text("{")
    output = tmp_path / "out"
    output.mkdir()
    (output / "03_failing.html").write_text("an earlier, whole page")
    with pytest.raises(ReportError) as caught:
        build_reports(notebooks=tmp_path, output=output)
    first, second, third = str(caught.value).splitlines()
    assert first == "03_failing.ipynb, code cell 2: ArithmeticError: two lines of woe"
    assert second.startswith("04_loads.ipynb: the page would load '//x.y/z.png'")
    assert third.startswith("05_broken.ipynb is no notebook")
    assert sorted(os.listdir(output)) == ["02_second.html", "03_failing.html", "index.html"]
    assert (output / "03_failing.html").read_text() == "an earlier, whole page"
    assert "ArithmeticError" in (output / "index.html").read_text()
    assert re.search(r"02_second: \d+ s", capfd.readouterr().err)


def test_unwritable_page_leaves_no_part_of_it(tmp_path, monkeypatch):
    write_notebook(tmp_path / "02_second.ipynb", [new_markdown_cell("# Second")])

    def refuse(*paths):
        raise OSError("disk full")

    monkeypatch.setattr(os, "replace", refuse)
    with pytest.raises(OSError, match="disk full"):
        build_reports(notebooks=tmp_path, output=tmp_path / "out", progress=False)
    assert os.listdir(tmp_path / "out") == []


@pytest.mark.parametrize(
    "page",
    [
        '<script src="https://x.y/z.js"></script>', '<link rel="stylesheet" href="z.css">', "<img srcset='z.png 2x'>",
        "<style>@import 'z.css';</style>", "<style>a { background: url(https://x.y/z.png) }</style>",
        "<p style=\"background: url('z.png')\">", '<svg><use xlink:href="z.svg#a"/></svg>',
        "<iframe src=z.html></iframe>",
    ],
)  # fmt: skip
def test_whatever_would_load_something_is_refused(page):
    with pytest.raises(ReportError, match="would load"):
        _check_self_contained(page, "x")


def test_links_and_data_are_not_refused():
    _check_self_contained('<a href="https://x.y">a</a><img src="data:,"><use href="#a"/><g clip-path="url(#a)"/>', "x")


@pytest.mark.parametrize(
    ("options", "message"), [({}, "holds no numbered notebook"), ({"names": ["09"]}, "'09'; expected one of 02_second")]
)
def test_bad_names(tmp_path, options, message):
    if options:
        write_notebook(tmp_path / "02_second.ipynb", SECOND)
    with pytest.raises(ValueError, match=message):
        build_reports(notebooks=tmp_path, output=tmp_path / "out", **options)
