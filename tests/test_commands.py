"""The commands before, while and after they make their environment; each failure is one clear line."""

import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import textwrap
import time
import tomllib
from functools import partial
from pathlib import Path

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_notebook

from rigsim import __main__ as commands
from rigsim import environment, places, stopping

ROOT = Path(__file__).parents[1]
COMMANDS = ("report", "test", "lab", "bench", "identify")
FRONT = ("__init__.py", "__main__.py", "environment.py", "places.py", "stopping.py")


def run(folder, *arguments, begin="", **settings):
    """`python3 -m rigsim` in a folder, on this Python without its packages, after the code ``begin``."""
    code = f"import sys, runpy\nsys.argv = {['rigsim', *arguments]!r}\n{begin}\n"
    code += "runpy.run_module('rigsim', run_name='__main__')"
    variables = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", environment.VARIABLE)}
    base = getattr(sys, "_base_executable", sys.executable)
    return subprocess.run(
        [base, "-c", code], cwd=folder, env={**variables, **settings}, capture_output=True, text=True, timeout=300
    )


def one_line(done, *words):
    """The error is one line of text with these words, and no traceback."""
    assert done.returncode in (1, 2)
    errors = [line for line in done.stderr.splitlines() if not line.rstrip().endswith("s)")]  # without "... (3 s)"
    assert len(errors) == 1 and errors[0].startswith("rigsim: "), done.stderr
    for word in words:
        assert word in errors[0]


@pytest.fixture
def tree(tmp_path):
    return small_tree(tmp_path / "tree")


def small_tree(root):
    """A source tree whose environment needs nothing but pip."""
    (root / "rigsim").mkdir(parents=True)
    for name in FRONT:
        shutil.copy(ROOT / "rigsim" / name, root / "rigsim")
    (root / "environment.txt").write_text("# nothing\n")
    (root / "environment.lock").write_text("# part: base\n# part: test\n# part: browser\n# part: formats\n")
    (root / "pyproject.toml").write_text(
        '[project]\nname = "rigsim"\noptional-dependencies = {test = [], browser = [], formats = []}\n'
    )
    (root / "tests" / "benchmarks").mkdir(parents=True)
    (root / "tests" / "benchmarks" / "run.py").write_text("import sys\nprint('ran with', sys.prefix, *sys.argv[1:])\n")
    return root


@pytest.mark.parametrize("arguments", [(), *((name,) for name in COMMANDS)])
def test_help_helps_and_needs_nothing(tree, arguments):
    done = run(tree, *arguments, "--help")
    assert done.returncode == 0 and not done.stderr
    assert environment.VARIABLE in done.stdout and ".venv" in done.stdout
    assert all(name in done.stdout for name in arguments or COMMANDS)
    assert not (tree / ".venv").exists()


def test_no_command_shows_the_help(tree):
    done = run(tree)
    assert done.returncode == 2 and "usage" in done.stdout


def test_unknown_argument_is_refused_before_anything_is_made(tree):
    done = run(tree, "bench", "--fast")
    assert done.returncode == 2 and "--fast" in done.stderr
    assert not (tree / ".venv").exists()


def test_too_old_a_python(tree):
    one_line(run(tree, "test", begin="sys.version_info = (3, 10, 4, 'final', 0)"), "Python 3.11 or newer", "3.10.4")


def test_front_door_can_be_read_by_an_old_python():
    import ast

    for name in FRONT:
        ast.parse((ROOT / "rigsim" / name).read_text(encoding="utf-8"), feature_version=(3, 6))


def test_no_ensurepip(tree):
    block = "import importlib.util as u; find = u.find_spec\n"
    block += "u.find_spec = lambda name, *more: None if name == 'ensurepip' else find(name, *more)"
    one_line(run(tree, "report", begin=block), "no ensurepip", "python3-venv")
    assert not (tree / ".venv").exists()


def closed_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def pin(tree, package, digest="0" * 64):
    (tree / "environment.txt").write_text(f"{package}\n")
    lock = f"# part: base\n{package} --hash=sha256:{digest}\n# part: test\n# part: browser\n# part: formats\n"
    (tree / "environment.lock").write_text(lock)


