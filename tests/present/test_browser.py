"""Pages opened from disk in a real browser: nothing leaves the disk, nothing overflows, sliders move the picture."""

import os
from contextlib import contextmanager
from pathlib import Path

import pytest

NOTEBOOKS = Path(__file__).parents[2] / "notebooks"
PROMISED = ("00_tour", "01_modelling", "02_identification", "03_detached_curves", "04_wobbling")
MOVING = ("01_modelling", "03_detached_curves", "04_wobbling")
EVERY = sorted({*PROMISED, *(path.stem for path in NOTEBOOKS.glob("[0-9][0-9]_*.ipynb"))})

# Text outside code that a reader sees.
SEEN = """() => {
    const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT), seen = [];
    while (walk.nextNode()) {
        const inside = walk.currentNode.parentElement;
        if (!inside.closest("code, pre, script, style") && inside.getClientRects().length)
            seen.push(walk.currentNode.data);
    }
    return seen.join(" ");
}"""


@contextmanager
def opened(browser, path, width=1200, **options):
    """The page at a path, which must neither ask for anything but itself nor complain."""
    context = browser.new_context(viewport={"width": width, "height": 900}, **options)
    page = context.new_page()
    requests, complaints = [], []
    page.on("request", lambda request: requests.append(request.url))
    page.on("console", lambda message: complaints.append(message.text) if message.type != "log" else None)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.goto(path.as_uri())
    yield page
    page.wait_for_load_state("networkidle")
    away = [url for url in requests if url != path.as_uri() and not url.startswith("data:")]
    assert requests[0] == path.as_uri() and not away, "the page asks for what is not in it"
    assert not complaints
    context.close()


def move_every_slider(page):
    """Move each slider by keyboard, see its paths and its picture change, and return how many there are."""
    figures = page.locator(".rigsim-moving").all()
    for figure in figures:
        slider, drawing = figure.locator("input[type=range]"), figure.locator("svg")
        assert slider.evaluate("range => range.labels[0].textContent.trim()")

        def state(figure=figure, slider=slider, drawing=drawing):
            paths = figure.locator("path.moves").evaluate_all("paths => paths.map(path => path.getAttribute('d'))")
            shown = figure.locator("output").text_content()
            assert slider.get_attribute("aria-valuetext") == shown and shown in drawing.get_attribute("aria-label")
            return paths, shown, drawing.screenshot(animations="disabled")

        drawing.scroll_into_view_if_needed()
        before = state()
        slider.focus()
        page.keyboard.press("Home" if slider.evaluate("range => range.value === range.max") else "End")
        after = state()
        for old, new, what in zip(before, after, ("path", "value shown", "picture"), strict=True):
            assert old != new, f"the slider left its {what} as it was"
        page.keyboard.press("ArrowLeft" if slider.evaluate("range => range.value === range.max") else "ArrowRight")
        assert state()[:2] != after[:2]
    return len(figures)


def look_over(page):
    """What holds for every page: readable maths, no overflow, nothing serious for a screen reader."""
    from axe_playwright_python.sync_playwright import Axe

    seen = page.evaluate(SEEN)
    assert "$$" not in seen and "\\begin" not in seen and "\\frac" not in seen
    assert page.locator("code.tex").all_text_contents() == [], "maths that was not converted"
    for width in (1200, 400):
        page.set_viewport_size({"width": width, "height": 900})
        overflow = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
        assert overflow <= 0, f"{overflow} px too wide at {width} px"
        found = [
            f"{each['id']}: {each['nodes'][0]['html'][:200]}"
            for each in Axe().run(page).response["violations"]
            if each["impact"] in ("serious", "critical")
        ]
        assert not found, f"at {width} px"


@pytest.mark.parametrize("color_scheme", ["light", "dark"])
def test_page_is_sound(browser, small_reports, color_scheme):
    with opened(browser, small_reports / "01_first.html", color_scheme=color_scheme) as page:
        page.click("#code-button")
        assert page.locator("section.code > details[open]").count() == page.locator("section.code > details").count()
        look_over(page)


def test_index_is_sound_and_leads_to_the_pages(browser, small_reports):
    with opened(browser, small_reports / "index.html") as page:
        look_over(page)
    context = browser.new_context()
    page = context.new_page()
    page.goto((small_reports / "index.html").as_uri())
    page.click("text=Does the first page move?")
    page.click("text=the second")
    assert page.url.endswith("02_second.html#What-else")
    assert page.locator(":target").text_content() == "What else"
    context.close()


def test_policy_stops_what_is_not_the_pages_own(browser, small_reports, tmp_path):
    """The rest of this file sees that nothing of a page's own is stopped."""
    text = (small_reports / "01_first.html").read_text(encoding="utf-8")
    let_in = "<script>window.ran = 1</script><img src=x onerror='window.ran = 2'><img src='http://127.0.0.1:9/x.png'>"
    (tmp_path / "page.html").write_text(text.replace("</main>", f"{let_in}</main>"), encoding="utf-8")
    context = browser.new_context()
    page = context.new_page()
    stopped, complaints = [], []
    page.on("requestfailed", lambda request: stopped.append(request.failure))
    page.on("console", lambda message: complaints.append(message.text))
    page.goto((tmp_path / "page.html").as_uri())
    assert page.evaluate("window.ran") is None and stopped == ["csp", "csp"]
    assert sum("Content Security Policy" in line for line in complaints) == 4
    context.close()


