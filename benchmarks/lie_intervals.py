"""Coverage of the intervals of the effect of one lie, and power and size of its test, by simulation.

    python benchmarks/lie_intervals.py [--studies 1000] [--seed 1] [--workers 2]

Two estimates are audited on agents whose effect is exact (:mod:`lockprobe.simulation.exact.excursions`): that of
one more lie from the records of a flip study, and that of forks of recorded trials after one step.
"""

from __future__ import annotations

import argparse
import asyncio
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lockprobe.agents.catalogue import resolve
from lockprobe.foundation.parallel import Pool, Processes
from lockprobe.foundation.seeds import generator
from lockprobe.simulation.exact.excursions import lie_effects, one_lie
from lockprobe.simulation.montecarlo.populations import Population, population
from lockprobe.statistics.agent_comparison.paired import block_mean
from lockprobe.statistics.excursion import DecisionPoints, Excursion, excursion
from lockprobe.statistics.proportions import ALPHA
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.running.trial_setup import play_timed

AUDITED = (("random", 0.4), ("cognitive:perseverant", 0.3), ("cognitive:insistent", 0.4), ("human-inspired", 0.4))
"""Agents and flip rates; on ``random`` a lie has no effect."""

FORK_STEP = 4
"""The step after which trials are forked."""

BATCH = 25
"""Studies that a process plays before it reports."""

TRIALS = 210
"""Trials of a study."""

FORKED = 4000
"""Trials that are forked for each agent."""

Estimate = Literal["records", "forks"]


@dataclass(frozen=True, slots=True, kw_only=True)
class IntervalRates:
    """Coverage and rejection rates of the estimated effect of one lie, for studies of one agent.

    Attributes:
        agent: Agent spec.
        p: Flip rate, [0, 1].
        estimate: The source: the ``records`` of a flip study, or ``forks`` after step :data:`FORK_STEP`.
        exact: The exact effect, [-1, 1].
        mean: Mean of the estimates; None without an estimate.
        studies: Number of studies.
        shown: Studies with an estimate; the others have too few trials of either outcome.
        covered: Studies whose 95 % interval holds the exact effect.
        found: Studies whose test rejects at 0.05; false positives where the exact effect is 0.
    """

    agent: str
    p: float
    estimate: Estimate
    exact: float
    mean: float | None
    studies: int
    shown: int
    covered: int
    found: int

    @property
    def held(self) -> float | None:
        """Coverage: share of the intervals that hold the exact effect, [0, 1]; None without an estimate."""
        return self.covered / self.shown if self.shown else None

    @property
    def detected(self) -> float | None:
        """Share of the estimates whose test rejects, [0, 1]: power, or size if the effect is 0; None without any."""
        return self.found / self.shown if self.shown else None


class _StudyRange(NamedTuple):
    agent: str
    p: float
    exact: float
    seed: int
    first: int
    end: int


class _Estimate(NamedTuple):
    value: float
    covers: bool
    rejects: bool


def interval_rates(*, studies: int, seed: int, workers: Pool) -> list[IntervalRates]:
    """Simulate studies of agents with a known exact effect; count covering intervals and rejecting tests.

    The records of every study are played anew. Forks are played once; studies are drawn from them with replacement, and
    their intervals are compared with the mean of all forks.
    """
    effects = {(agent, p): lie_effects(agent, p=p, modality="symbolic") for agent, p in AUDITED}
    jobs = [
        _StudyRange(agent, p, effect.mean, seed, first, min(first + BATCH, studies))
        for (agent, p), effect in effects.items()
        for first in range(0, studies, BATCH)
    ]
    found: dict[tuple[str, float], list[_Estimate]] = {}
    for job, estimates in zip(jobs, workers.map(_of_records, jobs), strict=True):
        found.setdefault((job.agent, job.p), []).extend(estimates)
    pools = [
        _StudyRange(agent, p, effect.by_step[FORK_STEP - 1], seed, 0, studies) for (agent, p), effect in effects.items()
    ]
    rates = []
    for job, from_forks in zip(pools, workers.map(_of_forks, pools), strict=True):
        rates.append(_rates(job, "records", effects[job.agent, job.p].mean, found[job.agent, job.p]))
        rates.append(_rates(job, "forks", job.exact, from_forks))
    return rates