def test_no_network(tree):
    pin(tree, "rigsim-no-such-package==1.0")
    nowhere = f"http://127.0.0.1:{closed_port()}/simple"
    settings = {"PIP_CONFIG_FILE": os.devnull, "PIP_INDEX_URL": nowhere, "PIP_RETRIES": "0", "PIP_FIND_LINKS": ""}
    done = run(tree, "report", **settings)
    one_line(done, "no connection", "check the network", ".venv.log")
    assert "rigsim-no-such-package" in (tree / ".venv.log").read_text()
    assert not list(tree.glob(".venv-*")), "nothing half made stays"


def test_other_failures_show_the_decisive_line(tmp_path):
    log = tmp_path / "setup.log"
    text = "numba (from versions: 0.1, 0.2)\nERROR: No matching distribution found for numba==0.68.1\n\n[notice] new\n"
    message = environment._why(text, log)
    assert "No matching distribution found for numba==0.68.1" in message and str(log) in message and "\n" not in message
    assert "no connection" not in message
    assert "No space left" in environment._why("ERROR: Could not install: [Errno 28] No space left on device\n", log)


def test_environment_is_made_once_and_again_when_half_made(tree):
    first = run(tree, "bench", "a", "b")
    assert first.returncode == 0, first.stderr
    place = (tree / ".venv").resolve()
    assert first.stdout.split() == ["ran", "with", str(place), "a", "b"] and place.parent == tree
    assert "making .venv" in first.stderr
    again = run(tree, "bench")
    assert again.returncode == 0 and not again.stderr

    shutil.rmtree(next((tree / ".venv").glob("lib/python*/site-packages/pip/_internal")))
    rebuilt = run(tree, "bench")
    assert rebuilt.returncode == 0 and "making .venv" in rebuilt.stderr
    assert not place.exists() and str((tree / ".venv").resolve()) in rebuilt.stdout


def test_setup_compiles_what_the_notebooks_use(tree):
    """As its last step, whose failure, as of code that is being changed, keeps nobody from starting."""
    (tree / "rigsim" / "first_use.py").write_text("import sys\nopen('compiled', 'w').write(sys.prefix)\n")
    done = run(tree, "bench")
    assert done.returncode == 0 and "compiling what the notebooks use" in done.stderr
    assert (tree / "compiled").read_text() == str((tree / ".venv").resolve())
    (tree / "environment.txt").write_text("# nothing more\n")
    (tree / "rigsim" / "first_use.py").write_text("raise ValueError('half written')\n")
    done = run(tree, "bench")
    assert done.returncode == 0
    assert "not all was compiled ahead" in done.stderr and "half written" in done.stderr
    assert "compiling" not in run(tree, "bench").stderr


@pytest.fixture
def quick(monkeypatch):
    """Setups of no duration: the commands that would have run."""
    calls = []

    def pretend(command, root, say, settings=None):
        calls.append(command)
        if command[1:3] == ["-m", "venv"]:
            python = Path(command[-1], "bin", "python")
            python.parent.mkdir()
            python.touch()
            (python.parents[1] / "lib" / "python3.x" / "site-packages").mkdir(parents=True)

    monkeypatch.setattr(environment, "_run", pretend)
    monkeypatch.setattr(environment, "_reach", lambda place: {})
    return calls


