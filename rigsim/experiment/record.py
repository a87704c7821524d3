"""`Record`: the channels of a test, and what any file of them must say."""

import os
import reprlib
import shutil
from contextlib import suppress
from dataclasses import MISSING, asdict, dataclass, fields, replace
from pathlib import Path
from uuid import uuid4

import numpy as np

from .. import checks, parameters
from ..results import Result, frame
from .channels import HOLDS, KINDS, OUTPUTS, UNITS, checked_kinds
from .formats import FORMATS
from .lines import strongest_lines
from .realign import realigned

_REACH = np.pi / 2  # rad; at a right angle every rig's wires are past theirs
# What a file may say of a record, and as what: the fields above, and how many samples it should hold.
_DETAILS = {"sample_rate": (int, float), "hold": (str,), "seed": (int, float), "start": (str,), "parameters": (dict,)}
_DETAILS |= {"step": (int, float), "kinds": (dict,), "samples": (int,)}
_EXPECTED = {int: "a number", str: "a text", dict: "an object"}
_SPELLED = {
    "N": ("N", "newton", "newtons"),
    "m": ("m", "meter", "meters", "metre", "metres"),
    "s": ("s", "sec", "second", "seconds"),
    "rad": ("rad", "radian", "radians"),
}
_KINDS = {kind.__name__: kind for kind in (parameters.RigParameters, parameters.OscillatorParameters)}


