"""The curve by pyHarm: harmonic balance of a system its user describes, followed by arc length from the low end."""

from common import report


def curve(rig):
    """Points (Hz, m) of the relative amplitude at the forcing frequency over the band."""
    import logging

    import numpy as np
    from pyHarm.Maestro import Maestro

    logging.disable(logging.CRITICAL)
    ms, cs, ks, m, c, k1, k3 = (rig[name] for name in ("ms", "cs", "ks", "m", "c", "k1", "k3"))
    low, high = (2 * np.pi * f for f in rig["band"])
    matrices = {
        "M": np.diag([ms, m]),
        "C": np.array([[cs + c, -c], [-c, c]]),
        "K": np.array([[ks + k1, -k1], [-k1, k1]]),
        "G": np.zeros((2, 2)),
    }
    maestro = Maestro({
        "system": {
            "type": "Base", "nh": [1], "nti": 32,
            "adim": {"status": True, "lc": rig["force"] / ks, "wc": np.sqrt(ks / ms)},
        },
        "substructures": {"rig": {"matrix": matrices, "ndofs": 1, "nnodes": 2}},
        "connectors": {
            "wires": {"type": "CubicSpring", "connect": {"rig": [0], "INTERNAL": [1]}, "dirs": [0], "k": k3},
            "shaker": {"type": "CosinusForcing", "connect": {"rig": [0]}, "dirs": [0], "amp": rig["force"]},
        },
        "analysis": {
            "frf": {
                "study": "frf", "solver": "NewtonRaphson", "puls_inf": low, "puls_sup": high,
                "ds0": 0.01, "ds_max": 0.2, "ds_min": 1e-6, "verbose": False,
            }
        },
    })  # fmt: skip
    maestro.operate()
    x = np.array([solution.x for solution in maestro.nls["frf"].SolList if solution.flag_accepted])
    frequency = x[:, -1] * np.sqrt(ks / ms) / (2 * np.pi)
    return np.column_stack([frequency, rig["force"] / ks * np.hypot(x[:, 0] - x[:, 1], x[:, 2] - x[:, 3])])


if __name__ == "__main__":
    report(curve)
