"""What stepped-sine tests show: amplitudes over frequency, and how harmonic the motion is."""

import numpy as np

from ...experiment.out_of_plane import planar_only
from ...results import Status, counted
from .out_of_plane import in_space, rings
from .style import BLACK, BLUE, MOTIONS, legend, log_scale, marks, outer_labels, style, subplots

_NAMES = {"shaker": "shaker xs", "mass": "mass x", "relative": "relative z"}
_STATUS = {
    Status.SETTLED: {"marker": "o", "color": BLUE},
    Status.SUBHARMONIC: {"marker": "D", "color": MOTIONS["subharmonic"]},
    Status.STILL_DRIFTING: {"marker": "^", "color": BLACK},
    Status.NOT_PERIODIC: {"marker": "s", "color": MOTIONS["not periodic"]},
    Status.FLEW_APART: {"marker": "X", "color": BLACK},
}


def out_of_plane_figure(result, *, ax=None):
    """The planar `SineTest` of an `OutOfPlane`, with rings where it does not last or is optimistic."""
    return sine_test_figure(result.test, ax=ax, space=result)


def sine_test_figure(test, *, ax=None, space=()):
    """Amplitudes of xs, x and z of a `SineTest` over frequency, one symbol for each status; filled after a tap.

    A rig that flew apart has no amplitude: a cross on the lower edge marks its frequency. Rings mark what ``space``,
    `OutOfPlane` of the same tests, says of three dimensions; without it the figure warns of a single wire set.
    """
    tapped, (space, warned) = _tapped(test), in_space(space, test.parameters)
    told = counted(test.status)
    largest = np.nanmax(abs(test.relative)) if np.isfinite(test.relative).any() else np.nan
    alt = (
        f"Amplitudes of shaker, mass and relative displacement of {test.frequency.size} sine tests "
        f"from {test.frequency.min():g} to {test.frequency.max():g} Hz, {int(tapped.sum())} of them tapped: {told}; "
        f"largest relative amplitude {1e3 * largest:.3g} mm{f'; {warned}' if warned else ''}."
    )
    with style():
        figure, grid = subplots(3, 1, alt=alt, ax=ax, height=8.4, sharex=True)
        for axes, (name, words) in zip(grid, _NAMES.items(), strict=True):
            amplitude = 1e3 * abs(getattr(test, name))
            for status, look in _STATUS.items():
                for tap in (False, True):
                    points = (test.status == status) & (tapped == tap)
                    if points.any():
                        label = f"{status}, {'after a tap' if tap else 'from ' + test.start}"
                        marks(axes, test.frequency[points], amplitude[points], look, filled=tap, label=label)
            axes.set(xlabel="frequency [Hz]", ylabel=f"{words} [mm]")
            log_scale(axes, (1, 2, 5))
        rings(grid, space, warned)
        outer_labels(grid, ax=ax)
        legend(grid, ax=ax, loc="outside upper center", columns=3)
    return figure


def _tapped(test):
    return np.array([tap is not None for tap in test.tap])


def distortion_figure(test, *, ax=None):
    """Largest harmonic of xs, x and z over frequency, against the 5 % that the paper calls negligible.

    Points of the `SineTest` that did not settle are grey triangles: their lines are not steady.
    """
    percent = 100 * test.distortion
    settled, tapped = test.status == Status.SETTLED, _tapped(test)
    warned = ", in the plane only" if planar_only(test.parameters) else ""
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
        figure, grid = subplots(1, 3, alt=alt, ax=ax, width=9.5, height=4.0, sharey=True)
        for column, (axes, name) in enumerate(zip(grid, _NAMES.values(), strict=True)):
            for tap in (False, True):
                chosen = tapped == tap
                label = "after a tap" if tap else f"from {test.start}"
                for these, look, words in (
                    (chosen & settled, {"marker": "o", "color": BLUE}, ""),
                    (chosen & ~settled, {"marker": "^", "color": "#A0A0A0"}, ", not settled"),
                ):
                    if these.any():
                        key = {"filled": tap, "label": label + words}
                        marks(axes, test.frequency[these], percent[these, column], look, **key)
            axes.axhline(5, color=BLACK, linestyle="--", linewidth=1.2, label="5 %")
            log_scale(axes)
            axes.set(xlabel="frequency [Hz]", ylabel="largest harmonic [%]", title=f"{name}{warned}")
        outer_labels(grid, ax=ax)
        legend(grid, ax=ax, loc="outside upper center", columns=4)
    return figure