@pytest.mark.parametrize(
    "damage", ["no stamp", "no python", "torn stamp", "only a folder", "a file", "pins", "lock", "project", "moved"]
)
def test_stale_environment_is_made_again(tree, quick, damage):
    environment.prepare(tree)
    assert len(quick) == 2
    environment.prepare(tree)
    assert len(quick) == 2, "a finished one is left alone"
    venv, stamp = tree / ".venv", tree / ".venv" / "rigsim-stamp.json"
    place = venv.resolve()
    places._let_go(place)  # else this process would count as using it
    if damage == "no stamp":
        stamp.unlink()
    elif damage == "no python":
        (venv / "bin" / "python").unlink()
    elif damage == "torn stamp":
        stamp.write_text(stamp.read_text()[:20])
    elif damage in ("only a folder", "a file"):
        venv.unlink()
        venv.mkdir() if damage == "only a folder" else venv.touch()
    elif damage == "moved":
        tree = tree.rename(tree.with_name("elsewhere"))
    else:
        (tree / {"pins": "environment.txt", "lock": "environment.lock", "project": "pyproject.toml"}[damage]).open(
            "a"
        ).write("# changed\n")
    python = environment.prepare(tree)
    assert len(quick) == 4 and not place.exists()
    assert environment.prepare(tree) == python and len(quick) == 4
    assert Path(python).parents[1] == (tree / ".venv").resolve()
    kept = [found.name for found in tree.glob(".venv-before-*")]
    assert len(kept) == (damage in ("a file", "only a folder")), "what was not ours stays, under another name"


def test_interrupted_setup_says_so_and_is_repeated(tree, quick):
    stop = "import rigsim.environment as e\ndef stop(*_): raise KeyboardInterrupt\ne._run = stop"
    one_line(run(tree, "bench", begin=stop), "interrupted", "again")
    assert not list(tree.glob(".venv-*"))
    environment.prepare(tree)
    assert len(quick) == 2


