"""What stepped-sine tests show: amplitudes, branches beside theory, spectra, and how harmonic the motion is."""

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from ... import checks
from ...experiment.sine_test import SineTest
from ...paper.virtual_experiment import BRANCHES
from ...results import Status
from ...theory.amplitude import frequency_response
from .response import frequency_response_figure
from .style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, RED, SKY, style, subplots

_NAMES = {"shaker": "shaker xs", "mass": "mass x", "relative": "relative z"}
_STATUS = {
    Status.SETTLED: {"marker": "o", "color": BLACK},
    Status.SUBHARMONIC: {"marker": "D", "color": RED},
    Status.STILL_DRIFTING: {"marker": "^", "color": BLUE},
    Status.NOT_PERIODIC: {"marker": "s", "color": PURPLE},
    Status.FLEW_APART: {"marker": "X", "color": RED},
}
_MARGIN = 0.012  # of the band, so that symbols at its ends are whole
_CIRCLE = {"marker": "o", "markersize": 5}
_STRAY = {"marker": ".", "markersize": 4}
# The paper's circles for points on a branch of the theory, other shapes for the rest.
_BRANCH = {
    "only": _CIRCLE | {"color": BLACK},
    "high": _CIRCLE | {"color": RED},
    "middle": _CIRCLE | {"color": GREEN},
    "low": _CIRCLE | {"color": PURPLE},
    "elsewhere": {"marker": "v", "color": ORANGE},
    Status.SUBHARMONIC: {"marker": "D", "color": SKY},
    Status.STILL_DRIFTING: _STRAY | {"color": GREY},
    Status.NOT_PERIODIC: {"marker": "1", "color": GREY},
    Status.FLEW_APART: {"marker": "X", "color": RED},
}


def sine_test_figure(test):
    """Amplitudes of xs, x and z over frequency, one symbol for each status; filled after a tap.

    A rig that flew apart has no amplitude: a cross on the lower edge marks its frequency.

    Parameters
    ----------
    test : SineTest

    Returns
    -------
    DescribedFigure
    """
    tapped = _tapped(test)
    told = ", ".join(f"{int((test.status == s).sum())} {s}" for s in Status if (test.status == s).any())
    largest = np.nanmax(abs(test.relative)) if np.isfinite(test.relative).any() else np.nan
    alt = (
        f"Amplitudes of shaker, mass and relative displacement of {test.frequency.size} sine tests "
        f"from {test.frequency.min():g} to {test.frequency.max():g} Hz, {int(tapped.sum())} of them tapped: {told}; "
        f"largest relative amplitude {1e3 * largest:.3g} mm."
    )
    with style():
        figure, grid = subplots(3, 1, alt=alt, height=8.4, sharex=True)
        for axes, (name, words) in zip(grid, _NAMES.items(), strict=True):
            amplitude = 1e3 * abs(getattr(test, name))
            for status, look in _STATUS.items():
                for tap in (False, True):
                    points = (test.status == status) & (tapped == tap)
                    if points.any():
                        label = f"{status}, {'after a tap' if tap else 'from ' + test.start}"
                        _points(axes, test.frequency[points], amplitude[points], look, filled=tap, label=label)
            axes.set_ylabel(f"{words} (mm)")
            _log_scale(axes, (1, 2, 5))
        grid[-1].set_xlabel("frequency (Hz)")
        _legend(figure, grid)
    return figure


def _log_scale(axes, ticks=(1,)):
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(subs=ticks))
    axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())


def _tapped(test):
    return np.array([tap is not None for tap in test.tap])


def _points(axes, frequency, amplitude, look, filled=False, **options):
    """Markers; those without an amplitude stand on the lower edge."""
    known = np.isfinite(amplitude)
    look = {"linestyle": "none", "markersize": 5, "markeredgewidth": 1.1} | look | options
    look["markerfacecolor"] = look["color"] if filled else "none"
    axes.plot(frequency[known], amplitude[known], **look)
    if not known.all():
        edge = np.full((~known).sum(), 0.03)
        axes.plot(frequency[~known], edge, transform=axes.get_xaxis_transform(), **look)


def _legend(figure, grid, columns=3):
    """One legend for all axes, above them, each label once."""
    handles = {}
    for axes in np.ravel(grid):
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    figure.legend(handles.values(), handles.keys(), loc="outside upper center", ncols=columns)


