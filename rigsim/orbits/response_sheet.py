"""Every motion of a rig over frequency and force at once, and the forces at which its response changes its pieces.

The response at one force is a contour line of F on the response sheet (`rigsim.orbits.sheet`). Its pieces change
where F is stationary on the sheet, whatever the number of harmonics: at a minimum a closed curve is born, at a maximum
one dies, at a saddle pieces merge or split. All these lie on the fold loci, where F is stationary along them; pieces
that hang on other ones begin and end where F is stationary along the locus of their branching.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .. import checks
from ..blas import one_blas_thread
from ..campaign.progress import reporting
from ..parameters import OscillatorParameters, RigParameters, law_of
from ..results import Result, frame
from ..theory.detached import ForceEvent
from .accuracy import checked_harmonics
from .branches import PeriodicOrbits
from .continuation import sizes
from .curves import corrected, curve_through, place_on
from .loci import FOLD, hessian
from .periodic_orbits import explored_with, judged
from .sheet import SLICES, Exploration, from_rest

_NAMES = ("", "asymmetric ", "period-two ")
_NEAR = 1e-4  # of the force, how far on both sides of a saddle the pieces are compared
_SAME = 1e-6  # relative distance in force and frequency of one event found twice


@dataclass(frozen=True, eq=False, repr=False)
class ResponseSheet(Result):
    """What `response_sheet` returns.

    Attributes
    ----------
    parameters : RigParameters or OscillatorParameters
    band : (float, float)
        Hz.
    force : (float, float)
        N.
    harmonics : int
        Of the exploration, and if not ``automatic`` of every orbit.
    law : {"exact", "cubic"}
    tolerance : float
    automatic : bool
        Whether orbits have as many harmonics as the tolerance asks for.
    exploration : Exploration
        Slices and loci; its levels are 0 symmetric, 1 asymmetric, 2 of period two.
    """

    parameters: RigParameters | OscillatorParameters
    band: tuple
    force: tuple
    harmonics: int
    law: str
    tolerance: float
    automatic: bool
    exploration: Exploration

    plots = {"sheet": "sheet_figure", "amplitude": "sheet_amplitude_figure"}

    @one_blas_thread
    def at(self, force, period=1):
        """The `PeriodicOrbits` at a force (N) of the sheet's range, as `periodic_orbits` finds them."""
        force = checks.real("force", force, "N", low=self.force[0], high=self.force[1])
        period = checks.one_of("period", period, (1, 2))
        sheets = self.exploration.sheets[: period + 1]
        harmonics = "auto" if self.automatic else self.harmonics
        settings = self.band, self.law, sheets, self.exploration, harmonics, self.tolerance, period
        branches, count = judged(self.parameters, force, *settings)
        return PeriodicOrbits(branches, self.parameters, force, self.law, self.band, count)

    @cached_property
    def lines(self):
        """Tuple of (name, `Locus`): fold lines, and those of every loss of stability; "asymmetric fold" and so on."""
        levels = zip(_NAMES, self.exploration.loci, strict=False)
        return tuple((name + locus.kind, locus) for name, loci in levels for locus in loci)

    @cached_property
    def events(self):
        """Tuple of `ForceEvent`, ascending in force: births, deaths, splits, mergers, and what begins to branch off."""
        found = {}
        for level, loci in enumerate(self.exploration.loci):
            for locus in loci:
                for y, least, cusp in locus.stationary:
                    (frequency,), (force,), _ = locus.sheet.shown(y[None])
                    inside = self.force[0] <= force <= self.force[1] and self.band[0] <= frequency <= self.band[1]
                    others = found.setdefault((level, locus.kind), [])
                    if inside and not any(
                        abs(force / e.force - 1) < _SAME and abs(frequency / e.frequency - 1) < _SAME for e in others
                    ):
                        before, after, kind = self._change(level, locus, y, least, cusp)
                        others.append(ForceEvent(kind, float(force), float(frequency), before, after))
        return tuple(sorted(sum(found.values(), []), key=lambda event: event.force))

    def _change(self, level, locus, y, least, cusp):
        """Pieces before and after an event, and its name."""
        name = _NAMES[level]
        if locus.kind != FOLD:
            return (), (), f"{name}{locus.kind} {'begins' if least else 'ends'}"
        if cusp:
            side = f"{name}hysteresis"
            return ((), (side,), f"{side} birth") if least else ((side,), (), f"{side} death")
        bends, frame = hessian(locus.sheet, y)
        values, vectors = np.linalg.eigh(bends)
        if values[0] * values[1] > 0:
            side = name + (self._side(locus.sheet, y, y[-1]) if level == 0 else "piece")
            return ((), (side,), f"{side} birth") if values[0] > 0 else ((side,), (), f"{side} death")
        below, above = (self._pieces(level, locus.sheet, y, values[i], vectors[:, i] @ frame) for i in (0, 1))
        word = {(2, 1): "merger", (1, 2): "split"}.get((len(below), len(above)), "exchange")
        return below, above, f"{name}{word}: {' + '.join(below)} -> {' + '.join(above)}"

    def _pieces(self, level, sheet, y, bend, direction):
        """Names of the pieces beside a saddle, where F is below (``bend`` < 0) or above it, along a direction."""
        share = y[-1] * (1 + np.copysign(_NEAR, bend))
        equations = sheet.equations.at_force(share)
        away = np.sqrt(2 * _NEAR / abs(bend)) * direction * sizes(y, 2)
        curves = []
        for side in (1, -1):
            found = corrected(equations, (y + side * away)[:-1])
            if found and not any(place_on(*equations.system, *c[:2], found[0]) >= 0 for c in curves):
                curves.append(curve_through(equations, *found, *self.band))
        names = []
        for curve in curves:
            point = np.append(curve.points[len(curve.points) // 2], share)
            closed = curve.closed and (self._side(sheet, point, share) if level == 0 else "closed")
            names.append(closed or "open")
        return tuple(sorted(names))

    def _side(self, sheet, y, share):
        """Inner if the line from rest reaches beyond the motion y at its frequency and force, else outer."""
        equations = sheet.equations.at(y[-2] * sheet.equations.hertz)
        size = lambda points: np.hypot(*points[..., :2].T)  # noqa: E731  # the first of the odd lines
        for line in from_rest(equations, 1.2 * share):
            F = line.points[:, -1] - share
            passed = np.flatnonzero(F[:-1] * F[1:] <= 0)
            if passed.size and size(line.points[passed]).max() > size(y):
                return "inner"
        return "outer"

    def table(self):
        """`pandas.DataFrame` of the events."""
        rows = [(event.force, event.frequency, event.kind) for event in self.events]
        return frame(rows, ["force [N]", "frequency [Hz]", "event"])

    def summary(self):
        """One line: what was explored, and how many lines were found on it."""
        (low, high), (least, most) = self.band, self.force
        slices = len(set(self.exploration.frequencies))
        counts = {name: sum(known == name for known, _ in self.lines) for name, _ in self.lines}
        lines = ", ".join(f"{count} of {name}" for name, count in counts.items()) or "none"
        return (
            f"ResponseSheet: {low:g}-{high:g} Hz, {least:g}-{most:g} N, {self.harmonics} harmonics, {self.law} law; "
            f"{slices} slices, lines: {lines}"
        )


@one_blas_thread
def response_sheet(
    parameters, band=(5, 80), force=(0.1, 8.0), harmonics="auto", law=None, *, tolerance=1e-6, progress=False
):
    """Every motion connected with rest over a band of frequencies and a range of forces.

    Parameters
    ----------
    parameters : RigParameters or OscillatorParameters
    band : (float, float)
        Forcing frequencies (Hz).
    force : (float, float)
        Force amplitudes (N).
    harmonics, law, tolerance, progress
        See `rigsim.orbits.periodic_orbits.periodic_orbits`; "auto" is judged at the largest force.

    Returns
    -------
    ResponseSheet
        Symmetric and asymmetric motions and those of twice the period. Of what is connected with rest it has
        everything whose folds or branchings a slice at one of 24 frequencies meets, however small its curves
        (`rigsim.orbits.sheet`). Motions that hang on nothing, as of three periods, are not on it:
        `.at(force).verdict()` looks for them, from 64 starts at each of eight frequencies, and follows what it meets.
    """
    law, progress = law_of(parameters, law), checks.progress(progress)
    band, force = checks.pair("band", band, "Hz"), checks.pair("force", force, "N")
    harmonics = checked_harmonics(harmonics)
    tolerance = checks.real("tolerance", tolerance, low=1e-12, high=1e-2)
    with reporting(progress, SLICES, "response sheet") as report:
        _, exploration = explored_with(
            parameters, force[1], band, law, harmonics, tolerance, levels=3, branchings=True, report=report
        )
    automatic, count = isinstance(harmonics, str), exploration.sheets[0].equations.harmonics
    return ResponseSheet(parameters, band, force, count, law, tolerance, automatic, exploration)
