"""A study in numbers: one row per condition, trends and tests per agent."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, groupby

import numpy as np

from lockprobe.analysis.behaviour import Behaviour, behaviour
from lockprobe.analysis.curves import Relative, SuccessCurve, relative, success_curve
from lockprobe.analysis.inference.association import Correlation, correlation
from lockprobe.analysis.inference.battery import Inference, infer
from lockprobe.analysis.inference.peak import AnyDifference, Peak, peak
from lockprobe.analysis.inference.trend import TrendFit, trend_fit
from lockprobe.analysis.misinterpretation import Misinterpretations, misinterpretations
from lockprobe.analysis.outcomes import Outcomes, Point, ended, outcomes, points
from lockprobe.analysis.pace import Pace, pace
from lockprobe.analysis.proportions import ALPHA, Difference, Paired, Proportion, difference, paired, proportion
from lockprobe.analysis.rationality import Rationality, rationality
from lockprobe.analysis.reference import Reference, reference_of
from lockprobe.analysis.resample import resample
from lockprobe.errors import BadValue
from lockprobe.lockbox.box import Lockbox
from lockprobe.record import Trial
from lockprobe.seeds import generator

__all__ = [
    "AgentSummary",
    "ConditionSummary",
    "Contrast",
    "StudySummary",
    "summarise",
]

_REFERENCES = ("random", "random-no-repeat", "round-robin", "human-inspired", "ideal-observer")
"""Agents that stand in a study to be compared with, by the head of their spec."""


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
        curve: Success by step.
        relative: The same between a random agent and the optimum; None where the box is not known.
        behaviour: Loops, redundancy, entropy.
        claims: Misinterpretations.
        rationality: Its actions before two ideal observers; empty where the box is too large for a prior.
        points: One per repetition.
    """

    key: str
    agent: str
    modality: str
    p: float
    success: Proportion
    errors: Mapping[str, int]
    curve: SuccessCurve
    relative: Relative | None
    behaviour: Behaviour
    claims: Misinterpretations
    rationality: tuple[Rationality, ...]
    points: tuple[Point, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Contrast:
    """The condition with the fewest flips against the one whose success lies farthest from it.

    Attributes:
        baseline: The lower p.
        other: The p whose success differs most.
        difference: Success at ``other`` minus success at ``baseline``, taken as independent.
        paired: The same over trials that both have, which share their luck; intervals are corrected for the choice.
        choices: Number of conditions that ``other`` was chosen from.
        p_adjusted: Permutation within trials that share their luck, corrected for the choice.
    """

    baseline: ConditionSummary
    other: ConditionSummary
    difference: Difference
    paired: Paired
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
        peak: Where success is highest, and how sure that is.
        inference: The tests, the valid ones and the paper's.
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
    peak: Peak
    inference: Inference
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
        paces: Every two agents at their common lowest p: who is faster.
        reference: What blind agents and the shortest plan reach on the box; None where the box is not known.
    """

    agents: tuple[AgentSummary, ...]
    paces: tuple[Pace, ...]
    reference: Reference | None

    @property
    def conditions(self) -> tuple[ConditionSummary, ...]:
        """All conditions of all agents."""
        return tuple(condition for agent in self.agents for condition in agent.conditions)

    @property
    def subjects(self) -> tuple[AgentSummary, ...]:
        """The agents that the study is about: those that are no reference, or all if all are."""
        return tuple(agent for agent in self.agents if not agent.reference) or self.agents


def summarise(trials: Sequence[Trial], box: Lockbox | None = None) -> StudySummary:
    """All numbers of a study. The order of an agent's trials does not matter.

    Args:
        trials: Of one box; those that ended as ``error`` are counted apart.
        box: The box, for what blind agents and the optimum reach on it.

    Raises:
        BadValue: If the trials are of several boxes.
    """
    boxes = sorted({trial.box for trial in trials} | ({box.name} if box else set()))
    if len(boxes) > 1:
        raise BadValue("trials to analyse together", f"boxes {', '.join(boxes)}", "trials of one box")
    for trial in trials:
        if not 0 <= trial.p <= 1:
            raise BadValue(f"p of {trial.key}", trial.p, "a number from 0 to 1")
    place = {name: i for i, name in enumerate(dict.fromkeys((trial.agent, trial.modality) for trial in trials))}

    def group(trial: Trial) -> tuple[int, float]:
        return place[trial.agent, trial.modality], trial.p

    reference = reference_of(box, max((trial.budget for trial in trials), default=0)) if box else None
    ordered = sorted(trials, key=lambda trial: (*group(trial), trial.repetition, trial.trial))
    by_agent = [list(members) for _, members in groupby(ordered, key=lambda trial: group(trial)[0])]
    return StudySummary(
        agents=tuple(_agent(members, reference) for members in by_agent), paces=_paces(by_agent), reference=reference
    )


def _paces(by_agent: Sequence[Sequence[Trial]]) -> tuple[Pace, ...]:
    """Every two agents that share their lowest p."""
    lowest = [[trial for trial in members if trial.p == members[0].p] for members in by_agent]
    found = [pace(first, second) for first, second in combinations(lowest, 2) if first[0].p == second[0].p]
    return tuple(compared for compared in found if compared)


def _condition(trials: Sequence[Trial], reference: Reference | None) -> ConditionSummary:
    first = trials[0]
    curve = success_curve(trials)
    budget = len(curve.share)
    return ConditionSummary(
        key=first.condition,
        agent=first.agent,
        modality=first.modality,
        p=first.p,
        success=proportion(len(curve.solved_at), curve.n),
        errors=dict(sorted(Counter(trial.error.boundary for trial in trials if trial.error).items())),
        curve=curve,
        relative=relative(curve, reference.random[:budget], reference.optimum) if reference else None,
        behaviour=behaviour(trials),
        claims=misinterpretations(trials),
        rationality=rationality(trials),
        points=tuple(points(outcomes(trials))),
    )


def _agent(trials: Sequence[Trial], reference: Reference | None) -> AgentSummary:
    first = trials[0]
    conditions = tuple(
        _condition(list(members), reference) for _, members in groupby(trials, key=lambda trial: trial.p)
    )
    blind = _is_blind(trials)
    distinct = conditions[:1] if blind else conditions
    shares = [point for condition in distinct for point in condition.points]
    shown = {condition.p for condition in distinct}
    counted = outcomes([trial for trial in trials if trial.p in shown])
    draws = resample(counted, _stream(first, "bootstrap"))
    inference = infer(counted, _stream(first, "permutation"))
    return AgentSummary(
        agent=first.agent,
        modality=first.modality,
        reference=re.split("[:?]", first.agent)[0] in _REFERENCES,
        blind=blind,
        conditions=conditions,
        success_fit=trend_fit(shares, "success", draws.success),
        loop_fit=trend_fit(shares, "loop_rate", draws.loop_rate),
        correlation=correlation(shares, draws.loop_rate, draws.success),
        peak=peak(counted, _stream(first, "peak")),
        inference=inference,
        contrast=None if blind else _contrast(conditions, counted, inference.difference),
    )


def _stream(first: Trial, use: str) -> np.random.Generator:
    return generator(first.seed, "analysis", first.agent, first.modality, use)


def _is_blind(trials: Sequence[Trial]) -> bool:
    """Whether the same repetition and trial went alike at every p, though it was told otherwise at least once."""
    acted: dict[tuple[int, int], set[tuple[str, ...]]] = {}
    told: dict[tuple[int, int], set[tuple[bool, ...]]] = {}
    for trial in ended(trials):
        luck = trial.repetition, trial.trial
        acted.setdefault(luck, set()).add(trial.actions)
        told.setdefault(luck, set()).add(tuple(step.told_moved for step in trial.steps))
    return all(len(ways) == 1 for ways in acted.values()) and any(len(ways) > 1 for ways in told.values())


def _contrast(conditions: Sequence[ConditionSummary], counted: Outcomes, tested: AnyDifference) -> Contrast | None:
    played = [condition for condition in conditions if condition.success.n]
    if len(played) < 2:
        return None
    baseline, *others = played
    other = max(others, key=lambda condition: abs(condition.success.value - baseline.success.value))
    found = difference(baseline.success, other.success, choices=len(others))
    adjusted = next((at.p_value for at in tested.at if at.p == other.p), None)
    if found is None or adjusted is None:
        return None
    first, second = (_by_luck(counted, condition.p) for condition in (baseline, other))
    both = sorted(first.keys() & second.keys())
    pairs = np.array([[first[luck], second[luck]] for luck in both], dtype=np.bool_).reshape(-1, 2)
    return Contrast(
        baseline=baseline,
        other=other,
        difference=found,
        paired=paired(pairs[:, 0], pairs[:, 1], choices=len(others)),
        choices=len(others),
        p_adjusted=adjusted,
    )


def _by_luck(counted: Outcomes, p: float) -> dict[tuple[int, int], bool]:
    """Whether each trial was solved at one p, by repetition and trial."""
    here = counted.at(counted.p == p)
    return dict(zip(zip(here.repetition.tolist(), here.trial.tolist(), strict=True), here.solved.tolist(), strict=True))