def branches_figure(overlay, nominal=None, band=(10.0, 80.0)):
    """The paper's Fig. 6: theory's lines, and the rig's points on them, one look for each branch.

    Parameters
    ----------
    overlay : Overlay
        Theory (with the identified parameters, as in the paper), sine tests and the branch of each.
    nominal : RigParameters or OscillatorParameters, optional
        Their theory is drawn thin beside the first.
    band : pair of float
        Hz.

    Returns
    -------
    DescribedFigure
        Axes of xs, x and z over frequency, logarithmic millimetres. Crosses mark branches that theory calls stable and
        that no test reached.

    Raises
    ------
    ValueError
        If the band is not two ascending frequencies.
    """
    low, high = checks.array("band", band, "Hz", low=0.0, low_open=True, min_size=2)
    if low >= high:
        raise ValueError(f"band = {tuple(band)} Hz is not allowed; expected its lower end first")
    frequency = np.linspace(low, high, 701)
    force = overlay.response.force
    theory = frequency_response(overlay.response.parameters, force, frequency)
    beside = None if nominal is None else frequency_response(nominal, force, frequency)
    names = np.concatenate(overlay.branch)
    at = np.concatenate([test.frequency for test in overlay.tests])
    counts = {name: int((names == name).sum()) for name in _BRANCH if (names == name).any()}
    missing = overlay.missing()
    index = np.searchsorted(overlay.response.frequency, [f for f, _ in missing])
    column = np.array([0 if name == "only" else BRANCHES.index(name) for _, name in missing], dtype=int)
    alt = (
        f"Amplitudes of shaker, mass and relative displacement in millimetres, logarithmic, over {low:g} to {high:g} "
        f"hertz at {force:g} newtons: lines of theory, stable solid and unstable dashed, and {names.size} tests of the "
        f"rig: {', '.join(f'{count} {_label(name)}' for name, count in counts.items())}. "
        + _missing_words([f for f, _ in missing])
    )
    with style():
        figure, grid = subplots(3, 1, alt=alt, height=9.6, sharex=True)
        told = {"label": "theory", "beside": beside, "beside_label": "nominal theory"}
        frequency_response_figure(theory, ax=grid, **told)
        for axes, quantity in zip(grid, _NAMES, strict=True):
            amplitude = 1e3 * np.concatenate([abs(getattr(test, quantity)) for test in overlay.tests])
            for name in reversed(counts):
                these = names == name
                _points(axes, at[these], amplitude[these], _BRANCH[name], label=f"rig: {_label(name)}", zorder=3)
            if missing:
                amplitude = 1e3 * abs(getattr(overlay.response, quantity)[index, column])
                look = {"marker": "x", "color": BLACK, "label": "stable in theory, not reached", "zorder": 4}
                _points(axes, overlay.response.frequency[index], amplitude, look)
            axes.set_xlim(low - _MARGIN * (high - low), high + _MARGIN * (high - low))
        figure.align_ylabels(grid)
        _legend(figure, grid)
    return figure


def _label(name):
    return {"only": "only solution"}.get(name, f"{name} branch" if name in BRANCHES else str(name))


def _missing_words(frequency):
    if not frequency:
        return "Every branch that theory calls stable was reached."
    return (
        f"Crosses: at {len(set(frequency))} frequencies from {min(frequency):g} to {max(frequency):g} hertz a branch "
        "that theory calls stable was not reached."
    )


def spectrum_figure(test, indices, highest=4.0):
    """Amplitude spectra of z and tilt of single sine tests, so that a motion at f/2 or f/3 cannot pass unseen.

    Parameters
    ----------
    test : SineTest, or sequence of SineTest
        One for all indices, or one for each.
    indices : sequence of int
        Which of its points, one row each.
    highest : float
        Spectra end at this multiple of the force's frequency.

    Returns
    -------
    DescribedFigure
        Amplitudes zero to peak; see `amplitude_spectrum`.

    Raises
    ------
    ValueError
        If there is no such point, or not as many tests as indices.
    """
    indices = [indices] if np.ndim(indices) == 0 else list(indices)
    tests = [test] * len(indices) if isinstance(test, SineTest) else list(test)
    if not indices or len(tests) != len(indices):
        raise ValueError(f"test has {len(tests)} elements for {len(indices)} indices; expected one each, at least one")
    highest = checks.positive("highest", highest)
    records = [each.record(i) for each, i in zip(tests, indices, strict=True)]
    words = [_spectrum_words(each, i) for each, i in zip(tests, indices, strict=True)]
    alt = "Amplitude spectra of relative displacement and tilt. " + " ".join(words)
    with style():
        figure, grid = subplots(
            len(indices), 2, alt=alt, width=9.5, height=0.9 + 2.5 * len(indices), squeeze=False, sharey="col"
        )
        for row, each, i, record in zip(grid, tests, indices, records, strict=True):
            f = each.frequency[i]
            for axes, signal in zip(row, (1e3 * record.relative, np.degrees(record.tilt)), strict=True):
                frequency, amplitude = amplitude_spectrum(record, signal, f)
                shown = frequency <= highest * f
                axes.semilogy(frequency[shown], amplitude[shown], color=BLACK, linewidth=0.9)
                for part, dash in ((1, "-"), (2, "--"), (3, ":")):
                    label = "f" if part == 1 else f"f/{part}"
                    axes.axvline(f / part, color=ORANGE, linestyle=dash, linewidth=1.3, label=label, zorder=1)
                axes.set_xlim(0, highest * f)
            row[0].set_ylabel("z (mm)")
            row[1].set_ylabel("tilt (°)")
            rig = f"{f:g} Hz, {_rig_words(each.parameters[i])}, {_start_words(each, each.tap[i])}"
            row[0].set_title(rig, loc="left", fontsize=10)
            row[1].set_title(str(each.status[i]), loc="left", fontsize=10)
        for column in grid.T:
            peaks = [axes.lines[0].get_ydata().max() for axes in column]
            column[0].set_ylim(min(1e-5 * max(peaks), 1e-2 * min(peaks)), 3 * max(peaks))
        for axes in grid[-1]:
            axes.set_xlabel("frequency (Hz)")
        _legend(figure, grid)
    return figure


