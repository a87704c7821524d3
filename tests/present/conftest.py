"""Pages of small notebooks, and a browser to look at them."""

import os
import shutil

import pytest

from tests.present.small_notebooks import FIRST, SECOND, write_notebook


@pytest.fixture(scope="session")
def small_notebooks(tmp_path_factory):
    """Folder with 01_first (a bit of everything) and 02_second."""
    folder = tmp_path_factory.mktemp("notebooks")
    write_notebook(folder / "01_first.ipynb", FIRST)
    write_notebook(folder / "02_second.ipynb", SECOND)
    return folder


@pytest.fixture(scope="session")
def small_reports(small_notebooks, tmp_path_factory):
    """Folder with the pages of `small_notebooks`."""
    from rigsim.present.report.build import build_reports

    output = tmp_path_factory.mktemp("reports")
    build_reports(notebooks=small_notebooks, output=output, progress=False)
    return output


@pytest.fixture(scope="module")
def browser():
    """A headless Chromium; without one the tests skip, but not where CI=true promises one."""
    try:
        from playwright.sync_api import sync_playwright

        missing = "no chromium on the path"
        chromium = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    except ModuleNotFoundError as error:
        missing, chromium = f"{error.name} is not installed", None
    if chromium is None:
        (pytest.fail if os.environ.get("CI") == "true" else pytest.skip)(f"{missing}: browser tests need both")
    quiet = "--no-sandbox --disable-gpu --disable-background-networking --disable-component-update --disable-sync"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=[*quiet.split(), "--no-first-run"])
        yield browser
        browser.close()
