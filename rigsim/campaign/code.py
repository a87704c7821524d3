"""Which code computes: a digest of the sources that a function can reach, and of the packages below them."""

import ast
import hashlib
import sys
import time
from importlib.metadata import version
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent.parent
_BELOW = ("numpy", "scipy", "numba", "pymunk")
_LOADED = time.time()


def code_fingerprint(function):
    """SHA-256 (hexadecimal str) of the module of a function and all of rigsim that it imports, wherever in the file.

    Of a module that is not rigsim's its own file counts, and all of rigsim. `ValueError` if a file has changed since
    this Python started, which then computes with what no file holds any more.
    """
    source = getattr(sys.modules.get(function.__module__), "__file__", None)
    source = source and Path(source).resolve()
    if source and _PACKAGE in source.parents:
        files = _reached(source)
    else:
        files = {*_PACKAGE.rglob("*.py"), *([source] if source else [])}
    digest = hashlib.sha256(" ".join([sys.version, *map(version, _BELOW)]).encode())
    for file in sorted(files):
        if file.stat().st_mtime > _LOADED:
            raise ValueError(f"{file} has changed since this Python started; start Python again to use a checkpoint")
        name = file.relative_to(_PACKAGE).as_posix() if _PACKAGE in file.parents else file.name
        digest.update(f"\0{name}\0".encode() + file.read_bytes())
    return digest.hexdigest()


def _reached(start):
    """Files of rigsim that one of its files imports, itself and theirs among them."""
    reached, waiting = set(), {start}
    while waiting:
        file = waiting.pop()
        reached.add(file)
        for node in ast.walk(ast.parse(file.read_bytes())):
            if isinstance(node, ast.ImportFrom):
                base = file.parents[node.level - 1] if node.level else _PACKAGE.parent
                folder = base.joinpath(*(node.module or "").split("."))
                found = [folder.with_suffix(".py"), *(folder / f"{alias.name}.py" for alias in node.names)]
                waiting |= {path for path in found if path.is_file()} - reached
    return reached
