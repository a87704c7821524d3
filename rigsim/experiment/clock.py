"""The sample rate that a file's instants, its words and its reader agree on."""

import numpy as np

from .. import checks

_SLOW = 20.0, 200.0  # Hz, below which instants without unit are refused, or told: they may be milliseconds
_SURE = 1e-4  # of the rate
_PIECE = 1 << 18


def rate(path, details, intervals, asked, time, notes, *, assumed=False, place=None):
    """Sample rate (Hz), the same whoever says it.

    ``details`` may hold one, ``intervals`` are those of the channels (s), ``asked`` is the reader's (Hz), ``time`` are
    instants (s), of a unit that is ``assumed`` or said; ``place`` names a sample.
    """
    said = {"its first line": details.get("sample_rate")} if "sample_rate" in details else {}
    said |= {f"the interval {interval:g} s": 1 / interval for interval in intervals}
    said |= {"sample_rate=": asked} if asked is not None else {}
    values = {who: checks.positive(f"sample_rate in {path}", value, "Hz") for who, value in said.items()}
    first = next(iter(values.values()), None)
    for who, value in values.items():
        if abs(value / first - 1) > _SURE:
            raise ValueError(f"sample_rate of {path} = {first:g} Hz, but {who} says {value:g} Hz; expected one")
    if time is None and first is None:
        raise ValueError(
            f"{path} has no sample rate; expected sample_rate=, a column time, or a first line such as "
            '# {"sample_rate": 2000}'
        )
    if time is None:
        return first
    return _of_time(path, time, first, notes, assumed, place)


def _of_time(path, time, said, notes, assumed, place):
    """Sample rate of instants: what was said, if they agree."""
    time = checks.array(f"time in {path}", time, "s", min_size=2, physical=False)
    with np.errstate(all="ignore"):
        if time[0] > time[-1] + 43200:  # a clock that passes midnight
            time = time + 86400.0 * np.r_[0, np.cumsum(np.diff(time) < -43200)]
        step, unsure = _fitted(path, time, said, place)
        found = 1 / step
    if not np.isfinite(found):
        raise ValueError(f"sample_rate = {found} Hz is not allowed; expected steps of time in {path} that are longer")
    if said is None:
        if 3 * unsure > _SURE:
            raise ValueError(
                f"time in {path} is rounded so far that it gives the rate ({found:g} Hz) only within "
                f"{300 * unsure:.2g} %; expected sample_rate="
            )
        if assumed:
            _slow(path, found, notes)
        return _round(found, 3 * unsure)
    if abs(said * step - 1) <= 1e-3:
        if abs(said * step - 1) > _SURE + 3 * unsure:
            notes.append(f"{said:g} Hz as said, though its time gives {found:g} Hz")
        return said
    for unit, factor in (("ms", 1e3), ("us", 1e6)):
        if assumed and abs(said * step / factor - 1) <= 1e-3:
            notes.append(f"time in {unit}, as {said:g} Hz is said")
            return said
    raise ValueError(f"sample_rate in {path} = {said:g} Hz is not allowed; its time gives {found:g} Hz")


def _fitted(path, time, said, place):
    """The step that fits all instants best (s), and its standard error (a share)."""
    n = time.size
    mean = (time[-1] - time[0]) / (n - 1)
    total, squares, moment, drift, jump = 0.0, 0.0, 0.0, 0.0, 0.0
    for begin in range(0, n - 1, _PIECE):  # a long record has no room for more arrays of its length
        part = time[begin : begin + _PIECE + 1]
        k = np.arange(begin, begin + part.size)
        off = part - (time[0] + mean * k)
        drift, jump = max(drift, np.abs(off).max()), max(jump, np.abs(np.diff(part) - mean).max())
        off, k = off[begin > 0 :], k[begin > 0 :] - (n - 1) / 2
        total, squares, moment = total + off.sum(), squares + off @ off, moment + k @ off
    # Instants are often written with few digits; a lost sample doubles a step, a drifting clock gains whole ones.
    if 0 < mean < np.inf and jump <= 0.45 * mean and drift <= mean:
        spread = n * (n**2 - 1) / 12  # the sum of k**2
        rest = max(squares / n - (total / n) ** 2 - moment**2 / spread / n, 0.0)
        return float(mean + moment / spread), float(np.sqrt(rest / spread) / mean)
    steps = np.diff(time)
    # Stamps coarser than a sample: with a rate that is said they may hold it up within their rounding.
    coarse = steps[steps > 0].min() if (steps > 0).any() else 0.0
    if said and coarse and (steps >= 0).all() and coarse < 50 / said:
        off = time - time[0] - np.arange(n) / said
        if np.ptp(off) <= 1.01 * coarse + 1e-9 * abs(time).max() and steps.max() <= 1.01 * coarse + 1 / said:
            return 1 / said, 0.0
    if coarse and (steps >= 0).all() and (steps == 0).mean() > 0.1 and steps.max() <= 1.5 * coarse:
        raise ValueError(
            f"time in {path} is not evenly spaced: it is rounded to {coarse:g} s, which is coarser than its samples; "
            f"expected sample_rate= (about {1 / mean:g} Hz)"
        )
    worst = int(np.abs(steps - np.median(steps)).argmax())
    where = f"; {place(worst + 1)}" if place else ""
    usual = np.median(steps)
    what = f"that after sample {worst} is {steps[worst]:g} s"
    if steps[worst] == 0:
        what += ", an instant that stands twice"
    elif usual > 0 and steps[worst] > 1.5 * usual:
        what += f", as if {steps[worst] / usual - 1:.0f} samples were lost"
    raise ValueError(f"time in {path} is not evenly spaced; expected rising steps of one length ({what}{where})")


def _slow(path, found, notes):
    if found < _SLOW[0]:
        raise ValueError(
            f"time in {path} gives {found:g} Hz if it is in s, {1e3 * found:g} Hz if it is in ms; expected "
            'units={"time": "s"} or another unit'
        )
    if found < _SLOW[1]:
        notes.append(f"time in s ({found:g} Hz)")


def _round(value, unsure):
    """The value, or the number of few digits that it cannot be told from."""
    few = float(f"{value:.5g}")
    return few if abs(few / value - 1) <= unsure + 1e-9 else value
