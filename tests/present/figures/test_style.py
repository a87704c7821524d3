"""What every figure keeps: it draws into axes handed to it, says its units in brackets, and shows itself."""

import inspect
import os
import re
import subprocess
import sys
import webbrowser
from functools import cache
from pathlib import Path
from urllib.parse import urlparse

import IPython.display
import numpy as np
import pytest
from matplotlib import pyplot
from matplotlib.figure import Figure
from matplotlib.text import Text

import rigsim
from rigsim.design.probability import curve_probability
from rigsim.identification.order import model_order
from rigsim.present import figures
from rigsim.present.figures import style

RIG = rigsim.RigParameters()
UNIT_IN_ROUND_BRACKETS = re.compile(r"\((%|°|deg|[µmk]?(Hz|m|N|s|g|rad)([ /^][^)]*)?)\)")


@cache
def identified():
    record = rigsim.random_test(RIG, duration=10)
    return rigsim.identify(record), rigsim.identify(record, conversion="all")


@cache
def driven():
    return rigsim.compare_drives(RIG, 3.18, [40.0], duration=3)


@cache
def stepped():
    return rigsim.stepped_test(RIG, 1.0, [20.0, 22.0])


@cache
def compared():
    return rigsim.compare_tests(rigsim.periodic_orbits(RIG, 1.0), stepped())


@cache
def shaken():
    return rigsim.sine_test(RIG, 3.18, [30.0, 66.0] * 2, [None] * 2 + [rigsim.Tap()] * 2)


@cache
def explored():
    return rigsim.response_sheet(RIG, (20, 60), (2.0, 7.0), 3)


@cache
def held():
    return rigsim.feedback_test(RIG, 3.18, [30.0, 34.0], points=8, average=0.5, settle=0.2)