@dataclass(frozen=True, eq=False, repr=False)
class Record(Result):
    """Force and motions of one test, sampled together.

    Sample k of every motion is taken before ``force[k]`` acts. An array that nobody can write to is kept as it is,
    any other is copied.

    Parameters
    ----------
    force : array_like, shape (n,)
        Force on the shaker (N).
    shaker, mass : array_like, shape (n,)
        Displacement of the shaker xs and of the suspended mass x (m), or what ``kinds`` says. ``mass`` may be None: a
        rig with one sensor.
    sample_rate : float
        Samples a second (Hz).
    hold : {"zero", "linear", "band-limited"}
        What the force did between samples: kept its value, ran straight to the next
        one, or had nothing above half the sample rate (a measured force).
    tilt : array_like, shape (n,), optional
        Tilt of the suspended mass, counter-clockwise positive (rad), less than a right angle.
    seed : int, optional
        Seed of the force.
    start : str, optional
        State at the first sample: "rest" or "equilibrium".
    parameters : RigParameters or OscillatorParameters, optional
        What was tested, where it is known.
    step : float, optional
        Integration step behind a simulated record (s), at most a sample interval.
    kinds : dict of str to str, optional
        What "shaker" and "mass" are, "displacement" (the default, m), "velocity" (m/s) or "acceleration" (m/s^2);
        always whole in the record.

    Raises
    ------
    ValueError
        If a channel holds a value that is not finite, has fewer than 2 samples or not as
        many as the force, or if the sample rate, the hold or a detail is not allowed.
    """

    force: np.ndarray
    shaker: np.ndarray
    mass: np.ndarray | None
    sample_rate: float
    hold: str = "zero"
    tilt: np.ndarray | None = None
    seed: int | None = None
    start: str | None = None
    parameters: object = None
    step: float | None = None
    kinds: dict | None = None

    plots = {"record": "record_figure"}

    def __post_init__(self):
        set_field = lambda name, value: object.__setattr__(self, name, value)  # noqa: E731
        kinds = checked_kinds(self.kinds)
        set_field("kinds", {name: kind for name, kind in kinds.items() if getattr(self, name) is not None})
        for name in UNITS:
            values = getattr(self, name)
            if values is None and name in ("mass", "tilt"):
                continue
            reach = _REACH if name == "tilt" else np.inf
            values = checks.array(name, values, self.units[name], min_size=2, low=-reach, high=reach, physical=False)
            channel = np.array(values) if values.flags.writeable or values.base is not None else values
            n = channel.size if name == "force" else self.force.size
            if channel.size != n:
                raise ValueError(f"{name} has {channel.size} samples; expected {n}, as many as the force")
            channel.flags.writeable = False
            set_field(name, channel)
        set_field("sample_rate", checks.positive("sample_rate", self.sample_rate, "Hz"))
        set_field("hold", checks.one_of("hold", self.hold, HOLDS))
        if self.seed is not None:
            set_field("seed", checks.seed("seed", self.seed))
        if self.start is not None:
            set_field("start", checks.one_of("start", self.start, ("rest", "equilibrium")))
        if self.step is not None:
            longest = (1 + 1e-9) / self.sample_rate  # a sample interval takes one step or more
            set_field("step", checks.real("step", self.step, "s", low=0.0, low_open=True, high=longest))
        if self.parameters is not None:
            parameters.oscillator_of(self.parameters)

    def replace(self, **changes):
        """A copy with some fields changed, checked again."""
        return replace(self, **changes)

    def realigned(self, delay=None, clock=None, reverse=(), swap=False, spikes=None):
        """The record with its outputs brought together, as a `identify` offers where it finds them apart.

        Parameters
        ----------
        delay : dict of str to float, optional
            By how much "shaker" or "mass" is late against the force (s).
        clock : dict of str to float, optional
            By how much their clock is fast against the force's (ppm).
        reverse : sequence of str
            Those whose sign is changed.
        swap : bool
            Whether shaker and mass are exchanged, before all else.
        spikes : dict of str to sequence of int, optional
            Samples of theirs that are replaced by straight lines between their neighbours.

        Raises
        ------
        ValueError
            If a channel is neither shaker nor mass, a value is not finite, or less than a quarter of the record stays.
        """
        return realigned(self, delay, clock, reverse, swap, spikes)

    @property
    def time(self):
        """Instant of each sample from the first (s), shape (n,)."""
        return np.arange(self.force.size) / self.sample_rate

    @property
    def units(self):
        """Unit of each channel there is, by name."""
        outputs = {name: KINDS[kind] for name, kind in self.kinds.items()}
        return {name: outputs.get(name, unit) for name, unit in UNITS.items() if getattr(self, name) is not None}

    @property
    def relative(self):
        """Relative motion z = xs - x, shape (n,): a displacement (m) where both are. `ValueError` if there is none."""
        if len(set(self.kinds.values())) != 1 or self.mass is None:
            told = "the shaker alone" if self.mass is None else f"a shaker's {self.kinds['shaker']} and a mass's "
            told += "" if self.mass is None else self.kinds["mass"]
            raise ValueError(f"the record has {told}; z = xs - x is expected of two channels of one kind")
        return self.shaker - self.mass

    @property
    def duration(self):
        """Length of the record, n samples (s)."""
        return self.force.size / self.sample_rate

    @property
    def channels(self):
        """The measured channels by name, in the order force, shaker, mass and, where there is one, tilt."""
        return {name: getattr(self, name) for name in UNITS if getattr(self, name) is not None}

    def summary(self):
        """One line: how long, how fast, how large."""
        known = "relative" in (signals := self.signals)
        name, largest = ("|xs - x|", signals["relative"]) if known else ("|shaker|", self.shaker)
        unit = self.units["shaker"]
        scale, unit = (1e3, "mm") if unit == "m" else (1.0, unit)
        return (
            f"Record of {self.duration:g} s at {self.sample_rate:g} Hz ({self.force.size} samples): force "
            f"{self.force.std():.4g} N rms ({self.hold} hold), largest {name} {scale * abs(largest).max():.4g} {unit}"
        )

    def table(self):
        """`pandas.DataFrame` of rms about the mean, mean and largest value of each channel and of z."""
        units = self.units | {"relative": self.units["shaker"]}
        rows = [(name, c.std(), c.mean(), abs(c).max(), units[name]) for name, c in self.signals.items()]
        return frame(rows, ["channel", "rms", "mean", "largest", "unit"], index="channel")

    def spectrum(self, channel, frequency):
        """Amplitudes of a channel's lines under a Hann window, its mean taken away.

        The window is the end of the record, as many times six periods of the force as it holds (or as many periods,
        where it holds fewer), so that lines at f, f/2 and f/3 fall on points of the spectrum and keep their heights.

        Parameters
        ----------
        channel : str
            One of `channels`, or "relative".
        frequency : float
            Of the force (Hz).

        Returns
        -------
        frequency, amplitude : ndarray, shape (n,)
            Hz, and zero to peak in the channel's unit.

        Raises
        ------
        ValueError
            If there is no such channel, the record holds no whole period, or it has too few samples for that frequency.
        """
        signal, half = self._signal(channel), self.sample_rate / 2
        f = checks.real("frequency", frequency, "Hz", low=1 / self.duration, high=half)
        periods = int((signal.size + 0.5) / self.sample_rate * f)
        part = signal[-round((periods - periods % 6 or periods) / f * self.sample_rate) :]
        window = np.hanning(part.size + 1)[:-1]
        lines = np.fft.rfft((part - part.mean()) * window)
        return np.fft.rfftfreq(part.size, 1 / self.sample_rate), 2 * np.abs(lines) / window.sum()

    def strongest_line(self, channel, band):
        """Frequency (Hz) and amplitude (zero to peak) of the strongest single sine of a channel within a band.

        The channel is one of `channels`, or "relative"; the amplitude is 0 where the ``band`` (a pair in Hz) holds no
        frequency.
        """
        signal, band = self._signal(channel), checks.pair("band", band, "Hz", low_open=False)
        return strongest_lines(self.time, signal, band)[0]

    @property
    def signals(self):
        """The `channels` by name and, where two outputs of one kind make it, z as "relative"."""
        z = {} if self.mass is None or len(set(self.kinds.values())) > 1 else {"relative": self.relative}
        return self.channels | z

    def _signal(self, channel):
        signals = self.signals
        return signals[checks.one_of("channel", channel, tuple(signals))]

    def save(self, path):
        """Write the record, whole or not at all; the suffix chooses the format.

        ``.csv``: a first line ``# {...}`` with sample rate, hold and details as JSON, a line
        of channel names, then a line a sample, with every digit. ``.nc``: netCDF 4, the same
        details as attributes.

        Parameters
        ----------
        path : str or path
            Where to; an existing file is replaced.

        Raises
        ------
        ValueError
            If the suffix is neither.
        """
        path = Path(checks.path("path", path))
        write = _format(path).write
        # A link stays one: what it points to is replaced.
        target = Path(os.path.realpath(path))
        if target.exists() and not (target.is_file() and os.access(target, os.W_OK)):
            raise OSError(f"{path} cannot be replaced; expected the name of a new file, or of one that may be written")
        temporary = target.with_name(f".rigsim-{uuid4().hex}")
        try:
            with open(temporary, "xb") as file:
                write(file, _details(self), {"time": self.time} | self.channels, {"time": "s"} | self.units)
            if target.exists():
                shutil.copymode(target, temporary)
            os.replace(temporary, target)
        except BaseException as error:
            with suppress(OSError):
                temporary.unlink()
            if isinstance(error, OSError):
                reason = error.strerror or " ".join(str(error).split())
                raise OSError(error.errno, f"the record cannot be written: {reason}", str(path)) from None
            raise

    @classmethod
    def load(cls, path, hold=None):
        """Read a file that `save` wrote, or a ``.csv`` of one's own in the same form.

        The least a first line can say is ``# {"sample_rate": 2000, "hold": "zero"}``; the second
        names the columns, force, shaker and mass in any order, in N and m. A column ``time`` (s)
        must be evenly spaced, and stands for the sample rate where the first line names none.

        Parameters
        ----------
        path : str or path
            The file.
        hold : {"zero", "linear", "band-limited"}, optional
            What the force did between samples, where the file does not say it.

        Raises
        ------
        ValueError
            If the suffix is unknown, the file is not in that form, it and ``hold`` say no hold
            or two, or its values are not allowed.
        """
        path = Path(checks.path("path", path))
        hold = None if hold is None else checks.one_of("hold", hold, HOLDS)
        details, channels, units = _format(path).read(path)
        _check(path, details, channels, units)
        if "time" in channels:
            details["sample_rate"] = _rate_of(path, channels.pop("time"), details.get("sample_rate"))
        if "sample_rate" not in details:
            raise ValueError(f'{path} has no sample rate; expected a first line such as # {{"sample_rate": 2000}}')
        if hold is not None and details.setdefault("hold", hold) != hold:
            raise ValueError(f"hold = {hold!r} is not allowed; {path} says {details['hold']!r}")
        if "hold" not in details:
            raise ValueError(
                f"{path} does not say what the force did between samples; expected hold in its first line or as an "
                f"argument, one of {', '.join(map(repr, HOLDS))}"
            )
        details["parameters"] = _tested(path, details.get("parameters"))
        try:
            return cls(**{"mass": None} | channels, **details)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from None


