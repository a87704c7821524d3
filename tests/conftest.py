"""What every test shares: the options ``--full`` and ``--soak``, and the promise that no test changes global state."""

import random
import signal
import sys

import numpy as np
import pytest

try:
    import hypothesis
except ModuleNotFoundError:  # only the tests that use it need it
    pass
else:
    # The same examples every time, and no verdict that depends on how fast the machine is.
    hypothesis.settings.register_profile("rigsim", derandomize=True, deadline=None, database=None)
    hypothesis.settings.load_profile("rigsim")


def pytest_addoption(parser):
    parser.addoption("--full", action="store_true", help="run the long checks too")
    parser.addoption("--soak", action="store_true", help="run the longest checks too, and print what they find")


def pytest_configure(config):
    # Whoever starts the tests in the background may have Ctrl-C ignored, which every process of theirs would inherit.
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    config.addinivalue_line("markers", "full: a long check, run only with --full")
    config.addinivalue_line("markers", "soak: longer still, run only with --soak, which implies --full")


def pytest_collection_modifyitems(config, items):
    soak = config.getoption("--soak")
    allowed = {"full": soak or config.getoption("--full"), "soak": soak}
    for item in items:
        for kind in ("full", "soak"):
            if kind in item.keywords and not allowed[kind]:
                item.add_marker(pytest.mark.skip(reason=f"long check: run with --{kind}"))


def pytest_terminal_summary(terminalreporter):
    said = [text for reports in terminalreporter.stats.values() for report in reports
            for name, text in getattr(report, "user_properties", ()) if name == "told"]  # fmt: skip
    if said:
        terminalreporter.section("what long checks found")
        terminalreporter.write("".join(f"{text}\n" for text in dict.fromkeys(said)))


@pytest.fixture
def tell(record_property):
    """Say a line that stands below the tests, whichever process they run in."""
    return lambda text: record_property("told", text)


def _global_state():
    state = {
        "numpy's floating-point error handling": np.geterr(),
        "numpy's legacy random state": [np.asarray(part).tobytes() for part in np.random.get_state()],  # noqa: NPY002
        "the random module's state": random.getstate(),
    }
    matplotlib = sys.modules.get("matplotlib")
    if matplotlib is not None:
        settings = dict(dict.items(matplotlib.rcParams))
        settings.pop("backend", None)  # resolved by matplotlib itself when first used
        state["matplotlib's rcParams"] = settings
    return state


@pytest.fixture(autouse=True)
def no_global_state():
    """No test, and nothing that a test calls, changes a setting that others see."""
    before = _global_state()
    yield
    after = _global_state()
    changed = [name for name in before if before[name] != after[name]]
    assert not changed, f"the test changed {', '.join(changed)}"
