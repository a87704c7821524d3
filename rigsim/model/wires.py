"""Force of the taut wires along the motion axis: Eq. (1), its cubic approximation Eq. (2), and what that costs."""

import numpy as np

from .. import checks
from ..compiled import inlinable
from ..parameters import law_of, wires_law


@inlinable
def axial_force(spring, z):
    """Force of all wires along the axis at the relative displacement z, in the units of ``spring``, see `spring_of`.

    From Python z may be an array. The quotient is 1 - d0/l without cancellation between lengths that differ by 1e-4.
    """
    if spring[0] == 0.0:
        return z * (spring[1] + spring[2] * z * z)
    d, d0 = spring[1], spring[2]
    length = np.sqrt(z * z + d * d)
    return spring[0] * z * (z * z + spring[3] * (d + d0)) / (length * (length + d0))


@inlinable
def axial_stiffness(spring, z):
    """Slope of `axial_force`; 1 - d0 d^2/l^3 as a quotient likewise, with l - d = z^2/(l + d)."""
    if spring[0] == 0.0:
        return spring[1] + 3.0 * spring[2] * z * z
    d = spring[1]
    length = np.sqrt(z * z + d * d)
    grown = z * z / (length + d) * (length * length + length * d + d * d)
    return spring[0] * (grown + d * d * spring[3]) / (length * length * length)


def spring_of(parameters, law=None, stiffness=1.0, length=1.0):
    """What `axial_force` reads: 0, k1, k3, 0 of Eq. (2), or sum(k), d, d0, d - d0 of Eq. (1), four floats.

    ``stiffness`` (N/m) and ``length`` (m) are the units of what it is given and gives; for ``law`` see `wires_law`.
    """
    if wires_law(parameters, law) == "cubic":
        return 0.0, parameters.k1 / stiffness, parameters.k3 / stiffness * length**2, 0.0
    d, d0 = parameters.d, parameters.d0
    return float(parameters.wire_stiffness.sum()) / stiffness, d / length, d0 / length, (d - d0) / length


def suspension_force(z, parameters, law=None):
    """Restoring force (N), of the shape and sign of z, of all wires on the suspended mass, straight along the axis.

    ``z`` is the relative displacement xs - x (m). The ``law`` is "exact", Eq. (1), sum(k) z (1 - d0/sqrt(z^2 + d^2)),
    the default for a rig; or "cubic", Eq. (2), k1 z + k3 z^3, the only one without wires. Slack wires (``tension_only``
    and d0 > d) have no force within `RigParameters.gap`, by the exact law; Eq. (2) knows of no slack.
    """
    z = checks.array("z", z, "m", ndim=None)
    force = axial_force(spring_of(parameters, law), z)
    slack = wires_law(parameters, law) == "exact" and parameters.tension_only
    return np.where(np.abs(z) < parameters.gap, 0.0, force) if slack else force


def cubic_law_error(z, parameters):
    """Relative error of Eq. (2) against Eq. (1), (cubic - exact)/exact.

    Parameters
    ----------
    z : array_like, shape (...,)
        Relative displacement (m); zero gives zero.
    parameters : RigParameters

    Returns
    -------
    ndarray, shape (...,)
        Dimensionless; positive where the cubic law is too stiff. To leading order the
        difference of force is the next Taylor term, +3 sum(k) d0 z^5/(8 d^5).

    Raises
    ------
    ValueError
        If z is not finite, ``parameters`` has no wires, or d0 > d, where forces vanish that Eq. (2) does not.
    """
    law_of(parameters, "exact")
    z = checks.array("z", z, "m", ndim=None)
    exact = suspension_force(z, parameters, law="exact")
    difference = suspension_force(z, parameters, law="cubic") - exact
    return np.divide(difference, exact, out=np.zeros_like(z), where=exact != 0)
