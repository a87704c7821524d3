"""The curve by contique: component-based continuation of a residual that its user writes."""

from common import report


def curve(rig):
    """Points (Hz, m) of the relative amplitude, from the low end of the band until it leaves it or stops."""
    import itertools

    import contique
    import numpy as np
    from scipy.optimize import fsolve

    ms, cs, ks, m, c, k1, k3 = (rig[name] for name in ("ms", "cs", "ks", "m", "c", "k1", "k3"))
    unit, rate = rig["force"] / ks, np.sqrt(ks / ms)

    def balance(x, Omega):
        Y, Z = unit * (x[0] + 1j * x[1]), unit * (x[2] + 1j * x[3])
        w = Omega * rate
        spring = (k1 + 0.75 * k3 * abs(Z) ** 2 + 1j * w * c) * Z
        shaker = (ks - ms * w**2 + 1j * w * cs) * Y + spring - rig["force"]
        mass = -m * w**2 * (Y - Z) - spring
        return np.array([shaker.real, shaker.imag, mass.real, mass.imag]) / rig["force"]

    low, high = (2 * np.pi * f / rate for f in rig["band"])
    start = fsolve(balance, np.zeros(4), args=(low,), xtol=1e-12)
    steps = contique.solve(
        fun=balance, x0=start, lpf0=low, dxmax=0.2, dlpfmax=0.02, maxsteps=1500, maxcycles=4, maxiter=20, tol=1e-8,
        overshoot=1.05,
    )  # fmt: skip
    curve = np.array([step.x for step in itertools.takewhile(lambda step: low <= step.x[4] <= high, steps)])
    return np.column_stack([curve[:, 4] * rate / (2 * np.pi), unit * np.hypot(curve[:, 2], curve[:, 3])])


if __name__ == "__main__":
    report(curve)
