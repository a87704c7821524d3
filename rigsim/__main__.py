"""The commands: ``python3 -m rigsim {report,test,lab,bench,identify}``.

Standard library only, since they start on a fresh clone before anything is installed; see `rigsim.environment`.
"""

import argparse
import contextlib
import re
import sys
import time
from pathlib import Path

from . import environment, stopping

ROOT = environment.ROOT
NOTEBOOKS = ROOT / "notebooks"

_EPILOG = f"""\
On first use each command makes .venv beside this clone's environment.lock (a minute or two, about 1 GB) and runs
there; when environment.txt, its lock, pyproject.toml or Python change, a new one is made beside it and then takes its
place. Delete .venv* at any time. Ctrl-C ends any command within two seconds, and says what is kept.
To use the Python environment you are in instead, with the packages of environment.txt installed by yourself, set
{environment.VARIABLE}=current."""


def main(argv=None):
    """Run one command; return its exit status: 0, 1 if it failed, 2 if it could not start."""
    parser = _parser()
    args, args.rest = parser.parse_known_args(argv)
    if args.command is None:
        parser.print_help()
        return 2
    if args.rest and not args.passes_on:
        parser.error(f"{args.command} does not know {' '.join(args.rest)}; see python3 -m rigsim {args.command} --help")
    with stopping.listening():
        try:
            environment.enter(args.extras)
            return args.run(args)
        except environment.SetupError as error:
            print(f"rigsim: {error}", file=sys.stderr)
            return 2
        except KeyboardInterrupt as stop:
            return _stopped(stop)


def _stopped(stop):
    """Say what is kept, and how to go on; return the exit status."""
    kept = [*getattr(stop, "__notes__", []), "give the same command again to start afresh"]
    with contextlib.suppress(OSError):  # where the terminal is gone
        newline = "\n" if sys.stderr.isatty() else ""  # after the terminal's ^C
        print(f"{newline}rigsim: interrupted; {'; '.join(kept)}", file=sys.stderr, flush=True)
    return getattr(stop, "status", 1)


def _parser():
    layout = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(
        prog="python3 -m rigsim",
        formatter_class=layout,
        description="A virtual experiment on a rig whose frequency response has detached resonance curves.",
        epilog=_EPILOG,
    )
    commands = parser.add_subparsers(dest="command", metavar="{report,test,lab,bench,identify}")

    def add(name, run, summary, description, extras=(), passes_on=False):
        command = commands.add_parser(
            name, help=summary, description=description, epilog=_EPILOG, formatter_class=layout, allow_abbrev=False
        )
        command.set_defaults(run=run, extras=extras, passes_on=passes_on)
        return command

    report = add(
        "report", _report, "run every notebook and write reports/*.html",
        "Runs the notebooks and writes each as one offline HTML page, with an index: reports/index.html.",
    )  # fmt: skip
    named = "by name or number: 03, 03_detached_curves"
    report.add_argument("names", nargs="*", metavar="notebook", help=f"only these, {named}")
    report.add_argument("--output", type=Path, default=ROOT / "reports", help="folder to write to (default: reports/)")

    test = add(
        "test", _test, "run the unit tests, and the notebooks under nbval",
        "Runs ruff, the unit tests and, beside them, every notebook under nbval. Any other argument goes to pytest\n"
        "(-k NAME, -x, a file ...), and then only pytest runs, on what those arguments choose.",
        extras=("test", "browser", "formats"), passes_on=True,
    )  # fmt: skip
    test.add_argument("--full", action="store_true", help="add the long checks (under 40 minutes instead of under 10)")
    test.add_argument("--soak", action="store_true", help="add those that are longer still")

    lab = add(
        "lab", _lab, "open the notebooks in JupyterLab",
        "Starts JupyterLab in notebooks/. Any other argument goes to JupyterLab (--no-browser, --port=8899 ...).",
        passes_on=True,
    )  # fmt: skip
    lab.add_argument("notebook", nargs="?", help=f"the notebook to open, {named}")

    bench = add(
        "bench", _bench, "measure speed, as ratios to a unit measured in the same run",
        "Runs tests/benchmarks and prints a table: what was measured, and its ratio to the unit of the same benchmark.",
    )  # fmt: skip
    bench.add_argument("names", nargs="*", metavar="benchmark", help="only these; all but peers by default")

    known = add(
        "identify", _identify, "identify the rig of a record of your own, and write a page about it",
        "Reads a record (a force or a base's acceleration, and displacements, velocities or accelerations of two\n"
        "masses or one), identifies its rig and writes one offline HTML page: what is wrong with the record and was\n"
        "mended, the parameters and how sure they are, whether the rig has a detached curve. Several files are tests\n"
        "of one rig.",
    )  # fmt: skip
    known.add_argument("record", type=Path, nargs="+", help="the file, or one for each test")
    known.add_argument("--force", type=float, metavar="N", help="amplitude at which detached curves are asked for")
    listed = {"nargs": "+", "action": "append", "default": [], "metavar": "NAME=..."}
    known.add_argument(
        "--channels", **listed, help="columns of the file: force=Ch1,shaker=Ch2,mass=Ch3, or their numbers"
    )
    known.add_argument("--units", **listed, help="where the file says none: shaker=mm,mass=mm")
    known.add_argument("--hold", help="what the force did between samples: zero, linear or band-limited")
    known.add_argument("--rate", type=float, metavar="HZ", help="samples a second, where the file does not say it")
    known.add_argument("--band", type=float, nargs=2, metavar="HZ", help="frequencies to identify over (default: 2 80)")
    order = "of the model: two a mode, or auto: the one that the record tells (default: 4, or 2 of one mass)"
    known.add_argument("--order", type=_order, help=order)
    known.add_argument("--out", type=Path, help="the page (default: RECORD_identified.html, in this folder)")
    return parser


