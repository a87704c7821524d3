"""Notebooks are narrative clients: short cells, nothing stored, no algorithm; see what each one asks."""

import ast
import json
import re
from pathlib import Path
from statistics import median

import pytest

NOTEBOOKS = sorted((Path(__file__).parents[1] / "notebooks").glob("*.ipynb"))

pytestmark = pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)


def cells(path, kind):
    notebook = json.loads(path.read_text(encoding="utf-8"))
    return [cell for cell in notebook["cells"] if cell["cell_type"] == kind]


def source(cell):
    return "".join(cell["source"])


def code(path):
    """Code cells as Python: magics taken out."""
    return [re.sub(r"(?m)^\s*[%!].*$", "", source(cell)) for cell in cells(path, "code")]


def test_name_is_two_digits_and_words(path):
    assert re.fullmatch(r"\d\d_[a-z0-9]+(_[a-z0-9]+)*", path.stem)


def test_nothing_is_stored(path):
    assert path.stat().st_size < 40_000
    for cell in cells(path, "code"):
        assert not cell["outputs"] and cell["execution_count"] is None
    assert not any("attachments" in cell for cell in cells(path, "markdown"))
    assert "widgets" not in json.loads(path.read_text(encoding="utf-8"))["metadata"]


def test_cells_are_short(path):
    lengths = [len([line for line in text.splitlines() if line.strip()]) for text in code(path)]
    assert median(lengths) <= 5
    assert max(lengths) <= 25


def test_begins_with_a_question_and_the_run_time(path):
    notebook = json.loads(path.read_text(encoding="utf-8"))
    first = notebook["cells"][0]
    assert first["cell_type"] == "markdown"
    text = source(first)
    assert text.startswith("# ") and "?" in text
    assert re.search(r"(?i)run(s|ning)?[ -](time|in)\b.*?\d+\s*(s|seconds?|min|minutes?)\b", text, re.S)


def test_imports_come_from_the_front_door(path):
    """One import cell, and no algorithm that would want more than the companion and plain arrays."""
    importing = [number for number, text in enumerate(code(path)) if re.search(r"(?m)^(import|from)\s", text)]
    assert len(importing) == 1
    for node in ast.walk(ast.parse("\n".join(code(path)))):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [node.module]
        for name in names:
            assert name in ("rigsim", "numpy", "pandas", "IPython.display"), name


def test_no_algorithm_lives_in_a_cell(path):
    for node in ast.walk(ast.parse("\n".join(code(path)))):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            assert node.end_lineno - node.lineno < 8, f"{node.name} is long: it belongs in rigsim"
        assert not isinstance(node, (ast.While, ast.ClassDef, ast.Global)), "this belongs in rigsim"


def test_ends_with_checks(path):
    """Without stored outputs nbval compares nothing: the numbers are held by the cells themselves."""
    tail = "\n".join(code(path)[-3:])
    assert re.search(r"\bassert\b|np\.testing|assert_allclose", tail)


def test_ruff_would_find_no_unused_name(path):
    """Everything imported is used (the part of ruff's check that matters to a reader)."""
    tree = ast.parse("\n".join(code(path)))
    imported = {
        (alias.asname or alias.name).split(".")[0]
        for node in ast.walk(tree)
        if isinstance(node, (ast.Import, ast.ImportFrom))
        for alias in node.names
    }
    used = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    assert not imported - used