def _rates(job: _StudyRange, estimate: Estimate, exact: float, found: Sequence[_Estimate]) -> IntervalRates:
    return IntervalRates(
        agent=job.agent,
        p=job.p,
        estimate=estimate,
        exact=exact,
        mean=float(np.mean([one.value for one in found])) if found else None,
        studies=job.end,
        shown=len(found),
        covered=sum(one.covers for one in found),
        found=sum(one.rejects for one in found),
    )


def _of_records(job: _StudyRange) -> list[_Estimate]:
    """The estimates from the records of a range of studies."""
    number = job.end - job.first
    made = population(
        job.agent,
        p=job.p,
        modality="symbolic",
        trials=number * TRIALS,
        record=True,
        seed=job.seed,
        repetition=job.first // BATCH + 1,
        threads=1,
    )
    found = []
    for first in range(0, number * TRIALS, TRIALS):
        points = _points(made, job.p, slice(first, first + TRIALS))
        one = excursion(points, "solved", np.ones(len(points), dtype=np.bool_))
        if isinstance(one, Excursion):
            found.append(_Estimate(one.effect, one.low <= job.exact <= one.high, one.p_value < ALPHA))
    return found


def _points(made: Population, p: float, rows: slice) -> DecisionPoints:
    """The decision points of trials whose reports tell outcomes, without loops: no covariate is needed."""
    assert made.moved is not None  # it was recorded
    assert made.told_moved is not None
    steps, moved = made.steps[rows], made.moved[rows]
    runs = np.arange(moved.shape[1])[None, :] < steps[:, None] - 1
    trial, step = np.nonzero(runs)
    return DecisionPoints(
        flipped=(moved != made.told_moved[rows])[runs],
        p=np.full(len(trial), p),
        step=(step + 1).astype(np.float64),
        moved=moved[runs],
        looping=np.zeros(len(trial), dtype=np.bool_),
        cluster=trial.astype(np.int64),
        outcomes={"solved": made.solved[rows][trial].astype(np.float64)},
    )


def _of_forks(job: _StudyRange) -> list[_Estimate]:
    """The estimates from the forks of a range of studies."""
    changes = asyncio.run(_forked(job))
    truth, rng = float(changes.mean()), generator(job.seed, "interval rates", job.agent, f"p={job.p:g}")
    found = []
    for _ in range(job.end):
        drawn = block_mean(changes[rng.integers(len(changes), size=TRIALS)][:, None], unit=1.0)
        assert drawn.low is not None  # two trials or more
        assert drawn.high is not None
        assert drawn.p_value is not None
        found.append(_Estimate(drawn.value, drawn.low <= truth <= drawn.high, drawn.p_value < ALPHA))
    return found


async def _forked(job: _StudyRange) -> NDArray[np.float64]:
    """The change of success by a lie at the fork step, for every trial that goes on after it, shape (trials,)."""
    conditions = [f"{one_lie(FORK_STEP, rate, job.p)} + symbolic" for rate in (0.0, 1.0)]
    planned = study("flips", agent=job.agent, condition=conditions, trials=FORKED, repetitions=1, seed=job.seed)
    player = resolve(job.agent).make()
    changes = []
    for number in range(1, FORKED + 1):
        forks = [
            (await play_timed(planned.plan(job.agent, condition, 1, number), player))[0]
            for condition in planned.conditions[-2:]  # after those of the truth
        ]
        if len(forks[0].steps) > FORK_STEP:
            changes.append(float(forks[1].solved) - forks[0].solved)
    return np.array(changes)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--studies", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    asked = parser.parse_args()
    print("| agent | p | from | exact effect, points | mean estimate | coverage | P < 0.05 | studies |")
    print("|---|---|---|---|---|---|---|---|")
    for one in interval_rates(studies=asked.studies, seed=asked.seed, workers=Processes(asked.workers)):
        shares = ("-" if share is None else f"{100 * share:.1f} %" for share in (one.held, one.detected))
        size = (f"{100 * one.exact:.1f}", "-" if one.mean is None else f"{100 * one.mean:.1f}")
        shown = f"{one.shown} of {one.studies}"
        print(f"| {' | '.join([one.agent, f'{one.p:g}', one.estimate, *size, *shares, shown])} |", flush=True)


if __name__ == "__main__":
    main()
