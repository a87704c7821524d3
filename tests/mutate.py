"""How well the tests bite: the core's sources are broken one place at a time, and the tests that mirror them run.

    python tests/mutate.py                      # 120 mutations, about an hour on two cores
    python tests/mutate.py --only orbits --count 20 --jobs 2 --seed 1

A mutation negates a comparison, swaps + and -, * and /, `and` and `or`, min and max, drops a `not` or a minus, turns a
truth value, takes a whole number one off, or multiplies a constant: by 2 or 1/2, tolerances below 1e-5 by 1000.
Texts, errors, summaries, tables and annotations are left alone. Every file of the core has its turn before any has a
second one; which places of a file come first is the seed's choice, whatever else is asked for. A mutation is killed
by the first test that fails, and passes where nothing is mutated, or by taking too long.

Not mutmut or cosmic-ray: the one guides mutants through trampolines, which compiled functions do not take, the other
has one command for all files, where most of our tests would be run for nothing. Each job has a copy of the tree, whose
machine code is put back before every mutation, so that only what a mutation reaches is compiled again: run the tests
first, or every mutation compiles everything.
"""

import argparse
import ast
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import Queue

ROOT = Path(__file__).resolve().parents[1]
CORE = (
    "parameters.py", "checks.py", "model", "theory", "attraction", "orbits", "design", "experiment", "identification",
    "paper/virtual_experiment.py", "campaign",
)  # fmt: skip
BROKEN = "the test that fails does so without the mutation, too"

# Tests of a file besides tests/<room>/test_<name>.py.
ALSO = {
    "parameters.py": ["test_promises.py"],
    "model/excitation.py": ["test_promises.py"],
    "experiment/random_test.py": ["test_promises.py"],
    "experiment/sine_test.py": ["test_promises.py"],
    "model/oscillator.py": ["model/test_modes.py"],
    "theory/cubic.py": ["theory/test_amplitude.py", "theory/test_floquet.py"],
    "attraction/motions.py": ["attraction/test_attractors.py", "orbits/test_subharmonics.py"],
    "attraction/settle.py": ["attraction/test_attractors.py", "attraction/test_basins.py"],
    "attraction/traps.py": ["attraction/test_attractors.py", "attraction/test_basins.py"],
    "orbits/branches.py": ["orbits/test_periodic_orbits.py", "orbits/test_stability.py"],
    "orbits/continuation.py": ["orbits/test_periodic_orbits.py", "orbits/test_stability.py"],
    "orbits/curves.py": ["orbits/test_continuation.py", "orbits/test_sheet.py"],
    "orbits/loci.py": ["orbits/test_response_sheet.py"],
    "orbits/scenario.py": ["orbits/test_response_sheet.py"],
    "orbits/convergence.py": ["orbits/test_periodic_orbits.py"],
    "orbits/harmonic_balance.py": ["orbits/test_periodic_orbits.py", "orbits/test_stability.py"],
    "orbits/periodic_orbits.py": ["orbits/test_continuation.py", "orbits/test_stability.py"],
    "orbits/shooting.py": ["orbits/test_stability.py"],
    "experiment/formats/csv_text.py": ["experiment/test_record.py"],
    "experiment/formats/netcdf.py": ["experiment/test_record.py"],
    "experiment/steady.py": ["experiment/test_sine_test.py"],
    "identification/identify.py": ["test_promises.py"],
    "identification/refine.py": ["identification/test_identify.py"],
    "campaign/checkpoint.py": ["campaign/test_run.py"],
    "campaign/code.py": ["campaign/test_run.py"],
    "campaign/progress.py": ["campaign/test_run.py"],
}

