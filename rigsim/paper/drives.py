"""The same points under different drives of the shaker: what each does to the force and to the detached curve."""

from dataclasses import dataclass

import numpy as np

from .. import checks
from ..design.margins import margins
from ..experiment.sine_test import SineTest, sine_test
from ..model.excitation import Tap
from ..model.shaker import MODES, ShakerDrive
from ..parameters import RigParameters, oscillator_of, rig_of
from ..results import Result, Status, frame
from ..theory.detached import detached_curves, force_scenario
from ..theory.driven import driven_response

_LINES = 241  # frequencies at which the theory is drawn
_USUAL = tuple(ShakerDrive(mode) for mode in MODES)


@dataclass(frozen=True, eq=False, repr=False)
class DriveComparison(Result):
    """What `compare_drives` returns.

    Attributes
    ----------
    parameters : RigParameters
    force : float
        What was asked of every drive (N).
    drives : tuple of ShakerDrive, length k
    test : SineTest
        Of all drives one after the other, each with the points from the start and then those that were tapped.
    theory : tuple of DrivenResponse, length k
        Single-term theory over the band of the points.
    """

    parameters: RigParameters
    force: float
    drives: tuple
    test: SineTest
    theory: tuple

    plots = {"drives": "shaker_figure", "waveforms": "shaker_waveform_figure"}

    def points(self, i):
        """Indices in ``test`` of the points of drive ``i``."""
        i = checks.integer("i", i, low=0, high=len(self.drives) - 1)
        count = self.test.frequency.size // len(self.drives)
        return np.arange(i * count, (i + 1) * count)

    def apart(self, i):
        """How far each point of drive ``i`` is from the nearest solution of `driven_response`, over it.

        Distances of z and of the fundamental of the force, (points, 2): complex, phase included, and of the solution
        that z is nearest to; NaN for a point that did not settle.
        """
        these, sent = self.points(i), self.test.driven
        theory = driven_response(self.parameters, self.force, self.test.frequency[these], self.drives[i])
        off = np.abs(theory.relative - self.test.relative[these, None])
        nearest = np.nanargmin(np.where(np.isfinite(off), off, np.inf), axis=1)[:, None]
        pairs = (theory.relative, self.test.relative), (theory.force, sent.force)
        found = [np.take_along_axis(solution, nearest, 1)[:, 0] for solution, _ in pairs]
        apart = [np.abs(rig[these] / one - 1) for one, (_, rig) in zip(found, pairs, strict=True)]
        return np.where((self.test.status[these] == Status.SETTLED)[:, None], np.column_stack(apart), np.nan)

    def table(self):
        """`pandas.DataFrame` with a row a drive.

        Of single-term theory: the damping that the coil adds to cs, the detached curves at this force, by how much the
        force may fall and cs may rise until they are lost (NaN: there is none to lose), and at which forces there are
        inner ones at all. Of the rig's settled points: the least force and where, the largest one, its largest
        harmonics, the largest voltage, the largest distance of a line of z from the theory, and how many were at the
        limit.
        """
        rows, sent = [], self.test.driven
        for i, drive in enumerate(self.drives):
            kind, window, fall, rise = self._detached(drive)
            these = self.points(i)[self.test.status[self.points(i)] == Status.SETTLED]
            size = np.abs(sent.force[these])
            low, most = (these[choose(size)] if these.size else None for choose in (np.argmin, np.argmax))
            told = [np.nan] * 6 + [0]
            if these.size:
                told = [abs(sent.force[low]), self.test.frequency[low], abs(sent.force[most]),
                        100 * sent.distortion[these].max(), np.abs(sent.voltage[these]).max(),
                        100 * np.nanmax(self.apart(i)[:, 0]), sent.limited[these].sum()]  # fmt: skip
            rows.append((drive.mode, drive.damping, kind, window, fall, rise, *told))
        columns = ["drive", "Bl^2/R [N s/m]", "detached", "inner curves at [N]", "force may fall by [%]",
                   "cs may rise by [N s/m]", "least |f| [N]", "at [Hz]", "largest |f| [N]", "f harmonics [%]",
                   "voltage [V]", "z off theory [%]", "at the limit"]  # fmt: skip
        return frame(rows, columns, index="drive")

    def _detached(self, drive):
        """Kinds, window of forces, and margins of force (%) and cs (N s/m) of a drive's detached curves."""
        equivalent, effective = drive.equivalent(self.parameters, self.force)
        scale = abs(effective) / self.force
        curves = detached_curves(equivalent, abs(effective))
        told = ", ".join(f"{one.kind} {one.low:.1f} to {one.high:.1f} Hz" for one in curves) or "none"
        events = force_scenario(equivalent)
        ends = [event.force / scale for event in events if "inner" in event.kind]
        window = f"{min(ends):.3g} to {max(ends):.3g}" if ends else "none"
        if not any(one.kind == "inner" for one in curves):
            return told, window, np.nan, np.nan
        found = margins(equivalent, abs(effective), names=["force", "cs"])
        return told, window, 100 * found["force"].down / abs(effective), found["cs"].up

    def summary(self):
        """One line: how many drives, how far the force drops, and which of them keep a detached curve."""
        kept = [d.mode for d in self.drives if self._detached(d)[0] != "none"]
        low = np.nanmin(np.abs(self.test.driven.force)) / self.force
        return (
            f"DriveComparison of {len(self.drives)} drives at {self.force:g} N: the force falls to {low:.0%} of it; "
            f"detached curves with constant {', '.join(kept) or 'none of them'}"
        )


def compare_drives(
    parameters, force, frequency, drives=_USUAL, tap=Tap(), duration=6, step=5e-5, *,  # noqa: B008
    progress=False, executor=None, checkpoint=None,
):  # fmt: skip
    """`DriveComparison`: sine tests at the same points with each drive, beside single-term theory with that drive.

    Parameters
    ----------
    parameters : RigParameters
    force : float
        What is asked of every drive (N), as `ShakerDrive` reads it.
    frequency : array_like, shape (n,)
        Hz.
    drives : sequence of ShakerDrive
        By default a small shaker's four: constant current, voltage, force and acceleration.
    tap : Tap, optional
        Of a second test at each frequency; None for tests from rest alone.
    duration, step, progress, executor, checkpoint
        See `rigsim.experiment.sine_test.sine_test`. Six seconds leave a controller of 1 Hz five for the motion.

    Raises
    ------
    ValueError
        If an argument is not allowed.
    """
    parameters, force = rig_of(parameters), checks.positive("force", force, "N")
    oscillator_of(parameters)  # theory comes last, and what it refuses need not be shaken
    drives = tuple(checks.one_or_many("drives", drives, ShakerDrive, "a ShakerDrive or several"))
    if not drives:
        raise ValueError("drives has 0 elements; expected at least 1")
    tap = checks.instance("tap", tap, (Tap, type(None)), "a Tap or None")
    frequency = checks.array("frequency", frequency, "Hz", low=0.0, low_open=True)
    taps = [None] * frequency.size + ([tap] * frequency.size if tap else [])
    each = len(taps)
    test = sine_test(
        parameters, force, np.resize(frequency, each * len(drives)), taps * len(drives), duration, step=step,
        drive=[drive for drive in drives for _ in taps], progress=progress, executor=executor, checkpoint=checkpoint,
    )  # fmt: skip
    band = np.linspace(frequency.min(), frequency.max(), _LINES if frequency.size > 1 else 1)
    theory = tuple(driven_response(parameters, force, band, drive) for drive in drives)
    return DriveComparison(parameters, force, drives, test, theory)
