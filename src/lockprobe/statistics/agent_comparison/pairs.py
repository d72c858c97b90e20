"""Pairwise comparisons of agents, and bounds for broken trials.

A trial that broke for one agent is dropped together with its pair. If an agent's long trials break, the remaining ones
overstate its success. So such comparisons hold at both ends: with the broken trials of the one agent solved in the step
in which they broke and those of the other unsolved, and the reverse (:mod:`lockprobe.statistics.broken_trials`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations, product

import numpy as np

from lockprobe.foundation.seeds import generator
from lockprobe.statistics.agent_comparison.interaction import Interaction
from lockprobe.statistics.agent_comparison.pair import AgentComparison, Among, compare, corrected
from lockprobe.statistics.agent_comparison.paired import Sheet, sheets
from lockprobe.statistics.broken_trials import bounded, completed
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
    """All pairs without correction for their number."""
    ended = _sheets_by_name(entrants, [one.counted for one in entrants])
    broken = [one.broken.at(np.isin(one.broken.dose, ended[0])) for one in entrants]
    failed, solved = (
        _sheets_by_name(
            entrants,
            [completed(one.counted, own, soon, one.budget) for one, own in zip(entrants, broken, strict=True)],
        )
        for soon in (False, True)
    )
    found = []
    for first, second, among in pairs:
        of_pair = partial(_compared, first, second, among, seed, of)
        if (one := of_pair(ended, ended)) is None:
            continue
        if len(first.broken) or len(second.broken):
            one = _bounded(one, of_pair(solved, failed), of_pair(failed, solved))
        found.append(one)
    return found


_Sheets = tuple[tuple[float, ...], dict[tuple[str, str], Sheet]]
"""The values of p, and the sheet of each agent by its name."""


def _compared(
    first: Entrant, second: Entrant, among: Among, seed: int, of: Sequence[str], ones: _Sheets, others: _Sheets
) -> AgentComparison | None:
    """Two agents, the first with its sheet of ``ones``, the second with that of ``others``.

    In their interaction, the lowest p has the sheets the other way round: there success of the first agent counts for
    the change, and that of the second against it.
    """
    rng = generator(seed, "analysis", *_stream(first), *_stream(second), "comparison", *of)
    (values, _), laid = ones, (ones[1][first.name], others[1][second.name])
    lowest = others[1][first.name], ones[1][second.name]
    names, budget = (first.name, second.name), max(first.budget, second.budget)
    return compare(names, values, laid, among, rng, budget=budget, lowest=lowest)


def _stream(one: Entrant) -> tuple[str, str]:
    return one.spec, one.modality


def _sheets_by_name(entrants: Sequence[Entrant], groups: list[Outcomes]) -> _Sheets:
    values, laid = sheets(groups)
    return values, {one.name: found for one, found in zip(entrants, laid, strict=True)}


def _bounded(found: AgentComparison, low: AgentComparison | None, high: AgentComparison | None) -> AgentComparison:
    """The comparison over the trials that both finished, with what holds at both ends."""
    assert low is not None
    assert high is not None
    at = [{one.dose: one for one in end.at} for end in (low, high)]
    return replace(
        found,
        success=bounded(found.success, low.success, high.success),
        steps=bounded(found.steps, low.steps, high.steps),
        at=tuple(
            replace(
                one,
                success=bounded(one.success, *(end[one.dose].success for end in at)),
                steps=bounded(one.steps, *(end[one.dose].steps for end in at)),
            )
            for one in found.at
        ),
        interaction=_bounded_interaction(found.interaction, low.interaction, high.interaction),
        bounded=True,
    )


def _bounded_interaction(
    found: Interaction | None, low: Interaction | None, high: Interaction | None
) -> Interaction | None:
    if found is None or low is None or high is None:
        return None
    ends = [{one.dose: one for one in end.at} for end in (low, high)]
    at = tuple(
        replace(
            one,
            change=bounded(one.change, *(end[one.dose].change for end in ends)),
            p_adjusted=max(end[one.dose].p_adjusted for end in ends)
            if len({np.sign(other.change.value) for other in (one, *(end[one.dose] for end in ends))}) == 1
            else 1.0,
        )
        for one in found.at
    )
    mean = bounded(found.mean, low.mean, high.mean)
    return replace(found, at=at, mean=mean, p_value=min(one.p_adjusted for one in at))
