"""The page of a record: every section, whatever the record says, and no text of a file as HTML."""

import re
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bs4 import BeautifulSoup

from rigsim.experiment.record import Record
from rigsim.identification.identify import identify
from rigsim.identification.troubles import Trouble
from rigsim.present.report import identified
from rigsim.present.report.identified import identified_page, identify_file
from tests.identification.cubic import cubic_record
from tests.identification.test_records import ACCELERATION, DISPLACEMENT
from tests.identification.test_records import record as record_of

SECTIONS = ["The record", "Troubles", "Parameters"]
SIMULATED = ["Residuals", "Prediction"]
LINEAR = ["Receptances", "Nonlinear coefficient", "Order"]


@pytest.fixture(scope="module")
def record():
    return cubic_record(duration=10, noise=0.01)


@pytest.fixture(scope="module")
def found(record):
    return identify(record)


@pytest.fixture
def quick(monkeypatch):
    """Leaves out figures, which take most of the time."""
    monkeypatch.setattr(identified._Page, "figure", lambda *_: None)


def soup_of(page):
    return BeautifulSoup(page, "html.parser")


def test_page_has_every_section_and_its_figures_say_what_is_seen(found, record):
    page = identified_page(found, record, "own.csv", force=3.18, settings={"order": 4})
    soup = soup_of(page)
    headings = [heading.text for heading in soup.find_all("h2")]
    assert headings == [*SECTIONS, *SIMULATED, *LINEAR, "Detached curves", "Settings"]
    assert [a.text for a in soup.select("nav.contents a")] == headings
    assert {a["href"][1:] for a in soup.select("nav.contents a")} == {heading["id"] for heading in soup.find_all("h2")}
    assert soup.h1.text == "What own.csv says of its rig" and "order = 4" in soup.text
    assert len(soup.find_all("svg")) == 9 and all(len(svg["aria-label"]) > 40 for svg in soup.find_all("svg"))
    cells = [cell.text for cell in soup.find_all(["td", "th"])]
    assert f"{found.k3:.5g}" in cells and f"{found.errors.half_width[6]:.5g}" in cells
    assert re.search(r"At 3.18 N an inner detached curve exists with \d+ %", soup.text)
    ids = re.findall(r'\sid="([^"]*)"', page)
    assert len(ids) == len(set(ids)) and not soup.find("a", href="index.html")


@pytest.mark.usefixtures("quick")
def test_troubles_are_told_by_what_became_of_them(found, record):
    trouble = Trouble("delay", "mass is late", {"delay": {"mass": 1e-3}})
    changed = replace(
        found, mended=(trouble, Trouble("break", "begins anew")), troubles=(Trouble("gain", "too small"),)
    )
    text = soup_of(identified_page(changed, record, "own.csv")).text
    places = [text.index(part) for part in ("Found and mended", "is late", "begins anew", "Not mended", "too small")]
    assert places == sorted(places) and "None was found" not in text
    hopeless = replace(found, mended=(Trouble("lost", "samples were lost"),), troubles=())
    text = soup_of(identified_page(hopeless, record, "own.csv")).text
    assert text.index("not to be mended") < text.index("samples were lost")
    assert "None was found" in soup_of(identified_page(replace(found, mended=(), troubles=()), record, "x")).text


def test_a_record_that_no_rig_repeats_has_a_page_too():
    noise = np.random.default_rng(0).standard_normal((3, 20_000))
    record = Record(noise[0], 1e-4 * noise[1], 1e-4 * noise[2], 2000)
    found = identify(record)
    soup = soup_of(identified_page(found, record, "noise.csv"))
    headings = [heading.text for heading in soup.find_all("h2")]
    assert headings == [*SECTIONS, *LINEAR] and "doubtful" in soup.text and "no intervals" in soup.text


@pytest.mark.usefixtures("quick")
def test_nothing_that_a_file_says_is_html(tmp_path, monkeypatch, record, found):
    odd = "<script>alert('1')<\N{DIVISION SLASH}script> & \"x\" #?%41 é.csv"
    record.save(tmp_path / odd)

    def guessing(path, **options):
        warnings.warn(f"{path.name} has a channel <img src=x onerror=alert(2)>", UserWarning, stacklevel=1)
        return record.replace(**{name: value for name, value in options.items() if name == "hold"})

    monkeypatch.setattr(identified.Record, "load", guessing)
    monkeypatch.setattr(identified, "identify", lambda record, **_: found)
    _, guessed, page = identify_file(tmp_path / odd, tmp_path / "out.html", load={"hold": "zero"})
    soup = soup_of(page.read_text(encoding="utf-8"))
    assert len(guessed) == 1 and odd in soup.h1.text and "<img src=x" in soup.text
    assert not soup.find("img") and not [script for script in soup.find_all("script") if "alert" in script.text]
    policy = soup.find("meta", attrs={"http-equiv": True})["content"]
    assert "default-src 'none'" in policy and "unsafe-inline'; script-src 'sha256-" in policy


