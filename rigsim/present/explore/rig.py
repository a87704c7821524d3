"""Panel: the rig as it hangs under gravity, over wire sets, wire tension, offset, spacing and gravity."""

import numpy as np

from ... import checks
from ...model.planar import linear_modes, static_equilibrium
from ..figures.rig_parts import SETS, only_rigs, rig_parts
from ..figures.style import BLACK, BLUE, GREY, RED, SKY, style, subplots
from .controls import PAPERS_RIG, changed, choice, offset_slider, reset_label, sets_choice, slider, stretch_slider
from .live import LivePanel

_EXAGGERATIONS = (1, 10, 100, 1000)
_TEST_BAND = (10.0, 80.0)  # Hz, the paper's
_LARGEST_DRAWN = np.radians(45)
_OUTLINES = {
    "frame": {"facecolor": "#D9D9D9", "edgecolor": BLACK, "linewidth": 1.0},
    "mass": {"facecolor": SKY, "edgecolor": BLACK, "alpha": 0.7},
}
_LINES = {
    "ground": {"color": GREY, "linewidth": 1.0},
    "rollers": {"color": BLACK, "marker": "o", "markerfacecolor": "white", "markersize": 8, "linestyle": "none"},
    "shaker": {"color": BLACK, "linewidth": 1.2},
    "damper": {"color": BLACK, "linewidth": 1.0},
    "wires": {"color": RED, "label": "wires in the plane"},
    "hidden": {"color": RED, "marker": "o", "markerfacecolor": "white", "markersize": 7, "linestyle": "none",
               "label": "wires across the plane"},
    "pins": {"color": BLACK, "marker": ".", "markersize": 5, "linestyle": "none"},
    "P": {"color": BLACK, "marker": "+", "markersize": 9, "markeredgewidth": 1.6, "linestyle": "none", "label": "P"},
    "G": {"color": BLUE, "marker": "o", "markersize": 6, "linestyle": "none", "label": "centre of mass"},
}  # fmt: skip


def rig_panel(parameters=PAPERS_RIG, exaggeration=10):
    """`LivePanel` of the rig at its static equilibrium, its tilt and sag, and the modes about it.

    Controls "sets", "stretch" (µm), "offset" (mm), "spacing" (percent of the widest), "gravity" (m/s^2) and
    "exaggeration".

    Parameters
    ----------
    parameters : RigParameters
        What the controls start from.
    exaggeration : {1, 10, 100, 1000}
        How many times as large the tilt is drawn at first; fewer where it would pass 45 degrees.

    Raises
    ------
    ValueError
        If the parameters are not a rig's.
    """
    (parameters,), exaggeration = only_rigs([parameters]), checks.one_of("exaggeration", exaggeration, _EXAGGERATIONS)
    two = parameters.double_set()
    share = 100 * (two.half_spacing / (two.replace(set_half_spacing=None).half_spacing or 1))
    controls = {
        "sets": sets_choice(parameters),
        "stretch": stretch_slider(parameters),
        "offset": offset_slider(parameters),
        "spacing": slider("set spacing [% of widest]", share, 0.0, 100.0, 1.0, 0),
        "gravity": slider("gravity [m/s²]", parameters.gravity, 0.0, 20.0, 0.01, 2),
        "exaggeration": choice("tilt drawn", [(f"× {n}", n) for n in _EXAGGERATIONS], exaggeration),
    }
    with style():
        figure, axes = subplots(alt="Side view of the rig at rest", width=7.6, height=4.6)
        parts = {name: axes.fill([0], [0], animated=True, **look)[0] for name, look in _OUTLINES.items()}
        parts |= {name: axes.plot([], [], animated=True, **look)[0] for name, look in _LINES.items()}
        note = axes.text(0.5, 0.01, "", transform=axes.transAxes, ha="center", va="bottom", animated=True)
        _fix_axes(axes, parameters)
        figure.legend(loc="outside right upper")

    def update(sets, stretch, offset, spacing, gravity, exaggeration):
        widest = two.replace(LG=1e-3 * offset, set_half_spacing=None, gravity=gravity)
        rig = changed(widest, stretch, sets, set_half_spacing=spacing / 100 * widest.half_spacing)
        at, modes = static_equilibrium(rig), linear_modes(rig)
        while exaggeration > 1 and exaggeration * abs(at.tilt) > _LARGEST_DRAWN:
            exaggeration //= 10
        for name, points in rig_parts(rig, at.coordinates, exaggeration).items():
            parts[name].set_xy(1e3 * points) if name in _OUTLINES else parts[name].set_data(*1e3 * points.T)
        drawn = "to scale" if exaggeration == 1 else f"drawn {exaggeration} times as large"
        note.set_text(f"tilt {np.degrees(abs(at.tilt)):.3g}°, {drawn}")
        return _words(rig, at, modes)

    return LivePanel(figure, controls, update, reset_label=reset_label(parameters))


def _fix_axes(axes, parameters):
    """Limits that hold the rig at the largest offset the slider has."""
    far = parameters.replace(LG=0.45 * parameters.Lm, set_half_spacing=None, set_centre=0)
    x, y = 1e3 * rig_parts(far, [0.0, far.LG, 0.0, 0.0])["ground"].T
    axes.set(
        xlabel="x [mm]", ylabel="y [mm]", aspect="equal",
        xlim=(np.nanmin(x) - 2, np.nanmax(x) + 2), ylim=(np.nanmin(y) - 8, -np.nanmin(y) + 2),
    )  # fmt: skip
    axes.grid(False)


def _words(rig, at, modes):
    apart = f", {1e3 * (rig.set_positions[1] - rig.set_positions[0]):.3g} mm apart" if rig.wire_sets == 2 else ""
    tension = rig.wire_stiffness.mean() * (0.0 if rig.tension_only and rig.gap else rig.d - rig.d0)
    listed = ", ".join(f"{name} {f:.4g} Hz" for name, f in zip(modes.names, modes.frequency, strict=True))
    rocking = dict(zip(modes.names, modes.frequency, strict=True))["rocking"]
    turn = "clockwise" if at.tilt < 0 else "counter-clockwise"
    inside = _TEST_BAND[0] <= rocking <= _TEST_BAND[1]
    return (
        f"On {SETS[rig.wire_sets]}{apart}, tension {tension:.3g} N a wire, the mass <b>tilts by "
        f"{np.degrees(abs(at.tilt)):.3g}°</b> {turn} and P hangs {1e6 * at.sag:.3g} µm low. Modes: {listed}. "
        f"The rocking mode lies {'<b>inside</b>' if inside else 'outside'} the paper's test, 10 to 80 Hz."
    )