def _check(path, details, channels, units):
    """What every file must hold, whatever reads it."""
    kinds = details.get("kinds")
    one_sensor = isinstance(kinds, dict) and "mass" not in kinds
    for name in ("force", "shaker") if one_sensor else ("force", "shaker", "mass"):
        if name not in channels:
            raise ValueError(f"{path} has no channel {name}; expected force, shaker and mass")
    for name, value in details.items():
        kind = _DETAILS[checks.one_of(f"detail in {path}", name, tuple(_DETAILS))]
        if not isinstance(value, kind) or isinstance(value, bool):
            raise ValueError(f"{name} in {path} = {reprlib.repr(value)} is not allowed; expected {_EXPECTED[kind[0]]}")
    count = details.pop("samples", channels["force"].size)
    for name, values in channels.items():
        name = checks.one_of(f"channel in {path}", name, (*UNITS, "time"))
        if values.size != count:
            raise ValueError(
                f"{name} in {path} has {values.size} samples; expected {count}, as the file or its force says"
            )
    for name, unit in units.items():
        kind = (kinds or {}).get(name, "displacement") if name in OUTPUTS else None
        said = {"velocity": "m/s", "acceleration": "m/s^2"}.get(kind, UNITS.get(name, "s"))
        known = _SPELLED.get(said, (said,))
        if name in channels and unit.strip().partition(" since ")[0] not in known:
            raise ValueError(f"unit of {name} in {path} = {reprlib.repr(unit)} is not allowed; expected {known[0]}")