@pytest.mark.usefixtures("quick")
def test_page_is_named_after_the_record_and_written_whole_or_not_at_all(tmp_path, monkeypatch, record, found):
    record.save(tmp_path / "own.csv")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(identified, "identify", lambda record, **_: found)
    assert identify_file("own.csv")[2] == Path("own_identified.html")
    before = Path("own_identified.html").read_bytes()

    def refuse(*_):
        raise OSError("disk full")

    monkeypatch.setattr("os.replace", refuse)
    with pytest.raises(OSError, match="disk full"):
        identify_file("own.csv")
    assert Path("own_identified.html").read_bytes() == before and len(list(tmp_path.iterdir())) == 2


def test_what_is_not_allowed_is_found_before_the_work(tmp_path, monkeypatch, record):
    record.save(tmp_path / "own.csv")
    monkeypatch.setattr(identified, "identify", None)
    with pytest.raises(ValueError, match="force = -3"):
        identify_file(tmp_path / "own.csv", tmp_path / "out.html", -3)
    with pytest.raises(ValueError, match="record itself"):
        identify_file(tmp_path / "own.csv", tmp_path / "own.csv")
    with pytest.raises(OSError, match="a folder is there"):
        identify_file(tmp_path / "own.csv", tmp_path)


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("kinds", [(ACCELERATION,), (ACCELERATION, DISPLACEMENT)])
def test_what_was_measured_is_called_what_it_is(kinds):
    on_base = record_of(kinds, n=20_000, base=True, rms=10.0 if len(kinds) == 1 else 1.0, noise=1e-3)
    known = identify(on_base)
    assert known.errors.half_width[0] == known.errors.bound[0] == 0.0 and (known.errors.half_width[1:] > 0).all()
    text = soup_of(identified_page(known, on_base, "base.csv", settings={"band": (2.0, 80.0), "order": "auto"})).text
    assert re.search(r"base [\d.]+ m/s\^2 rms", text) and "the force" not in text
    assert "first mass, which is 1" in text and "base's acceleration alone" in text
    assert "band = 2 to 80 Hz, order = auto" in text and "weighed" not in text and "Detached curves" not in text
    figure = known.plot("residuals")
    assert figure.axes[2 * len(kinds)].get_ylabel() == "correlation with base" and "with the base out" in figure.alt
    drawn = known.plot("parameters").axes[0]
    assert drawn.get_xlim()[0] > 1e-8  # an interval of nothing sets no scale
    assert on_base.plot().axes[0].get_ylabel() == "base [m/s^2]"
    assert on_base.plot().axes[1].get_ylabel() == "shaker [m/s^2]" and list(on_base.table().index)[0] == "base"


@pytest.mark.usefixtures("quick")
def test_several_files_are_tests_of_one_rig(tmp_path, monkeypatch, found):
    monkeypatch.setattr(identified, "identify", lambda record, **_: seen.append(record) or found)
    monkeypatch.chdir(tmp_path)
    seen, names = [], ["soft.csv", "hard.csv"]
    for name, rms in zip(names, (0.3, 1.115), strict=True):
        record_of(n=500, rms=rms).save(name)
    _, _, page = identify_file(names, progress=False)
    assert page == Path("soft_identified.html") and seen[0].joints == (0, 500)
    assert soup_of(page.read_text(encoding="utf-8")).h1.text == "What soft.csv and hard.csv say of their rig"
    with pytest.raises(ValueError, match="record itself"):
        identify_file(names, "hard.csv")
    with pytest.raises(ValueError, match=r"path = \[\]"):
        identify_file([])
    record_of((ACCELERATION,), n=500).save("other.csv")
    with pytest.raises(ValueError, match="kinds of the records"):
        identify_file([*names, "other.csv"])


@pytest.mark.usefixtures("quick")
def test_columns_are_named_or_counted(tmp_path, monkeypatch, found):
    monkeypatch.setattr(identified, "identify", lambda record, **_: seen.append(record) or found)
    seen, table = [], np.random.default_rng(0).standard_normal((50, 4))
    for name, header in (("words.csv", "Ch A,Ch B,Ch C,Ch D"), ("numbers.csv", "tacho,2,1,0")):
        np.savetxt(tmp_path / name, table, delimiter=",", header=header, comments="")
        load = {"channels": {"force": "0", "shaker": "1", "mass": "2"}, "hold": "zero", "sample_rate": 100.0}
        load["units"] = {"force": "N", "shaker": "m", "mass": "m"}
        identify_file(tmp_path / name, tmp_path / "out.html", load=load, progress=False)
    by_number, by_name = seen
    np.testing.assert_allclose(by_number.force, table[:, 0])
    np.testing.assert_allclose(by_name.force, table[:, 3])
