"""The paper's numbers as it prints them, the one place where they are written down."""

from .. import checks

# section -> symbol -> (text, unit)
PRINTED = {
    "Table 1": {
        "ms": ("0.154", "kg"), "ks": ("1.88e4", "N/m"), "cs": ("9.86", "N s/m"),
        "m": ("0.0052", "kg"), "k": ("4e4", "N/m"), "c": ("0.026", "N s/m"),
    },
    "Table 2": {
        "d": ("0.034", "m"), "d0": ("0.033997", "m"), "Lm": ("0.025", "m"), "Rm": ("0.004", "m"),
        "LG/Lm": ("0.125", ""),
    },
    "Eq. (2)": {"k1": ("28.235", "N/m"), "k3": ("1.382e8", "N/m^3")},
    "Tests": {
        "gravity": ("9.81", "m/s^2"), "random force, rms": ("1.115", "N"), "sample rate": ("2000", "Hz"),
        "length of the record": ("100", "s"), "force F": ("3.18", "N"), "length of a sine test": ("3", "s"),
    },
    "Fig. 3": {"mean k3": ("1.380e8", "N/m^3")},
    "Table 3": {
        "fn1": ("11.7186", "Hz"), "zeta1": ("0.0339", ""), "fn2": ("55.7434", "Hz"), "zeta2": ("0.0917", ""),
    },
    "Table 4": {
        "ms": ("0.1540", "kg"), "ks": ("1.8862e4", "N/m"), "cs": ("9.8642", "N s/m"),
        "m": ("0.0052", "kg"), "k1": ("28.2212", "N/m"), "c": ("0.0260", "N s/m"),
    },
    "Table 5": {
        "mu": ("0.034", ""), "zeta_s": ("0.091", ""), "zeta": ("0.007", ""), "Omega0": ("0.211", ""),
        "gamma": ("0.006", ""),
    },
    "Claims": {"error of Table 4": ("0.06", "%"), "harmonics": ("5", "%")},
}  # fmt: skip


def printed(section, symbol):
    """A number as the paper prints it.

    Parameters
    ----------
    section : str
        Where it stands: "Table 1", "Eq. (2)", "Fig. 3" ...
    symbol : str
        Which of its numbers: "ms", "k3", "mean k3" ...

    Returns
    -------
    float
        In the unit that is printed with it.

    Raises
    ------
    ValueError
        If the paper prints no such number.
    """
    numbers = PRINTED[checks.one_of("section", section, tuple(PRINTED))]
    return float(numbers[checks.one_of("symbol", symbol, tuple(numbers))][0])
