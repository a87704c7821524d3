"""What the README shows works as it stands there, and what it maps is there."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


@pytest.mark.skipif(os.name == "nt", reason="the browser is a shell script")
def test_the_five_lines_are_a_script_that_prints_and_shows_a_picture(tmp_path):
    (code,) = re.findall(r"(?s)```python\n(.*?)```", README)
    (tmp_path / "lines.py").write_text(code, encoding="utf-8")
    browser = tmp_path / "browser"
    browser.write_text(f'#!/bin/sh\ncp "${{1#file://}}" "{tmp_path}/seen.html"\n')
    browser.chmod(0o755)
    settings = {**os.environ, "PYTHONPATH": str(ROOT), "TMPDIR": str(tmp_path), "MPLBACKEND": "agg"}
    settings["BROWSER"] = f"{browser} %s"
    command = [sys.executable, "lines.py"]
    done = subprocess.run(command, cwd=tmp_path, env=settings, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    told = [f"{float(number):.3f}" for number in re.search(r"inner +([\d.]+) +([\d.]+)", done.stdout).groups()]
    assert "# one inner curve, {} to {} Hz".format(*told) in code
    seen = (tmp_path / "seen.html").read_text(encoding="utf-8")
    assert '<svg role="img"' in seen and "detached" in re.search(r'aria-label="([^"]*)"', seen)[1]


def test_every_room_is_on_the_map():
    rooms = {path.parent.name for path in (ROOT / "rigsim").glob("*/__init__.py")}
    named = set(re.findall(r"`(\w+)/", README))
    assert rooms <= named
    for path in re.findall(r"`rigsim/([\w/.]+)`", README):
        assert (ROOT / "rigsim" / path).exists(), path


def test_every_notebook_is_listed_with_its_question():
    for path in sorted((ROOT / "notebooks").glob("*.ipynb")):
        assert f"(notebooks/{path.name})" in README