@pytest.mark.skipif(sys.platform == "win32", reason="needs SIGKILL")
def test_second_setup_waits_for_the_first(tree):
    """Two commands at once make one environment; a killed one does not block the other."""
    hold = "import sys, time\nfrom pathlib import Path\nfrom rigsim.places import lock\n"
    hold += "with lock(Path('.').resolve()):\n    print('held', flush=True)\n    time.sleep(%d)\n"
    first = subprocess.Popen([sys.executable, "-c", hold % 100], cwd=tree, stdout=subprocess.PIPE)
    assert first.stdout.readline() == b"held\n"
    second = subprocess.Popen(
        [sys.executable, "-c", hold % 0], cwd=tree, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert "waiting" in second.stderr.readline()
    assert second.poll() is None
    first.send_signal(signal.SIGKILL)
    first.communicate()
    output, _ = second.communicate(timeout=60)
    assert second.returncode == 0 and output == "held\n"


def test_extras_are_added_to_a_finished_environment(tree, quick, monkeypatch):
    (tree / "environment.lock").write_text(
        "# part: base\n# part: test\npytest==1 --hash=sha256:0\n# part: browser\n# part: formats\n"
    )
    python = environment.prepare(tree)

    def fail(*_):
        raise environment.SetupError("no connection")

    with monkeypatch.context() as broken:
        broken.setattr(environment, "_run", fail)
        with pytest.raises(environment.SetupError, match="no connection; .venv stays as it was"):
            environment.prepare(tree, ["test"])
    assert environment.prepare(tree) == python and len(quick) == 2
    environment.prepare(tree, ["test"])
    environment.prepare(tree, ["test"])
    assert environment.prepare(tree) == python
    venv, base, extra = quick
    assert venv[1:3] == ["-m", "venv"]
    for command in (base, extra):
        assert {"--require-hashes", "--no-deps", "--only-binary"} <= set(command)
    assert Path(extra[-1]).read_text() == "pytest==1 --hash=sha256:0\n"
    assert json.loads((tree / ".venv" / "rigsim-stamp.json").read_text())["parts"] == ["base", "test"]
    with pytest.raises(environment.SetupError, match="no part dreams"):
        environment.prepare(tree, ["dreams"])


def test_an_environment_in_use_stays_until_nobody_uses_it(tree, quick):
    first = Path(environment.prepare(tree)).parents[1]
    code = "import sys, time\nfrom pathlib import Path\nfrom rigsim import places\n"
    code += f"places._hold(Path({str(first)!r}))\nprint('held', flush=True)\ntime.sleep(100)"
    with subprocess.Popen([sys.executable, "-c", code], cwd=tree, stdout=subprocess.PIPE) as user:
        assert user.stdout.readline() == b"held\n"
        places._let_go(first)
        for changes in (1, 2):
            (tree / "environment.txt").open("a").write("# changed\n")
            environment.prepare(tree)
            assert first.exists() and len(list(tree.glob(".venv-*"))) == 2, changes
        user.kill()
    (tree / "environment.txt").open("a").write("# changed\n")
    environment.prepare(tree)
    assert len(list(tree.glob(".venv-*"))) == 1 and not first.exists()


@pytest.mark.skipif(not Path("/proc/self/cmdline").exists(), reason="only Linux tells who runs from a folder")
def test_the_folder_of_an_earlier_version_is_taken_over_once_nobody_runs_from_it(tree, quick):
    old = tree / ".venv"
    (old / "bin").mkdir(parents=True)
    (old / "setup.log").touch()
    os.symlink("/bin/sleep", old / "bin" / "python")
    with subprocess.Popen([str(old / "bin" / "python"), "100"]) as runs:
        python = environment.prepare(tree)
        assert (old / "setup.log").exists() and not old.is_symlink()
        assert environment.prepare(tree) == python and len(quick) == 2, "found without the link"
        runs.kill()
    (tree / "environment.txt").open("a").write("# changed\n")
    python = environment.prepare(tree)
    assert Path(python).parents[1] == old.resolve() and old.is_symlink()
    assert len(list(tree.glob(".venv-*"))) == 1


def test_finished_but_not_linked_is_found(tree, quick, monkeypatch):
    """As after a kill between the two."""
    with monkeypatch.context() as killed:
        killed.setattr(places, "link", lambda *_: None)
        python = environment.prepare(tree)
    assert not (tree / ".venv").exists()
    assert environment.prepare(tree) == python and len(quick) == 2


def lock_parts():
    """Name and version of what the lock holds, by part, and the hashes of each."""
    held = {}
    for piece in (ROOT / "environment.lock").read_text(encoding="utf-8").split("# part: ")[1:]:
        part, _, text = piece.partition("\n")
        for item in re.split(r"\n(?=\S)", text.strip()):
            held.setdefault(part, {})[environment._name(item)] = re.findall(r"--hash=sha256:([0-9a-f]{64})\b", item)
    return held


def test_the_lock_holds_every_pin_with_hashes_and_nothing_else():
    held = lock_parts()
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    base = {environment._name(item) for item in environment._pins(ROOT) if item != "-e ."}
    assert set(held["base"]) == base and {"pip", "setuptools"} <= {name for name, _ in base}
    for part in ("test", "browser", "formats"):
        assert set(held[part]) == {environment._name(item) for item in extras[part]} - base
    assert set(held) == {"base", "test", "browser", "formats"}
    assert all(hashes for part in held.values() for hashes in part.values())
    assert "://" not in (ROOT / "environment.lock").read_text()
    assert environment._read_lock(ROOT).keys() == held.keys()


def test_own_environment(tree):
    done = run(tree, "bench", "x", **{environment.VARIABLE: "current"})
    assert done.returncode == 0 and "x" in done.stdout and not (tree / ".venv").exists()
    one_line(run(tree, "bench", **{environment.VARIABLE: "conda"}), environment.VARIABLE, "conda", "current")
    (tree / "rigsim" / "present").mkdir()
    (tree / "rigsim" / "present" / "report.py").write_text("import no_such_package\n")
    one_line(run(tree, "report", **{environment.VARIABLE: "current"}), "no_such_package", "environment.txt")


@pytest.mark.parametrize("own", ["", "current"])
@pytest.mark.parametrize("other", ["rigsim.py", "rigsim/__init__.py"])
def test_another_rigsim_on_the_path_is_not_run(tree, tmp_path, own, other):
    place = tmp_path / "other" / other
    place.parent.mkdir(parents=True)
    place.write_text("raise SystemExit('the other rigsim')\n")
    (tree / "tests" / "benchmarks" / "run.py").write_text("import rigsim\nprint(rigsim.__file__)\n")
    done = run(tree, "bench", PYTHONPATH=str(tmp_path / "other"), **{environment.VARIABLE: own})
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == [str(tree / "rigsim" / "__init__.py")]
    (tree / "notebooks").mkdir()
    shutil.copy(place, tree / "notebooks" / "rigsim.py")
    one_line(run(tree, "bench", **{environment.VARIABLE: own}), "notebooks/rigsim.py hides the rigsim of", "rename")


_WHERE = """\
from concurrent.futures import ProcessPoolExecutor
from importlib.util import find_spec
from multiprocessing import get_context
import rigsim
with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
    places = {rigsim.__file__, pool.submit(find_spec, "rigsim").result().origin}
assert places == {%r}, places
"""


@pytest.mark.parametrize(
    "arguments",
    [("report", "01", "--output", "pages"), ("test", "--nbval-lax", "--nbval-current-env", "notebooks", "tests")],
    ids=lambda arguments: arguments[0],
)
def test_kernels_workers_and_tests_are_this_clones(tmp_path, arguments):
    """In an environment where another clone is installed, with a third on the path."""
    root = tmp_path / "clone"
    shutil.copytree(ROOT / "rigsim", root / "rigsim", ignore=shutil.ignore_patterns("__pycache__"))
    where = _WHERE % str(root / "rigsim" / "__init__.py")
    (root / "notebooks").mkdir()
    nbformat.write(new_notebook(cells=[new_code_cell(where)]), root / "notebooks" / "01_where.ipynb")
    (root / "tests").mkdir()
    (root / "tests" / "test_where.py").write_text(f"def test_where():\n{textwrap.indent(where, '    ')}")
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "rigsim.py").write_text("raise SystemExit('the other rigsim')\n")
    settings = {**os.environ, "PYTHONPATH": str(tmp_path / "other"), environment.VARIABLE: "current"}
    command = [sys.executable, "-m", "rigsim", *arguments]
    done = subprocess.run(command, cwd=root, env=settings, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr


def test_installed_copy_says_that_it_needs_the_tree(tree):
    (tree / "environment.txt").unlink()
    one_line(run(tree, "report"), "no environment.txt", "clone")


def test_notebooks_go_by_name_or_number(tmp_path, monkeypatch):
    (tmp_path / "03_detached_curves.ipynb").touch()
    monkeypatch.setattr(commands, "NOTEBOOKS", tmp_path)
    for name in ("03", "03_detached_curves", "03_detached_curves.ipynb", "notebooks/03_detached_curves.ipynb"):
        assert commands._notebook(name) == "03_detached_curves.ipynb"
    with pytest.raises(environment.SetupError, match="no notebook 07"):
        commands._notebook("07")


@pytest.fixture
def called(monkeypatch):
    """Commands that would have run, and with which settings of their own."""
    calls = []
    monkeypatch.setattr(stopping, "call", lambda command, folder, defaults: calls.append((command, defaults)) or 3)
    monkeypatch.setattr(environment, "enter", lambda extras: calls.append(extras))
    return calls


def test_test_command_runs_notebooks_and_tests_side_by_side(called):
    assert commands.main(["test"]) == 1
    (extras, (command, defaults)) = called
    assert extras == ("test", "browser", "formats") and defaults["OPENBLAS_NUM_THREADS"] == "1"
    assert command[-2:] == ["notebooks", "tests"] and command[command.index("-n") + 1] == "2"
    assert "--nbval-lax" in command and "--full" not in command and "--soak" not in command


@pytest.mark.parametrize("how", ["--full", "--soak"])
def test_test_command_passes_arguments_to_pytest(called, how):
    assert commands.main(["test", how, "-k", "checks", "-x"]) == 1
    assert called[1][0][1:] == ["-m", "pytest", how, "-k", "checks", "-x"]


def test_a_setting_of_the_users_own_is_kept(monkeypatch):
    show = "import os; raise SystemExit(int(os.environ['OPENBLAS_NUM_THREADS']))"
    for said, wanted in ((None, 1), ("4", 4)):
        monkeypatch.setenv("OPENBLAS_NUM_THREADS", said) if said else monkeypatch.delenv(
            "OPENBLAS_NUM_THREADS", raising=False
        )
        assert stopping.call([sys.executable, "-c", show], ".", {"OPENBLAS_NUM_THREADS": "1"}) == wanted


def test_report_errors_are_lines(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(environment, "enter", lambda extras: None)
    assert commands.main(["report", "99", "--output", str(tmp_path)]) == 1
    assert capsys.readouterr().err.startswith("rigsim: n")


@pytest.fixture
def own_record(tmp_path, monkeypatch):
    """Runs `identify` on a small record of its own, in its folder."""
    from tests.identification.cubic import cubic_record

    monkeypatch.setattr(environment, "enter", lambda *_: None)
    monkeypatch.chdir(tmp_path)
    cubic_record(duration=6, noise=0.01).save("own.csv")
    return lambda *arguments: commands.main(["identify", *arguments])


def test_identify_prints_and_writes_a_page(own_record, tmp_path, capsys):
    assert own_record("own.csv", "--force", "3.18", "--band", "3", "70", "--out", "new/page.html") == 0
    said = capsys.readouterr()
    assert said.out.startswith('Identification ("force"): modes 11.7') and "k3" in said.out and not said.err
    assert said.out.splitlines()[-1].endswith(f"open {Path('new/page.html')}")
    page = (tmp_path / "new" / "page.html").read_text(encoding="utf-8")
    assert "What own.csv says of its rig" in page and "band = 3 to 70 Hz" in page and "At 3.18 N" in page


def test_identify_takes_tests_of_one_rig_and_the_order_they_tell(own_record, capsys):
    from tests.identification.cubic import cubic_record

    cubic_record(duration=6, noise=0.01, rms=0.8, seed=1).save("other.csv")
    assert own_record("own.csv", "other.csv", "--order", "auto") == 0
    assert capsys.readouterr().out.splitlines()[-1].endswith("open own_identified.html")
    page = Path("own_identified.html").read_text(encoding="utf-8")
    assert "What own.csv and other.csv say of their rig" in page and "order = auto" in page and "in 2 tests" in page
    with pytest.raises(SystemExit):
        own_record("own.csv", "--order", "most")
    assert "'most' is not allowed; expected a whole number or auto" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["none.csv"], "none.csv"),
        (["own.csv", "none.csv"], "none.csv"),
        (["own.csv", "--hold", "linear"], "hold = 'linear' is not allowed"),
        (["own.csv", "--order", "5"], "order = 5 is not allowed"),
        (["own.csv", "--force", "-1"], "force = -1"),
        (["own.csv", "--band", "80", "2"], "band"),
        (["own.csv", "--out", "own.csv"], "is the record itself"),
        (["own.csv", "--out", "folder"], "folder"),
        (["own.csv", "--out", "own.csv/page.html"], "own.csv"),
        (["own.csv", "--channels", "force"], "'force' is not allowed; expected NAME="),
    ],
)
def test_identify_errors_are_lines(own_record, tmp_path, capsys, arguments, words):
    (tmp_path / "folder").mkdir()
    before = (tmp_path / "own.csv").read_bytes()
    assert own_record(*arguments) in (1, 2)
    said = capsys.readouterr()
    assert said.err.startswith("rigsim: ") and said.err.count("\n") == 1 and words in said.err and not said.out
    assert sorted(path.name for path in tmp_path.iterdir()) == ["folder", "own.csv"]
    assert (tmp_path / "own.csv").read_bytes() == before