# Figure: what draws it, which of its plots, the plot's options, and its panels.
EXAMPLES = {
    "attractors_figure": (lambda: rigsim.attractors(RIG, 3.18, 30.0, starts=64), "motions", {}, 1),
    "basins_figure": (lambda: rigsim.basins(RIG, 3.18, 30.0, pixels=5, samples=16, starts=64), "basins", {}, 1),
    "branches_figure": (lambda: rigsim.overlay(RIG, shaken()), "branches", {"nominal": RIG.replace(cs=9.0)}, 3),
    "curve_probability_figure": (lambda: curve_probability(identified()[0]), "probability", {"force": 3.18}, 1),
    "design_figure": (lambda: rigsim.design_for_detached_curve(RIG, 3.18, {"force": (2.5, 7.0)}), "design", {}, 1),
    "detached_curves_figure": (lambda: rigsim.detached_curves(RIG, 3.18), "response", {}, 3),
    "detached_probability_figure": (lambda: identified()[0], "detached curves", {"force": 3.18}, 1),
    "distortion_figure": (shaken, "distortion", {}, 3),
    "event_curves_figure": (
        lambda: rigsim.force_scenario(RIG, 3, band=(50, 60), force=(2.5, 4)).over("cs", [9.5, 9.86, 10.2]), "curves",
        {"force": 3.18}, 1,
    ),
    "existence_chart_figure": (
        lambda: rigsim.existence_chart(RIG, 3.18, ("d0", 33.985e-3, 34.001e-3), ("force", 0.3, 8.0), points=(9, 9)),
        "chart",
        {},
        1,
    ),
    "force_scenario_figure": (lambda: rigsim.force_scenario(RIG), "scenario", {"force": 3.18}, 1),
    "frequency_response_figure": (
        lambda: rigsim.frequency_response(RIG, 3.18, np.linspace(10, 80, 50)), "response", {}, 3,
    ),
    "growth_figure": (lambda: shaken().out_of_plane(), "growth", {}, 2),
    "harmonics_figure": (
        lambda: rigsim.harmonics_worth(RIG, 3.18, (50, 60), harmonics=(1, 3)), "harmonics", {}, 2,
    ),
    "held_motion_figure": (lambda: held()[5], "record", {}, 3),
    "identification_figure": (lambda: identified()[0], "identification", {}, 9),
    "integrity_figure": (
        lambda: rigsim.integrity(RIG, 3.18, [30.0, 45.0], "low", samples=16, starts=64), "integrity", {}, 1,
    ),
    "invasiveness_figure": (held, "invasiveness", {}, 1),
    "margins_figure": (lambda: rigsim.margins(RIG, 3.18), "margins", {}, 1),
    "measured_response_figure": (lambda: held().at(2.5), "response", {}, 1),
    "measured_sheet_figure": (held, "sheet", {"forces": [2.5, 3.0], "beside": "sheet"}, 2),
    "modes_figure": (lambda: rigsim.linear_modes(RIG), "shapes", {}, 4),
    "nonlinear_coefficient_figure": (lambda: identified()[0], "nonlinear coefficient", {}, 2),
    "orbits_figure": (lambda: rigsim.periodic_orbits(RIG, 3.18, (20, 60), harmonics=1)[0], "orbits", {}, 3),
    "out_of_plane_figure": (lambda: shaken().out_of_plane(), "marks", {}, 3),
    "parameter_figure": (lambda: identified()[0], "parameters", {}, 2),
    "phase_locked_figure": (
        lambda: rigsim.phase_locked_test(RIG, [0.1, 0.2], average=0.5, patience=2.0), "backbone", {}, 1,
    ),
    "prediction_figure": (lambda: identified()[0], "prediction", {}, 4),
    "readings_figure": (lambda: identified()[0], "readings", {"beside": "all"}, 2),
    "receptance_figure": (lambda: identified()[0], "receptances", {}, 6),
    "record_figure": (lambda: shaken().record(0), "record", {}, 5),
    "residual_figure": (lambda: identified()[0], "residuals", {}, 6),
    "response_surface_figure": (lambda: rigsim.force_scenario(RIG), "surface", {}, 2),
    "rig_figure": (lambda: RIG.single_set(), "rig", {"beside": RIG}, 2),
    "shaker_figure": (lambda: driven(), "drives", {}, 3),
    "shaker_waveform_figure": (lambda: driven(), "waveforms", {}, 2),
    "s_curves_figure": (held, "s-curves", {"force": 3.0}, 1),
    "sheet_amplitude_figure": (lambda: explored(), "amplitude", {"forces": [3.18]}, 1),
    "sheet_figure": (lambda: explored(), "sheet", {"force": 3.18}, 1),
    "sine_test_figure": (shaken, "lines", {}, 3),
    "singular_value_figure": (lambda: identified()[0], "singular values", {}, 1),
    "bench_test_figure": (stepped, "points", {}, 2),
    "waits_figure": (stepped, "waits", {}, 1),
    "comparison_figure": (compared, "tests", {}, 1),
    "spectrum_figure": (shaken, "spectrum", {"indices": [0, 1]}, 4),
    "stabilisation_figure": (lambda: model_order(rigsim.random_test(RIG, duration=10)), "stabilisation", {}, 2),
    "statics_figure": (lambda: rigsim.static_equilibrium(RIG), "statics", {"points": 3}, 4),
    "subharmonics_figure": (lambda: rigsim.subharmonic_motions(RIG, 3.18, [70.0], starts=32), "subharmonics", {}, 2),
    "tap_map_figure": (
        lambda: rigsim.tap_map(RIG, 3.18, 40.0, velocity=np.linspace(-0.5, 0.5, 5), instants=4, starts=64),
        "taps",
        {},
        1,
    ),
    "tolerance_study_figure": (
        lambda: rigsim.tolerance_study(RIG, 3.18, {"d0": 1e-6, "m": "2 %"}, samples=64), "study", {}, 2,
    ),
    "debug_figure": (lambda: rigsim.static_equilibrium(RIG), "pymunk", {}, 1),
    "wire_law_figure": (lambda: RIG, "wire law", {"reached": (1e-4, 2e-3)}, 2),
    "wobbling_figure": (lambda: rigsim.wobbling_map(RIG, {"LG": [0.0, 0.001]}, 3.18, points=1), "map", {}, 3),
}  # fmt: skip
every_figure = pytest.mark.parametrize("name", figures.__all__)


@cache
def example(name):
    make, what, options, panels = EXAMPLES[name]
    result = make()
    assert result.plots[what] == name
    named = {"all": lambda: identified()[1], "sheet": explored}
    words = options.get("beside")
    return result, what, options | ({"beside": named[words]()} if isinstance(words, str) else {}), panels


