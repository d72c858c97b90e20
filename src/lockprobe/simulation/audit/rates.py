"""False-positive rates and power of every test, over many simulated studies with known truth.

Simulated studies go through the same tests as a user's. If the truth is *no*, a test may reject in 5 % of the studies;
if it is *yes*, the share of rejections is the power. ``measured.json`` ships the rates of this release, as
``python benchmarks/audit.py`` prints them, and ``every_look.json`` those of studies that are looked at after every
block, as ``python benchmarks/every_look.py`` writes them.
"""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from typing import Any, Literal

import numpy as np

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.parallel import THIS_PROCESS, Pool
from lockprobe.foundation.seeds import generator
from lockprobe.foundation.spec import PEOPLE
from lockprobe.simulation.audit.simulate import BUDGET, simulate_outcomes, simulate_study
from lockprobe.simulation.audit.simulated_agents import Design, World
from lockprobe.statistics.agent_comparison.pair import compare, corrected
from lockprobe.statistics.agent_comparison.paired import sheets
from lockprobe.statistics.inference.battery import infer
from lockprobe.statistics.inference.verdict import Question
from lockprobe.statistics.outcomes import Outcomes
from lockprobe.statistics.proportions import ALPHA

__all__ = [
    "COMPARISON",
    "Asked",
    "EveryLookRate",
    "Progress",
    "Rate",
    "false_positives",
    "measure",
    "measured",
    "shipped",
    "standard_error",
    "within_error",
]

BATCH = 10
"""Studies that a process plays before it reports."""

Progress = Callable[[int, int], None]
"""Called with the studies done and the studies in all."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Rate:
    """The rejection rate of one test in one world: a false-positive rate or a power.

    Attributes:
        world: Name of the world.
        trials: Trials per p in each study.
        question: The question of the test.
        test: Name of the test.
        recommended: Whether the report concludes from it.
        truth: The true answer: False for a false-positive rate, True for power.
        studies: Number of studies.
        rejected: Studies in which it rejected at 0.05; a test that cannot be computed does not reject.
        early: Rejections in the first 20 studies, which are quick to repeat.
    """

    world: str
    trials: int
    question: Asked
    test: str
    recommended: bool
    truth: bool
    studies: int
    rejected: int
    early: int

    @property
    def rate(self) -> float:
        """The share of studies in which the test rejected, [0, 1]."""
        return self.rejected / self.studies

    @property
    def error(self) -> float:
        """Monte Carlo standard error of the rate, after adding one study of each outcome."""
        return standard_error(self.rejected, self.studies)

    @property
    def valid(self) -> bool | None:
        """Whether a false-positive rate is at most 0.05 within Monte Carlo error; None for power."""
        return None if self.truth else within_error(self.rejected, self.studies)


@dataclass(frozen=True, slots=True, kw_only=True)
class EveryLookRate:
    """The share of studies that make a false statement at any of their looks, one after every block.

    Attributes:
        says: What is said falsely.
        world: Name of the world.
        agents: Agents that are judged together.
        studies: Number of studies.
        said: Studies that say it at least once.
    """

    says: str
    world: str
    agents: int
    studies: int
    said: int

    @property
    def rate(self) -> float:
        """The share of studies, [0, 1]."""
        return self.said / self.studies

    @property
    def error(self) -> float:
        """Monte Carlo standard error of the rate, after adding one study of each outcome."""
        return standard_error(self.said, self.studies)

    @property
    def valid(self) -> bool:
        """Whether the rate is at most 0.05 within Monte Carlo error."""
        return within_error(self.said, self.studies)


def standard_error(rejected: int, studies: int) -> float:
    """Monte Carlo standard error of a rate, after adding one study of each outcome."""
    smooth = (rejected + 1) / (studies + 2)
    return math.sqrt(smooth * (1 - smooth) / studies)


def within_error(rejected: int, studies: int) -> bool:
    """Whether this number of rejections or more has a binomial probability above 0.001 at a rate of 0.05."""
    from scipy.special import bdtrc

    return rejected < 1 or bool(bdtrc(rejected - 1, studies, ALPHA) > 0.001)


@dataclass(frozen=True, slots=True, kw_only=True)
class _StudyRange:
    """Some studies of one world, by their numbers: the work of one job."""

    truth: World
    design: Design
    seed: int
    numbers: range


Asked = Question | Literal["comparison"]
"""The question of a test; those of one agent's trials, and :data:`COMPARISON`."""

