"""Monte Carlo over building tolerances: which share of rigs keeps its detached curve, and what decides it."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from .. import checks
from ..blas import one_blas_thread
from ..campaign.cost import affordable
from ..campaign.run import join, run_chunks, split
from ..orbits.accuracy import checked_harmonics
from ..parameters import law_of, oscillator_of
from ..results import Result, frame
from .converged import Edges
from .variation import half_widths, judge_varied, kind_number, quantity

_BYTES, _RIG, _CONVERGED = 250, 3e-5, 1e-2  # a rig: bytes, and seconds by single-term theory or converged
_COMPARED = 2000  # rigs of the study that are drawn again with one quantity exact, or alone
_CHUNK, _CONVERGED_CHUNK = 4096, 16  # rigs that are judged at a time, in some 0.1 s


@dataclass(frozen=True, repr=False)
class Share:
    """A share of trials with its 95 % confidence interval (Wilson)."""

    kept: int
    tried: int
    low: float
    high: float

    @property
    def value(self):
        """The share itself, 0 to 1."""
        return self.kept / self.tried

    def __repr__(self):
        return f"{100 * self.value:.1f} % ({100 * self.low:.1f} to {100 * self.high:.1f} %, {self.tried} tried)"


def share(kept):
    """The `Share` of trials that are true, from a bool array (n,)."""
    from scipy.stats import binomtest

    hits = int(np.count_nonzero(kept))
    interval = binomtest(hits, kept.size).proportion_ci(0.95, method="wilson")
    return Share(hits, int(kept.size), float(interval.low), float(interval.high))


@dataclass(frozen=True, eq=False, repr=False)
class ToleranceStudy(Result):
    """Rigs drawn within tolerances; see `tolerance_study`.

    Attributes
    ----------
    parameters, force, kind, distribution, seed
        As given: the nominal rig, its force (N) and how others were drawn.
    tolerances : dict of str to float
        Half-widths (SI units).
    values : dict of str to (n,) array
        What was drawn (SI units).
    kept : (n,) bool array
        Whether the curve exists.
    distance : (n,) array
        ln(F/F_edge) of the nearest edge of existence, positive inside; -infinity where no force gives such a curve.
    share : Share
        Of the rigs that keep the curve.
    alone : dict of str to Share
        The same draws (the first 2000) of one quantity alone, the others exact.
    exact : dict of str to Share
        The same draws (the first 2000), but this one quantity exact: what better workmanship there would give.
    """

    parameters: object
    force: float
    kind: str
    distribution: str
    seed: object
    tolerances: dict
    values: dict
    kept: np.ndarray
    distance: np.ndarray
    share: Share
    alone: dict
    exact: dict

    plots = {"study": "tolerance_study_figure"}

    @property
    def ranking(self):
        """Names, most harmful first: by the share kept if it were exact, then by the share kept alone."""
        return tuple(sorted(self.tolerances, key=lambda name: (-self.exact[name].kept, self.alone[name].kept)))

    def summary(self):
        """The share and the quantity that matters most."""
        kept = f"{self.share} of the rigs keep the {self.kind} detached curve at {self.force:g} N"
        return f"{kept}; most depends on {self.ranking[0]}"

    def table(self):
        """`pandas.DataFrame`: for each quantity its tolerance and the shares kept (%)."""
        rows = []
        for name in self.ranking:
            item = quantity(self.parameters, self.force, name)
            given = item.value * item.factor, self.tolerances[name] * item.factor, item.shown_unit
            rows.append((name, *given, 100 * self.alone[name].value, 100 * self.exact[name].value))
        columns = ["quantity", "value", "tolerance", "unit", "kept if it alone varies [%]", "kept if it is exact [%]"]
        return frame(rows, columns, index="quantity")


@one_blas_thread
def tolerance_study(
    parameters,
    force,
    tolerances,
    samples=10_000,
    seed=2014,
    kind="inner",
    distribution="uniform",
    *,
    harmonics=1,
    law=None,
    progress=False,
    executor=None,
    checkpoint=None,
):
    """The share of rigs, built and driven within tolerances, that have a detached curve.

    Every rig is judged as `rigsim.detached_curves` would judge it. A drawn rig that cannot be (an unstretched wire
    longer than the installed one) has no curve.

    Parameters
    ----------
    parameters : RigParameters or OscillatorParameters
        The nominal rig; it need not have the curve itself.
    force : float
        Nominal amplitude (N, above zero).
    tolerances : dict of str to float or str
        For each quantity that varies (a field, "force", "k1", "k3" or a non-dimensional name) its half-width, in SI
        units, or as text in per cent of its value: ``{"d0": 1e-6, "c": "20 %"}``. Quantities vary independently.
    samples : int
        Number of rigs.
    seed : int or numpy.random.Generator
        The same seed gives the same rigs.
    kind : {"inner", "outer"}
    distribution : {"uniform", "normal"}
        Uniform between minus and plus the half-width, or normal with it as two standard deviations.
    harmonics, law
        See `rigsim.margins`; with more than one harmonic take some hundred ``samples``, 10 ms each, three times.
    progress, executor, checkpoint
        See `rigsim.campaign.run.run_chunks`.

    Returns
    -------
    ToleranceStudy

    Raises
    ------
    ValueError
        If an input is not allowed, or the shaker is undamped.

    Examples
    --------
    >>> tolerance_study(RigParameters(), 3.18, {"d0": 1e-6, "force": "2 %"})  # doctest: +SKIP
    """
    oscillator_of(parameters)
    progress, executor, checkpoint = checks.running(progress, executor, checkpoint)
    force = checks.positive("force", force, "N")
    widths = half_widths(parameters, force, tolerances)
    samples = checks.integer("samples", samples, low=1)
    distribution = checks.one_of("distribution", distribution, ("uniform", "normal"))
    number, seed = kind_number(kind), checks.seed("seed", seed, generator=True)
    harmonics, law = checked_harmonics(harmonics), law_of(parameters, law)
    each = _RIG if harmonics == 1 else _CONVERGED
    affordable(
        f"samples = {samples}", instead="fewer samples", memory=samples * (_BYTES + 16 * len(widths)),
        seconds=each * (samples + 2 * len(widths) * min(samples, _COMPARED)), shared=executor or checkpoint,
    )  # fmt: skip
    generator, values = np.random.default_rng(seed), {}
    for name, width in widths.items():
        uniform = distribution == "uniform"
        drawn = generator.uniform(-1, 1, samples) if uniform else 0.5 * generator.standard_normal(samples)
        values[name] = quantity(parameters, force, name).value + width * drawn

    first = {name: drawn[:_COMPARED] for name, drawn in values.items()}
    nominal = {"force": np.full(min(samples, _COMPARED), force)}  # what is left when the only quantity is exact
    but_one = [{other: drawn for other, drawn in first.items() if other != name} or nominal for name in widths]
    studies = [values, *({name: first[name]} for name in widths), *but_one]
    converged = None if harmonics == 1 else (parameters, force, kind, tuple(widths), harmonics, law)
    if converged:
        _edges(*converged)  # found once, and refused before anything is begun
    rig = {"parameters": parameters, "force": force, "number": number, "converged": converged}
    size = _CONVERGED_CHUNK if converged else _CHUNK
    parts = [(study, part) for study in studies for part in split(len(next(iter(study.values()))), size)]
    chunks = [rig | {"changes": {name: drawn[part] for name, drawn in study.items()}} for study, part in parts]
    options = {"progress": progress, "executor": executor, "checkpoint": checkpoint, "label": "batches of rigs"}
    judged = join(run_chunks(_judge_chunk, chunks, threads=not converged, **options))
    ends = np.cumsum([len(next(iter(study.values()))) for study in studies])[:-1]
    kept, *others = np.split(judged["kept"], ends)
    shares = [share(one) for one in others]
    alone, exact = (dict(zip(widths, some, strict=True)) for some in (shares[: len(widths)], shares[len(widths) :]))
    distance = judged["distance"][: len(kept)]
    return ToleranceStudy(
        parameters, force, kind, distribution, seed, widths, values, kept, distance, share(kept), alone, exact
    )


@one_blas_thread
def _judge_chunk(chunk):
    if chunk["converged"]:
        distance = _edges(*chunk["converged"]).judge(chunk["changes"])
        return {"kept": distance > 0, "distance": distance}
    counts, distances = judge_varied(chunk["parameters"], chunk["force"], chunk["changes"])
    return {"kept": counts[:, chunk["number"]] > 0, "distance": distances[:, chunk["number"]]}


_edges = lru_cache(4)(Edges)  # seconds to find, and the same for every chunk of a study
