"""An electrodynamic shaker as it is: a coil in a field, an amplifier, and maybe a controller that holds an amplitude.

    f = Bl i,    u = R i + L di/dt + Bl xs',

f the force on the frame, u the voltage at the coil. With a current amplifier f is prescribed, as in the paper, and its
cs is that of an open circuit. With a voltage amplifier the frame's motion drives a current of its own: damping Bl^2/R
at low frequency, a force that drops where the frame moves much, and harmonics of the force where the motion has some.

The current is a state at the instants of the positions, half a step from the velocities, so that

    L (i_k - i_k-1) = h [u - R (i_k + i_k-1)/2 - Bl v_k-1/2]

is of second order with the leapfrog, and what the coil takes from the frame it gives to the circuit to the last bit:
the frame's work, Bl i_k (v_k-1/2 + v_k+1/2)/2 summed, is the circuit's, Bl v_k-1/2 (i_k-1 + i_k)/2 summed, but for the
ends. To the leapfrog the coil is a spring of stiffness Bl^2/L between frame and field, which shortens the longest step.

A stinger between armature and frame is left out, since it moves the paper's rig by less than its numbers are known
to. A steel rod of 1.5 mm, 50 mm long (7e6 N/m, 380 ks) between 20 g of armature and the other 134 g of ms resonates at
3.2 kHz. With constant current it changes xs and z by up to 1.1 % at the shaker's resonance, as ms 0.07 % up, ks 0.13 %
and cs 0.24 % down would, which identified values hold already: what those leave is 0.13 % up to 80 Hz. Detached curves
allow moves of 2.7 % in these (`rigsim.design.margins`). Below 100 ks a stinger would have to be modelled: at 32 ks xs
and z are 13 % off.
"""

from dataclasses import dataclass, fields, replace

import numpy as np

from .. import checks
from ..compiled import compiled
from ..parameters import oscillator_of
from ..results import Result, frame
from .planar import longest_step

MODES = ("current", "voltage", "force", "acceleration")
DRIVE = np.dtype([(name, float) for name in (
    "kind", "factor", "resistance", "inductance", "limit", "pace", "slew", "mass",
)], align=True)  # fmt: skip
# nominal, before: what is asked for in the middle of the step that is taken, and of the one before it, F exp(i theta)
# in N; gain: the controller's, on that; last: of the step before, the frame's speed, or of a prescribed force the
# voltage; sums: of a period, see `_control`.
CIRCUIT = np.dtype([
    ("current", float), ("voltage", float), ("last", float), ("limited", float), ("count", float),
    ("nominal", complex), ("before", complex), ("gain", complex), ("sums", float, (8,)),
], align=True)  # fmt: skip
_VOLTAGE, _ACCELERATION = 1.0, 3.0  # places in `MODES`
_QUICKEST = 0.5  # of a deviation, that a controller takes away in a period at most
_FEWEST = 8  # steps a period, without which nothing is read
_HEAVY = 1e6  # times: what is shaken at a given acceleration moves as if it were so heavy


