"""What every result shares: a one-line summary, a small table, and a forwarding ``.plot()``."""


class Result:
    """Base of the frozen dataclasses that functions return; they hold data only.

    A subclass gives ``summary()`` (one line of text) and, where a table says more than
    that line, ``table()`` (a `pandas.DataFrame`). Its ``plot_name`` is the function of
    `rigsim.present.figures` that ``.plot()`` calls.
    """

    plot_name = None

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

    def plot(self, **options):
        """Draw the result; see the function of `rigsim.present.figures` that bears its name.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        NotImplementedError
            If the result has no figure.
        """
        if self.plot_name is None:
            raise NotImplementedError(f"{type(self).__name__} has no figure")
        # The one arrow against the flow: imported on call, so that results need no matplotlib.
        from .present import figures

        return getattr(figures, self.plot_name)(self, **options)