def _rate_of(path, time, said):
    """Sample rate that an evenly spaced ``time`` (s) gives: what the file said, if that agrees."""
    time = checks.array(f"time in {path}", time, "s", min_size=2, physical=False)
    with np.errstate(all="ignore"):
        steps = np.diff(time)
        mean = (time[-1] - time[0]) / steps.size
        # Instants are often written with few digits; a lost sample doubles a step, a drifting clock gains whole ones.
        drift = np.abs(time - (time[0] + mean * np.arange(time.size))).max()
        rate = 1 / mean
        even = 0 < mean < np.inf and np.abs(steps - mean).max() <= 0.45 * mean and drift <= mean
        worst = np.abs(steps - np.median(steps)).argmax()
    if not even:
        raise ValueError(
            f"time in {path} is not evenly spaced; expected rising steps of one length (that after sample {worst} is "
            f"{steps[worst]:g} s)"
        )
    if said is None:
        return rate
    said = checks.positive(f"sample_rate in {path}", said, "Hz")
    if abs(said * mean - 1) > 1e-3:
        raise ValueError(f"sample_rate in {path} = {said:g} Hz is not allowed; its time gives {rate:g} Hz")
    return said


def _tested(path, values):
    """Parameters from their JSON object."""
    if values is None:
        return None
    kind = _KINDS[checks.one_of(f"kind of parameters in {path}", values.pop("kind", None), tuple(_KINDS))]
    known = {item.name: item for item in fields(kind)}
    values = {checks.one_of(f"parameter in {path}", name, tuple(known)): value for name, value in values.items()}
    missing = [name for name, item in known.items() if item.default is MISSING and name not in values]
    if missing:
        raise ValueError(f"parameters in {path} lack {', '.join(missing)}; expected every value of {kind.__name__}")
    try:
        return kind(**values)
    except (ValueError, TypeError, OverflowError) as error:
        raise ValueError(f"parameters in {path}: {error}") from None


def _details(record):
    """What the header of a file says, without what is unknown."""
    details = {name: getattr(record, name) for name in _DETAILS if name != "samples"}
    if record.kinds == checked_kinds(None):
        del details["kinds"]
    if record.parameters is not None:
        details["parameters"] = {"kind": type(record.parameters).__name__, **asdict(record.parameters)}
    return {name: value for name, value in details.items() if value is not None}


def _format(path):
    return FORMATS[checks.one_of(f"suffix of {path.name}", path.suffix.lower(), tuple(FORMATS))]