@dataclass(frozen=True, repr=False)
class ShakerDrive(Result):
    """What drives the frame: a small laboratory shaker, and how it is operated.

    The force F that tests ask for (N) means in each mode: "current", the force itself, as without a drive; "voltage",
    that of the coil held still, so that the amplifier gives u = F R/Bl; "force", the amplitude that a controller holds
    the force's fundamental at; "acceleration", ms times the amplitude that it holds the frame's acceleration at.

    The numbers of the coil are typical of data sheets of shakers for 20 to 50 N: none is of the paper's, or measured.

    Parameters
    ----------
    mode : {"current", "voltage", "force", "acceleration"}
    force_factor : float
        Bl (N/A).
    resistance : float
        Of coil and leads (ohm).
    inductance : float
        Of the coil (H); at least R/2 times the integration step.
    max_voltage : float
        Peak of what the amplifier gives (V): there it clips, and the controller stops. A current amplifier is not held
        to it, but told of.
    bandwidth : float
        Of the controller (Hz): deviations die away as exp(-2 pi bandwidth t), by a half a period at most. It sees one
        period at a time, and sets amplitude and phase of the voltage after each.
    compression : float
        Largest speed at which it moves the amplitude (dB/s).

    Raises
    ------
    ValueError
        If a value is not allowed.
    """

    mode: str = "voltage"
    force_factor: float = 10.0
    resistance: float = 3.0
    inductance: float = 3e-4
    max_voltage: float = 20.0
    bandwidth: float = 1.0
    compression: float = 60.0

    def __post_init__(self):
        set_field = lambda name, value: object.__setattr__(self, name, value)  # noqa: E731
        set_field("mode", checks.one_of("mode", self.mode, MODES))
        for name, unit, low, high in (
            ("force_factor", "N/A", 1e-3, 1e4), ("resistance", "ohm", 1e-3, 1e4), ("inductance", "H", 1e-7, 10.0),
            ("max_voltage", "V", 1e-3, 1e4), ("bandwidth", "Hz", 1e-3, 20.0), ("compression", "dB/s", 0.1, 1e3),
        ):  # fmt: skip
            set_field(name, checks.real(name, getattr(self, name), unit, low=low, high=high))

    def replace(self, **changes):
        """A copy with some fields changed, checked again."""
        known = tuple(item.name for item in fields(self))
        return replace(self, **{checks.one_of("field of ShakerDrive", name, known): v for name, v in changes.items()})

    @property
    def damping(self):
        """Bl^2/R (N s/m): what a voltage amplifier adds to cs at low frequency; none in the mode "current"."""
        return 0.0 if self.mode == "current" else self.force_factor**2 / self.resistance

    def equivalent(self, parameters, force, frequency=0.0):
        """Parameters and complex force (N) that a constant force would need for the same fundamentals at a frequency.

        With U = F R/Bl at the coil, Bl I = F_eff - (i omega c_e + omega^2 m_e) Xs: F_eff = F/(1 + i omega L/R), damping
        c_e = Bl^2 R/(R^2 + omega^2 L^2) more, and mass m_e = L Bl^2/(R^2 + omega^2 L^2) less. At the frequency 0 that
        is cs + Bl^2/R and ms - L (Bl/R)^2, which holds while omega L is far below R. A held force is one; at a held
        acceleration the frame is no degree of freedom: it moves as one a million times as heavy, driven as hard. The
        parameters are of the kind that is given, so that converged theory takes them, too.

        Parameters
        ----------
        parameters : RigParameters or OscillatorParameters
        force : float
            What is asked for (N).
        frequency : float
            Hz.
        """
        mass, force = oscillator_of(parameters).ms, checks.positive("force", force, "N")
        frequency = checks.real("frequency", frequency, "Hz", low=0.0)
        if self.mode == "acceleration":
            return parameters.replace(ms=_HEAVY * mass), complex(_HEAVY * force)
        if self.mode != "voltage":
            return parameters, complex(force)
        R, reactance = self.resistance, 2 * np.pi * frequency * self.inductance
        admittance = self.force_factor**2 / (R**2 + reactance**2)
        if not self.inductance * admittance < mass:
            least = self.inductance * admittance
            raise ValueError(f"ms = {mass:g} kg is lighter than the coil makes it; expected above {least:.3g} kg")
        damping = parameters.cs + R * admittance
        changed = parameters.replace(cs=damping, ms=mass - self.inductance * admittance)
        return changed, complex(force / (1 + 1j * reactance / R))

    def summary(self):
        """One line: the mode and the coil."""
        control = f", controller of {self.bandwidth:g} Hz" if self.mode in MODES[2:] else ""
        return (
            f"ShakerDrive with constant {self.mode}: Bl {self.force_factor:g} N/A, {self.resistance:g} ohm, "
            f"{1e3 * self.inductance:g} mH{control}"
        )

    def table(self):
        """`pandas.DataFrame` of the settings, and of what follows from them."""
        coil = self.force_factor**2 / self.resistance
        rows = [
            ("mode", self.mode, ""), ("force_factor", self.force_factor, "N/A"), ("resistance", self.resistance, "ohm"),
            ("inductance", self.inductance, "H"), ("max_voltage", self.max_voltage, "V"),
            ("bandwidth", self.bandwidth, "Hz"), ("compression", self.compression, "dB/s"),
            ("Bl^2/R", coil, "N s/m"), ("L/R", self.inductance / self.resistance, "s"),
        ]  # fmt: skip
        return frame(rows, ["drive", "value", "unit"], index="drive")


def check_drives(drives, parameters, step):
    """Refuse a step (s) that is too long for a drive's circuit, or for the rig with the coil's spring."""
    for drive, p in {pair for pair in zip(drives, parameters, strict=True) if pair[0] is not None}:
        if step > (longest := 2 * drive.inductance / drive.resistance):
            least = f"2 L/R = {longest:.3g} s or less, or inductance of at least {drive.resistance * step / 2:.3g} H"
            raise ValueError(f"step = {step:g} s is too long for the drive's coil; expected {least}")
        limit = longest_step(p.replace(ks=p.ks + drive.force_factor**2 / drive.inductance))
        if drive.mode != "current" and step >= limit:
            raise ValueError(f"step = {step:g} s is unstable with this drive; expected below 2/omega = {limit:.3g} s")


def pack_drives(drives, parameters):
    """Drives (n,) as compiled loops read them, and their circuits (n,) as they start: no current."""
    packed, circuits = np.zeros(len(drives), dtype=DRIVE), np.zeros(len(drives), dtype=CIRCUIT)
    circuits["gain"] = 1.0
    packed["kind"], packed["factor"] = -1.0, 1.0
    for i, (drive, p) in enumerate(zip(drives, parameters, strict=True)):
        if drive is not None:
            packed[i] = (MODES.index(drive.mode), drive.force_factor, drive.resistance, drive.inductance,
                         drive.max_voltage, 2 * np.pi * drive.bandwidth, drive.compression * np.log(10) / 20,
                         p.ms)  # fmt: skip
    return packed, circuits


