"""The paper's rig, cubic law, one harmonic, 3.18 N, 5 to 120 Hz: other packages on the same curve.

Runs only when asked for by name. The peers live in .venv-peers, made on first use from peers.txt (some minutes,
1.3 GB); delete it at any time. Each runs its own script of the folder peers/ in a process of its own, and is timed in
there without its imports. The ratio is to periodic_orbits, or for the second row of a package to the unit: one call of
numpy.linalg.eigvals on the 1501 companion matrices of the cubic (5a). Lines are what a user writes to describe the rig
and get the curve. The main piece counts as found if it was followed from one end of the band to the other, the detached
one if any point of it was; every point is checked against Eq. (5a).

The curve has two pieces: the main one, with folds at 106.9 and 56.4 Hz, and a detached one from 20.5 to 53.7 Hz.

- pyHarm 1.2.2: harmonic balance with arc length, of a system described by matrices and connectors.
- contique 1.1.1: continuation of any residual; its user writes the balance, and chooses a step that holds: with its
  option to adapt the step it turned back at a fold.
- PyCont-Lite 0.6.0, not compared: installs, but did not finish the curve in 150 s (same residual, steps up to 0.2).
- mousai 0.3.1, not compared: installs and balances one frequency after another, but has no continuation, so that it
  passes no fold; a sweep with one harmonic came out 29 % off at 5 Hz, where it is nearly linear, and was not pursued.
"""

import ast
import hashlib
import inspect
import json
import os
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
from orbits import BAND, FORCE
from response import companions
from run import fastest

from rigsim import RigParameters, frequency_response, periodic_orbits
from rigsim.theory.cubic import dynamic_stiffness

FOLDER = Path(__file__).parent
ROOT = FOLDER.parent.parent
PEERS = {"pyHarm": "pyharm_curve.py", "contique": "contique_curve.py"}


def environment():
    """Python of .venv-peers, made if it is missing or peers.txt has changed."""
    venv, pins = ROOT / ".venv-peers", FOLDER / "peers.txt"
    python = venv / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    stamp, key = venv / "stamp", hashlib.sha256(pins.read_bytes() + sys.version.encode()).hexdigest()
    if not (stamp.is_file() and stamp.read_text() == key):  # written last, so that a half made one is made again
        print("rigsim: making .venv-peers, which takes a few minutes the first time", file=sys.stderr, flush=True)
        base = getattr(sys, "_base_executable", None) or sys.executable
        subprocess.run([base, "-m", "venv", "--clear", str(venv)], check=True)
        install = ["install", "--quiet", "--no-input", "--disable-pip-version-check", "-r", str(pins)]
        subprocess.run([str(python), "-m", "pip", *install], check=True)
        stamp.write_text(key)
    return str(python)


def lines(function):
    """Lines of code of a function's body, without its docstring, blank lines and comments."""
    source = textwrap.dedent(function)
    body = ast.parse(source).body[0].body[1:]  # the docstring goes
    text = source.splitlines()[body[0].lineno - 1 : body[-1].end_lineno]
    return sum(bool(line.strip()) and not line.strip().startswith("#") for line in text)


def of_script(script):
    """Source of a script's ``curve``."""
    text = (FOLDER / "peers" / script).read_text(encoding="utf-8")
    (found,) = [node for node in ast.parse(text).body if isinstance(node, ast.FunctionDef) and node.name == "curve"]
    return ast.get_source_segment(text, found)


def ours():
    """Every curve."""
    return periodic_orbits(RigParameters(), FORCE, BAND, harmonics=1, law="cubic", search="seeds")


def pieces_found(points):
    """(main, detached): whether there are points on each; and the share of points that solve Eq. (5a)."""
    points = points[(points[:, 0] >= BAND[0]) & (points[:, 0] <= BAND[1])]
    group, rig = RigParameters().nondimensional(FORCE), RigParameters().oscillator
    Omega, U = 2 * np.pi * points[:, 0] / rig.omega_s, 0.75 * group.gamma * (points[:, 1] * rig.ks / FORCE) ** 2
    numbers = group.mu, group.zeta_s, group.zeta, group.Omega0
    r, s, e = np.array([dynamic_stiffness(*numbers, X) for X in Omega**2]).T
    needed = FORCE * np.sqrt(U * ((U + r) ** 2 + s**2) * e / (0.75 * group.gamma * Omega**4))
    right = abs(needed / FORCE - 1) < 1e-3  # the force is explicit in the amplitude, also at a fold
    response = frequency_response(RigParameters(), FORCE, points[:, 0])
    solution = np.nanargmin(abs(np.abs(response.relative) - points[:, 1:]), axis=1)
    # Below 55 Hz the high solution is the main curve's, and where there are three the others are the detached one's.
    detached = right & (points[:, 0] < 55) & (response.count == 3) & (solution < 2)
    whole = right & ~detached & ((points[:, 0] < 6) | (points[:, 0] > 110))
    return bool((points[whole, 0] < 6).any() and (points[whole, 0] > 110).any()), bool(detached.any()), right.mean()


def measure():
    """Rows (name, value, unit, ratio)."""
    python, rig = environment(), RigParameters().oscillator
    numbers = {name: getattr(rig, name) for name in ("ms", "cs", "ks", "m", "c", "k1", "k3")}
    matrices = companions(RigParameters(), FORCE, np.linspace(5, 80, 1501))
    unit = fastest(lambda: np.linalg.eigvals(matrices), 20)
    own, branches = fastest(ours, 20), ours()
    points = np.concatenate([np.column_stack([b.frequency, abs(b.relative[:, 1])]) for b in branches])
    rows = [("unit: eigvals of companion matrices", 1e3 * unit, "ms", 1.0)]
    results = {"rigsim": (own, points, lines(inspect.getsource(ours)))}
    for name, script in PEERS.items():
        done = subprocess.run(
            [python, "-W", "ignore", str(FOLDER / "peers" / script)],
            input=json.dumps({**numbers, "force": FORCE, "band": BAND}),
            cwd=ROOT / ".venv-peers",  # where pyHarm may leave its settings
            capture_output=True, text=True, check=False, timeout=600,
        )  # fmt: skip
        if done.returncode:
            raise RuntimeError(f"{name} failed: {done.stderr.strip().splitlines()[-1]}")
        result = json.loads(done.stdout)
        results[name] = result["seconds"], np.array(result["points"]), lines(of_script(script))
    for name, (seconds, points, written) in results.items():
        main, detached, share = pieces_found(points)
        rows += [
            (f"{name}: curve, against periodic_orbits", 1e3 * seconds, "ms", seconds / own),
            (f"{name}: curve, against the unit", 1e3 * seconds, "ms", seconds / unit),
            (f"{name}: points", len(points), "", None),
            (f"{name}: points whose force by Eq. (5a) is right to 0.1 %", 100 * share, "%", None),
            (f"{name}: user's lines", written, "", None),
            (f"{name}: pieces found untold, of 2", main + detached, "", None),
            (f"{name}: detached curve found", int(detached), "", None),
        ]
    return rows
