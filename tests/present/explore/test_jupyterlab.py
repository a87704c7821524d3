"""Notebooks run in a real JupyterLab: a panel's slider is moved by keyboard and its picture changes."""

import os
import re
import secrets
import shutil
import socket
import subprocess
import sys
import time
from pathlib import Path
from urllib.request import urlopen

import pytest
from nbformat.v4 import new_code_cell, new_markdown_cell

from tests.present.small_notebooks import write_notebook

pytestmark = pytest.mark.full
NOTEBOOKS = Path(__file__).parents[3] / "notebooks"
PANEL = [
    new_markdown_cell("# A panel"),
    new_code_cell(
        "import io\n\nimport ipywidgets\nimport numpy as np\nfrom IPython.display import display\n"
        "from matplotlib.figure import Figure\n\nfrom rigsim.present.moving.plot import Curve, MovingPlot, Panel\n\n"
        "figure = Figure(figsize=(4, 2))\nline = figure.subplots().plot([0, 1], [0, 1])[0]\n"
        "image = ipywidgets.Image(format='png', width=400, height=200)\n\n\n"
        "def draw(change=None):\n    line.set_ydata([0, slider.value])\n    buffer = io.BytesIO()\n"
        "    figure.savefig(buffer)\n    image.value = buffer.getvalue()\n\n\n"
        "slider = ipywidgets.FloatSlider(value=1, min=0, max=2, description='Slope')\n"
        "slider.observe(draw, 'value')\ndraw()\ndisplay(ipywidgets.VBox([slider, image]))"
    ),
    new_code_cell(
        "panel = Panel([[Curve([0, 1], [0, slope])] for slope in range(5)], 'x', 'y')\n"
        "MovingPlot('Slope', range(5), '', panel, alt='A line', seconds=1)"
    ),
]


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    """A JupyterLab of its own over a copy of the notebooks: (address, token)."""
    home = tmp_path_factory.mktemp("lab")
    notebooks = home / "notebooks"
    shutil.copytree(NOTEBOOKS, notebooks, ignore=shutil.ignore_patterns(".*"))
    write_notebook(notebooks / "panel.ipynb", PANEL)
    settings = home / "settings" / "@jupyterlab"
    for name, text in {
        # Every cell is in the page, whether it has been scrolled to or not.
        "notebook-extension/tracker": '{"windowingMode": "none"}',
        "apputils-extension/notification": '{"fetchNews": "false", "checkForUpdates": false}',
    }.items():
        (settings / name).parent.mkdir(parents=True)
        (settings / f"{name}.jupyterlab-settings").write_text(text)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    token = secrets.token_hex()
    own = {
        name: str(home / name)
        for name in ("JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR", "IPYTHONDIR")
    }
    options = {"ip": "127.0.0.1", "port": port, "port_retries": 0, "root_dir": notebooks, "open_browser": False}
    command = [sys.executable, "-m", "jupyterlab", "--allow-root", f"--IdentityProvider.token={token}"]
    with (home / "log").open("w") as log:
        server = subprocess.Popen(
            [*command, *(f"--ServerApp.{name}={value}" for name, value in options.items())],
            env={**os.environ, **own, "JUPYTERLAB_SETTINGS_DIR": str(settings.parent)},
            stdout=log,
            stderr=subprocess.STDOUT,
        )
    try:
        address = f"http://127.0.0.1:{port}"
        end = time.monotonic() + 60
        while True:
            try:
                urlopen(f"{address}/api?token={token}", timeout=5).close()
                break
            except OSError:
                if server.poll() is not None or time.monotonic() > end:
                    pytest.fail(f"JupyterLab did not start:\n{(home / 'log').read_text()[-2000:]}")
                time.sleep(0.3)
        yield address, token
    finally:
        server.terminate()
        try:
            server.wait(20)
        except subprocess.TimeoutExpired:
            server.kill()
            server.wait()


def run_all(browser, lab, name, minutes):
    """Open a notebook, run its cells from the menu, and return the page once every cell has run without an error."""
    address, token = lab
    page = browser.new_context(viewport={"width": 1400, "height": 1000}).new_page()
    # A workspace of its own: the default one would bring back the notebook that was open before, and run that.
    page.goto(f"{address}/lab/workspaces/{Path(name).stem}/tree/{name}?token={token}")
    page.wait_for_selector(".jp-Notebook .jp-CodeCell", timeout=60_000)
    page.get_by_text("| Idle").wait_for(timeout=60_000)  # in the status bar, once the kernel has answered
    page.get_by_role("menuitem", name="Run", exact=True).click()
    page.get_by_role("menuitem", name="Run All Cells", exact=True).click()
    prompts = page.locator(".jp-CodeCell .jp-InputPrompt")
    end = time.monotonic() + 60 * minutes
    while True:
        texts = prompts.all_text_contents()
        errors = page.locator('.jp-OutputArea-output[data-mime-type="application/vnd.jupyter.error"]')
        assert not errors.count(), errors.first.text_content()
        if texts and all(re.fullmatch(r"\[\d+\]:", text) for text in texts):
            return page
        assert time.monotonic() < end, f"cells not run after {minutes} minutes: {texts}"
        page.wait_for_timeout(500)


def move_panel(page):
    """Move the first slider that stands with a picture, by keyboard; the picture must change."""
    panel = page.locator(".jp-OutputArea-child", has=page.locator(".widget-slider")).filter(
        has=page.locator("img.widget-image")
    )
    panel.first.wait_for(timeout=30_000)
    panel = panel.first
    picture, handle = panel.locator("img.widget-image").first, panel.locator(".widget-slider .noUi-handle").first
    picture.scroll_into_view_if_needed()
    page.wait_for_timeout(1000)
    before, size = picture.screenshot(), picture.bounding_box()
    assert size["width"] > 100 and size["height"] > 50
    readout = panel.locator(".widget-readout").first  # aria-valuenow has one decimal only
    source, value = picture.get_attribute("src"), readout.text_content()
    handle.focus()
    for _ in range(5):
        page.keyboard.press("ArrowRight")
    assert readout.text_content() != value, "the slider follows the keyboard"
    page.wait_for_function(
        "([image, old]) => image.src !== old", arg=[picture.element_handle(), source], timeout=60_000
    )
    page.wait_for_timeout(1000)
    assert picture.screenshot() != before, "the picture answers"
    after = picture.bounding_box()
    assert (after["width"], after["height"]) == (size["width"], size["height"]), "and keeps its size"


def test_panel_answers_the_keyboard(browser, lab):
    page = run_all(browser, lab, "panel.ipynb", minutes=1)
    move_panel(page)
    moving = page.locator(".rigsim-moving")
    before = moving.locator("path.moves").get_attribute("d")
    moving.locator("input").focus()
    page.keyboard.press("End")
    assert moving.locator("output").text_content() == "4.00"
    assert moving.locator("path.moves").get_attribute("d") != before
    page.keyboard.press("Space")
    page.wait_for_function("() => document.querySelector('.rigsim-moving button').textContent == 'Pause'")
    page.wait_for_function("() => document.querySelector('.rigsim-moving input').value == 2")
    page.keyboard.press("Space")
    assert moving.locator("button").text_content() == "Play"
    page.context.close()


@pytest.mark.parametrize("name", ["03_detached_curves.ipynb"])
def test_real_panel_answers_the_keyboard(browser, lab, name):
    if not (NOTEBOOKS / name).exists() and os.environ.get("CI") != "true":
        pytest.skip(f"NOT TESTED: the promised notebook {name} does not exist")
    page = run_all(browser, lab, name, minutes=8)
    move_panel(page)
    page.context.close()