# Mutations that change nothing that could be tested: the file, its line as it is after the change, and why.
EQUIVALENT = {
    (
        "orbits/convergence.py",
        "equations = balance(branch.parameters, branch.force, count, branch.law, symmetric=False)",
    ): "mirrored orbits are found among all, only more slowly",
    (
        "orbits/sheet.py",
        "return _CEILING * max(1.0, max(math.sqrt(upper / group.gamma), _HIGHEST / _CEILING))",
    ): "slices are followed further than they need be",
    ("design/variation.py", "good = np.isfinite(sets[:, -1])"): "a set is NaN throughout or nowhere",
    (
        "experiment/lines.py",
        "for apart in (spacing / 1, spacing / 32):",
    ): "the first of two parabolas; the second decides, to as many digits",
    (
        "experiment/steady.py",
        "parts = [(time >= begin - 1e-9) & (time <= begin + half + 1.0000000000000002e-06) "
        "for begin in (time[0], time[-1] - half)]",
    ): "still far below the time between two samples",
    ("attraction/traps.py", "for _ in range(16):"): "more steps than are ever needed",
    (
        "design/enclosures.py",
        "largest, error, binomial = 0.0, 1e-247, 1.0  # far above what underflow could lose",
    ): "as far below what any coefficient is known to",
    (
        "design/enclosures.py",
        "errors[0] = error + 2.0 * unit * np.abs(bernstein).min()",
    ): "coefficients come with a bound of their own, thirty times this rounding and more",
    (
        "experiment/steady.py",
        "lines = [k for k in multiples if k < 4 * f or round(k / f * parts) % parts == 0]",
    ): "further lines of a subharmonic are fitted beside the one that is read, which none of them moves",
    (
        "identification/subspace.py",
        "left, singular_values, _ = linalg.svd(lower[second:, first:second], full_matrices=True)",
    ): "more columns than are read, the same first ones",
    (
        "identification/physical.py",
        'options = {"bounds": (lower, np.inf), "x_scale": "jac", "jac": "3-point", "max_nfev": 201}',
    ): "more steps than are ever needed",
    (
        "campaign/checkpoint.py",
        "self._database = sqlite3.connect(self.path, timeout=15.0)",
    ): "how long another process that writes is waited for",
    (
        "experiment/lines.py",
        "size = scipy.fft.next_fast_len(8 * len(time), real=False)",
    ): "another length of padding; peaks are placed between the points of any",
    (
        "theory/cubic.py",
        "root = math.sqrt(max(half * half - ninth**4, 0.0))",
    ): "where a root is looked for first; a bracket holds it",
}

NEGATED = {
    ast.Lt: ast.GtE, ast.GtE: ast.Lt, ast.Gt: ast.LtE, ast.LtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip
SWAPPED = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.And: ast.Or, ast.Or: ast.And}
EXTREMES = {"min": "max", "minimum": "maximum", "argmin": "argmax", "nanmin": "nanmax", "nanargmin": "nanargmax"}
EXTREMES |= {value: key for key, value in EXTREMES.items()}
PRECAUTIONS = {"strict", "check_finite", "kind", "copy"}  # arguments that change no number
FOR_PEOPLE = {"summary", "table", "to_dataframe", "__repr__", "__str__", "_repr_html_", "__reduce__"}


@dataclass(frozen=True)
class Mutation:
    """A stretch of a source (bytes) and what stands there instead."""

    file: str
    start: int
    end: int
    line: int
    kind: str
    before: str
    after: str
    mutated: str  # the line


def sites(file, rng):
    """Every `Mutation` of a file of the package, in the order of the text."""
    source = (ROOT / "rigsim" / file).read_bytes()
    starts = [0]
    for line in source.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    found = []

    def add(node, kind, after):
        start = starts[node.lineno - 1] + node.col_offset
        end = starts[node.end_lineno - 1] + node.end_col_offset
        mutated = (source[starts[node.lineno - 1] : start] + after.encode() + source[end:]).splitlines()[0]
        before = " ".join(source[start:end].decode().split())
        found.append(Mutation(file, start, end, node.lineno, kind, before, after, mutated.decode().strip()))

    def visit(node):
        if isinstance(node, ast.arguments):
            node.kw_defaults = [
                None if arg.arg == "progress" else value
                for arg, value in zip(node.kwonlyargs, node.kw_defaults, strict=True)
            ]  # a bar changes no number
        if _skipped(node):
            return
        for kind, after in changes(node, rng):
            add(node, kind, after)
        if isinstance(node, ast.UnaryOp) and isinstance(node.operand, ast.Constant):
            return  # a negative number is one place, its sign
        for name, value in ast.iter_fields(node):
            if name in ("decorator_list", "annotation", "returns"):
                continue
            for child in value if isinstance(value, list) else [value]:
                if isinstance(child, ast.AST):
                    visit(child)

    visit(ast.parse(source))
    return found


def _skipped(node):
    """Whether a node and all below it say or guard something, but compute nothing."""
    return (
        isinstance(node, ast.Raise | ast.JoinedStr | ast.Assert)
        or (isinstance(node, ast.FunctionDef) and node.name in FOR_PEOPLE)
        or (isinstance(node, ast.keyword) and node.arg in PRECAUTIONS)
    )


