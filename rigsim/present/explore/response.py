"""Panel: the frequency response and its detached curves, over force, wire tension, mass and damping."""

from ... import checks
from ..figures.rig_parts import only_rigs
from ..figures.style import style, subplots
from .controls import PAPERS_RIG, changed, choice, reset_label, slider, stretch_slider
from .curve import ResponseCurve
from .live import LivePanel

_QUANTITIES = [("relative z", "relative"), ("mass x", "mass"), ("shaker xs", "shaker")]


def response_panel(parameters=PAPERS_RIG, force=3.18, quantity="relative"):
    """`LivePanel` of the theory's response from 5 to 80 Hz, with its folds and detached curves.

    Controls "force" (N), "stretch" (µm), "mass" (g), "damping" (N s/m) and "quantity".

    Parameters
    ----------
    parameters : RigParameters
        What the controls start from.
    force : float
        Force amplitude at first (N).
    quantity : {"relative", "mass", "shaker"}
        Displacement shown at first.

    Raises
    ------
    ValueError
        If the parameters are not a rig's.
    """
    (parameters,), force = only_rigs([parameters]), checks.positive("force", force, "N")
    quantity = checks.one_of("quantity", quantity, [value for _, value in _QUANTITIES])
    controls = {
        "force": slider("force F [N]", force, 0.05, 8.0, 0.01, 2),
        "stretch": stretch_slider(parameters),
        "mass": slider("suspended mass m [g]", 1e3 * parameters.m, 0.5, 20.0, 0.1, 1),
        "damping": slider("axial damping c [N s/m]", parameters.c, 0.0, 0.2, 0.001, 3),
        "quantity": choice("displacement", _QUANTITIES, quantity),
    }
    with style():
        figure, axes = subplots(alt="Frequency response of the rig by theory", width=7.6, height=4.2)
        curve = ResponseCurve(axes)
        figure.legend(loc="outside lower center", ncols=6, handlelength=1.6, columnspacing=1.2)

    def update(force, stretch, mass, damping, quantity):
        return curve.show(changed(parameters, stretch, m=1e-3 * mass, c=damping), force, quantity)

    return LivePanel(figure, controls, update, reset_label=reset_label(parameters))
