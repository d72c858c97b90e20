"""All results of a study: a summary per condition, trends and tests per agent, comparisons between agents."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from operator import call
from types import MappingProxyType
from typing import Any

from lockprobe.boxes.box import Lockbox
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.left_out import of_whom, section
from lockprobe.foundation.parallel import Each
from lockprobe.statistics.agent_comparison.pairs import AgentComparison, comparisons
from lockprobe.statistics.agent_summary import AgentSummary, agent_summary
from lockprobe.statistics.conditions.axis import FLIPS, Axis
from lockprobe.statistics.conditions.axis_trials import AxisTrials, Place, on_axis, on_flip_axis
from lockprobe.statistics.conditions.condition import ConditionSummary
from lockprobe.statistics.conditions.modality_effect import ModalityEffect, modality_effects
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.outcomes import heeded_at_most
from lockprobe.statistics.reference import Reference, reference_of
from lockprobe.statistics.sequential.order import NO_ORDERS, BlockOrder
from lockprobe.trial.record import Trial


@dataclass(frozen=True, slots=True, kw_only=True)
class StudySummary:
    """The results of a whole study.

    Attributes:
        agents: The results by agent, in the order of the trials.
        comparisons: Pairwise comparisons of the agents that the study is about, and of each with the baselines.
        reference: Success of random agents and the shortest plan on the box; None if the box is not known.
        modalities: The effect of the modality on every agent with several.
        axis: The dose in which conditions differ.
    """

    agents: tuple[AgentSummary, ...]
    comparisons: tuple[AgentComparison, ...]
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
        box: The box, for the reference curves.
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
    for members in by_agent if axis == FLIPS else ():
        for trial, dose in zip(members.trials, members.doses, strict=True):
            if not 0 <= dose <= 1:
                raise BadValue(f"{axis.name} of {trial.key}", dose, "a number from 0 to 1")
    reference = section(
        "Curves of random agents and of the shortest plan",
        lambda: reference_of(box, max((trial.budget for trial in trials), default=0)) if box else None,
        lambda: None,
    )
    shown = Counter(members.agent for members in by_agent)
    several = {agent for agent, count in shown.items() if one_of_several or count > 1}
    compared, *found = _longest_first(each, _jobs(by_agent, axis, several, place, known), by_agent)
    agents = tuple[AgentSummary, ...](agent for agent in found if agent is not None)
    return StudySummary(
        agents=agents,
        comparisons=compared,
        reference=reference,
        modalities=section("Modalities", lambda: modality_effects(by_agent), tuple),
        axis=axis,
    )


def _longest_first(each: Each, jobs: Sequence[Callable[[], Any]], by_agent: Sequence[AxisTrials]) -> list[Any]:
    """All comparisons and every agent, in their order; agents with many steps begin first, so that all end together."""
    steps = [sum(len(trial.steps) for trial in members.trials) for members in by_agent]
    order = [0, *sorted(range(1, len(jobs)), key=lambda job: -steps[job - 1])]
    done = dict(zip(order, each(call, [jobs[job] for job in order]), strict=True))
    return [done[job] for job in range(len(jobs))]


def _jobs(
    by_agent: Sequence[AxisTrials],
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
            lambda: comparisons(by_agent),
            tuple,
        ),
        *(
            partial(
                _agent_if_possible,
                partial(
                    agent_summary,
                    members,
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


def _judged_together(by_agent: Sequence[AxisTrials], heeded: Sequence[float | None]) -> list[int]:
    """The size of each agent's family: agents that heed reports and have trials at two doses or more.

    In each modality the agents that the study is about are one family, since one sentence names those of them that
    change; baselines are another.
    """
    heeding = [
        share is None and len(members.finished_doses) > 1 for members, share in zip(by_agent, heeded, strict=True)
    ]
    families = [(members.modality, is_baseline(members.spec)) for members in by_agent]
    sizes = Counter(family for family, counts in zip(families, heeding, strict=True) if counts)
    return [max(1, sizes[family]) for family in families]


def _agent_if_possible(make: Callable[[], AgentSummary], name: str) -> AgentSummary | None:
    """One agent; None if what no other number replaces cannot be computed."""
    with of_whom(name):
        return section("All numbers", make, lambda: None)
