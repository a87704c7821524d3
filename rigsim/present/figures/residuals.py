"""What an identified rig leaves of its record, and how well it foretells it."""

import numpy as np
from scipy import signal

from ... import checks
from ...identification.result import Identification
from .style import BLACK, BLUE, GREY, ORANGE, RED, outer_labels, style, subplots

_NAMES = ("shaker", "mass")
_SURE = 2.576  # standard deviations of a band that 99 % of white noise stay in
_LAGS = 0.25  # s
_SHOWN = 0.4  # s of each stretch of a prediction
_RESOLVED = 2.0  # s of a block of a spectrum
_MOST = 400  # points of a line over lags
_SHOWN_AS = {"m": (1e3, "mm")}  # other units as they are
_DENSITY_AS = {"m": (1e6, "µm")}


def checked(identification):
    """The `Identification`, if it has a simulated rig; a ValueError if it is by one of the paper's readings."""
    identification = checks.instance("identification", identification, Identification, "an Identification")
    if identification.modelled is None:
        raise ValueError(
            f"identification (conversion = {identification.conversion!r}) has no simulated rig; expected one by "
            'conversion = "force" of a record that a rig repeats'
        )
    return identification


def left_over(identification):
    """What is left of each recorded output, in its unit, without its mean: (n, outputs)."""
    modelled = checked(identification).modelled
    left = _recorded(identification) - modelled
    return left - left.mean(axis=0)


def _recorded(identification):
    channels = [getattr(identification.record, name) for name in _NAMES[: identification.modelled.shape[1]]]
    return np.column_stack(channels)


def residual_figure(identification, *, ax=None):
    """What the simulated rig leaves of each output: its spectrum, autocorrelation, and correlation with the input.

    The spectrum stands beside that of the output and the record's own floor, the median of the output's spectrum above
    a quarter of the sample rate. White noise stays within the grey bands at 99 % of the lags; what is correlated with
    the force, or the base's acceleration, is motion that the rig does not explain.

    Raises
    ------
    ValueError
        If the identification is by one of the paper's readings, which simulate no rig.
    """
    left, recorded = left_over(identification), _recorded(identification)
    record, q = identification.record, left.shape[1]
    out, shaken = [_correlations(record, left[:, i]) for i in range(q)], record.called("force")
    told = [
        f"{_share(left[:, i], recorded[:, i])} of {_NAMES[i]} are left, {100 * np.mean(own_out):.2g} percent of the "
        f"autocorrelation and {100 * np.mean(cross_out):.2g} percent of that with the {shaken} out of the bands"
        for i, (*_, own_out, cross_out) in enumerate(out)
    ]
    with style():
        alt = f"Residuals of the simulated rig: {'; '.join(told)}."
        figure, axes = subplots(3, q, alt=alt, ax=ax, width=9.5, height=8.0, squeeze=False)
        for column, name, rest, output, found in zip(axes.T, _NAMES, left.T, recorded.T, out, strict=False):
            _draw_spectra(column[0], identification, output, rest, record.units[name])
            column[0].set_title(f"{name}: {_share(rest, output)} left", loc="left")
            lags, own, own_band, both, cross, cross_band, *_ = found
            for axis, x, y, band in ((column[1], lags, own, own_band), (column[2], both, cross, cross_band)):
                axis.axhspan(-band, band, color=GREY, alpha=0.35, linewidth=0, label="99 % of white noise")
                axis.plot(1e3 * x, y, color=RED, linewidth=0.9)
                axis.set(xlabel="lag [ms]", xlim=1e3 * x[[0, -1]])
                axis.set_ylim(*np.array((-1.3, 1.3)) * max(np.abs(y).max(), 2 * band))
            column[1].set_ylabel("autocorrelation")
            column[2].set_ylabel(f"correlation with {shaken}")
        axes[0, 0].legend(loc="lower left")
        axes[1, 0].legend(loc="upper right")
        if ax is None:
            for column in axes.T[1:]:
                for axis in column:
                    axis.set_ylabel("")
        return figure


def _share(rest, output):
    return f"{100 * rest.std() / output.std():.2g} %"


