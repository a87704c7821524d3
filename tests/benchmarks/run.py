"""What ``python3 -m rigsim bench`` runs: every benchmark of this folder, and a table of what it measured.

A benchmark is a module with a function ``measure()`` that returns rows (name, value, unit, ratio). Seconds differ
from machine to machine and from day to day; the ratio is to a unit that the same run measured just before or after,
a calculation everybody can repeat, and the module's docstring says which.
"""

import argparse
import importlib
import sys
import time
from pathlib import Path

FOLDER = Path(__file__).parent
ON_REQUEST = ("campaign", "peers", "peers_identification", "peers_spatial")  # minutes, or an environment of their own


def fastest(function, repeats=5):
    """Least seconds of several calls, after one that compiles and warms up."""
    function()
    seconds = []
    for _ in range(repeats):
        begun = time.perf_counter()
        function()
        seconds.append(time.perf_counter() - begun)
    return min(seconds)


def known():
    """Names of the benchmarks."""
    return sorted(path.stem for path in FOLDER.glob("*.py") if path.stem != Path(__file__).stem)


def table(title, rows):
    """The rows as text."""
    cells = [
        (name, f"{value:.4g} {unit}", "" if ratio is None else f"{ratio:.3g}") for name, value, unit, ratio in rows
    ]
    cells.insert(0, (title, "measured", "ratio"))
    widths = [max(len(row[column]) for row in cells) for column in range(3)]
    lines = [f"{a:<{widths[0]}}  {b:>{widths[1]}}  {c:>{widths[2]}}" for a, b, c in cells]
    return "\n".join([lines[0], "-" * len(lines[0]), *lines[1:]])


def main(arguments=None):
    """Run the benchmarks named, by default all but those on request; return the exit status."""
    parser = argparse.ArgumentParser(prog="python3 -m rigsim bench")
    parser.add_argument("names", nargs="*")
    names = parser.parse_args(arguments).names or [name for name in known() if name not in ON_REQUEST]
    unknown = [name for name in names if name not in known()]
    if unknown:
        print(f"rigsim: no benchmark {unknown[0]}; there are {', '.join(known())}", file=sys.stderr)
        return 1
    for name in names:
        begun = time.perf_counter()
        module = importlib.import_module(name)
        print(f"\n{module.__doc__.strip()}\n\n{table(name, module.measure())}")
        print(f"({time.perf_counter() - begun:.0f} s)", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
