"""What protocols are asked: their arguments, one bench for each of what broadcasts, and the run of all of them."""

import numpy as np

from ... import checks
from ...campaign.cost import affordable
from ...campaign.run import join, run_chunks
from ...model.chipmunk import STARTS, check_step
from ...model.shaker import ShakerDrive, check_drives
from ...parameters import rigs_of
from ...results import Status
from ..steady import LOWEST, WINDOW, highest
from .bench import run_bench
from .drive import Drive
from .result import BenchPoint, BenchTest
from .sensors import Sensors
from .waiting import Patience

_STEP = 7e-7  # seconds a step of a rig
_LONGEST = 1e5  # s, that anyone waits for a point


def patience_of(dwell, tolerance, limit):
    """The `Patience` of a protocol's arguments."""
    tolerance = checks.real("tolerance", tolerance, low=1e-5, high=0.1)
    limit = checks.real("limit", limit, "s", low=3 * WINDOW, high=_LONGEST)
    if isinstance(dwell, str):
        return Patience(checks.one_of("dwell", dwell, ("settled",)), tolerance, limit)
    return Patience(checks.real("dwell", dwell, "s", low=WINDOW, high=_LONGEST), tolerance, limit)


def window_of(window):
    """The moving window of a protocol's readings (s)."""
    return checks.real("window", window, "s", low=0.05, high=60.0)


def bench_of(parameters, start, step):
    """Rigs, where they start from, and the step (s), good for all of them: first, since other limits follow from it."""
    rigs, step = rigs_of(parameters), checks.positive("step", step, "s")
    if not rigs:
        raise ValueError("parameters has 0 elements; expected at least 1")
    check_step(rigs, step)
    return rigs, checks.one_of("start", start, STARTS), step


def rows(name, values, step=None, least=1):
    """Frequencies at a ``step`` (Hz), or without it forces (N), as an array (n, k), k at ``least``: a row a bench."""
    dimensions = None if np.iterable(values) else 1
    if step is None:
        values = checks.array(name, values, "N", low=0.0, low_open=True, ndim=dimensions)
    else:
        values = checks.array(name, values, "Hz", low=LOWEST, high=highest(step), ndim=dimensions)
    if values.ndim > 2:
        raise ValueError(f"{name} has {values.ndim} dimensions; expected 1, or 2 with a row a bench")
    values = np.atleast_2d(values)
    if values.shape[1] < least:
        raise ValueError(f"{name} has {values.shape[1]} elements; expected at least {least}, where it begins and ends")
    return values


def broadcast(rigs, step, sensors, drive, **arrays):
    """Rigs (n,), each of the arrays with n rows, sensors (n,) and drives (n,), which allow the ``step``."""
    sensors = checks.one_or_many("sensors", sensors, (Sensors, type(None)), "Sensors or None")
    shakers = checks.one_or_many("drive", drive, (ShakerDrive, type(None)), "a ShakerDrive or None")
    n = checks.broadcast(parameters=rigs, sensors=sensors, drive=shakers, **arrays)
    widened = [np.repeat(values, n // len(values), axis=0) for values in arrays.values()]
    rigs, sensors, shakers = (tuple(each * (n // len(each))) for each in (rigs, sensors, shakers))
    check_drives(shakers, rigs, step)
    return rigs, (*widened, sensors, shakers)


def ran(protocol, over, rigs, plans, shakers, start, step, options):
    """The `BenchTest` of plans on their rigs."""
    progress, executor, checkpoint = options
    longest = [plan.longest for plan in plans]
    given = f"a {protocol} of up to {max(longest):.4g} s in steps of {step:g} s"
    affordable(given, seconds=max(longest) / step * _STEP, instead="a shorter test or longer steps")
    shared = executor or checkpoint
    seconds = sum(longest) / step * _STEP
    affordable(f"{given} on {len(rigs)} benches", seconds=seconds, instead="fewer of them", shared=shared)
    chunks = [
        {"rig": rig, "plan": plan, "number": number, "start": start, "step": step}
        | ({"shaker": shaker} if shaker else {})
        for number, (rig, plan, shaker) in enumerate(zip(rigs, plans, shakers, strict=True))
    ]
    run = {"progress": progress, "executor": executor, "checkpoint": checkpoint, "label": "benches"}
    done = join(run_chunks(run_bench, chunks, threads=True, **run))
    rows = done.pop("drives")
    drives = tuple(tuple(Drive.of(row[1:]) for row in rows[rows[:, 0] == number]) for number in range(len(rigs)))
    done["status"] = [Status[name] for name in done["status"]]
    done["message"] = [str(text) for text in done["message"]]
    points = [dict(zip(done, values, strict=True)) for values in zip(*done.values(), strict=True)]
    members = tuple(BenchPoint(**{name: _plain(value) for name, value in point.items()}) for point in points)
    sensors = tuple(plan.sensors for plan in plans)
    return BenchTest(members, protocol, over, rigs, drives, sensors, start, step, shakers)


def _plain(value):
    return value.item() if isinstance(value, np.generic) else value