@compiled
def pushed(drive, circuit, force, nominal, speed, h):
    """Force (N) on the frame at the end of a step in which it had a ``speed``: as it is asked for, or the coil's.

    ``force`` is what is prescribed then, ``nominal`` what is asked for in the middle of the step to come.
    """
    if drive.kind > 0.0:
        return _driven(drive, circuit, nominal, speed, h)
    if drive.kind == 0.0:
        _prescribed(drive, circuit, force, speed, h)
    return force


@compiled
def given(drive, circuit, force):
    """Force (N) and voltage (V) at the end of a step, ``force`` where it is prescribed."""
    if drive.kind <= 0.0:
        return force, circuit.voltage
    after = min(max(_wanted_voltage(drive, circuit), -drive.limit), drive.limit)
    return drive.factor * circuit.current, (circuit.voltage + after) / 2


@compiled
def _prescribed(drive, circuit, force, speed, h):
    """The voltage that a prescribed force (N) takes at the coil; a force that jumps takes a pulse of it."""
    old, now = circuit.current, force / drive.factor
    between = drive.inductance * (now - old) / h + drive.resistance * (now + old) / 2 + drive.factor * speed
    circuit.voltage = between + (between - circuit.last) / 2  # from the middle of the step to its end
    circuit.limited = 1.0 if abs(between) > drive.limit else 0.0
    circuit.last, circuit.current = between, now


@compiled
def _driven(drive, circuit, nominal, speed, h):
    """Force (N) of the coil: the circuit's step."""
    old = circuit.current
    if drive.kind != _VOLTAGE:
        seen = old * drive.factor
        if drive.kind == _ACCELERATION:
            seen = drive.mass * (speed - circuit.last) / h
        _control(drive, circuit, seen, h)
    wanted = _wanted_voltage(drive, circuit)
    circuit.voltage = min(max(wanted, -drive.limit), drive.limit)
    if drive.kind == _VOLTAGE and wanted != circuit.voltage:
        circuit.limited = 1.0
    half = h * drive.resistance / (2 * drive.inductance)
    push = h / drive.inductance * (circuit.voltage - drive.factor * speed)
    circuit.current = ((1.0 - half) * old + push) / (1.0 + half)
    circuit.last, circuit.before, circuit.nominal = speed, circuit.nominal, nominal
    return drive.factor * circuit.current


@compiled
def _wanted_voltage(drive, circuit):
    """V, of what is asked for (N, complex) times the controller's gain."""
    return drive.resistance / drive.factor * (circuit.gain * circuit.nominal).real


@compiled
def _control(drive, circuit, seen, h):
    """Gather what is ``seen`` (N) at the beginning of the step, and set the gain anew where a period ends.

    Over a period, seen = mean + Re(r c) by least squares with c the nominal force, so that r is what is held over what
    was asked for, and log(gain) goes by -pace T log(r): first-order decay, whatever lies between gain and r.
    """
    c, sums = (circuit.before + circuit.nominal) / 2, circuit.sums
    if circuit.before.imag < 0.0 <= circuit.nominal.imag:
        if circuit.count >= _FEWEST:
            _adjust(drive, circuit, sums, circuit.count * h)
        sums[:] = 0.0
        circuit.count = 0.0
    circuit.count += 1.0
    sums[0] += c.real
    sums[1] -= c.imag
    sums[2] += c.real * c.real
    sums[3] -= c.real * c.imag
    sums[4] += c.imag * c.imag
    sums[5] += seen
    sums[6] += seen * c.real
    sums[7] -= seen * c.imag


@compiled
def _adjust(drive, circuit, sums, period):
    n = circuit.count
    # Without the means, two normal equations for r = p + i q are left.
    pp, pq, qq = sums[2] - sums[0] ** 2 / n, sums[3] - sums[0] * sums[1] / n, sums[4] - sums[1] ** 2 / n
    p, q = sums[6] - sums[0] * sums[5] / n, sums[7] - sums[1] * sums[5] / n
    found = complex(qq * p - pq * q, pp * q - pq * p) / (pp * qq - pq * pq)
    share, most = min(drive.pace * period, _QUICKEST), drive.slew * period
    size = -share * np.log(max(abs(found), 1e-9))
    turn = -share * np.arctan2(found.imag, found.real)
    size, turn = min(max(size, -most), most), min(max(turn, -most), most)
    circuit.gain *= np.exp(size) * complex(np.cos(turn), np.sin(turn))
    peak = drive.resistance / drive.factor * abs(circuit.gain) * abs(circuit.nominal)
    circuit.limited = 1.0 if peak > drive.limit else 0.0
    if peak > drive.limit:
        circuit.gain *= drive.limit / peak
