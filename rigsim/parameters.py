"""Parameters of the rig and of the two-degree-of-freedom theory (the paper's Tables 1, 2 and 5)."""

from dataclasses import dataclass, field, fields, replace
from functools import cached_property

import numpy as np

from . import checks
from .results import Result, frame


def _quantity(unit, meaning, *, allowed=None, **options):
    """A field with its unit, its meaning and, if it is a plain number, the range that `checks.real` allows it."""
    return field(metadata={"unit": unit, "meaning": meaning, "allowed": allowed}, **options)


class _Table(Result):
    """Replacing and tabulating, shared by the parameter sets."""

    def replace(self, **changes):
        """A copy with some fields changed, checked again."""
        known = [item.name for item in fields(self)]
        return replace(
            self, **{checks.one_of(f"field of {type(self).__name__}", n, known): v for n, v in changes.items()}
        )

    def table(self):
        """`pandas.DataFrame` of name, value, unit and meaning."""
        rows = [(f.name, getattr(self, f.name), f.metadata["unit"], f.metadata["meaning"]) for f in fields(self)]
        return frame(rows, ["parameter", "value", "unit", "meaning"], index="parameter")

    def _repr_html_(self):
        return self.table().to_html()

    def __post_init__(self):
        for item in fields(self):
            if item.metadata["allowed"] is not None:
                value = getattr(self, item.name)
                value = checks.real(item.name, value, item.metadata["unit"], **item.metadata["allowed"])
                object.__setattr__(self, item.name, value)


_POSITIVE = {"allowed": {"low": 0.0, "low_open": True}}
_NOT_NEGATIVE = {"allowed": {"low": 0.0}}
_LARGEST = 1e60  # of a number without a unit: no product of a few of them overflows
_RATIO = {"allowed": {"low": 0.0, "high": _LARGEST}}


@dataclass(frozen=True)
class Nondimensional(_Table):
    """The five numbers of Eqs. (4a, b): the paper's Table 5."""

    mu: float = _quantity("", "mass ratio m/ms", allowed={"low": 1 / _LARGEST, "high": _LARGEST})
    zeta_s: float = _quantity("", "damping ratio of the shaker, cs/(2 ms omega_s)", **_RATIO)
    zeta: float = _quantity("", "damping ratio of the attachment, c/(2 m omega_s)", **_RATIO)
    Omega0: float = _quantity("", "frequency ratio sqrt(k1/m)/omega_s", **_RATIO)
    gamma: float = _quantity("", "nonlinear coefficient k3 (F/ks)^2/(mu ks)", **_RATIO)


@dataclass(frozen=True)
class OscillatorParameters(_Table):
    """The seven numbers of the two-degree-of-freedom theory, Eqs. (3a, b).

    Raises
    ------
    ValueError
        If a mass or ``ks`` is not above zero, or another value is negative or not finite.
    """

    ms: float = _quantity("kg", "mass of the shaker's moving part and frame", **_POSITIVE)
    ks: float = _quantity("N/m", "stiffness of the shaker", **_POSITIVE)
    cs: float = _quantity("N s/m", "damping of the shaker", **_NOT_NEGATIVE)
    m: float = _quantity("kg", "suspended mass", **_POSITIVE)
    c: float = _quantity("N s/m", "axial damping of the suspension", **_NOT_NEGATIVE)
    k1: float = _quantity("N/m", "linear stiffness of the suspension", **_NOT_NEGATIVE)
    k3: float = _quantity("N/m^3", "cubic stiffness of the suspension", **_NOT_NEGATIVE)

    @property
    def oscillator(self):
        """Itself, so that single-term theory takes this or `RigParameters` alike."""
        return self

    @property
    def omega_s(self):
        """Natural frequency of the shaker alone, sqrt(ks/ms) (rad/s)."""
        return float(np.sqrt(self.ks / self.ms))

    def nondimensional(self, force):
        """The five numbers of Eqs. (4a, b) at force amplitude ``force`` (N, above zero)."""
        force = checks.positive("force", force, "N")
        mu = self.m / self.ms
        return Nondimensional(
            mu=mu,
            zeta_s=self.cs / (2 * self.ms * self.omega_s),
            zeta=self.c / (2 * self.m * self.omega_s),
            Omega0=float(np.sqrt(self.k1 / self.m)) / self.omega_s,
            gamma=self.k3 * (force / self.ks) ** 2 / (mu * self.ks),
        )

    @classmethod
    def from_nondimensional(cls, mu, zeta_s, zeta, Omega0, gamma, *, ms=1.0, ks=1.0, force=1.0):
        """Parameters whose `nondimensional` at ``force`` (N) is the given set; ``ms`` in kg, ``ks`` in N/m."""
        group = Nondimensional(mu, zeta_s, zeta, Omega0, gamma)
        ms, ks = checks.positive("ms", ms, "kg"), checks.positive("ks", ks, "N/m")
        force = checks.positive("force", force, "N")
        m, omega_s = group.mu * ms, np.sqrt(ks / ms)
        return cls(
            ms=ms,
            ks=ks,
            cs=2 * group.zeta_s * ms * omega_s,
            m=m,
            c=2 * group.zeta * m * omega_s,
            k1=m * (group.Omega0 * omega_s) ** 2,
            k3=group.gamma * group.mu * ks * (ks / force) ** 2,
        )


