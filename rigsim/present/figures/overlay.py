"""The rig laid over the theory: points of its tests, one look for each motion, on the theory's lines."""

import numpy as np

from ...paper.virtual_experiment import BRANCHES
from ...parameters import oscillator_of
from ...results import Status
from .out_of_plane import in_space, rings
from .response import frequency_response_figure
from .style import BLACK, MOTIONS, PANELS, legend, marks, outer_labels, style, subplots

_MARGIN = 0.012  # of the band, so that symbols at its ends are whole
# The paper's circles for points on a branch of the theory, other shapes for the rest.
_SHAPES = dict.fromkeys(("only", "high", "middle", "low"), "o")
_SHAPES |= {"elsewhere": "v", "subharmonic": "D", "not periodic": "1"}
_LOOKS = {name: {"marker": shape, "color": MOTIONS[name]} for name, shape in _SHAPES.items()} | {
    str(Status.STILL_DRIFTING): {"marker": ".", "markersize": 4, "color": BLACK},
    str(Status.FLEW_APART): {"marker": "X", "color": BLACK},
}


def branches_figure(overlay, *, ax=None, nominal=None, band=(10.0, 80.0), space=()):
    """The paper's Fig. 6: theory's lines, and the rig's points on them, one look for each motion.

    Parameters
    ----------
    overlay : Overlay
        Theory (with the identified parameters, as in the paper), sine tests and the branch of each.
    ax : sequence of three axes, optional
        Of xs, x and z. Crosses mark branches that theory calls stable and that no test reached.
    nominal : RigParameters or OscillatorParameters, optional
        Their theory is drawn thin beside the first.
    band : pair of float
        Hz.
    space : OutOfPlane or sequence of them
        What `SineTest.out_of_plane` says of the overlay's tests: rings mark where these are optimistic. Without it the
        figure warns of a single wire set.

    Raises
    ------
    ValueError
        If the band is not two ascending frequencies.
    """
    nominal = None if nominal is None else oscillator_of(nominal, "nominal")
    theory = overlay.theory(band)
    beside = () if nominal is None else overlay.theory(band, nominal)
    low, high = theory.frequency[[0, -1]]
    names = np.concatenate(overlay.branch)
    at = np.concatenate([test.frequency for test in overlay.tests])
    counts = {name: int((names == name).sum()) for name in _LOOKS if (names == name).any()}
    missing, (space, warned) = overlay.missing(), in_space(space, overlay.rigs)
    index = np.searchsorted(overlay.response.frequency, [f for f, _ in missing])
    column = np.array([0 if name == "only" else BRANCHES.index(name) for _, name in missing], dtype=int)
    alt = (
        f"Amplitudes of shaker, mass and relative displacement in millimetres, logarithmic, over {low:g} to {high:g} "
        f"hertz at {theory.force:g} newtons: lines of theory, stable solid and unstable dashed, and {names.size} tests "
        f"of the rig: {', '.join(f'{count} {_label(name)}' for name, count in counts.items())}. "
        + _missing_words([f for f, _ in missing])
        + (f" Note: {warned}." if warned else "")
    )
    with style():
        figure, grid = subplots(3, 1, alt=alt, ax=ax, height=9.6, sharex=True)
        told = {"label": "theory", "beside": beside, "beside_label": "nominal theory"}
        frequency_response_figure(theory, ax=grid, key=False, **told)
        for axes, (quantity, _) in zip(grid, PANELS, strict=True):
            amplitude = 1e3 * np.concatenate([abs(getattr(test, quantity)) for test in overlay.tests])
            for name in reversed(counts):
                these = names == name
                marks(axes, at[these], amplitude[these], _LOOKS[name], label=f"rig: {_label(name)}", zorder=3)
            if missing:
                amplitude = 1e3 * abs(getattr(overlay.response, quantity)[index, column])
                look = {"marker": "x", "color": BLACK, "label": "stable in theory, not reached", "zorder": 4}
                marks(axes, overlay.response.frequency[index], amplitude, look)
            axes.set_xlim(low - _MARGIN * (high - low), high + _MARGIN * (high - low))
        rings(grid, space, warned)
        outer_labels(grid, ax=ax)
        legend(grid, ax=ax, loc="outside upper center", columns=3)
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
