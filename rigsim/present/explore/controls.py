"""Sliders with their units in words, and the rig that a panel's settings describe."""

import ipywidgets

from ...parameters import RigParameters

PAPERS_RIG = RigParameters()

_STYLE = {"description_width": "172px"}
_LAYOUT = {"width": "370px"}


def slider(description, value, low, high, step, digits):
    """A `FloatSlider` whose range is widened to hold its first value."""
    value = float(f"{value:.9g}")  # 3, where a difference of two lengths leaves 2.99999999999...
    return ipywidgets.FloatSlider(
        value, min=min(low, value), max=max(high, value), step=step, description=description,
        readout_format=f".{digits}f", style=_STYLE, layout=_LAYOUT,
    )  # fmt: skip


def choice(description, options, value):
    """`Dropdown` in the same column as the sliders; ``options`` are pairs of text and value."""
    return ipywidgets.Dropdown(options=options, value=value, description=description, style=_STYLE, layout=_LAYOUT)


def stretch_slider(parameters):
    """Stretch of the wires (µm), which sets their tension k (d - d0)."""
    return slider("wire stretch d − d0 [µm]", 1e6 * (parameters.d - parameters.d0), 0.0, 30.0, 0.1, 1)


def offset_slider(parameters):
    """Offset LG of the centre of mass from P (mm)."""
    return slider("mass offset LG [mm]", 1e3 * parameters.LG, -11.0, 11.0, 0.125, 3)


def sets_choice(parameters):
    """One wire set or two."""
    return choice("wire sets", [("one", 1), ("two", 2)], parameters.wire_sets)


def reset_label(parameters):
    """What the controls are set back to."""
    return "Paper's rig" if parameters == PAPERS_RIG else "Rig as given"


def changed(parameters, stretch, sets=None, **others):
    """The rig with wires cut so that they are stretched by ``stretch`` (µm), on one set or two of the same k1, k3."""
    rig = parameters.replace(d0=parameters.d - 1e-6 * stretch, **others)
    return rig.single_set() if sets == 1 else rig.double_set() if sets == 2 else rig