def changes(node, rng):
    """Kinds and texts of what may stand for a node."""
    match node:
        case ast.Compare():
            i = rng.randrange(len(node.ops))
            ops = [*node.ops[:i], NEGATED[type(node.ops[i])](), *node.ops[i + 1 :]]
            yield "comparison", f"({ast.unparse(ast.Compare(node.left, ops, node.comparators))})"
        case ast.BinOp() if type(node.op) in SWAPPED and not _is_text(node.left):
            yield "arithmetic", f"({ast.unparse(ast.BinOp(node.left, SWAPPED[type(node.op)](), node.right))})"
        case ast.BoolOp():
            yield "logic", f"({ast.unparse(ast.BoolOp(SWAPPED[type(node.op)](), node.values))})"
        case ast.AugAssign() if type(node.op) in SWAPPED:
            yield "arithmetic", ast.unparse(ast.AugAssign(node.target, SWAPPED[type(node.op)](), node.value))
        case ast.UnaryOp() if isinstance(node.op, ast.Not | ast.USub):
            yield "logic" if isinstance(node.op, ast.Not) else "arithmetic", f"({ast.unparse(node.operand)})"
        case ast.Name() if node.id in EXTREMES:
            yield "extreme", EXTREMES[node.id]
        case ast.Attribute() if node.attr in EXTREMES:
            yield "extreme", f"{ast.unparse(node.value)}.{EXTREMES[node.attr]}"
        case ast.Constant(bool()):
            yield "logic", str(not node.value)
        case ast.Constant(int()):
            yield "whole", str(node.value + rng.choice((-1, 1)))
        case ast.Constant(float() | complex()) if node.value == 0:
            yield "constant", "1.0"
        case ast.Constant(float() | complex()):
            yield "constant", repr(node.value * (1e3 if abs(node.value) < 1e-5 else rng.choice((0.5, 2.0))))


def _is_text(node):
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str))


def chosen(seed, only, count):
    """``count`` mutations: every file has its turn before any has a second one."""
    files = [
        str(path.relative_to(ROOT / "rigsim"))
        for part in CORE
        for path in sorted((ROOT / "rigsim" / part).rglob("*.py") if "." not in part else [ROOT / "rigsim" / part])
    ]
    queues = {}
    for file in files:
        rng = random.Random(f"{seed} {file}")
        queue = sites(file, rng)
        if queue and only in file:
            queues[file] = _mixed(queue, rng)
    order = sorted(queues)
    random.Random(seed).shuffle(order)
    rounds = max(map(len, queues.values()), default=0)
    return [queues[file][turn] for turn in range(rounds) for file in order if turn < len(queues[file])][:count]


def _mixed(queue, rng):
    """The mutations of a file in random order, each kind in its turn: or else most would be whole numbers."""
    kinds = {}
    rng.shuffle(queue)
    for mutation in queue:
        kinds.setdefault(mutation.kind, []).append(mutation)
    order = rng.sample(sorted(kinds), len(kinds))
    return [kinds[kind][turn] for turn in range(len(queue)) for kind in order if turn < len(kinds[kind])]


def tests_of(file):
    """Test files that a mutation of a file is to be killed by, the mirrored one first."""
    path = Path(file)
    mirrored = path.parent / f"test_{path.stem}.py"
    found = [str(path) for path in [mirrored, *map(Path, ALSO.get(file, []))] if (ROOT / "tests" / path).is_file()]
    return found or [str(path.parent)]