def test_identify_names_its_own_options(own_record, capsys):
    Path("bare.csv").write_text("t,a,b,c\n" + "".join(f"{k / 100},{k % 3},{k % 5},{k % 7}\n" for k in range(300)))
    assert own_record("bare.csv") == 1
    assert "(here: --channels force=1,shaker=2,mass=3)" in capsys.readouterr().err
    assert own_record("bare.csv", "--channels", "force=1,shaker=2,mass=3") == 1
    assert "(here: --hold)" in capsys.readouterr().err


def test_columns_and_units_are_passed_on_as_they_are_called():
    given = [["force=Ch1, raw [N],shaker=2", "mass=a=b"], ["time=t"]]
    assert commands._pairs(given) == {"force": "Ch1, raw [N]", "shaker": "2", "mass": "a=b", "time": "t"}


def test_benchmarks_show_ratios_to_their_unit():
    script = str(ROOT / "tests" / "benchmarks" / "run.py")
    settings = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, script, "response"], env=settings, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    unit = next(line for line in done.stdout.splitlines() if line.startswith("unit:"))
    assert unit.split()[-1] == "1" and "frequency_response" in done.stdout
    done = subprocess.run([sys.executable, script, "nothing"], env=settings, capture_output=True, text=True)
    assert done.returncode == 1 and done.stderr.startswith("rigsim: no benchmark nothing; there are ")