@dataclass(frozen=True)
class MassParameters(_Table):
    """One mass on a spring and a damper to the ground: m x'' + c x' + k1 x + k3 x^3 = f.

    Raises
    ------
    ValueError
        If the mass is not above zero, or another value is negative or not finite.
    """

    m: float = _quantity("kg", "mass", **_POSITIVE)
    c: float = _quantity("N s/m", "damping", **_NOT_NEGATIVE)
    k1: float = _quantity("N/m", "linear stiffness", **_NOT_NEGATIVE)
    k3: float = _quantity("N/m^3", "cubic stiffness", **_NOT_NEGATIVE)


@dataclass(frozen=True)
class RigParameters(_Table):
    """The multi-body rig in the vertical plane; the defaults are the paper's (Tables 1 and 2).

    Wires are counted set by set in the order up, down, left, right. ``k`` is one number,
    or one for each of the ``4 wire_sets`` wires. P, where displacements are measured and the
    damper acts, lies in the sets' middle unless ``set_centre`` moves that along the axis,
    at LG to the cylinder's own. ``set_half_spacing`` None means Lm/2 - abs(LG - set_centre),
    the widest pair symmetric about that middle that the cylinder can carry.

    With d0 above d the rig is no longer pulled to its middle: with ``tension_only`` it is slack, free within `gap`;
    wires that push make it buckled, at rest on either side of the middle. Such rigs can be simulated; theory, which
    needs k1 of at least zero, refuses them.

    Raises
    ------
    ValueError
        If a value is not finite or outside its range, if the centre of mass or
        a wire set lies beyond the cylinder, or if ``k`` has the wrong length.
    """

    ms: float = _quantity("kg", "mass of the shaker's moving part and frame", default=0.154, **_POSITIVE)
    ks: float = _quantity("N/m", "stiffness of the shaker", default=1.88e4, **_POSITIVE)
    cs: float = _quantity("N s/m", "damping of the shaker", default=9.86, **_NOT_NEGATIVE)
    m: float = _quantity("kg", "suspended mass", default=0.0052, **_POSITIVE)
    c: float = _quantity("N s/m", "axial damping between frame and P", default=0.026, **_NOT_NEGATIVE)
    k: float | tuple[float, ...] = _quantity("N/m", "stiffness of a wire, one number or one per wire", default=4e4)
    d: float = _quantity("m", "installed length of a wire", default=0.034, **_POSITIVE)
    d0: float = _quantity("m", "unstretched length of a wire", default=0.033997, **_POSITIVE)
    Lm: float = _quantity("m", "length of the cylinder", default=0.025, **_POSITIVE)
    Rm: float = _quantity("m", "radius of the cylinder", default=0.004, **_POSITIVE)
    LG: float = _quantity("m", "centre of mass along the axis from P", default=0.025 / 8, allowed={})
    wire_sets: int = _quantity("", "number of wire sets: 1 (Fig. 1) or 2 (Fig. 2)", default=2)
    set_half_spacing: float | None = _quantity("m", "distance of each of two sets from their middle", default=None)
    gravity: float = _quantity("m/s^2", "acceleration of gravity", default=9.81, **_NOT_NEGATIVE)
    wire_damping: float = _quantity("N s/m", "damping along each wire", default=0.0, **_NOT_NEGATIVE)
    rocking_damping: float = _quantity("N m s/rad", "damping of the tilt rate", default=0.0, **_NOT_NEGATIVE)
    tension_only: bool = _quantity("", "whether slack wires let go instead of pushing", default=False)
    set_centre: float = _quantity("m", "the sets' middle along the axis from P", default=0.0, allowed={})

    plots = {"rig": "rig_figure", "wire law": "wire_law_figure"}

    def __post_init__(self):
        super().__post_init__()
        if abs(self.LG) >= self.Lm / 2:
            expected = f"P must lie on the cylinder, abs(LG) < Lm/2 = {checks.digits(self.Lm / 2)} m"
            raise ValueError(f"LG = {checks.digits(self.LG)} m is not allowed; {expected}")
        set_field = lambda name, value: object.__setattr__(self, name, value)  # noqa: E731
        set_field("wire_sets", checks.integer("wire_sets", self.wire_sets, low=1, high=2))
        set_field("tension_only", checks.flag("tension_only", self.tension_only))
        set_field("k", self._checked_stiffness())
        ends = {"low": self.LG - self.Lm / 2, "high": self.LG + self.Lm / 2}
        set_field("set_centre", checks.real("set_centre", self.set_centre, "m", **ends))
        if self.set_half_spacing is not None:
            set_field("set_half_spacing", self._checked_half_spacing())

    def _checked_stiffness(self):
        stiffness = checks.array("k", self.k, "N/m", low=0.0)
        if not stiffness.sum() > 0:
            raise ValueError("k = 0 N/m is not allowed; expected at least one wire of stiffness above 0 N/m")
        if stiffness.size == 1:
            return float(stiffness[0])
        if stiffness.size != 4 * self.wire_sets:
            raise ValueError(f"k has {stiffness.size} values; expected 1 or {4 * self.wire_sets}, one per wire")
        return tuple(stiffness.tolist())

    def _checked_half_spacing(self):
        half = checks.real("set_half_spacing", self.set_half_spacing, "m", low=0.0, high=self._widest)
        if self.wire_sets == 1:
            given = f"set_half_spacing = {checks.digits(half)} m"
            raise ValueError(f"{given} is not allowed with wire_sets = 1; expected None, set_centre says where it is")
        return half

    @property
    def _widest(self):
        return max(0.0, self.Lm / 2 - abs(self.LG - self.set_centre))

    @cached_property
    def wire_stiffness(self):
        """Stiffness of each wire (N/m), shape (4 wire_sets,)."""
        return np.broadcast_to(np.asarray(self.k, dtype=float), (4 * self.wire_sets,))

    @property
    def set_positions(self):
        """Axial positions of the wire sets from P (m), one value a set."""
        if self.wire_sets == 1:
            return (self.set_centre,)
        return self.set_centre - self.half_spacing, self.set_centre + self.half_spacing

    @property
    def half_spacing(self):
        """Distance of each of two sets from their middle (m), whether given or the widest there is."""
        return self._widest if self.set_half_spacing is None else self.set_half_spacing

    @property
    def gap(self):
        """Displacement z at which the wires are as long as unstretched, sqrt(d0^2 - d^2) (m); 0 where d0 <= d."""
        return float(np.sqrt(max(0.0, (self.d0 - self.d) * (self.d0 + self.d))))

    @property
    def inertia(self):
        """Moment of inertia of the uniform cylinder about its centre, across the axis (kg m^2)."""
        return self.m * (3 * self.Rm**2 + self.Lm**2) / 12

    @property
    def k1(self):
        """Linear stiffness of Eq. (2), sum(k) (1 - d0/d) (N/m), if wires may push; negative where d0 > d."""
        return float(self.wire_stiffness.sum() * (self.d - self.d0) / self.d)

    @property
    def k3(self):
        """Cubic stiffness of Eq. (2), sum(k) d0/(2 d^3) (N/m^3)."""
        return float(self.wire_stiffness.sum() * self.d0 / (2 * self.d**3))

    @property
    def oscillator(self):
        """`OscillatorParameters` of the same rig: Eq. (2) in place of the wires. `ValueError` if d0 > d."""
        if self.d0 > self.d:
            raise ValueError(
                f"k1 = {self.k1:.6g} N/m of d0 = {checks.digits(self.d0)} m is not allowed; theory expects d0 of at "
                f"most d = {checks.digits(self.d)} m, and a slack or buckled rig can be simulated, with sine_test"
            )
        return OscillatorParameters(self.ms, self.ks, self.cs, self.m, self.c, self.k1, self.k3)

    def nondimensional(self, force):
        """The five numbers of Eqs. (4a, b) at force amplitude ``force`` (N, above zero)."""
        return self.oscillator.nondimensional(force)

    def single_set(self):
        """The rig of Fig. 1: one set in the sets' middle, each wire as stiff as the two it replaces: k1 and k3 stay."""
        if self.wire_sets == 1:
            return self
        first, second = self.wire_stiffness.reshape(2, 4)
        stiffness = 2 * self.k if np.ndim(self.k) == 0 else tuple((first + second).tolist())
        return self.replace(wire_sets=1, set_half_spacing=None, k=stiffness)

    def double_set(self):
        """The rig of Fig. 2: two sets as far apart as can be, wires half as stiff as one set's, so k1 and k3 stay."""
        if self.wire_sets == 2:
            return self
        stiffness = self.k / 2 if np.ndim(self.k) == 0 else tuple(np.tile(self.wire_stiffness / 2, 2).tolist())
        return self.replace(wire_sets=2, k=stiffness)


