"""One look for every figure: size, colours, line key, units, and a text alternative that travels with it."""

import io
import re
import tempfile
import threading
import webbrowser
from contextlib import contextmanager
from pathlib import Path
from xml.sax.saxutils import quoteattr

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.registry import BackendFilter, backend_registry
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from ... import checks

# Okabe and Ito's colours survive colour blindness; line style and marker carry the meaning in grey print.
BLUE, ORANGE, GREEN, RED, PURPLE, SKY, YELLOW, BLACK = (
    "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#F0E442", "#000000",
)  # fmt: skip
GREY = "#6E6E6E"

# A motion has one colour on every page; motions without a name of their own take those of OTHERS in turn.
MOTIONS = {
    "low": SKY, "middle": PURPLE, "high": RED, "only": GREEN, "subharmonic": ORANGE, "not periodic": GREY,
    "elsewhere": BLACK,
}  # fmt: skip
OTHERS = (YELLOW, BLUE, BLACK)

# The panels of Fig. 6: a field of results, and its name.
PANELS = (("shaker", "shaker $x_s$"), ("mass", "suspended mass $x$"), ("relative", "relative $z = x_s - x$"))

# The paper's key (Fig. 6).
STABLE = {"linestyle": "-"}
UNSTABLE = {"linestyle": "--"}
RIG = {"linestyle": "none", "marker": "o", "markerfacecolor": "none"}

_RC = {
    "figure.constrained_layout.use": True,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "font.size": 10,
    "axes.titlesize": 11,
    "legend.fontsize": 9,
    "legend.framealpha": 0.9,
    "lines.linewidth": 1.6,
    "svg.fonttype": "path",
    "svg.hashsalt": "rigsim",  # the same figure is the same text, so that reports can be compared
}


_DRAWING = threading.RLock()  # settings are the process's: two threads' would get mixed up


class DescribedFigure(Figure):
    """A figure that shows itself as SVG and says in words what is seen (``alt``)."""

    alt = ""

    def svg(self):
        """The figure as one ``<svg role="img" aria-label=...>`` element (str)."""
        buffer = io.StringIO()
        with matplotlib.rc_context(_RC):
            self.savefig(buffer, format="svg", metadata={"Date": None})
        text = buffer.getvalue()
        text = text[text.index("<svg") :]
        return re.sub(r"^<svg ", f'<svg role="img" aria-label={quoteattr(self.alt)} ', text, count=1)

    def show(self):
        """Open the figure in a window, as in a script; without one, in the web browser; in a notebook, below the cell.

        Raises
        ------
        RuntimeError
            If there is neither; ``savefig("figure.png")`` then keeps the picture.
        """
        from matplotlib import pyplot

        backend = pyplot.get_backend().lower()  # resolves to a window's, where there is a display
        if "inline" in backend:
            from IPython.display import display

            display(self)
            return
        if backend not in backend_registry.list_builtin(BackendFilter.NON_INTERACTIVE):
            pyplot.figure(self)
            pyplot.show()
            return
        with tempfile.NamedTemporaryFile("w", suffix=".html", prefix="rigsim-", encoding="utf-8", delete=False) as page:
            page.write(f"<!DOCTYPE html><meta charset='utf-8'><title>rigsim</title>{self.svg()}")
        if not webbrowser.open(Path(page.name).as_uri()):
            Path(page.name).unlink()
            raise RuntimeError("there is no display to show the figure on; keep it with savefig('figure.png')")

    def _repr_mimebundle_(self, include=None, exclude=None):
        return {"image/svg+xml": self.svg()}, {"image/svg+xml": {"alt": self.alt}}


@contextmanager
def style():
    """Apply the house style inside a ``with`` block; global settings stay as they were."""
    with _DRAWING, matplotlib.rc_context(_RC):
        yield


def subplots(rows=1, columns=1, *, alt, ax=None, width=7.5, height=None, **options):
    """A `DescribedFigure` and its axes, to be filled inside ``with style():``; or the axes that the user handed in.

    ``alt`` says what a reader who cannot see the figure should know. Into ``ax``, one axes a panel in rows, is drawn
    instead of a new figure; their figure's size and text are then the user's. ``width`` and ``height`` are in inches,
    by default 2.9 a row high, plus a little; options are those of `matplotlib.figure.Figure.subplots`. `ValueError` if
    ``ax`` is not as many axes as there are panels.
    """
    if ax is None:
        figure = DescribedFigure(figsize=(width, height or 0.6 + 2.9 * rows), layout="constrained")
        figure.alt = alt
        return figure, figure.subplots(rows, columns, **options)
    handed = np.ravel(np.array(ax, dtype=object))
    if handed.size != rows * columns or not all(isinstance(one, Axes) for one in handed):
        raise ValueError(f"ax has {handed.size} elements; expected {rows * columns} matplotlib axes, one a panel")
    grid = handed.reshape(rows, columns)
    if options.get("squeeze", True):
        grid = grid.squeeze()[()]  # as Matplotlib does: one axes, a row or a grid
    return handed[0].figure, grid


