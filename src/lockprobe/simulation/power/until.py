"""What a study that stops when it is decided is expected to play, by simulation.

Blocks of luck are drawn as for :func:`lockprobe.simulation.power.conditions.condition_power`. Each simulated study goes
through the rule of the runner (:mod:`lockprobe.studies.decisions`): a look after every five blocks, and conditions that
no open question needs are no longer played.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.parallel import THIS_PROCESS, Pool
from lockprobe.foundation.seeds import generator
from lockprobe.simulation.montecarlo.blocks import Blocks
from lockprobe.simulation.power.conditions import BATCH, STATED, by_success, check_stated
from lockprobe.simulation.power.flip_rates import MOST_TRIALS
from lockprobe.statistics.agent_summary import is_reference
from lockprobe.statistics.proportions import ALPHA, Proportion, proportion
from lockprobe.studies.costs.expected_trials import Spread, spread
from lockprobe.studies.decisions import Family, PlayedOut, Question, played_out
from lockprobe.studies.stopping import families
from lockprobe.studies.study import Study
from lockprobe.studies.until import Until

__all__ = ["QuestionPower", "UntilPower", "until_power"]

_LARGE = 100_000
"""Blocks by which the variance of a stated difference is computed."""

Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True)
class QuestionPower:
    """How often a question is decided, and in which way.

    Attributes:
        name: The condition, or the contrast of arms.
        difference: The true difference, [-1, 1]; of a single condition its success.
        effect: Share of studies that decide that there is an effect.
        small: Share that decides that the difference is smaller than the margin.
        narrow: Share in which its interval becomes as narrow as asked.
        fixed: Trials per condition with which a study of fixed size shows that the difference is smaller than the
            margin, or has an interval as narrow, by the normal approximation; None where neither is to be shown.
    """

    name: str
    difference: float
    effect: float
    small: float
    narrow: float
    fixed: int | None

    @property
    def open(self) -> float:
        """Share of studies that leave it open."""
        return max(0.0, 1 - self.effect - self.small - self.narrow)


@dataclass(frozen=True, slots=True, kw_only=True)
class UntilPower:
    """What studies of one agent play until they are decided.

    Attributes:
        agent: Name of the agent, or :data:`lockprobe.simulation.power.conditions.STATED`.
        until: When they stop.
        most: Trials under each condition at most.
        success: Condition -> its true success, [0, 1].
        played: Condition -> the trials under it.
        trials: The trials under all of them together.
        steps: The steps of these, which are the calls of an agent that calls a model; None where they are not known.
        decided: Studies in which everything is decided within the most.
        questions: What is asked, in the order of the report.
    """

    agent: str
    until: Until
    most: int
    success: Mapping[str, float]
    played: Mapping[str, Spread]
    trials: Spread
    steps: Spread | None
    decided: Proportion
    questions: tuple[QuestionPower, ...]

    @property
    def most_trials(self) -> int:
        """The trials of a study that is never decided."""
        return self.most * len(self.played)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Source:
    """What trials of one agent are drawn from; conditions are those that it plays, in the order of the study."""

    agent: str
    labels: tuple[str, ...]
    asked: tuple[Family, ...]
    until: Until
    most: int
    success: tuple[float, ...]
    shared: float
    pool: Blocks | None

    def drawn(self, rng: np.random.Generator) -> tuple[Flags, NDArray[np.int64] | None]:
        """Whether each trial would be solved, shape (most, conditions), and its steps, if they are known."""
        if self.pool is None:
            return by_success(self.success, self.shared, self.most, rng), None
        rows = rng.integers(len(self.pool.solved), size=self.most)
        return self.pool.solved[rows], self.pool.steps[rows]


@dataclass(frozen=True, slots=True, kw_only=True)
class _StudyRange:
    """Some studies, by their numbers: the work of one job."""

    source: _Source
    seed: int
    numbers: range


@dataclass(frozen=True, slots=True)
class _Course:
    """A simulated study, and its steps if they are known."""

    played: PlayedOut
    steps: int | None


def until_power(
    study: Study,
    *,
    success: Sequence[float] | None = None,
    shared: float = 0.0,
    target: float = 0.8,
    studies: int = 100,
    pools: Sequence[Blocks] = (),
    workers: Pool = THIS_PROCESS,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> list[UntilPower]:
    """What a study that stops when it is decided plays, and how often it decides what.

    Args:
        study: The study, with ``until``; its trials are the most under each condition. With ``success`` its agents are
            only counted, and the first that is no baseline is the one that plays.
        success: As in :func:`lockprobe.simulation.power.conditions.condition_power`.
        shared: As there.
        target: Power of the study of fixed size that it is held against, (0, 1).
        studies: Simulated studies.
        pools: Without ``success``, the blocks that each agent played
            (:func:`lockprobe.simulation.power.conditions.played_pools`).
        workers: The pool of processes.
        progress: Called with the number of studies simulated.

    Raises:
        BadValue: If a number is out of range.
    """
    if study.until is None:
        raise BadValue("until", None, "decided, ±10 or another number of points")
    if not 0 < target < 1:
        raise BadValue("target power", target, "a number between 0 and 1")
    if (most := study.repetitions * study.trials) > MOST_TRIALS:
        raise BadValue("most", most, f"at most {MOST_TRIALS} trials per condition, which are simulated")
    if success is not None:
        check_stated(study, success, shared)
        judged = next((one for one in study.agents if not is_reference(one)), study.agents[0])
        sources = [_source(study, judged, STATED, success, shared, None)]
    else:
        sources = [
            _source(study, agent, study.label_of(agent), one.solved.mean(axis=0).tolist(), 0.0, one)
            for agent, one in zip(study.agents, pools, strict=True)
        ]
    jobs = [
        (place, _StudyRange(source=source, seed=study.seed, numbers=range(studies)[first : first + BATCH]))
        for place, source in enumerate(sources)
        for first in range(0, studies, BATCH)
    ]
    found: list[list[_Course]] = [[] for _ in sources]
    for (place, _), courses in zip(jobs, workers.map(_batch, [job for _, job in jobs]), strict=True):
        found[place] += courses
        progress(sum(map(len, found)), studies * len(sources))
    return [_power(source, courses, target) for source, courses in zip(sources, found, strict=True)]


def _source(
    study: Study, agent: str, called: str, success: Sequence[float], shared: float, pool: Blocks | None
) -> _Source:
    """The conditions that an agent plays, with what they are drawn from."""
    assert study.until is not None
    own = {one.label for one in study.conditions_of(agent)}
    places = [i for i, one in enumerate(study.conditions) if one.label in own]
    return _Source(
        agent=called,
        labels=tuple(study.conditions[i].label for i in places),
        asked=families(study, agent),
        until=study.until,
        most=study.repetitions * study.trials,
        success=tuple(success[i] for i in places),
        shared=shared,
        pool=None if pool is None else Blocks(pool.solved[:, places], pool.steps[:, places]),
    )


def _batch(job: _StudyRange) -> list[_Course]:
    source, found = job.source, []
    for number in job.numbers:
        solved, steps = source.drawn(generator(job.seed, "until", source.agent, number))
        nothing = np.zeros(len(solved), dtype=np.bool_)
        outcomes = {label: (solved[:, i].astype(np.float64), nothing) for i, label in enumerate(source.labels)}
        played = played_out(source.asked, outcomes, source.until)
        taken = None
        if steps is not None:
            taken = sum(int(steps[: played.bought[label], i].sum()) for i, label in enumerate(source.labels))
        found.append(_Course(played, taken))
    return found


def _power(source: _Source, courses: Sequence[_Course], target: float) -> UntilPower:
    studies = len(courses)
    bought = [one.played.bought for one in courses]
    steps = [one.steps for one in courses if one.steps is not None]
    large = by_success(source.success, source.shared, _LARGE, generator(1, "until", "variance"))
    solved = dict(zip(source.labels, (large if source.pool is None else source.pool.solved).T, strict=True))
    success = dict(zip(source.labels, source.success, strict=True))
    asked = [(family, one) for family in source.asked for one in family.questions]
    questions = []
    for i, (family, one) in enumerate(asked):
        verdicts = [course.played.decisions[i].verdict for course in courses]
        difference = _of(one, success)
        spread_of = float(np.var(_of(one, {label: solved[label].astype(np.float64) for label in one.labels})))
        questions.append(
            QuestionPower(
                name=one.name,
                difference=difference,
                effect=verdicts.count("effect") / studies,
                small=verdicts.count("small") / studies,
                narrow=verdicts.count("narrow") / studies,
                fixed=_fixed(source.until, one, difference, spread_of, ALPHA / len(family.questions), target),
            )
        )
    all_decided = sum(all(one.at is not None for one in course.played.decisions) for course in courses)
    return UntilPower(
        agent=source.agent,
        until=source.until,
        most=source.most,
        success=success,
        played={label: spread([one[label] for one in bought]) for label in source.labels},
        trials=spread([sum(one.values()) for one in bought]),
        steps=spread(steps) if steps else None,
        decided=proportion(all_decided, studies),
        questions=tuple(questions),
    )


def _of(question: Question, success: Mapping[str, float]) -> float:
    """The difference that a question asks for, from success under each condition, or from arrays of outcomes."""
    found: float = sum(success[more] - (success[less] if less else 0.0) for more, less in question.terms)
    return found / len(question.terms)


def _fixed(
    until: Until, question: Question, difference: float, variance: float, level: float, target: float
) -> int | None:
    """Trials of a study of fixed size for a narrow interval, or to show that a small difference is small.

    Source: the normal approximation; of two one-sided tests (Schuirmann 1987) with a difference d within the margin m
    both reject in at least 1 - 2 q of studies if m - |d| is z(1 - level) + z(1 - q) standard errors. Where all trials
    go alike, it takes as many as exclude a share of the margin (Clopper and Pearson).
    """
    normal = NormalDist()
    if until.rule == "width" or question.of_share:
        least = math.ceil(math.log(level / 2) / math.log(1 - until.points))
        return max(least, math.ceil(variance * (normal.inv_cdf(1 - level / 2) / until.points) ** 2))
    if (room := until.points - abs(difference)) <= 1e-9:
        return None
    reached = normal.inv_cdf((1 + target) / 2 if difference == 0 else target)
    least = math.ceil(math.log(level) / math.log(1 - until.points))
    return max(least, math.ceil(variance * ((normal.inv_cdf(1 - level) + reached) / room) ** 2))
