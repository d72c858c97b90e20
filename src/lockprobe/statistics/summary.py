"""All results of a study: a summary per condition, trends and tests per agent, comparisons between agents."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations
from operator import call
from types import MappingProxyType
from typing import Any, TypedDict

import numpy as np

from lockprobe.boxes.box import Lockbox
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.left_out import of_whom, section
from lockprobe.foundation.parallel import Each
from lockprobe.foundation.seeds import generator
from lockprobe.foundation.spec import PEOPLE, spec_kind
from lockprobe.statistics.agent_comparison.leaderboard import Entrant, comparisons, ranked
from lockprobe.statistics.agent_comparison.leaderboard_row import Standing, standing
from lockprobe.statistics.agent_comparison.pair import AgentComparison
from lockprobe.statistics.behaviour import heeded_at_most
from lockprobe.statistics.conditions.axis import FLIPS, Axis
from lockprobe.statistics.conditions.axis_trials import AxisTrials, Place, on_axis, on_flip_axis
from lockprobe.statistics.conditions.condition import ConditionSummary, Contrast, condition_at, contrast
from lockprobe.statistics.conditions.modalities import ModalityEffect, modality_effect, spoken
from lockprobe.statistics.inference.association import Correlation, correlation
from lockprobe.statistics.inference.battery import Inference, infer
from lockprobe.statistics.inference.peak import Peak, peak
from lockprobe.statistics.inference.trend import TrendFit, trend_fit
from lockprobe.statistics.loops.habit_baseline import blind_twin
from lockprobe.statistics.outcomes import Point, outcomes
from lockprobe.statistics.pace import Pace, pace
from lockprobe.statistics.reference import Reference, reference_of
from lockprobe.statistics.resample import resample
from lockprobe.statistics.sequential.order import NO_ORDERS, BlockOrder
from lockprobe.trial.record import PLAIN_WORDS, Trial

__all__ = [
    "AgentSummary",
    "StudySummary",
    "check_trials",
    "entrant",
    "is_reference",
    "summarise",
]

_REFERENCES = ("random", "random-no-repeat", "round-robin", "human-inspired", "ideal-observer")
"""The kinds of agents that are baselines."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentSummary:
    """The results of one agent in one modality over all doses of one axis.

    Attributes:
        agent: Its name, or its spec if it has none.
        modality: How the box was shown.
        shown: The modality (unless it is the default and the only one) and ``axis.rest``, in words.
        reference: Whether it is a baseline.
        heeded: Upper 95 % bound of the share of reports that it acts on if it plays alike whatever it is told, or None.
        conditions: The results by dose, ascending. Those that never acted are in no fit, test or contrast.
        success_fit: Trend of success over p (Fig. 4).
        loop_fit: Trend of the loop rate over p (Fig. 5b).
        correlation: Loop rate against success (Fig. 5a).
        peak: The p of highest success, with its uncertainty.
        inference: The tests, recommended ones and the paper's.
        contrast: The lowest p against the p that differs most clearly; None with one p, or if blind.
        axis: The dose in which its conditions differ.
        spec: The spec of the agent; of several that differ in an option, without options.
    """

    agent: str
    modality: str
    shown: str
    reference: bool
    heeded: float | None
    conditions: tuple[ConditionSummary, ...]
    success_fit: TrendFit
    loop_fit: TrendFit
    correlation: Correlation
    peak: Peak
    inference: Inference
    contrast: Contrast | None
    axis: Axis = FLIPS
    spec: str = ""

    @property
    def name(self) -> str:
        """What tables call it, and ``shown`` in brackets."""
        return f"{self.agent} ({self.shown})" if self.shown else self.agent

    @property
    def idle(self) -> tuple[ConditionSummary, ...]:
        """Its conditions above the lowest dose under which nothing was changed, or no report was false."""
        return tuple(one for one in self.conditions[1:] if one.never_acted)

    @property
    def blind(self) -> bool:
        """Whether it plays alike whatever it is told, so that its conditions are copies of each other."""
        return self.heeded is not None

    @property
    def invited(self) -> bool:
        """Whether it is people, who are invited rather than run; their trials are clustered by person."""
        return self.agent == PEOPLE

    @property
    def points(self) -> tuple[Point, ...]:
        """All repetitions of all its conditions."""
        return tuple(point for condition in self.conditions for point in condition.points)


