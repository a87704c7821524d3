"""Mode shapes drawn on the rig."""

import numpy as np

from ... import checks
from .rig_parts import SETS, rig_parts
from .style import GREY, RED, legend, outer_labels, style, subplots


def modes_figure(modes, *, ax=None, largest=4e-3):
    """The four mode shapes of `linear_modes`, drawn on the rig; their amplitude is arbitrary.

    Each is drawn so large that no corner of frame or mass moves by more than ``largest`` (m).

    Raises
    ------
    ValueError
        If the modes are not those of a rig, or ``largest`` is not above zero.
    """
    if modes.about is None:
        raise ValueError("the modes have no rig to be drawn on; expected those of linear_modes")
    largest = checks.positive("largest", largest, "m")
    parameters, rest = modes.about.parameters, modes.about.coordinates
    told = [f"{name} {f:.4g} Hz" for name, f in zip(modes.names, modes.frequency, strict=True)]
    sets = SETS[parameters.wire_sets]
    alt = f"Mode shapes of the rig with {sets}, thick on the grey rig at rest, not to scale: {', '.join(told)}."
    with style():
        figure, grid = subplots(1, 4, alt=alt, ax=ax, width=11.0, height=5.0, sharex=True, sharey=True)
        still = rig_parts(parameters, rest)
        for axes, shape, text, damping in zip(grid, modes.shape, told, modes.damping, strict=True):
            # To first order the corners move in proportion, so one step tells how far to go.
            small = 1e-6 * shape.real
            reach = max(
                np.linalg.norm(rig_parts(parameters, rest + small)[name] - still[name], axis=-1).max()
                for name in ("frame", "mass")
            )
            _outline(axes, still, "at rest", GREY, 0.8)
            moved = rig_parts(parameters, rest + small * (largest / reach))
            _outline(axes, moved, "in the mode (amplitude and sign arbitrary)", RED, 1.6)
            title = f"{text}\ndamping {100 * damping:.2f} %"
            axes.set(xlabel="x [mm]", ylabel="y [mm]", title=title, aspect="equal")
        outer_labels(grid, ax=ax)
        legend(grid, ax=ax, loc="outside upper center", inside=False)
    return figure


def _outline(axes, parts, label, color, width):
    for name in ("frame", "mass"):
        axes.fill(*(1e3 * parts[name]).T, fill=False, edgecolor=color, linewidth=width)
    axes.plot(*(1e3 * parts["wires"]).T, color=color, linewidth=0.8, label=label)