COMPARISON = "Do people solve the box more or less often than an agent? (Here it is equally good.)"
"""The question that is asked in worlds with people alone."""

Verdict = tuple[str, Asked, bool, bool]
Row = tuple[str, int, str, Asked, bool]

EARLY = 20


def measure(
    worlds: Sequence[World],
    *,
    studies: int,
    seed: int = 1,
    designs: Sequence[Design] = (),
    workers: Pool = THIS_PROCESS,
    progress: Progress = lambda done, of: None,
) -> list[Rate]:
    """Simulate studies of every world and count the rejections of each test.

    Args:
        worlds: Simulated agents with known truth.
        studies: Studies per world and design, at least 1.
        seed: Seed of everything; the number of workers changes nothing.
        designs: The designs of a study; by default its world's design.
        workers: The pool of processes that simulates the studies.
        progress: Called with the number of studies done.

    Returns:
        By world, then design, then test in the order of the battery.
    """
    if studies < 1:
        raise BadValue("studies", studies, "at least 1")
    kinds = [(made.name, design.clusters) for made in worlds for design in designs or (made.design,)]
    if len(set(kinds)) < len(kinds):
        raise BadValue("worlds and designs", sorted(kinds), "every one once")
    jobs = [
        _StudyRange(truth=w, design=d, seed=seed, numbers=range(studies)[first : first + BATCH])
        for w in worlds
        for d in designs or (w.design,)
        for first in range(0, studies, BATCH)
    ]
    counts, early = Counter[Row](), Counter[Row]()
    done = 0
    for job, verdicts in zip(jobs, workers.map(_batch, jobs), strict=True):
        for test, question, recommended, rejects in verdicts:
            row = job.truth.name, job.design.clusters, test, question, recommended
            counts[row] += rejects
            early[row] += rejects and job.numbers.start < EARLY
        done += len(job.numbers)
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


def _batch(job: _StudyRange) -> list[Verdict]:
    """The verdict of every test on each study: name, question, recommended, rejects."""
    verdicts: list[Verdict] = []
    for number in job.numbers:
        place = (job.seed, "audit", job.truth.name, job.design.clusters, number)
        found, broken, _ = simulate_study(job.truth, job.design, generator(*place))
        drawn = generator(*place, "tests")
        tests = infer(found, drawn, broken=broken, budget=BUDGET).tests
        verdicts += [(test.name, test.question, test.recommended, test.rejects) for test in tests]
        if job.truth.people:
            apart = _people_differ(found, job.truth, job.design, generator(*place, "agent"))
            verdicts.append(("people and an agent, clustered by person and block", "comparison", True, apart))
    return verdicts


def _people_differ(people: Outcomes, truth: World, design: Design, rng: np.random.Generator) -> bool:
    """Whether people are told apart from an agent that solves as many boxes, on the trials that both played."""
    alone = replace(truth, people=0, likeness=0.0, leaves=0.0)
    values, (agent, human) = sheets([simulate_outcomes(alone, design, rng), people])
    names = ("simulated", "symbolic"), (PEOPLE, "symbolic")
    compared = compare(names, values, (agent, human), "reference", rng, budget=BUDGET)
    return compared is not None and corrected([compared])[0].verdict != 0


@cache
def shipped() -> dict[str, Any]:
    """The shipped audit as JSON data, with what was measured at every look; do not modify it."""
    return _file("measured.json") | {"every_look": _file("every_look.json")}


def _file(name: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(files("lockprobe.simulation.audit").joinpath(name).read_text(encoding="utf-8"))
    return found


@cache
def measured() -> tuple[Rate, ...]:
    """The shipped audit."""
    derived = ("rate", "error", "valid")
    return tuple(
        Rate(**{name: value for name, value in row.items() if name not in derived}) for row in shipped()["rates"]
    )


def false_positives(test: str) -> tuple[Rate, Rate] | None:
    """The lowest and the highest false-positive rate of a test over the worlds where it should find nothing."""
    found = sorted((rate for rate in measured() if rate.test == test and not rate.truth), key=lambda rate: rate.rate)
    return (found[0], found[-1]) if found else None
