"""How a rig of equal wires tilts and rocks, by hand: the closed forms behind the maps, and where they end.

Wires of stiffness k, stretched by e = d - d0 >= 0, so of tension T = k e; n sets at a_j from their middle, the centre
of mass r = LG - set_centre from it. With c = Rm (Rm + d)/d, by which a wire's tension turns back a pin that has turned,

    tilt:  2 k (sum(a_j^2) + n e c) = kappa     yaw: the same     roll: 4 n k e c     up and down, or sideways: 2 n k

and the weight m g at r tilts by m g r / kappa. Two sets at +-s have sum(a_j^2) = 2 s^2: micrometres of stretch count
for nothing beside millimetres of spacing. Where the sets coincide only e is left, and the tilt itself tightens the
upright wires, by Rm tilt^2/2, for it pulls their pins apart:

    2 n k c (e tilt + Rm tilt^3 / 2) = m g r.

Frequencies are those of the mass on kappa and 2 n k at once, about the sets' middle, off which its centre lies by r;
about a tilt that tightens, with e + (3/2) Rm tilt^2 in the tilt's kappa, and e + Rm tilt^2/2 in two of the four wires'
share of the roll.

Range, by comparison with statics and modes in three dimensions (tests hold it). Two sets, half a spacing of at least
1 mm, r up to 0.8 of that: all within 0.2 %. One set, e of at least 1 um, tilts up to 0.07 rad: tilt within 4 %,
rocking 2.5 %, roll 1.5 %, the others 0.3 %. Nothing is said of sets that are nearer and yet apart, nor where e < 0.
"""

import numpy as np
import scipy.linalg

RIGID = ("rocking", "yaw", "roll", "bounce", "sway")


def wobble_by_hand(parameters):
    """Tilt at rest (rad) under "tilt", and the frequencies (Hz) of `RIGID`, a dict by name; NaN where d0 > d.

    ``parameters`` are `RigParameters`; of unequal wires the mean counts.
    """
    p, names = parameters, ("tilt", *RIGID)
    e = p.d - p.d0
    if e < 0:
        return dict.fromkeys(names, np.nan)
    k, a = float(p.wire_stiffness.mean()), np.array(p.set_positions) - p.set_centre
    n, r, c = a.size, p.LG - p.set_centre, p.Rm * (p.Rm + p.d) / p.d
    spread, weight = (a**2).sum(), p.m * p.gravity * r
    if spread:
        tilt, tightened = -weight / (2 * k * (spread + n * e * c)), 0.0
    else:
        roots = np.roots([p.Rm / 2, 0.0, e, weight / (2 * n * k * c)])
        tilt = float(roots[np.abs(roots.imag).argmin()].real)
        tightened = p.Rm * tilt**2 / 2
    across = np.array([[p.m, p.m * r], [p.m * r, p.inertia + p.m * r * r]])
    found = {"tilt": tilt}
    for (low, high), stretch in ((("rocking", "bounce"), e + 3 * tightened), (("yaw", "sway"), e)):
        turning = 2 * k * (spread + n * stretch * c)
        squared, shapes = scipy.linalg.eigh(np.diag([2 * n * k, turning]), across)
        pair = np.sqrt(np.maximum(squared, 0.0)) / (2 * np.pi)
        # The mode that holds more of its energy in the turn is the rocking one.
        turns = turning * shapes[1] ** 2 > 2 * n * k * shapes[0] ** 2
        found |= {low: pair[int(turns[1])], high: pair[int(turns[0])]}
    roll = 2 * n * k * c * (2 * e + tightened)
    found["roll"] = np.sqrt(roll / (p.m * p.Rm**2 / 2)) / (2 * np.pi)
    return {name: float(found[name]) for name in names}