def blank(name, panels):
    """A user's own axes, in two rows; those of the surface must be solid."""
    figure = Figure(figsize=(6, 5))
    solid = [0] if name == "response_surface_figure" else []
    places = range(1, panels + 1)
    ax = [figure.add_subplot(2, (panels + 1) // 2, i, projection="3d" if i - 1 in solid else None) for i in places]
    return figure, ax if panels > 1 else ax[0]


@every_figure
def test_a_figure_draws_into_the_axes_it_is_handed(name, monkeypatch):
    result, what, options, panels = example(name)
    monkeypatch.setattr(style, "DescribedFigure", None)  # a figure of its own would fail
    figure, ax = blank(name, panels)
    assert result.plot(what, ax=ax, **options) is figure
    assert all(one.has_data() for one in np.ravel(np.array(ax, dtype=object))) and tuple(figure.get_size_inches()) == (
        6,
        5,
    )
    assert not figure.legends and not pyplot.get_fignums()
    _, more = blank(name, panels + 1)
    with pytest.raises(ValueError, match=f"ax has {panels + 1} elements; expected {panels} matplotlib axes"):
        result.plot(what, ax=more, **options)


@every_figure
def test_a_figure_has_words_and_units_in_square_brackets(name):
    result, what, options, _ = example(name)
    figure = result.plot(what, **options)
    assert len(figure.alt) > 40 and next(iter(inspect.signature(getattr(figures, name)).parameters)) != "ax"
    table = result.table()
    columns = [] if table is None else [str(column) for column in (*table.columns, *table.index.names)]
    for text in (*(text.get_text() for text in figure.findobj(Text)), *columns):
        assert not UNIT_IN_ROUND_BRACKETS.search(text), text
    labels = [axis.get_label_text() for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)]
    assert any("[" in label for label in labels) or name in ("singular_value_figure", "margins_figure")


def test_what_is_no_axes_is_refused():
    with pytest.raises(ValueError, match="ax has 3 elements; expected 3 matplotlib axes"):
        shaken().plot(ax=[1, 2, 3])
    with pytest.raises(ValueError, match="ax has 1 elements"):
        shaken().plot(ax="axes")


def test_without_a_window_the_figure_opens_in_the_browser(monkeypatch):
    opened = []
    monkeypatch.setattr(pyplot, "get_backend", lambda: "agg")
    monkeypatch.setattr(webbrowser, "open", lambda address: opened.append(address) or True)
    RIG.plot().show()
    (page,) = (Path(urlparse(address).path) for address in opened)
    text = page.read_text(encoding="utf-8")
    page.unlink()
    assert text.startswith("<!DOCTYPE html>") and '<svg role="img" aria-label="Side view of the rig' in text
    monkeypatch.setattr(webbrowser, "open", lambda address: bool(opened.append(address)))
    with pytest.raises(RuntimeError, match="no display"):
        RIG.plot().show()
    assert not Path(urlparse(opened[1]).path).exists()


def test_in_a_notebook_the_figure_stands_below_the_cell(monkeypatch):
    shown = []
    monkeypatch.setattr(pyplot, "get_backend", lambda: "inline")
    monkeypatch.setattr(IPython.display, "display", shown.append)
    figure = RIG.plot()
    figure.show()
    assert shown == [figure]


def test_in_a_script_the_figure_opens_a_window(tmp_path):
    (tmp_path / "window.py").write_text(
        "from matplotlib.backend_bases import FigureManagerBase\n"
        "from matplotlib.backends.backend_agg import FigureCanvasAgg\n\n\n"
        "class FigureManager(FigureManagerBase):\n"
        "    def show(self):\n        print('shown', self.canvas.figure.alt[:9])\n\n"
        "    @classmethod\n    def start_main_loop(cls):\n        print('open until closed')\n\n\n"
        "class FigureCanvas(FigureCanvasAgg):\n    manager_class = FigureManager\n"
    )
    script = (
        "import sys\nfrom rigsim import RigParameters\nfigure = RigParameters().plot()\n"
        "print('matplotlib.pyplot' in sys.modules)\nfigure.show()\n"
    )
    paths = os.pathsep.join([str(Path(rigsim.__file__).parents[1]), str(tmp_path)])
    environment = os.environ | {"MPLBACKEND": "module://window", "PYTHONPATH": paths}
    done = subprocess.run(
        [sys.executable, "-c", script], env=environment, cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines() == ["False", "shown Side view", "open until closed"]
