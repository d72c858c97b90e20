"""A study in numbers: one row per condition, trends per agent."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby

from lockprobe.analysis.behaviour import Behaviour, behaviour, has_loop
from lockprobe.analysis.curves import SuccessCurve, success_curve
from lockprobe.analysis.inference.association import Correlation, correlation
from lockprobe.analysis.inference.trend import TrendFit, trend_fit
from lockprobe.analysis.misinterpretation import Misinterpretations, misinterpretations
from lockprobe.analysis.outcomes import Point, ended
from lockprobe.analysis.proportions import Difference, Proportion, difference, proportion
from lockprobe.analysis.resample import resample
from lockprobe.record import Trial
from lockprobe.seeds import generator

__all__ = [
    "AgentSummary",
    "ConditionSummary",
    "Contrast",
    "StudySummary",
    "summarise",
]

_REFERENCES = ("random", "random-no-repeat", "round-robin", "human-inspired")
"""Agents that stand in a study to be compared with, by the head of their spec."""

ALPHA = 0.05


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionSummary:
    """One agent under one condition.

    Attributes:
        key: Its readable name, for example ``flips/random/p=0.4``.
        agent: Agent spec.
        modality: How the box was shown.
        p: Flip probability, [0, 1].
        success: Solved trials of those that ended as solved or out of budget.
        errors: Trials that ended as error, by boundary; in no other number.
        curve: Cumulative success by step.
        behaviour: Loops, redundancy, entropy.
        claims: Misinterpretations.
        points: One per repetition.
    """

    key: str
    agent: str
    modality: str
    p: float
    success: Proportion
    errors: Mapping[str, int]
    curve: SuccessCurve
    behaviour: Behaviour
    claims: Misinterpretations
    points: tuple[Point, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Contrast:
    """The condition with the fewest flips against the one whose success lies farthest from it.

    Attributes:
        baseline: The lower p.
        other: The p whose success differs most.
        difference: Success at ``other`` minus success at ``baseline``, its interval corrected for the choice.
        choices: Number of conditions that ``other`` was chosen from.
        p_adjusted: Fisher's p-value times ``choices`` (Bonferroni), at most 1.
    """

    baseline: ConditionSummary
    other: ConditionSummary
    difference: Difference
    choices: int
    p_adjusted: float

    @property
    def detectable(self) -> bool:
        """Whether the difference is more than chance and the choice of the best would explain."""
        return self.p_adjusted < ALPHA


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentSummary:
    """One agent over all p.

    Attributes:
        agent: Agent spec.
        modality: How the box was shown.
        reference: Whether it is there to be compared with.
        blind: Whether its trials are the same at every p, so that its conditions are copies of each other.
        conditions: By p, ascending.
        success_fit: Trend of success over p (Fig. 4).
        loop_fit: Trend of the loop rate over p (Fig. 5b).
        correlation: Loop rate against success (Fig. 5a).
        contrast: Success at the lowest p against the p farthest from it; None with one p, or if blind.
    """

    agent: str
    modality: str
    reference: bool
    blind: bool
    conditions: tuple[ConditionSummary, ...]
    success_fit: TrendFit
    loop_fit: TrendFit
    correlation: Correlation
    contrast: Contrast | None

    @property
    def points(self) -> tuple[Point, ...]:
        """All repetitions of all its conditions."""
        return tuple(point for condition in self.conditions for point in condition.points)


@dataclass(frozen=True, slots=True, kw_only=True)
class StudySummary:
    """A whole study.

    Attributes:
        agents: In the order in which they first appear in the trials.
    """

    agents: tuple[AgentSummary, ...]

    @property
    def conditions(self) -> tuple[ConditionSummary, ...]:
        """All conditions of all agents."""
        return tuple(condition for agent in self.agents for condition in agent.conditions)

    @property
    def subjects(self) -> tuple[AgentSummary, ...]:
        """The agents that the study is about: those that are no reference, or all if all are."""
        return tuple(agent for agent in self.agents if not agent.reference) or self.agents


def summarise(trials: Sequence[Trial]) -> StudySummary:
    """All numbers of a study. The order of an agent's trials does not matter."""
    place = {name: i for i, name in enumerate(dict.fromkeys((trial.agent, trial.modality) for trial in trials))}

    def group(trial: Trial) -> tuple[int, float]:
        return place[trial.agent, trial.modality], trial.p

    ordered = sorted(trials, key=lambda trial: (*group(trial), trial.repetition, trial.trial))
    return StudySummary(
        agents=tuple(_agent(list(members)) for _, members in groupby(ordered, key=lambda trial: group(trial)[0]))
    )