class Copy:
    """A copy of the tree in which one mutation after the other is tried."""

    def __init__(self, folder):
        self.folder, self.running = folder, None
        listed = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
        for name in subprocess.run(listed, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines():
            if (ROOT / name).is_file() and not name.startswith("notebooks/"):
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(ROOT / name, folder / name)

    def put_back(self):
        """Machine code as the tree has it, if it was ever run: for the sources as they are."""
        known, here = (folder / "rigsim" / "__pycache__" / "compiled" for folder in (ROOT, self.folder))
        here.mkdir(parents=True, exist_ok=True)
        for path in known.glob("[!.]*"):
            if not (here / path.name).exists():
                shutil.copy2(path, here / path.name)

    def run(self, tests, patience):
        """The first test that fails here, "" if all pass, or what else went wrong."""
        environment = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
        environment |= {"PYTHONPATH": str(self.folder), "PYTHONDONTWRITEBYTECODE": "1"}
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-rfE", "--tb=no", "-p", "no:cacheprovider"]
        process = subprocess.Popen(
            [*command, *(f"tests/{test}" for test in tests)], cwd=self.folder, env=environment, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
        )  # fmt: skip
        self.running = process
        try:
            said, _ = process.communicate(timeout=patience)
        except subprocess.TimeoutExpired:
            self.stop()
            return "takes too long"
        if process.returncode == 0:
            return ""
        failed = re.findall(r"^(?:FAILED|ERROR) tests/(.*?)(?: - .*)?$", said, re.M)
        return failed[0] if failed else BROKEN if process.returncode > 3 else "crashes"  # 4, 5: no such test

    def stop(self):
        """End what runs here, with all that it started."""
        if self.running is not None and self.running.poll() is None:
            os.killpg(self.running.pid, signal.SIGKILL)
            self.running.wait()

    def attempt(self, mutation, patience):
        """Words of what became of a mutation, "" if no test fails."""
        path, tests = self.folder / "rigsim" / mutation.file, tests_of(mutation.file)
        source = path.read_bytes()
        self.put_back()
        try:
            path.write_bytes(source[: mutation.start] + mutation.after.encode() + source[mutation.end :])
            failed = self.run(tests, patience)
        finally:
            path.write_bytes(source)
        if failed in ("", BROKEN, "crashes", "takes too long"):
            return failed
        self.put_back()
        # A module that does not load stands for all of its tests.
        return failed if self.passes_as_it_is(failed.partition("[")[0], patience) else BROKEN

    def passes_as_it_is(self, test, patience):
        """Whether a test passes where nothing is mutated."""
        if test not in self.known:
            self.known[test] = self.run([test], patience) == ""
        return self.known[test]

    known = {}  # of all copies


def main():
    """Try mutations and print the score."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--only", default="", metavar="PATTERN", help="files whose path holds this")
    parser.add_argument("--count", type=int, default=120)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--seed", type=int, default=2014)
    parser.add_argument("--patience", type=float, default=600.0, help="seconds after which a mutation counts as killed")
    parser.add_argument("--list", action="store_true", help="print the mutations, try none")
    options = parser.parse_args()
    mutations = chosen(options.seed, options.only, options.count)
    if options.list:
        for mutation in mutations:
            print(f"{mutation.file}:{mutation.line}  {mutation.before}  ->  {mutation.after}")
        return
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # that leaves nothing behind, too
    begun, results = time.perf_counter(), []
    with tempfile.TemporaryDirectory(prefix="mutate-") as folder:
        every = [Copy(Path(folder, str(job))) for job in range(options.jobs)]
        copies = Queue()
        for copy in every:
            copies.put(copy)

        def one(mutation):
            copy = copies.get()
            start = time.perf_counter()
            try:
                return mutation, copy.attempt(mutation, options.patience), time.perf_counter() - start
            finally:
                copies.put(copy)

        pool = ThreadPoolExecutor(options.jobs)
        try:
            for number, result in enumerate(pool.map(one, mutations), 1):
                results.append(result)
                print(f"{number:4}/{len(mutations)} {told(*result)}", flush=True)
        except KeyboardInterrupt:
            print("interrupted")
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
            for copy in every:
                copy.stop()
            pool.shutdown(wait=True)
    print(score(results, time.perf_counter() - begun))


def told(mutation, failed, seconds):
    """One line on a mutation that was tried."""
    verdict = {"": "SURVIVED", BROKEN: "not tried"}.get(failed, "killed")
    by = f"  ({failed})" if failed else ""
    return f"{verdict:9} {seconds:6.1f} s  {mutation.file}:{mutation.line}  {mutation.before}  ->  {mutation.after}{by}"


def score(results, seconds):
    """The score, and the survivors with why."""
    results = [result for result in results if result[1] != BROKEN]
    survivors = [mutation for mutation, failed, _ in results if failed == ""]
    known = [mutation for mutation in survivors if (mutation.file, mutation.mutated) in EQUIVALENT]
    killed, tried = len(results) - len(survivors), max(1, len(results))
    lines = [
        f"{killed} of {len(results)} mutations killed, {killed / tried:.0%}; {len(survivors)} survived, "
        f"{len(known)} of them known to change nothing; {seconds / 60:.0f} min"
    ]
    for mutation in survivors:
        why = EQUIVALENT.get((mutation.file, mutation.mutated), "no test sees it")
        lines.append(f"  {mutation.file}:{mutation.line}  {mutation.before}  ->  {mutation.after}: {why}")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