def oscillator_of(parameters, name="parameters"):
    """The `OscillatorParameters` of either kind of parameter set; `ValueError` if it is neither, or d0 > d."""
    return parameters_of(parameters, name).oscillator


def parameters_of(parameters, name="parameters"):
    """``parameters`` themselves if they are of either kind, whatever theory makes of them; `ValueError` if not."""
    kinds = OscillatorParameters, RigParameters
    return checks.instance(name, parameters, kinds, "RigParameters or OscillatorParameters")


_RIG = "RigParameters, since the multi-body rig expects RigParameters"


def rig_of(parameters, name="parameters"):
    """``parameters`` themselves if they are `RigParameters`; `ValueError` if not."""
    return checks.instance(name, parameters, RigParameters, _RIG)


def rigs_of(parameters):
    """List of the `RigParameters` in a sequence of them, or of the one given; `ValueError` for anything else."""
    return checks.one_or_many("parameters", parameters, RigParameters, _RIG)


def band_of(parameters, band):
    """A checked ``band`` (a pair in Hz), within ten thousand times the shaker's natural frequency, down and up."""
    natural = oscillator_of(parameters).omega_s / (2 * np.pi)
    low, high = (float(f"{times * natural:.3g}") for times in (1e-4, 1e4))
    return checks.pair("band", band, "Hz", low=low, high=high, low_open=False)


LAWS = ("exact", "cubic")


def law_of(parameters, law=None):
    """The suspension's law, "exact" for a rig with wires (Eq. (1)) and "cubic" for k1 and k3 (Eq. (2)), unless said.

    Raises
    ------
    ValueError
        If the law is unknown, ``parameters`` is of neither kind or slack or buckled, or the exact law is asked of a
        set without wires.
    """
    oscillator_of(parameters)
    return wires_law(parameters, law)


def wires_law(parameters, law=None):
    """`law_of` rigs that theory refuses, too."""
    parameters_of(parameters)
    wires = isinstance(parameters, RigParameters)
    law = checks.one_of("law", ("exact" if wires else "cubic") if law is None else law, LAWS)
    if law == "exact" and not wires:
        raise ValueError(f"parameters = {checks.shown(parameters)} has no wires; the exact law expects RigParameters")
    return law