def _condition(trials: Sequence[Trial]) -> ConditionSummary:
    first = trials[0]
    curve = success_curve(trials)
    return ConditionSummary(
        key=first.key.rsplit("/rep=", 1)[0],
        agent=first.agent,
        modality=first.modality,
        p=first.p,
        success=proportion(len(curve.solved_at), curve.n),
        errors=dict(sorted(Counter(trial.error.boundary for trial in trials if trial.error).items())),
        curve=curve,
        behaviour=behaviour(trials),
        claims=misinterpretations(trials),
        points=tuple(_point(list(members)) for _, members in groupby(trials, key=lambda trial: trial.repetition)),
    )


def _point(trials: Sequence[Trial]) -> Point:
    counted = ended(trials)
    return Point(
        p=trials[0].p,
        repetition=trials[0].repetition,
        n=len(counted),
        success=proportion(sum(trial.solved for trial in counted), len(counted)).value,
        loop_rate=proportion(sum(map(has_loop, counted)), len(counted)).value,
    )


def _agent(trials: Sequence[Trial]) -> AgentSummary:
    first = trials[0]
    conditions = tuple(_condition(list(members)) for _, members in groupby(trials, key=lambda trial: trial.p))
    blind = _is_blind(trials)
    distinct = conditions[:1] if blind else conditions
    points = [point for condition in distinct for point in condition.points if point.n]
    shown = {condition.p for condition in distinct}
    draws = resample(
        ended(trial for trial in trials if trial.p in shown),
        points,
        generator(first.seed, "analysis", first.agent, first.modality, "bootstrap"),
    )

    return AgentSummary(
        agent=first.agent,
        modality=first.modality,
        reference=first.agent.partition(":")[0] in _REFERENCES,
        blind=blind,
        conditions=conditions,
        success_fit=trend_fit(points, "success", draws.success),
        loop_fit=trend_fit(points, "loop_rate", draws.loop_rate),
        correlation=correlation(points, draws.loop_rate, draws.success),
        contrast=None if blind else _contrast(conditions),
    )


def _is_blind(trials: Sequence[Trial]) -> bool:
    """Whether the same repetition and trial went alike at every p, though it was told otherwise at least once."""
    acted: dict[tuple[int, int], set[tuple[str, ...]]] = {}
    told: dict[tuple[int, int], set[tuple[bool, ...]]] = {}
    for trial in ended(trials):
        luck = trial.repetition, trial.trial
        acted.setdefault(luck, set()).add(trial.actions)
        told.setdefault(luck, set()).add(tuple(step.told_moved for step in trial.steps))
    return all(len(ways) == 1 for ways in acted.values()) and any(len(ways) > 1 for ways in told.values())


def _contrast(conditions: Sequence[ConditionSummary]) -> Contrast | None:
    counted = [condition for condition in conditions if condition.success.n]
    if len(counted) < 2:
        return None
    baseline, *others = counted
    other = max(others, key=lambda condition: abs(condition.success.value - baseline.success.value))
    found = difference(baseline.success, other.success, choices=len(others))
    if found is None:
        return None
    return Contrast(
        baseline=baseline,
        other=other,
        difference=found,
        choices=len(others),
        p_adjusted=min(1.0, found.p_value * len(others)),
    )
