"""Pairwise comparisons of agents, and bounds for broken trials.

A trial that broke for one agent is dropped together with its pair. If an agent's long trials break, the remaining ones
overstate its success. So such comparisons are made three times: without the broken trials, with all of them unsolved,
and with all of them solved at the next step (between conditions: :mod:`lockprobe.statistics.inference.broken_trials`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product

import numpy as np

from lockprobe.foundation.seeds import generator
from lockprobe.statistics.agent_comparison.interaction import Interaction
from lockprobe.statistics.agent_comparison.pair import AgentComparison, Among, ComparisonAt, compare, corrected
from lockprobe.statistics.agent_comparison.paired import BlockMean, Sheet, sheets
from lockprobe.statistics.inference.broken_trials import completed
from lockprobe.statistics.outcomes import Outcomes

BASELINES = ("human-inspired", "random")
"""References that every agent is compared with, if they were played: by the head of their spec."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Entrant:
    """One agent to compare.

    Attributes:
        agent: What tables call it.
        spec: Agent spec, which names its random streams.
        modality: How the box was shown.
        head: The agent spec without options.
        reference: Whether it is a baseline, which others are compared with.
        counted: Its ended trials.
        broken: Its trials that ended as error.
        budget: Steps of a trial.
    """

    agent: str
    spec: str
    modality: str
    head: str
    reference: bool
    counted: Outcomes
    broken: Outcomes
    budget: int

    @property
    def name(self) -> tuple[str, str]:
        """Agent and modality, as tables call them."""
        return self.agent, self.modality


def comparisons(entrants: Sequence[Entrant], seed: int, of: Sequence[str] = ()) -> tuple[AgentComparison, ...]:
    """Compare every two agents that the study is about, and each of them with the baselines.

    Two agents are compared if they saw the boxes in the same modality. Baselines read reports and are compared with
    all.

    Args:
        entrants: The agents, in the order of the study.
        seed: That of the study.
        of: Specs of the condition under which they are compared, which name random streams; empty over flip rates.
    """
    subjects = [one for one in entrants if not one.reference] or list(entrants)
    pairs: list[tuple[Entrant, Entrant, Among]] = [
        (second, first, "subjects")
        for first, second in combinations(subjects, 2)
        if first.modality == second.modality and first.agent != second.agent
    ]
    names = {one.name for one in subjects}
    baselines = [one for one in entrants if one.name not in names and one.head in BASELINES]
    pairs += [(baseline, subject, "reference") for subject, baseline in product(subjects, baselines)]
    return corrected(_uncorrected(pairs, entrants, seed, of))


def _uncorrected(
    pairs: Sequence[tuple[Entrant, Entrant, Among]], entrants: Sequence[Entrant], seed: int, of: Sequence[str]
) -> list[AgentComparison]:
    """All pairs without correction for their number; pairs with broken trials get worst-case P values."""
    ends = [both_ends(one.counted, one.broken, one.budget) for one in entrants]
    three = [
        _sheets_by_name(entrants, groups)
        for groups in ([one.counted for one in entrants], *map(list, zip(*ends, strict=True)))
    ]
    found = []
    for first, second, among in pairs:
        bounded = len(first.broken) or len(second.broken)
        made = [
            compare(
                (first.name, second.name),
                values,
                (sheet[first.name], sheet[second.name]),
                among,
                generator(seed, "analysis", *_stream(first), *_stream(second), "comparison", *of),
                budget=max(first.budget, second.budget),
            )
            for values, sheet in (three if bounded else three[:1])
        ]
        if (one := made[0]) is None:
            continue
        found.append(worst_case(one, (made[1], made[2])) if bounded and made[1] and made[2] else one)
    return found


def _stream(one: Entrant) -> tuple[str, str]:
    return one.spec, one.modality


def _sheets_by_name(
    entrants: Sequence[Entrant], groups: list[Outcomes]
) -> tuple[tuple[float, ...], dict[tuple[str, str], Sheet]]:
    values, laid = sheets(groups)
    return values, {one.name: found for one, found in zip(entrants, laid, strict=True)}


def both_ends(counted: Outcomes, broken: Outcomes, budget: int) -> tuple[Outcomes, Outcomes]:
    """All trials of an agent, twice: broken ones as unsolved with the whole budget, and as solved one step later."""
    unsolved, solved = completed(counted, broken)
    beyond = np.arange(len(unsolved)) >= len(counted)
    return replace(unsolved, length=np.where(beyond, budget, unsolved.length)), solved


def worst_case(found: AgentComparison, ends: tuple[AgentComparison, AgentComparison]) -> AgentComparison:
    """The comparison without the broken trials, with the largest P value of all three cases (Manski bounds).

    Args:
        found: The comparison over the trials that both agents finished.
        ends: The same with all broken trials unsolved, and with all solved.
    """
    return replace(
        found,
        success=_worst_case_mean(found.success, *(end.success for end in ends)),
        steps=_worst_case_mean(found.steps, *(end.steps for end in ends)),
        at=tuple(_worst_case_at(one, [{at.dose: at for at in end.at}[one.dose] for end in ends]) for one in found.at),
        interaction=_worst_case_interaction(found.interaction, *(end.interaction for end in ends)),
        bounded=True,
    )


def _worst_case_mean(*three: BlockMean) -> BlockMean:
    """The first mean with the largest P value; 1 if signs differ, or an interval holds 0 where the first does not."""
    values = [one.p_value for one in three if one.p_value is not None]
    if len(values) < len(three):
        return replace(three[0], p_value=None)
    holds = len({np.sign(one.value) for one in three}) == 1 and all(one.clear >= three[0].clear for one in three)
    return replace(three[0], p_value=max(values) if holds else 1.0)


def _worst_case_at(found: ComparisonAt, ends: list[ComparisonAt]) -> ComparisonAt:
    three = [found, *ends]
    alike = len({np.sign(one.success.value) for one in three}) == 1
    success = replace(found.success, p_value=max(one.success.p_value for one in three) if alike else 1.0)
    return replace(found, success=success, steps=_worst_case_mean(*(one.steps for one in three)))


def _worst_case_interaction(found: Interaction | None, *ends: Interaction | None) -> Interaction | None:
    if found is None:
        return None
    three = [found, *(end for end in ends if end is not None)]
    signs = {np.sign(at.change.value) for one in three for at in one.at if at.dose == found.clearest.dose}
    return replace(found, p_value=max(one.p_value for one in three) if len(three) == 3 and len(signs) == 1 else 1.0)
