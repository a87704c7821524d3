"""`Record`: the channels of a test, and what any file of them must say."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from .. import checks, parameters
from ..results import Result, frame
from .channels import HOLDS, KINDS, OPTIONAL, UNITS, checked_kinds
from .joints import joined, slices
from .lines import strongest_lines
from .on_disk import let_go, on_disk
from .reading import fields_of, inspected
from .realign import realigned
from .saving import saved, tested

_REACH = np.pi / 2  # rad; at a right angle every rig's wires are past theirs


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
    base : bool
        Whether there was no force, and ``force`` is the acceleration of the base that the rig stands on (m/s^2).
        Displacements and velocities are then relative to the base; accelerations are not.
    joints : tuple of int
        First sample of each test, where there are several, end to end; see `joined`.
    voltage : array_like, shape (n,), optional
        At the shaker's coil (V), of a rig with a `rigsim.model.shaker.ShakerDrive`: what the amplifier gave while the
        force was what it was. The current is the force over the drive's Bl.
    slack : pair of float, optional
        Of a simulated rig whose wires let go: the share of time in which one is slack, and how often one goes slack.

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
    base: bool = False
    joints: tuple = (0,)
    voltage: np.ndarray | None = None
    slack: tuple | None = None

    plots = {"record": "record_figure"}

    def __post_init__(self):
        set_field = lambda name, value: object.__setattr__(self, name, value)  # noqa: E731
        kinds = checked_kinds(self.kinds)
        set_field("base", checks.flag("base", self.base))
        set_field("kinds", {name: kind for name, kind in kinds.items() if name == "shaker" or self.mass is not None})
        for name in UNITS:
            values = getattr(self, name)
            if values is None and name in OPTIONAL:
                continue
            reach = _REACH if name == "tilt" else np.inf
            values = checks.array(name, values, self.units[name], min_size=2, low=-reach, high=reach, physical=False)
            lasting = not values.flags.writeable and (values.base is None or on_disk(values) is not None)
            channel = values if lasting else np.array(values)
            let_go(channel)
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
            parameters.parameters_of(self.parameters)
        if self.slack is not None:
            share, times = checks.array("slack", self.slack, low=0.0, size=2).tolist()
            set_field("slack", (checks.real("share of slack", share, high=1.0), times))
        joints = checks.integers("joints", self.joints, low=0, high=self.force.size - 2)
        if joints[:1] != (0,) or (np.diff(joints) < 2).any():
            raise ValueError(f"joints = {joints} is not allowed; expected 0 and, two samples apart, where others begin")
        set_field("joints", joints)

    @classmethod
    def joined(cls, records):
        """Several tests of one rig, at whatever levels, as one record that knows where each of them begins.

        Parameters
        ----------
        records : sequence of Record
            With the same channels, kinds, sample rate and hold.

        Raises
        ------
        ValueError
            If there is none, or two differ in what they should share.
        """
        records = checks.one_or_many("records", records, cls, "a Record")
        if not records:
            raise ValueError("records = [] holds no record; expected a Record or several")
        return joined(records)

    @property
    def tests(self):
        """The tests it is made of, a list of records."""
        if len(self.joints) == 1:
            return [self]
        return [
            self.replace(joints=(0,), **{name: values[test] for name, values in self.channels.items()})
            for test in slices(self.joints, self.force.size)
        ]

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
        outputs |= {"force": KINDS["acceleration"]} if self.base else {}
        there = [name for name in UNITS if name not in OPTIONAL or getattr(self, name) is not None]
        return {name: outputs.get(name, UNITS[name]) for name in there}

    def called(self, channel):
        """What people read a channel's name as: a force that is the acceleration of a base is the "base"."""
        channel = checks.one_of("channel", channel, tuple(self.signals))
        return "base" if self.base and channel == "force" else channel

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
        """The measured channels by name, in order: force, shaker, mass and, where there are such, tilt and voltage."""
        return {name: getattr(self, name) for name in UNITS if getattr(self, name) is not None}

    def summary(self):
        """One line: how long, how fast, how large."""
        known = "relative" in (signals := self.signals)
        name, largest = ("|xs - x|", signals["relative"]) if known else ("|shaker|", self.shaker)
        unit = self.units["shaker"]
        scale, unit = (1e3, "mm") if unit == "m" else (1.0, unit)
        tests = f" in {len(self.joints)} tests" if len(self.joints) > 1 else ""
        loose = ""
        if self.slack is not None:
            loose = f"; a wire is slack {self.slack[0]:.0%} of the time and goes so {self.slack[1]:.0f} times"
        return (
            f"Record of {self.duration:g} s{tests} at {self.sample_rate:g} Hz ({self.force.size} samples): "
            f"{self.called('force')} {self.force.std():.4g} {self.units['force']} rms ({self.hold} hold), "
            f"largest {name} {scale * abs(largest).max():.4g} {unit}{loose}"
        )

    def table(self):
        """`pandas.DataFrame` of rms about the mean, mean and largest value of each channel and of z."""
        units = self.units | {"relative": self.units["shaker"]}
        rows = [(self.called(name), c.std(), c.mean(), abs(c).max(), units[name]) for name, c in self.signals.items()]
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

        ``.csv``, or ``.csv.gz``: a first line ``# {...}`` with sample rate, hold, number of samples and details as
        JSON, a line of channel names, then a line a sample, with every digit. ``.nc``: netCDF 4, the same details as
        attributes.

        Parameters
        ----------
        path : str or path
                Where to; an existing file is replaced, under every name that it has, and keeps its permissions.

        Raises
        ------
        ValueError
            If the suffix is none of these.
        """
        saved(self, path)

    @classmethod
    def load(cls, path, hold=None, *, channels=None, units=None, sample_rate=None):
        """Read a test from a file: one that `save` wrote, or one's own.

        What can be read: text (``.csv``, ``.txt``, ``.tsv``, ``.dat``, ``.asc``, ``.prn``, LabVIEW's ``.lvm``, each
        also with ``.gz``) with any separator, decimal commas, names and units above the samples; ``.nc``, ``.h5``,
        ``.hdf5``, ``.mat``, ``.npz``, ``.uff``, ``.unv``, ``.tdms``. All is turned to SI. What the file says is
        compared with itself; what it does not say is asked for by the name of an argument, and what can only be meant
        is taken and told by a warning (`rigsim.experiment.reading.GuessWarning`). `inspect` lists what a file holds.

        Channels of four million samples or more are kept on disk, in a temporary file that goes with them.

        A text file that says all begins with a line ``# {"sample_rate": 2000, "hold": "zero"}`` and one that names the
        columns force, shaker and mass (N and m). A column ``time`` must be evenly spaced.

        Parameters
        ----------
        path : str or path
            The file.
        hold : {"zero", "linear", "band-limited"}, optional
            What the force did between samples, where the file does not say it.
        channels : dict of str to str or int, optional
            Names of the columns, or their numbers from 0, for "force", "shaker", "mass" (left out: a rig of one sensor)
            and, where there are such, "tilt" and "time".
        units : dict of str to str, optional
            Units by channel where the file says none, such as ``{"shaker": "mm", "mass": "g", "time": "ms"}``. Those of
            a velocity or an acceleration make the output one.
        sample_rate : float, optional
            Samples a second (Hz), where the file does not say it.

        Raises
        ------
        ValueError
            If the file cannot be read as such, does not say what is needed, says two things, lacks a sample, or its
            values are not allowed.
        """
        details = fields_of(path, hold, channels, units, sample_rate)
        path = Path(path)
        details["parameters"] = tested(path, details.get("parameters"))
        try:
            return cls(**details)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from None

    @classmethod
    def inspect(cls, path):
        """What a file holds, before it is read: names, units, counts, rates, first values, what each would be read as.

        Parameters
        ----------
        path : str or path
            The file, of any form that `load` reads.

        Returns
        -------
        rigsim.experiment.reading.FileContents
            Its ``table()`` has a row a column of the file.

        Raises
        ------
        ValueError
            If the file cannot be read as such.
        """
        return inspected(path)