def _draw_spectra(axis, identification, output, rest, unit):
    scale, unit = _DENSITY_AS.get(unit, (1.0, unit))
    rate = identification.record.sample_rate
    block = min(output.size, int(_RESOLVED * rate))
    frequency, lines = signal.welch(np.column_stack([output, rest]), rate, nperseg=block, axis=0)
    lines = scale * np.sqrt(lines)
    floor = np.median(lines[frequency > rate / 4, 0])
    shown = (frequency > 0) & (frequency <= min(4 * identification.frequency[-1], rate / 2))
    axis.semilogy(frequency[shown], lines[shown, 0], color=BLUE, linewidth=1.0, label="recorded")
    axis.semilogy(frequency[shown], lines[shown, 1], color=RED, linewidth=1.0, label="left")
    axis.axhline(floor, color=BLACK, linestyle=":", label="floor of the record")
    axis.axvspan(*identification.frequency[[0, -1]], color=GREY, alpha=0.15, linewidth=0)
    axis.set(xlabel="frequency [Hz]", ylabel=f"density [{unit}/√Hz]", xlim=(0, frequency[shown][-1]))


def _correlations(record, rest):
    """Lags (s), autocorrelation and its band, lags, correlation with the force and its band, and where each is out."""
    n = rest.size
    most = min(int(_LAGS * record.sample_rate), n // 4)
    force = record.force - record.force.mean()

    def correlated(one, other):
        size = np.sqrt(np.sum(one**2) * np.sum(other**2)) + 1e-300
        return signal.correlate(one, other, method="fft")[n - 1 - most : n + most] / size

    own, forces, cross = correlated(rest, rest), correlated(force, force), correlated(rest, force)
    lags = np.arange(-most, most + 1) / record.sample_rate
    own_band = _SURE / np.sqrt(n)
    # Of two channels that have nothing to do with each other, whatever the colour of each.
    cross_band = _SURE * np.sqrt(max(np.sum(own * forces), 1.0) / n)
    out = np.abs(own[most + 1 :]) > own_band, np.abs(cross) > cross_band
    after = slice(most + 1, None, max(1, most // _MOST))
    both = slice(None, None, max(1, 2 * most // _MOST))
    return lags[after], own[after], own_band, lags[both], cross[both], cross_band, *out


def prediction_figure(identification, *, ax=None, interval=None):
    """Recorded and simulated outputs over ``interval`` and over the last part of the record.

    ``interval`` is the first and the last instant of the left panels (s); by default 0.4 s from the middle.

    Raises
    ------
    ValueError
        If the identification is by one of the paper's readings, or the interval holds fewer than two samples.
    """
    modelled = checked(identification).modelled
    record, recorded, q = identification.record, _recorded(identification), modelled.shape[1]
    time = record.time
    low, high = (0.5 * time[-1], 0.5 * time[-1] + _SHOWN) if interval is None else checks.pair(
        "interval", interval, "s", low_open=False
    )  # fmt: skip
    parts = [(time >= low) & (time <= high), time > time[-1] - _SHOWN]
    if parts[0].sum() < 2:
        expected = f"two samples of 0 to {time[-1]:g} s"
        raise ValueError(f"interval = {low:g} to {high:g} s is not allowed; expected {expected}")
    left = left_over(identification)
    last = time > 0.9 * time[-1]
    told = ", ".join(f"{_share(left[last, i], recorded[last, i])} of {_NAMES[i]}" for i in range(q))
    with style():
        alt = f"Recorded outputs and those of the simulated rig, which leaves {told} over the last tenth of the record."
        figure, axes = subplots(q, 2, alt=alt, ax=ax, width=9.5, height=0.8 + 2.4 * q, squeeze=False)
        for row, name, output, simulated, rest in zip(axes, _NAMES, recorded.T, modelled.T, left.T, strict=False):
            constant = (output - simulated).mean()  # of the sensor
            scale, unit = _SHOWN_AS.get(record.units[name], (1.0, record.units[name]))
            for axis, part in zip(row, parts, strict=True):
                axis.plot(time[part], scale * output[part], color=BLUE, label="recorded")
                shown = scale * (simulated[part] + constant)
                axis.plot(time[part], shown, color=ORANGE, linestyle="--", label="simulated")
                axis.set(xlabel="time [s]", ylabel=f"{name} [{unit}]", xlim=time[part][[0, -1]])
            row[1].set_title(f"the end: {_share(rest[last], output[last])} of the last tenth left", loc="left")
        axes[0, 0].legend(loc="upper right")
        outer_labels(axes, ax=ax)
        return figure
