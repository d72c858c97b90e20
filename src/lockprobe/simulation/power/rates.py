"""How often each test rejects, over many simulated studies with known truth, which pass through a user's tests."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from lockprobe.foundation.parallel import THIS_PROCESS, Pool
from lockprobe.foundation.seeds import generator
from lockprobe.simulation.power.simulate import BUDGET, simulate_outcomes
from lockprobe.simulation.power.worlds import Design, World
from lockprobe.statistics.inference.over_doses import TESTS, Question, p_values
from lockprobe.statistics.proportions import ALPHA

BATCH = 10
"""Studies that a process plays before it reports."""

Progress = Callable[[int, int], None]
"""Called with the studies done and the studies in all."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Rate:
    """The rejection rate of one test in one world.

    Attributes:
        world: Name of the world.
        trials: Trials per p in each study.
        question: The question of the test.
        test: Name of the test.
        truth: The true answer: False for a false-positive rate, True for power.
        studies: Number of studies.
        rejected: Studies in which it rejected at 0.05; a test that cannot be computed does not reject.
    """

    world: str
    trials: int
    question: Question
    test: str
    truth: bool
    studies: int
    rejected: int

    @property
    def rate(self) -> float:
        """The share of studies in which the test rejected, [0, 1]."""
        return self.rejected / self.studies

    @property
    def error(self) -> float:
        """Monte Carlo standard error of the rate, after adding one study of each outcome."""
        smooth = (self.rejected + 1) / (self.studies + 2)
        return math.sqrt(smooth * (1 - smooth) / self.studies)


@dataclass(frozen=True, slots=True, kw_only=True)
class _StudyRange:
    """Some studies of one world, by their numbers: the work of one job."""

    truth: World
    design: Design
    seed: int
    numbers: range


def measure(
    worlds: Sequence[World],
    designs: Sequence[Design],
    *,
    studies: int,
    seed: int = 1,
    workers: Pool = THIS_PROCESS,
    progress: Progress = lambda done, of: None,
) -> list[Rate]:
    """Simulate studies of every world and count the rejections of each test.

    Args:
        worlds: Simulated agents with known truth.
        designs: The designs of a study.
        studies: Studies per world and design, at least 1.
        seed: Seed of everything; the number of workers changes nothing.
        workers: The pool of processes that simulates the studies.
        progress: Called with the number of studies done.

    Returns:
        By world, then design, then test.
    """
    jobs = [
        _StudyRange(truth=w, design=d, seed=seed, numbers=range(studies)[first : first + BATCH])
        for w in worlds
        for d in designs
        for first in range(0, studies, BATCH)
    ]
    counts, done = Counter[tuple[str, int, Question]](), 0
    for job, verdicts in zip(jobs, workers.map(_batch, jobs), strict=True):
        for question, rejects in verdicts:
            counts[job.truth.name, job.design.clusters, question] += rejects
        done += len(job.numbers)
        progress(done, studies * len(worlds) * len(designs))
    truths = {made.name: made.truths for made in worlds}
    return [
        Rate(
            world=name,
            trials=trials,
            question=question,
            test=TESTS[question],
            truth=question in truths[name],
            studies=studies,
            rejected=rejected,
        )
        for (name, trials, question), rejected in counts.items()
    ]


def _batch(job: _StudyRange) -> list[tuple[Question, bool]]:
    """Whether the test of each question rejects, in each study."""
    verdicts: list[tuple[Question, bool]] = []
    for number in job.numbers:
        place = (job.seed, "audit", job.truth.name, job.design.clusters, number)
        found = simulate_outcomes(job.truth, job.design, generator(*place))
        tests = p_values(found, generator(*place, "tests"), BUDGET)
        verdicts += [(question, p is not None and p < ALPHA) for question, p in tests.items()]
    return verdicts