def test_page_of_a_record_is_sound(browser, tmp_path):
    from rigsim.identification.identify import identify
    from rigsim.present.report.identified import identified_page
    from tests.identification.cubic import cubic_record

    record = cubic_record(duration=10, noise=0.01)
    page = identified_page(identify(record), record, "own.csv", ("something",), 3.18)
    (tmp_path / "page.html").write_text(page, encoding="utf-8")
    with opened(browser, tmp_path / "page.html") as page:
        look_over(page)


def test_maths_is_set(browser, small_reports):
    with opened(browser, small_reports / "01_first.html") as page:
        boxes = page.locator("math").evaluate_all("all => all.map(one => one.getBoundingClientRect().height)")
        assert len(boxes) == 5 and min(boxes) > 10
        one, fraction = (page.locator(name).first.bounding_box()["height"] for name in ("mn", "mfrac"))
        assert fraction > 1.8 * one, "numerator above denominator"
        cells = page.locator("mtd[columnalign=left]").evaluate_all(
            "all => all.map(one => one.getBoundingClientRect().x)"
        )
        assert cells[0] == pytest.approx(cells[1], abs=1), "aligned at the equals sign"


def test_sliders_move_the_picture(browser, small_reports):
    with opened(browser, small_reports / "01_first.html") as page:
        assert move_every_slider(page) == 2


@pytest.mark.parametrize("reduced_motion", ["no-preference", "reduce"])
def test_motion_waits_to_be_asked_for(browser, small_reports, reduced_motion):
    with opened(browser, small_reports / "01_first.html", reduced_motion=reduced_motion) as page:
        figure = page.locator(".rigsim-moving").nth(1)
        button, slider = figure.locator("button"), figure.locator("input")
        page.wait_for_timeout(300)
        assert slider.input_value() == "0" and button.text_content() == "Play"
        button.press("Enter")
        page.wait_for_function("() => document.querySelectorAll('.rigsim-moving input')[1].value > 2")
        button.press("Enter")
        stopped = slider.input_value()
        page.wait_for_timeout(300)
        assert slider.input_value() == stopped and button.text_content() == "Play"


@pytest.mark.parametrize(("reduced_motion", "ends"), [("no-preference", False), ("reduce", True)])
def test_keyboard_plays_pauses_and_steps_and_little_motion_ends_by_itself(browser, small_reports, reduced_motion, ends):
    with opened(browser, small_reports / "01_first.html", reduced_motion=reduced_motion) as page:
        figure = page.locator(".rigsim-moving").nth(1)
        button, slider = figure.locator("button"), figure.locator("input")
        slider.focus()
        page.keyboard.press("Space")
        page.wait_for_function("() => document.querySelectorAll('.rigsim-moving input')[1].value > 2")
        page.keyboard.press("Space")
        stopped = int(slider.input_value())
        assert button.text_content() == "Play"
        page.keyboard.press("ArrowRight")
        assert int(slider.input_value()) == stopped + 1
        page.keyboard.press("End")
        page.keyboard.press("ArrowLeft")
        page.keyboard.press("Space")  # from the last picture but one
        if ends:
            page.wait_for_function("() => document.querySelectorAll('.rigsim-moving button')[0].textContent == 'Play'")
            assert slider.input_value() == slider.get_attribute("max")
        else:
            page.wait_for_function("() => document.querySelectorAll('.rigsim-moving input')[1].value == 1")
            assert button.text_content() == "Pause"


@pytest.mark.parametrize(
    ("body", "complaint"),
    [
        ("<img src='http://127.0.0.1:9/x.png'>", "asks for what is not in it"),
        ("<script src='x.js'></script>", "asks for what is not in it"),
        ("<script>console.error('broken')</script>", "broken"),
        ("<script>nothing()</script>", "nothing is not defined"),
    ],
)
def test_recorder_sees_what_goes_wrong(browser, tmp_path, body, complaint):
    page = tmp_path / "page.html"
    page.write_text(f"<!DOCTYPE html><title>x</title><link rel=icon href='data:,'>{body}")
    with pytest.raises(AssertionError, match=complaint), opened(browser, page):
        pass


@pytest.fixture(scope="session")
def real_reports(tmp_path_factory):
    """The repository's own notebooks, each run and written once."""
    from rigsim.present.report.build import build_reports

    output = tmp_path_factory.mktemp("real") / "reports"
    build_reports(notebooks=NOTEBOOKS, output=output, progress=False)
    return output


@pytest.mark.full
@pytest.mark.parametrize("name", EVERY)
def test_real_report_is_sound_and_moves(browser, request, name):
    if not (NOTEBOOKS / f"{name}.ipynb").exists() and os.environ.get("CI") != "true":
        pytest.skip(f"NOT TESTED: the promised notebook {name} does not exist")
    path = request.getfixturevalue("real_reports") / f"{name}.html"
    assert path.stat().st_size < 5e6
    with opened(browser, path) as page:
        moved = move_every_slider(page)
        assert moved or name not in MOVING, "something moves on this page"
        look_over(page)
