"""Reports from notebooks to pages, without a browser."""

import html
import json
import os
import re
import sys
from urllib.parse import unquote

import pytest
from bs4 import BeautifulSoup
from nbformat.v4 import new_code_cell, new_markdown_cell

from rigsim.present.report.build import build_reports
from rigsim.present.report.run import ReportError
from tests.present.small_notebooks import FAILING, SECOND, write_notebook


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


ODD = "07_<script>alert('7')</script> & \"x\" #?%41 é"


@pytest.fixture
def odd_reports(tmp_path):
    """Pages of a notebook whose name and text would be HTML, and of one that fails."""
    odd = f"# {ODD}\n\nWhy <b>so</b>? <script>alert(1)</script>\n\n## {ODD}\n\n<img src='data:,' onerror='alert(2)'>"
    name = ODD.replace("/", "\N{DIVISION SLASH}")
    write_notebook(tmp_path / f"{name}.ipynb", [new_markdown_cell(odd), new_code_cell("'<script>alert(3)</script>'")])
    write_notebook(tmp_path / f"{name.replace('07', '08')}.ipynb", [new_code_cell(f"raise ValueError({ODD!r})")])
    with pytest.raises(ReportError, match="08_<script>"):
        build_reports(notebooks=tmp_path, output=tmp_path / "out", progress=False)
    return tmp_path / "out"


def test_names_and_texts_are_no_html(odd_reports):
    page, index = sorted(odd_reports.iterdir())
    for path in (page, index):
        soup = BeautifulSoup(path.read_text(encoding="utf-8"), "html.parser")
        assert not [script for script in soup.find_all("script") if "alert" in script.text]
        assert "default-src 'none'" in soup.find("meta", attrs={"http-equiv": True})["content"]
    links = [unquote(a["href"]) for a in soup.find_all("a")]
    assert links == [page.name] and "<script>" in soup.find("p", class_="failure").text


@pytest.mark.parametrize("trouble", ["a file", "below a file", "no notebook folder"])
def test_output_that_cannot_be_written_is_found_before_anything_runs(tmp_path, monkeypatch, trouble):
    write_notebook(tmp_path / "02_second.ipynb", SECOND)
    monkeypatch.setattr("rigsim.present.report.build.run_notebook", None)
    (tmp_path / "file").write_text("mine")
    output = {"a file": tmp_path / "file", "below a file": tmp_path / "file" / "out"}.get(trouble)
    if output is None:
        with pytest.raises(ValueError, match="holds no numbered notebook"):
            build_reports(notebooks=tmp_path / "file", output=tmp_path / "out")
        return
    with pytest.raises(OSError, match=re.escape(str(output))):
        build_reports(notebooks=tmp_path, output=output)
    assert (tmp_path / "file").read_text() == "mine"


@pytest.mark.parametrize(
    ("options", "message"), [({}, "holds no numbered notebook"), ({"names": ["09"]}, "'09'; expected one of 02_second")]
)
def test_bad_names(tmp_path, options, message):
    if options:
        write_notebook(tmp_path / "02_second.ipynb", SECOND)
    with pytest.raises(ValueError, match=message):
        build_reports(notebooks=tmp_path, output=tmp_path / "out", **options)
