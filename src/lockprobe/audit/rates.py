"""How often does each test reject, where there is something to find and where there is nothing?

Many studies of every world go from their records through the same tests as a user's study. Where the truth is *no*, a
test may reject in 5 % of the studies; where it is *yes*, the share that it rejects is its power.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing import get_context

from lockprobe.analysis.inference.battery import infer
from lockprobe.analysis.inference.verdict import Question
from lockprobe.analysis.outcomes import broken_off, outcomes
from lockprobe.analysis.proportions import ALPHA
from lockprobe.audit.simulate import simulate, simulate_columns
from lockprobe.audit.simulated_agents import Design, World
from lockprobe.errors import BadValue, Missing
from lockprobe.seeds import generator

__all__ = ["Progress", "Rate", "measure", "within_error"]

BATCH = 10
"""Studies that a process plays before it reports."""

Progress = Callable[[int, int], None]
"""Called with the studies done and the studies in all."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Rate:
    """How often one test rejected in one world.

    Attributes:
        world: Name of the world.
        trials: Trials per p in each study.
        question: What the test asks.
        test: Name of the test.
        recommended: Whether the report concludes from it.
        truth: The true answer; False makes the rate one of false positives, True makes it power.
        studies: Studies played.
        rejected: Those in which it rejected at 0.05; one that cannot be computed does not reject.
        early: How many of these are among the first 20, which are quickly measured again.
    """

    world: str
    trials: int
    question: Question
    test: str
    recommended: bool
    truth: bool
    studies: int
    rejected: int
    early: int

    @property
    def rate(self) -> float:
        """Share of studies in which the test rejected, [0, 1]."""
        return self.rejected / self.studies

    @property
    def error(self) -> float:
        """Monte Carlo standard error of the rate, with one more study that rejects and one more that does not."""
        smooth = (self.rejected + 1) / (self.studies + 2)
        return math.sqrt(smooth * (1 - smooth) / self.studies)

    @property
    def valid(self) -> bool | None:
        """Whether a false-positive rate is at most 0.05 within Monte Carlo error; None where it is power."""
        return None if self.truth else within_error(self.rejected, self.studies)


def within_error(rejected: int, studies: int) -> bool:
    """Whether so many rejections, or more, come from a rate of 0.05 more often than once in a thousand times."""
    from scipy.stats import binom

    return bool(binom.sf(rejected - 1, studies, ALPHA) > 0.001)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Job:
    """A few studies of one world: numbers ``first`` to ``end`` - 1."""

    truth: World
    design: Design
    seed: int
    first: int
    end: int
    records: bool


Verdict = tuple[str, Question, bool, bool]
Row = tuple[str, int, str, Question, bool]

EARLY = 20


def measure(
    worlds: Sequence[World],
    *,
    studies: int,
    seed: int = 1,
    designs: Sequence[Design] = (),
    processes: int = 1,
    records: bool = True,
    progress: Progress = lambda done, of: None,
) -> list[Rate]:
    """Play studies of every world and count what each test makes of them.

    Args:
        worlds: Simulated agents with known truth.
        studies: Studies per world and design, at least 1.
        seed: Seed of everything; the number of processes changes nothing.
        designs: How much a study plays; by default what its world says.
        processes: Worker processes.
        records: Whether studies are written and read as records; False is quicker and gives the same.
        progress: Told how many studies are done.

    Returns:
        By world, then design, then test in the order of the battery.
    """
    if studies < 1:
        raise BadValue("studies", studies, "at least 1")
    kinds = [(made.name, design.clusters) for made in worlds for design in designs or (made.design,)]
    if len(set(kinds)) < len(kinds):
        raise BadValue("worlds and designs", sorted(kinds), "every one once")
    jobs = [
        _Job(truth=w, design=d, seed=seed, first=first, end=min(first + BATCH, studies), records=records)
        for w in worlds
        for d in designs or (w.design,)
        for first in range(0, studies, BATCH)
    ]
    counts, early = Counter[Row](), Counter[Row]()
    done = 0
    for job, verdicts in zip(jobs, _played(jobs, processes), strict=True):
        for test, question, recommended, rejects in verdicts:
            row = job.truth.name, job.design.clusters, test, question, recommended
            counts[row] += rejects
            early[row] += rejects and job.first < EARLY
        done += job.end - job.first
        progress(done, studies * len(kinds))
    truths = {made.name: made.truths for made in worlds}
    return [
        Rate(
            world=name,
            trials=trials,
            question=question,
            test=test,
            recommended=recommended,
            truth=question in truths[name],
            studies=studies,
            rejected=rejected,
            early=early[name, trials, test, question, recommended],
        )
        for (name, trials, test, question, recommended), rejected in counts.items()
    ]


def _played(jobs: list[_Job], processes: int) -> Iterator[list[Verdict]]:
    """The verdicts in the order of the jobs, from as many processes as asked for."""
    if processes == 1:
        yield from map(_batch, jobs)
        return
    try:
        with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
            yield from pool.map(_batch, jobs)
    except BrokenProcessPool:
        remedy = f"is there memory enough for {processes}? try --workers 1"
        raise Missing("a worker process died before its work was done", remedy) from None


def _batch(job: _Job) -> list[Verdict]:
    """What every test makes of each study: name, question, recommended, rejects."""
    verdicts = []
    for number in range(job.first, job.end):
        place = (job.seed, "audit", job.truth.name, job.design.clusters, number)
        rng = generator(*place)
        if job.records:
            trials = simulate(job.truth, job.design, rng)
            found, broken = outcomes(trials), broken_off(trials)
        else:
            found, broken = simulate_columns(job.truth, job.design, rng)
        tests = infer(found, generator(*place, "tests"), broken=broken).tests
        verdicts += [(test.name, test.question, test.recommended, test.rejects) for test in tests]
    return verdicts