def _order(text):
    if text != "auto" and not re.fullmatch(r"-?\d+", text):
        raise argparse.ArgumentTypeError(f"{text!r} is not allowed; expected a whole number or auto")
    return text if text == "auto" else int(text)


def _lacking(error):
    return environment.SetupError(
        f"this environment has no {error.name}: install what environment.txt lists, "
        f"or leave {environment.VARIABLE} unset to have .venv made"
    )


def _report(args):
    try:
        from .present.report.build import build_reports
        from .present.report.run import ReportError
    except ModuleNotFoundError as error:
        raise _lacking(error) from None
    begun = time.monotonic()
    try:
        *_, index = build_reports(args.names, NOTEBOOKS, args.output, progress=True)
    except (ReportError, ValueError) as error:
        print(f"rigsim: {error}", file=sys.stderr)
        return 1
    except OSError as error:
        what = f"{error.filename} cannot be written: {error.strerror}" if error.filename else error
        print(f"rigsim: {what}; pages of before are as they were", file=sys.stderr)
        return 1
    print(f"rigsim: the reports are ready ({time.monotonic() - begun:.0f} s): open {index}")
    return 0


def _test(args):
    pytest = [sys.executable, "-m", "pytest", *(f"--{name}" for name in ("full", "soak") if getattr(args, name))]
    # Notebooks first, since they are the longest; each stays in one of the two processes, as every test file does.
    side_by_side = ["-n", "2", "--dist", "loadfile", "--no-loadscope-reorder"]
    nbval = ["--nbval-lax", "--nbval-current-env", "--nbval-cell-timeout=300"]
    # More threads inside each process would only slow both down.
    settings = {"MPLBACKEND": "agg", "OPENBLAS_NUM_THREADS": "1"}
    chosen = args.rest or [*side_by_side, *nbval, "notebooks", "tests"]
    return 1 if stopping.call([*pytest, *chosen], ROOT, settings) else 0


def _lab(args):
    command = [sys.executable, "-m", "jupyterlab", *args.rest]
    if args.notebook:
        command.append(_notebook(args.notebook))
    return stopping.call(command, NOTEBOOKS, spare=True)


def _notebook(name):
    """File name of the notebook that a name or number means."""
    known = sorted(path.name for path in NOTEBOOKS.glob("*.ipynb"))
    stem = Path(name).name
    found = [file for file in known if stem in (file, Path(file).stem, file[:2])]
    if not found:
        raise environment.SetupError(f"no notebook {name}; there are {', '.join(known) or 'none'}")
    return found[0]


def _bench(args):
    return stopping.call([sys.executable, str(ROOT / "tests" / "benchmarks" / "run.py"), *args.names], ROOT)


def _identify(args):
    try:
        from .present.report.identified import identify_file
    except ModuleNotFoundError as error:
        raise _lacking(error) from None
    load = {"hold": args.hold, "channels": _pairs(args.channels), "units": _pairs(args.units), "sample_rate": args.rate}
    settings = {"band": args.band, "order": args.order}
    try:
        found, guessed, page = identify_file(
            args.record, args.out, args.force, load=_given(load), progress=sys.stderr.isatty(), **_given(settings)
        )
    except (ValueError, OSError) as error:
        print(f"rigsim: {_words(error)}{_options(str(error))}", file=sys.stderr)
        return 1
    for sentence in guessed:
        print(f"rigsim: {sentence}", file=sys.stderr)
    print(found.summary())
    print(found.table().drop(columns="meaning", errors="ignore").to_string())
    print(f"rigsim: the page is ready: open {page}")
    return 0


def _words(error):
    """One line that says what is wrong, and with which file."""
    named = isinstance(error, OSError) and error.filename and error.strerror
    return f"{error.filename}: {error.strerror}" if named else " ".join(str(error).split())


def _options(message):
    """How the command is told what a reader of files asks for by its arguments."""
    asked = {"channels=": "--channels force=1,shaker=2,mass=3", "expected hold": "--hold", "sample_rate=": "--rate",
             "units=": "--units shaker=mm"}  # fmt: skip
    found = [option for words, option in asked.items() if words in message]
    return f" (here: {' and '.join(found)})" if found else ""


def _given(options):
    return {name: value for name, value in options.items() if value not in (None, {})}


def _pairs(texts):
    """Names and values of ``force=Ch1,shaker=2``; a comma ends a value only where another name follows it."""
    pairs = [pair for several in texts for text in several for pair in re.split(r",(?=\w+=)", text)]
    wrong = [pair for pair in pairs if not re.match(r"\w+=.", pair)]
    if wrong:
        raise environment.SetupError(f"{wrong[0]!r} is not allowed; expected NAME=..., such as force=Ch1,shaker=Ch2")
    return dict(pair.partition("=")[::2] for pair in pairs)


if __name__ == "__main__":
    sys.exit(main())
