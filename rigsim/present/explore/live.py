"""What every live panel shares: one image that is updated in place, a line of words, and what happens on a change."""

import io
import threading
from functools import partial
from html import escape

import ipywidgets
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

from ...campaign.stop import Stop, Stopped, look
from ..figures.style import style

_SHARPNESS = 2  # pixels of the picture a pixel of the page
_PIXELS_PER_INCH = 100  # of the page
_STALE = "rigsim-stale"
_LOOK = f"""<style>
.{_STALE} {{opacity: 0.35}}
.rigsim-panel [role] {{line-height: 1.5}}
.rigsim-panel :is(td, th) {{padding: 0 0.6em; text-align: right}}
</style>"""


class LivePanel(ipywidgets.VBox):
    """Controls over a picture of fixed size, and words below it that say what is seen.

    The figure is built once. A change of a control moves its animated artists over a kept background, so nothing is
    cleared and nothing flickers. Settings that are not possible leave the last picture standing, greyed, and the
    words say why.

    Parameters
    ----------
    figure : DescribedFigure
        What the controls move in it is made of artists with ``animated=True``.
    controls : dict of str to ipywidgets.Widget
    update : callable
        Called with the controls' values by name after each change; moves the artists and returns the words (HTML).
        Raises `ValueError`, before it moves anything, where the values are not possible.
    action : callable, optional
        Slow work behind a button: called with ``report(done, total)`` and the controls' values, for the rest as
        ``update``, in a thread of its own, so that the button can stop it. Afterwards the whole figure is drawn again,
        axes and all. What the controls say meanwhile is shown then.
    label : str
        On that button.
    reset_label : str
        On the button that sets the controls back.

    Attributes
    ----------
    image, message, reset, start, progress
        Its widgets; the last two are None without an ``action``.
    """

    def __init__(self, figure, controls, update, *, action=None, label="", reset_label="Start again"):
        self.figure, self.controls = figure, dict(controls)
        self._canvas, self._background = FigureCanvasAgg(figure), None
        figure.set_dpi(_SHARPNESS * _PIXELS_PER_INCH)
        self._live = sorted(figure.findobj(lambda artist: artist.get_animated()), key=lambda artist: artist.zorder)
        self._update, self._action, self._restoring = update, action, False
        self._label, self._stop, self._thread, self._missed = label, None, None, False
        self._lock = threading.RLock()  # between the thread of slow work and whoever moves the controls
        self._first_values = self.values

        width, height = (f"{inches * _PIXELS_PER_INCH:.0f}px" for inches in figure.get_size_inches())
        fixed = {"width": width, "height": height, "max_width": "100%", "object_fit": "contain", "flex": "0 0 auto"}
        # Without a tooltip: JupyterLab's view of an image fails on one. What is seen is said by the words below it.
        self.image = ipywidgets.Image(format="png", layout=fixed)
        self.message = ipywidgets.HTML(layout={"max_width": width})
        wide = {"width": "auto"}
        self.reset = ipywidgets.Button(description=reset_label, tooltip="Set every control back", layout=wide)
        self.start = self.progress = None
        buttons = [self.reset]
        if action is not None:
            self.start = ipywidgets.Button(description=label, button_style="primary", layout=wide)
            self.progress = ipywidgets.FloatProgress(max=1.0, layout={"visibility": "hidden", "width": "300px"})
            buttons = [self.start, self.reset, self.progress]
        rows = {"flex_flow": "row wrap", "max_width": width, "overflow": "visible"}
        top = ipywidgets.Box(list(self.controls.values()), layout=rows)
        look = ipywidgets.HTML(_LOOK, layout={"display": "none"})
        super().__init__([look, top, ipywidgets.HBox(buttons), self.image, self.message])
        self.add_class("rigsim-panel")

        for control in self.controls.values():
            control.observe(self._changed, "value")
        self.reset.on_click(self._restore)
        if self.start is not None:
            self.start.on_click(self._start_or_stop)
        self._changed()

    @property
    def values(self):
        """Values of the controls, by name."""
        return {name: control.value for name, control in self.controls.items()}

    def wait(self, seconds=None):
        """Return once the slow work is over, or after so many seconds."""
        if self._thread is not None:
            self._thread.join(seconds)

    def close(self):
        """Take the panel and every widget in it off the page and out of the kernel; slow work is stopped."""
        if (stop := self._stop) is not None:
            stop.ask()
            self.wait()
        for widget in _inside(self):
            widget.close()
        super().close()

    def _changed(self, _=None):
        with self._lock:
            self._missed = self._stop is not None
            if not self._restoring and not self._missed:
                self._show(partial(self._update, **self.values))

    def _restore(self, _):
        self._restoring = True  # one picture for all controls, not one for each
        try:
            for name, value in self._first_values.items():
                self.controls[name].value = value
        finally:
            self._restoring = False
        self._changed()

    def _start_or_stop(self, _):
        if (stop := self._stop) is not None:
            stop.ask()
            self.start.description, self.start.disabled = "Stopping", True
            return
        self._stop = Stop()
        self.start.description, self.start.button_style = "Stop", "warning"
        self.progress.value, self.progress.layout.visibility = 0.0, "visible"
        # A daemon, so that a kernel that is shut down does not wait for it.
        self._thread = threading.Thread(target=self._act, args=(self._stop, self.values), daemon=True)
        self._thread.start()

    def _act(self, stop, values):
        try:
            with stop.heeded():
                self._show(partial(self._action, self._report, **values), whole=True)
        finally:
            self.progress.layout.visibility = "hidden"
            self.start.description, self.start.button_style, self.start.disabled = self._label, "primary", False
            with self._lock:
                self._stop = None
                if self._missed:
                    self._changed()

    def _report(self, done, total):
        look()
        self.progress.value = done / total

    def _show(self, draw, whole=False):
        try:
            words = draw()
        except ValueError as error:
            self.message.value = (
                f'<p role="alert"><b>Not possible:</b> {escape(str(error))}. '
                "The picture is that of the last settings which were.</p>"
            )
            self.image.add_class(_STALE)
            if not self.image.value:
                self.image.value = self._picture(whole=True)
            return
        except Stopped:
            self.message.value = '<p role="status"><b>Stopped</b>, as asked: the picture is the one before.</p>'
            return
        except Exception as error:
            # The notebook logs what a callback raises, out of sight: say it here too.
            self.message.value = f'<p role="alert"><b>Failed:</b> {escape(repr(error))}</p>'
            raise
        self.image.value = self._picture(whole)
        self.image.remove_class(_STALE)
        self.message.value = f'<div role="status">{words}</div>'

    def _picture(self, whole):
        """The figure as PNG; the axes are drawn again only if ``whole``."""
        with style():
            if whole or self._background is None:
                self._canvas.draw()
                self.figure.set_layout_engine("none")  # laid out once: from now on the axes stay where they are
                self._background = self._canvas.copy_from_bbox(self.figure.bbox)
            self._canvas.restore_region(self._background)
            for artist in self._live:
                self.figure.draw_artist(artist)
        buffer = io.BytesIO()
        # Half the time that savefig needs: no transparency, light compression.
        Image.fromarray(np.asarray(self._canvas.buffer_rgba())).convert("RGB").save(buffer, "png", compress_level=1)
        return buffer.getvalue()


def _inside(widget):
    for child in getattr(widget, "children", ()):
        yield from _inside(child)
        yield child