@dataclass(frozen=True, slots=True, kw_only=True)
class StudySummary:
    """The results of a whole study.

    Attributes:
        agents: The results by agent, in the order of the trials.
        paces: The speed of every two agents at their common lowest p.
        comparisons: Pairwise comparisons of the agents that the study is about, and of each with the baselines.
        standings: Every agent over all p, the highest success first.
        reference: Success of random agents and the shortest plan on the box; None if the box is not known.
        modalities: The effect of the modality on every agent with several.
        axis: The dose in which conditions differ.
    """

    agents: tuple[AgentSummary, ...]
    paces: tuple[Pace, ...]
    comparisons: tuple[AgentComparison, ...]
    standings: tuple[Standing, ...]
    reference: Reference | None
    modalities: tuple[ModalityEffect, ...]
    axis: Axis = FLIPS

    @property
    def conditions(self) -> tuple[ConditionSummary, ...]:
        """All conditions of all agents."""
        return tuple(condition for agent in self.agents for condition in agent.conditions)

    @property
    def subjects(self) -> tuple[AgentSummary, ...]:
        """The agents that the study is about: all except baselines, or all if all are baselines."""
        return tuple(agent for agent in self.agents if not agent.reference) or self.agents

    @property
    def judged(self) -> tuple[AgentSummary, ...]:
        """Those of them that have an ended trial; all agents that have one if none of them has."""
        ended = [agent for agent in self.agents if any(one.success.n for one in agent.conditions)]
        return tuple(agent for agent in ended if agent in self.subjects) or tuple(ended)


def summarise(
    trials: Sequence[Trial],
    box: Lockbox | None = None,
    *,
    each: Each = map,
    axis: Axis = FLIPS,
    place: Callable[[Trial], Place] = on_flip_axis,
    one_of_several: bool = False,
    orders: Mapping[str, BlockOrder] = NO_ORDERS,
    known: Mapping[tuple[str, str], ConditionSummary] = MappingProxyType({}),
) -> StudySummary:
    """Compute all results over one axis. The order of an agent's trials does not matter.

    Args:
        trials: Trials of one box; those that ended as ``error`` are counted separately.
        box: The box, for the reference curves and the habit baseline.
        each: A map function over agents, sequential or parallel.
        axis: The dose in which conditions differ.
        place: The place of a trial on the axis.
        one_of_several: Whether the study has the axis in several modalities, so that agents are named with theirs.
        orders: Agent -> the order of its blocks, of agents of which everything must hold at every look.
        known: Results of agents under conditions that were computed before, of the same trials.

    Raises:
        BadValue: If the trials are of several boxes, or a flip rate is no probability.
    """
    by_agent = on_axis(trials, place, orders)
    check_trials(trials, box)
    _check_doses(by_agent, axis)
    reference = section(
        "Curves of random agents and of the shortest plan",
        lambda: reference_of(box, max((trial.budget for trial in trials), default=0)) if box else None,
        lambda: None,
    )
    shown = Counter(members.agent for members in by_agent)
    several = {agent for agent, count in shown.items() if one_of_several or count > 1}
    jobs = _jobs(by_agent, reference, box, axis, several, place, known)
    compared, *found = each(call, jobs)
    made = [(members, agent) for members, agent in zip(by_agent, found, strict=True) if agent is not None]
    agents = tuple[AgentSummary, ...](agent for _, agent in made)
    standings = section(
        "Leaderboard",
        lambda: ranked([standing(members, agent.conditions, reference) for members, agent in made], compared),
        tuple[Standing, ...],
    )
    return StudySummary(
        agents=agents,
        paces=section("Speed of every two agents", lambda: _paces(by_agent), tuple),
        comparisons=compared,
        standings=standings,
        reference=reference,
        modalities=section("Modalities", lambda: _modalities(by_agent), tuple),
        axis=axis,
    )