@pytest.mark.skipif(os.name == "nt", reason="Windows ends a process without a signal it could answer")
def test_who_stops_a_command_stops_what_it_started():
    sleeper = "import os, time; print(os.getpid(), flush=True); time.sleep(60)"
    code = (
        "import sys\nfrom rigsim import __main__ as commands, environment\nenvironment.enter = lambda extras: None\n"
        f"commands._lab = lambda *_: commands.stopping.call([sys.executable, '-c', {sleeper!r}], '.')\n"
        "commands.main(['lab'])"
    )
    with subprocess.Popen([sys.executable, "-c", code], cwd=ROOT, stdout=subprocess.PIPE, text=True) as process:
        started = int(process.stdout.readline())
        process.terminate()
        assert process.wait(20) == 143
    with pytest.raises(ProcessLookupError):
        os.kill(started, 0)


def test_a_folder_of_the_same_name_does_not_hide_the_package(tmp_path):
    """As where a script stands beside the clone."""
    (tmp_path / "rigsim").mkdir()
    variables = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    code = "from rigsim import RigParameters; print(RigParameters().k1)"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=variables, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


CELLS = {
    "sleeps": "time.sleep(300)",
    "swallows": "while True:\n    try:\n        time.sleep(300)\n    except BaseException:\n        pass",
    "compiled": "sum(range(10**12))",
}