def amplitude_spectrum(record, signal, f):
    """Amplitudes of a signal's lines under a Hann window, its mean taken away.

    The window is the end of the record, as many times six periods of the force as it holds (or as many periods, where
    it holds fewer), so that lines at f, f/2 and f/3 fall on points of the spectrum and keep their heights.

    Parameters
    ----------
    record : Record
    signal : array_like, shape (samples,)
        One of its channels, in any unit.
    f : float
        Frequency of the force (Hz).

    Returns
    -------
    frequency, amplitude : ndarray, shape (n,)
        Hz, and zero to peak in the signal's unit.
    """
    periods = int((record.force.size + 0.5) / record.sample_rate * f)
    samples = round((periods - periods % 6 or periods) / f * record.sample_rate)
    part = np.asarray(signal, dtype=float)[-samples:]
    window = np.hanning(part.size + 1)[:-1]
    spectrum = np.fft.rfft((part - part.mean()) * window)
    return np.fft.rfftfreq(part.size, 1 / record.sample_rate), 2 * np.abs(spectrum) / window.sum()


def _rig_words(parameters):
    damped = ", rocking damped" if parameters.rocking_damping else ""
    return ("one wire set" if parameters.wire_sets == 1 else "two wire sets") + damped


def _start_words(test, tap):
    return f"from {test.start}" if tap is None else f"tapped at {tap.velocity:g} m/s"


def _spectrum_words(test, i):
    line, order = test.subharmonic[i]
    return (
        f"{test.frequency[i]:g} Hz, {_start_words(test, test.tap[i])}, {test.status[i]}: z at f "
        f"{1e3 * abs(test.relative[i]):.3g} mm, its strongest line below f {100 * line:.2g} % of that at f/{order:.3g}."
    )


def distortion_figure(test):
    """Largest harmonic of xs, x and z over frequency, against the 5 % that the paper calls negligible.

    Parameters
    ----------
    test : SineTest
        Points that did not settle are grey triangles: their lines are not steady.

    Returns
    -------
    DescribedFigure
    """
    percent = 100 * test.distortion
    settled, tapped = test.status == Status.SETTLED, _tapped(test)
    words = []
    for column, name in enumerate(_NAMES.values()):
        if settled.any():
            worst = np.flatnonzero(settled)[np.argmax(percent[settled, column])]
            words.append(f"{name} {percent[worst, column]:.2g} % at {test.frequency[worst]:g} Hz")
    alt = (
        f"Largest harmonic over the fundamental, of {test.frequency.size} sine tests from {test.frequency.min():g} to "
        f"{test.frequency.max():g} Hz. Largest of the {int(settled.sum())} settled ones: {', '.join(words) or 'none'}; "
        f"{int((percent[settled] > 5).any(axis=1).sum())} points lie above the paper's 5 %."
    )
    with style():
        figure, grid = subplots(1, 3, alt=alt, width=9.5, height=4.0, sharey=True)
        for column, (axes, name) in enumerate(zip(grid, _NAMES.values(), strict=True)):
            for tap in (False, True):
                chosen = tapped == tap
                label = "after a tap" if tap else f"from {test.start}"
                for these, look, words in (
                    (chosen & settled, {"marker": "o", "color": BLUE}, ""),
                    (chosen & ~settled, {"marker": "^", "color": "#A0A0A0"}, ", not settled"),
                ):
                    if these.any():
                        _points(
                            axes, test.frequency[these], percent[these, column], look, filled=tap, label=label + words
                        )
            axes.axhline(5, color=BLACK, linestyle="--", linewidth=1.2, label="5 %")
            _log_scale(axes)
            axes.set(xlabel="frequency (Hz)", title=name)
        grid[0].set_ylabel("largest harmonic (%)")
        _legend(figure, grid, columns=4)
    return figure