def _jobs(
    by_agent: Sequence[AxisTrials],
    reference: Reference | None,
    box: Lockbox | None,
    axis: Axis,
    several: Collection[str],
    place: Callable[[Trial], Place],
    known: Mapping[tuple[str, str], ConditionSummary],
) -> list[Callable[[], Any]]:
    """The work of a summary: all comparisons first, then each agent."""
    heeded = [heeded_at_most(members.trials) for members in by_agent]
    family = _judged_together(by_agent, heeded)
    return [
        lambda: section(
            "Agents compared",
            lambda: comparisons([entrant(members) for members in by_agent], by_agent[0].seed if by_agent else 0),
            tuple,
        ),
        *(
            partial(
                _agent_if_possible,
                partial(
                    _agent,
                    members,
                    reference,
                    box,
                    axis,
                    place,
                    {name: one for name, one in known.items() if name in names},
                    several=members.agent in several,
                    heeded=share,
                    agents=n,
                ),
                members.agent,
            )
            for members, share, n in zip(by_agent, heeded, family, strict=True)
            for names in [members.names]
        ),
    ]


def check_trials(trials: Sequence[Trial], box: Lockbox | None = None) -> None:
    """Refuse trials that cannot be analysed together.

    Raises:
        BadValue: If the trials are of several boxes.
    """
    boxes = sorted({trial.box for trial in trials} | ({box.name} if box else set()))
    if len(boxes) > 1:
        raise BadValue("trials to analyse together", f"boxes {', '.join(boxes)}", "trials of one box")


def _check_doses(by_agent: Sequence[AxisTrials], axis: Axis) -> None:
    for members in by_agent:
        for trial, dose in zip(members.trials, members.doses, strict=True):
            if axis == FLIPS and not 0 <= dose <= 1:
                raise BadValue(f"{axis.name} of {trial.key}", dose, "a number from 0 to 1")


def _judged_together(by_agent: Sequence[AxisTrials], heeded: Sequence[float | None]) -> list[int]:
    """The size of each agent's family: agents that heed reports and have trials at two doses or more.

    In each modality the agents that the study is about are one family, since one sentence names those of them that
    change; baselines are another.
    """
    heeding = [
        share is None and len(members.finished_doses) > 1 for members, share in zip(by_agent, heeded, strict=True)
    ]
    families = [(members.modality, members.kind in _REFERENCES) for members in by_agent]
    sizes = Counter(family for family, counts in zip(families, heeding, strict=True) if counts)
    return [max(1, sizes[family]) for family in families]


def entrant(trials: AxisTrials) -> Entrant:
    """One agent, to be compared with others."""
    return Entrant(
        agent=trials.agent,
        spec=trials.spec,
        modality=trials.modality,
        counted=trials.outcomes,
        broken=trials.broken_off,
        budget=trials.budget,
        head=trials.kind,
        reference=trials.kind in _REFERENCES,
    )


def is_reference(agent: str) -> bool:
    """Whether the agent of a spec is a baseline."""
    return spec_kind(agent) in _REFERENCES


def _paces(by_agent: Sequence[AxisTrials]) -> tuple[Pace, ...]:
    """The paces of every two agents with the same lowest p."""
    lowest = [members.lowest for members in by_agent]
    found = [pace(first, second) for first, second in combinations(lowest, 2) if first.doses[0] == second.doses[0]]
    return tuple(compared for compared in found if compared)


def _modalities(by_agent: Sequence[AxisTrials]) -> tuple[ModalityEffect, ...]:
    """The modality effect of every agent with several modalities, at the lowest p.

    The agents that the study is about are one family, and baselines another.
    """
    lowest = [members.lowest for members in by_agent]
    least = min((members.doses[0] for members in lowest), default=0.0)
    named = grouped((members for members in lowest if members.doses[0] == least), lambda members: members.agent)
    groups = [[members.trials for members in own] for own in named.values()]
    baseline = [is_reference(group[0][0].spec) for group in groups if modality_effect(group)]
    return tuple(
        effect
        for group in groups
        if (effect := modality_effect(group, max(1, baseline.count(is_reference(group[0][0].spec)))))
    )