@pytest.mark.skipif(os.name == "nt", reason="Windows ends a process without a signal it could answer")
@pytest.mark.parametrize(
    ("cell", "number"),
    [
        ("swallows", signal.SIGINT),
        pytest.param("sleeps", signal.SIGTERM, marks=pytest.mark.full),
        pytest.param("compiled", signal.SIGHUP, marks=pytest.mark.full),
    ],
)
def test_a_cancelled_report_is_gone_within_two_seconds(tmp_path, cell, number):
    shutil.copytree(ROOT / "rigsim", tmp_path / "rigsim", ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "notebooks").mkdir()
    begun = tmp_path / "begun"
    code = f"import os, time\nopen({str(begun)!r}, 'w').write(str(os.getpid()))\n{CELLS[cell]}"
    nbformat.write(new_notebook(cells=[new_code_cell(code)]), tmp_path / "notebooks" / "01_long.ipynb")
    settings = {**os.environ, environment.VARIABLE: "current"}
    command = [sys.executable, "-m", "rigsim", "report"]
    heard = partial(signal.signal, number, signal.SIG_DFL)  # nohup has it ignored, which processes inherit
    pipes = {"stderr": subprocess.PIPE, "text": True, "preexec_fn": heard}
    with subprocess.Popen(command, cwd=tmp_path, env=settings, **pipes) as process:
        for _ in range(1200):
            if begun.exists() and begun.read_text():
                break
            time.sleep(0.05)
        sent = time.monotonic()
        process.send_signal(number)
        try:
            _, said = process.communicate(timeout=20)
        finally:
            process.terminate()  # else leaving the block would wait for it
    assert time.monotonic() - sent < 2 and process.returncode == (1 if number == signal.SIGINT else 128 + number)
    assert said.splitlines()[-1].startswith("rigsim: interrupted; no page was written; 'report 01_long' makes the rest")
    assert not Path(f"/proc/{begun.read_text()}").exists()
    assert [path.name for path in (tmp_path / "reports").iterdir()] == ["index.html"]
