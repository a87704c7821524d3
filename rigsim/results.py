"""What every result shares: a one-line summary, a small table, a status in words, and a forwarding ``.plot()``."""

import enum
from collections.abc import Sequence

from . import checks


class Status(enum.Enum):
    """How a computation or a test ended: one enumeration for the whole package.

    A member's value is the sentence that explains it; ``str()`` gives the words for a table. Results carry the
    figures that led to it in their ``message``.
    """

    # motions in a test
    SETTLED = "The motion settled: z drifts less than 1e-3 between half windows and has no other line above 2 %."
    SUBHARMONIC = "The motion repeats only after several periods of the force: it has a lasting line below f."
    STILL_DRIFTING = "The motion was still drifting when the test ended; shake for longer."
    NOT_PERIODIC = "The motion lasts but does not repeat within a few periods of the force."
    FLEW_APART = "The mass went past its wires' reach; expect a weaker force or stiffer wires."
    STAYS_IN_PLANE = "The planar motion lasts in three dimensions: roll and yaw stay below 1e-3 rad."
    LEAVES_THE_PLANE = "Roll or yaw grow past 1e-3 rad, yet z is what the planar test says, within 1 %."
    OPTIMISTIC = "Roll or yaw grow and change z by more than 1 %: the planar test shows a better rig than there is."
    PASSING = "The force was moving on: what was read is a mean over a window, of a motion on its way."
    ELSEWHERE = "The motion settled, but near no solution of the theory."
    # tests under feedback
    HELD = "Feedback holds the motion and adds less than 1 % of the force off its own line: it is one of the open rig."
    INVASIVE = "Feedback holds a motion, but one that it takes part in: the target's harmonics did not converge."
    LOST = "The loop did not hold the motion that it was designed for."
    UNTRIED = "This motion was not tried; the message says why."
    # curves of periodic orbits
    CLOSED = "The curve closes on itself inside the band."
    LEAVES_THE_BAND = "The curve was followed to the ends of the band."
    BRANCHES_OFF = "The curve begins or ends where it branches off another one."
    STOPPED = "The curve was not followed to its end; the message says where and why."
    # searches and fits
    CONVERGED = "The iteration converged."
    NOT_CONVERGED = "The iteration did not converge in the steps it was given."
    FOUND = "What was searched for was found."
    NOT_FOUND = "What was searched for was not found; the message says how far the search went."
    IDENTIFIED = "The model explains the record, and the parameters explain the model."
    DOUBTFUL = "Something in the record speaks against this result; the message says what."

    def __str__(self):
        return self.name.lower().replace("_", " ")

    def __contains__(self, words):
        return words in self.value


def counted(statuses):
    """How many of a sequence of `Status` there are of each, in words."""
    statuses = list(statuses)
    return ", ".join(f"{statuses.count(status)} {status}" for status in Status if status in statuses)


def spanned(values):
    """From where to where an array of numbers goes, in words."""
    low, high = values.min(), values.max()
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"


def frame(data, columns=None, index=None):
    """`pandas.DataFrame` of rows or columns, under one of them if ``index`` names it; loads pandas at its first use."""
    import pandas as pd

    table = pd.DataFrame(data, columns=columns)
    return table if index is None else table.set_index(index)


class Result:
    """Base of the frozen dataclasses that functions return; they hold data only.

    A subclass gives ``summary()`` (one line of text) and, where a table says more than that line, ``table()`` (a
    `pandas.DataFrame`). Its ``plots`` names what can be drawn of it: a word for ``what`` to the function of
    `rigsim.present.figures` that draws it, the usual one first.
    """

    plots = {}

    def summary(self):
        """One line that says what the result is."""
        return type(self).__name__

    def table(self):
        """The result as a small `pandas.DataFrame`, or None."""
        return None

    def __repr__(self):
        return self.summary()

    def _repr_html_(self):
        from html import escape

        table = self.table()
        body = "" if table is None else table.to_html(float_format=lambda x: f"{x:.6g}", max_rows=12)
        return f"<p>{escape(self.summary())}</p>{body}"

    def plot(self, what=None, *, ax=None, **options):
        """Draw the result.

        Parameters
        ----------
        what : str, optional
            Which of the result's ``plots``, by default the first.
        ax : matplotlib.axes.Axes or sequence of them, optional
            Where to draw, one for each panel of the figure, instead of a new figure.
        **options
            Of the function of `rigsim.present.figures` that draws it.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        ValueError
            If the result has no such figure, or ``ax`` not as many axes as the figure has panels.
        """
        if not self.plots:
            raise ValueError(f"{type(self).__name__} has no figure")
        what = checks.one_of("what", next(iter(self.plots)) if what is None else what, tuple(self.plots))
        # The one arrow against the flow: imported on call, so that results need no matplotlib.
        from .present import figures

        return getattr(figures, self.plots[what])(self, ax=ax, **options)


class ResultSequence(Result, Sequence):
    """Base of results that hold many things of a kind, and *are* a sequence of them.

    A subclass is a frozen dataclass (``eq=False, repr=False``) whose field ``members`` is a tuple; it prints as its
    table.
    """

    members: tuple

    def __getitem__(self, index):
        return self.members[index]

    def __len__(self):
        return len(self.members)

    def __repr__(self):
        table = self.table() if self.members else None
        return self.summary() if table is None else f"{self.summary()}\n{table.to_string(index=False)}"
