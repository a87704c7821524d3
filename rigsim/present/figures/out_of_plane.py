"""What three dimensions make of planar sine tests: rings where these are optimistic, and how deviations grow."""

import numpy as np

from ... import checks
from ...experiment.out_of_plane import GROWN, OutOfPlane, planar_only
from ...results import Status
from .style import BLACK, BLUE, GREEN, ORANGE, PANELS, RED, legend, log_scale, marks, outer_labels, style, subplots

_RING = {"marker": "o", "markersize": 11, "markeredgewidth": 1.6}
_RINGS = {
    Status.OPTIMISTIC: _RING | {"color": RED, "label": "z changes by > 1 % in space"},
    Status.LEAVES_THE_PLANE: _RING | {"color": ORANGE, "label": "leaves the plane"},
}


def in_space(space, rigs):
    """Checked `OutOfPlane` of planar tests of ``rigs``, one or a sequence, and what to say of the tests in words."""
    space = checks.one_or_many("space", space, OutOfPlane, "what SineTest.out_of_plane() gives")
    if not space:
        return (), planar_only(rigs)
    leave, changed = (sum(int((one.status == status).sum()) for one in space) for status in reversed(_RINGS))
    return space, f"in three dimensions z changes by more than 1 % in {changed} tests, and {leave} more leave the plane"


def rings(grid, space, told):
    """Mark points by what `OutOfPlane` says of them, in the panels of xs, x and z, or else warn above the first."""
    if told and not space:
        grid[0].set_title(told, fontsize=8, loc="right")
    for axes, (quantity, _) in zip(grid, PANELS, strict=True):
        for status, look in _RINGS.items():
            for one in space:
                these = one.status == status
                if these.any():
                    amplitude = 1e3 * abs(getattr(one.test, quantity)[these])
                    marks(axes, one.test.frequency[these], amplitude, look, zorder=5)


def growth_figure(result, *, ax=None):
    """Largest roll and yaw of an `OutOfPlane` over frequency, and how fast deviations from periodic motions grow.

    Filled after a tap. The growth is known where a test settled.
    """
    test = result.test
    tapped = np.array([tap is not None for tap in test.tap])
    known = np.isfinite(result.growth)
    grown = int((np.maximum(result.roll, result.yaw) > GROWN).sum())
    alt = (
        f"Largest roll and yaw of {len(tapped)} sine tests in three dimensions over {test.frequency.min():g} to "
        f"{test.frequency.max():g} Hz, logarithmic: {grown} grow past {GROWN:g} rad. Below, the growth of deviations "
        f"from {int(known.sum())} periodic motions: {int(result.unstable.sum())} grow."
    )
    with style():
        figure, grid = subplots(2, 1, alt=alt, ax=ax, height=6.4, sharex=True)
        for tap in (False, True):
            told = f"after {'a tap' if tap else 'no tap'}"
            chosen = tapped == tap
            for values, look, name in (
                (result.roll, {"marker": "o", "color": BLUE}, "roll"),
                (result.yaw, {"marker": "D", "color": GREEN}, "yaw"),
            ):
                if chosen.any():
                    marks(grid[0], test.frequency[chosen], values[chosen], look, tap, label=f"{name}, {told}")
            these = chosen & known
            if these.any():
                look = {"marker": "o", "color": BLACK, "label": f"growth, {told}"}
                marks(grid[1], test.frequency[these], result.growth[these], look, tap)
        grid[1].axhline(0, color=BLACK, linewidth=0.8)
        grid[0].axhline(GROWN, color=RED, linestyle="--", linewidth=1.2, label="1e-3 rad")
        grid[0].set(ylabel="largest angle [rad]", xlabel="frequency [Hz]")
        grid[1].set(ylabel="growth [1/s]", xlabel="frequency [Hz]")
        log_scale(grid[0])
        outer_labels(grid, ax=ax)
        legend(grid, ax=ax, loc="outside upper center", columns=3)
    return figure
