"""Live panels for JupyterLab: controls, a picture that follows them, and words that say what is seen.

The only door to ipywidgets. Every panel function returns a `LivePanel`, which can be driven without a browser::

    panel = response_panel()
    panel.controls["force"].value = 4.0
    panel.message.value
"""

from .identification import identification_panel
from .live import LivePanel
from .protocol import protocol_panel
from .record import record_panel
from .response import response_panel
from .rig import rig_panel
from .shake import shake_panel

__all__ = [
    "LivePanel", "identification_panel", "protocol_panel", "record_panel", "response_panel", "rig_panel", "shake_panel",
]  # fmt: skip
