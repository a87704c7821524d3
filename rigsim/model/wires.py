"""Force of the taut wires along the motion axis: Eq. (1), its cubic approximation Eq. (2), and what that costs."""

import numpy as np

from .. import checks
from ..parameters import LAWS, RigParameters, oscillator_of


def suspension_force(z, parameters, law="exact"):
    """Restoring force of all wires on the suspended mass, pulled straight along the axis.

    Parameters
    ----------
    z : array_like, shape (...,)
        Relative displacement xs - x (m).
    parameters : RigParameters or OscillatorParameters
        The latter knows no wires, so it takes the cubic law only.
    law : {"exact", "cubic"}
        Eq. (1), sum(k) z (1 - d0/sqrt(z^2 + d^2)), or Eq. (2), k1 z + k3 z^3.

    Returns
    -------
    ndarray, shape (...,)
        Force (N), with the sign of z.

    Raises
    ------
    ValueError
        If the law is unknown, z is not finite, the exact law is asked of a set without wires, or ``parameters``
        is of neither kind.
    """
    checks.one_of("law", law, LAWS)
    z = _displacement(z)
    if law == "cubic":
        oscillator = oscillator_of(parameters)
        return oscillator.k1 * z + oscillator.k3 * z**3
    rig = _with_wires(parameters)
    # 1 - d0/l as a quotient of a difference of squares: no cancellation between d0 and l, which differ by 1e-4.
    length = np.hypot(z, rig.d)
    stretch = (z**2 + (rig.d - rig.d0) * (rig.d + rig.d0)) / (length + rig.d0)
    return rig.wire_stiffness.sum() * z * stretch / length


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
        If z is not finite or ``parameters`` has no wires.
    """
    z = _displacement(z)
    exact = suspension_force(z, _with_wires(parameters))
    difference = suspension_force(z, parameters, law="cubic") - exact
    return np.divide(difference, exact, out=np.zeros_like(z), where=exact != 0)


def _displacement(z):
    z = np.asarray(z, dtype=float)
    if not np.isfinite(z).all():
        raise ValueError("z holds values that are not finite; expected displacements in m")
    return z


def _with_wires(parameters):
    if not isinstance(parameters, RigParameters):
        raise ValueError(f"parameters = {parameters!r} has no wires; the exact law expects RigParameters")
    return parameters