def _agent_if_possible(make: Callable[[], AgentSummary], name: str) -> AgentSummary | None:
    """One agent; None if what no other number replaces cannot be computed."""
    with of_whom(name):
        return section("All numbers", make, lambda: None)


def _agent(
    trials: AxisTrials,
    reference: Reference | None,
    box: Lockbox | None,
    axis: Axis,
    place: Callable[[Trial], Place],
    known: Mapping[tuple[str, str], ConditionSummary],
    *,
    several: bool,
    heeded: float | None,
    agents: int,
) -> AgentSummary:
    """One agent in one modality; ``several`` if other trials of it have another, ``agents`` are judged together."""
    conditions = tuple(
        condition_at(members, reference, box, place, known, trials.order) for _, members in trials.by_dose()
    )
    acting = (conditions[0], *(one for one in conditions[1:] if not one.never_acted))
    distinct = acting if heeded is None else conditions[:1]
    shares = [point for condition in distinct for point in condition.points]
    looked_at = trials.at({condition.dose for condition in distinct})
    inference = _tested(looked_at, box, conditions, trials.budget, agents)
    return AgentSummary(
        agent=trials.agent,
        spec=trials.spec,
        modality=trials.modality,
        shown=", ".join(filter(None, (_shown(trials.modality, several=several), axis.rest))),
        reference=trials.kind in _REFERENCES,
        heeded=heeded,
        conditions=conditions,
        **_fits(shares, looked_at),
        inference=inference,
        contrast=section(
            "Clearest difference",
            lambda: contrast(conditions, inference.difference) if heeded is None else None,
            lambda: None,
        ),
        axis=axis,
    )


def _tested(
    trials: AxisTrials,
    box: Lockbox | None,
    conditions: Sequence[ConditionSummary],
    budget: int,
    agents: int,
) -> Inference:
    """The tests of one agent's trials; without a result if they cannot be made."""
    twin = section(
        "Blind agent with the same habits",
        lambda: blind_twin(trials.trials, box, _stream(trials, "blind"), trials.doses),
        lambda: None,
    )
    return section(
        "Hypothesis tests",
        lambda: infer(
            trials.outcomes,
            _stream(trials, "permutation"),
            broken=trials.broken_off,
            blind=twin,
            persistence=conditions[0].persistence,
            budget=budget,
            agents=agents,
        ),
        lambda: infer(outcomes(()), _stream(trials, "permutation"), agents=agents),
    )


class _Fits(TypedDict):
    """The curves over the dose, as fields of :class:`AgentSummary`."""

    success_fit: TrendFit
    loop_fit: TrendFit
    correlation: Correlation
    peak: Peak


def _fits(shares: Sequence[Point], trials: AxisTrials) -> _Fits:
    """The curves over the dose; those that cannot be fitted are fits of no trials."""
    counted, none, empty = trials.outcomes, outcomes(()), np.empty((0, 0))
    draws = section(
        "Bootstrap of the trend",
        lambda: resample(counted, _stream(trials, "bootstrap")),
        lambda: resample(none, _stream(trials, "bootstrap")),
    )
    return _Fits(
        success_fit=section(
            "Trend of success",
            lambda: trend_fit(shares, "success", draws.success),
            lambda: trend_fit((), "success", empty),
        ),
        loop_fit=section(
            "Trend of loops",
            lambda: trend_fit(shares, "loop_rate", draws.loop_rate),
            lambda: trend_fit((), "loop_rate", empty),
        ),
        correlation=section(
            "Correlation of loops and success",
            lambda: correlation(shares, draws.loop_rate, draws.success),
            lambda: correlation((), empty, empty),
        ),
        peak=section(
            "Best flip rate",
            lambda: peak(counted, _stream(trials, "peak")),
            lambda: peak(none, _stream(trials, "peak")),
        ),
    )


def _shown(modality: str, *, several: bool) -> str:
    return spoken(modality) if several or modality not in PLAIN_WORDS else ""


def _stream(trials: AxisTrials, use: str) -> np.random.Generator:
    return generator(trials.seed, "analysis", trials.spec, trials.modality, use)