def circles_of(circles):
    """Frequency (Hz), shaker, mass and relative amplitudes (m) of a user's points: four rows of equal length."""
    if not isinstance(circles, (list, tuple)) or len(circles) != 4:
        raise ValueError(f"circles = {checks.shown(circles)} is not allowed; expected four arrays of one length")
    rows = [checks.lines(f"circles[{i}]", row, finite=False) for i, row in enumerate(circles)]
    if len({row.size for row in rows}) != 1:
        sizes = ", ".join(str(row.size) for row in rows)
        raise ValueError(f"circles have {sizes} elements; expected four arrays of one length")
    return (rows[0].real, *rows[1:])


def as_tuple(beside):
    """What a user wants beside a result, one or a list or tuple of them, as a tuple."""
    return tuple(beside) if isinstance(beside, (list, tuple)) else (beside,)


def outer_labels(axes, *, ax=None):
    """Keep shared labels on the outside of our own figure; axes the user handed in (``ax`` of `subplots`) keep all."""
    if ax is None:
        panels = np.ravel(np.array(axes, dtype=object))
        for one in panels:
            place = one.get_subplotspec()
            one.set_xlabel(one.get_xlabel() if place.is_last_row() else "")
            one.set_ylabel(one.get_ylabel() if place.is_first_col() else "")
        panels[0].figure.align_ylabels(panels)


def panels(axes):
    """Yield (field, axes) of the three `PANELS` with their titles and a logarithmic scale of amplitudes."""
    for letter, (name, title), one in zip("abc", PANELS, axes, strict=True):
        yield name, one
        log_scale(one, (1, 2, 5))
        one.set_ylabel("amplitude [mm]")
        one.set_title(f"({letter}) {title}", loc="left")


def in_runs(axes, curve, height, label, **look):
    """Draw ``height`` over a curve's ``frequency``, its ``runs`` of equal stability in the paper's key."""
    for run, stable in curve.runs:
        text = f"{label}, {'stable' if stable else 'unstable'}" if label else None
        axes.plot(curve.frequency[run], height[run], label=text, **(STABLE if stable else UNSTABLE), **look)


def log_scale(axes, ticks=(1,), which="y"):
    """A logarithmic x or y axis with plain numbers at ``ticks`` of each decade."""
    axes.set(**{f"{which}scale": "log"})
    axis = getattr(axes, f"{which}axis")
    axis.set_major_locator(LogLocator(subs=ticks))
    axis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.set_minor_formatter(NullFormatter())


def marks(axes, frequency, amplitude, look, filled=False, **options):
    """Markers at frequencies; those without an amplitude, NaN, stand on the lower edge."""
    known = np.isfinite(amplitude)
    look = {"linestyle": "none", "markersize": 5, "markeredgewidth": 1.1} | look | options
    look["markerfacecolor"] = look["color"] if filled else "none"
    axes.plot(frequency[known], amplitude[known], **look)
    if not known.all():
        edge = np.full((~known).sum(), 0.03)
        axes.plot(frequency[~known], edge, transform=axes.get_xaxis_transform(), **look)


def legend(axes, *, ax=None, columns=2, loc="outside lower center", inside=True, **options):
    """One key for all panels, each label once: outside our own figure, or at the last ``ax`` that the user handed in.

    ``columns`` and ``loc`` are those of the key outside, ``inside`` says whether the user's axes have room for it (else
    it stands below them), and further options are passed on to matplotlib's ``legend``.
    """
    panels = np.ravel(np.array(axes, dtype=object))
    keys = {}
    for one in panels:
        for handle, name in zip(*one.get_legend_handles_labels(), strict=True):
            keys.setdefault(name, handle)
    if ax is None:
        panels[0].figure.legend(keys.values(), keys.keys(), loc=loc, ncols=columns, **options)
    else:
        place = {} if inside else {"loc": "upper center", "bbox_to_anchor": (0.5, -0.25)}
        panels[-1].legend(keys.values(), keys.keys(), **{"fontsize": "small"} | place | options)
