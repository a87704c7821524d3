"""One look for every figure: size, colours, line key, units, and a text alternative that travels with it."""

import io
import re
from contextlib import contextmanager
from xml.sax.saxutils import quoteattr

import matplotlib
from matplotlib.figure import Figure

# Okabe and Ito's colours survive colour blindness; line style and marker carry the meaning in grey print.
BLUE, ORANGE, GREEN, RED, PURPLE, SKY, YELLOW, BLACK = (
    "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#F0E442", "#000000",
)  # fmt: skip
GREY = "#6E6E6E"

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

    def _repr_mimebundle_(self, include=None, exclude=None):
        return {"image/svg+xml": self.svg()}, {"image/svg+xml": {"alt": self.alt}}


@contextmanager
def style():
    """Apply the house style inside a ``with`` block; global settings stay as they were."""
    with matplotlib.rc_context(_RC):
        yield


def subplots(rows=1, columns=1, *, alt, width=7.5, height=None, **options):
    """A `DescribedFigure` and its axes, to be filled inside ``with style():``.

    Parameters
    ----------
    alt : str
        What a reader who cannot see the figure should know.
    width, height : float
        Inches; the height defaults to 3.2 a row, plus a little.
    **options
        Passed on to `matplotlib.figure.Figure.subplots`.

    Returns
    -------
    tuple of (DescribedFigure, matplotlib.axes.Axes or array of them)
    """
    figure = DescribedFigure(figsize=(width, height or 0.6 + 2.9 * rows), layout="constrained")
    figure.alt = alt
    return figure, figure.subplots(rows, columns, **options)
