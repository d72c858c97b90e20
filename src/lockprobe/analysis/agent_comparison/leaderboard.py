"""Every agent beside every other: which pairs are compared, and who stands where."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product

from lockprobe.analysis.agent_comparison.broken_trials import agreed, both_ends
from lockprobe.analysis.agent_comparison.leaderboard_row import Standing
from lockprobe.analysis.agent_comparison.pair import Among, Comparison, compare, corrected
from lockprobe.analysis.agent_comparison.paired import Sheet, sheets
from lockprobe.analysis.outcomes import Outcomes
from lockprobe.seeds import generator

__all__ = ["Entrant", "comparisons", "ranked"]

BASELINES = ("human-inspired", "random")
"""References that every agent is compared with, if they were played: by the head of their spec."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Entrant:
    """One agent that is to be compared.

    Attributes:
        agent: Agent spec.
        modality: How the box was shown.
        head: Its spec without options.
        reference: Whether it is there to be compared with.
        counted: Its ended trials.
        broken: Its trials that ended as error.
        budget: Steps of a trial.
    """

    agent: str
    modality: str
    head: str
    reference: bool
    counted: Outcomes
    broken: Outcomes
    budget: int

    @property
    def name(self) -> tuple[str, str]:
        """Agent spec and modality."""
        return self.agent, self.modality


def comparisons(entrants: Sequence[Entrant], seed: int) -> tuple[Comparison, ...]:
    """Every two agents that the study is about, and each of them with the baselines.

    Where boxes are shown in several ways, two agents are compared that saw them alike; baselines, which read reports,
    with all.

    Args:
        entrants: All agents, in the order of the study.
        seed: Seed of the study.
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
    return corrected(_compared(pairs, entrants, seed))


def _compared(
    pairs: Sequence[tuple[Entrant, Entrant, Among]], entrants: Sequence[Entrant], seed: int
) -> list[Comparison]:
    """All pairs, without corrections; those with broken trials as far as they hold whatever became of these."""
    ends = [both_ends(one.counted, one.broken, one.budget) for one in entrants]
    three = [
        _laid(entrants, groups) for groups in ([one.counted for one in entrants], *map(list, zip(*ends, strict=True)))
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
                generator(seed, "analysis", *first.name, *second.name, "comparison"),
            )
            for values, sheet in (three if bounded else three[:1])
        ]
        if (one := made[0]) is None:
            continue
        found.append(agreed(one, (made[1], made[2])) if bounded and made[1] and made[2] else one)
    return found


def _laid(
    entrants: Sequence[Entrant], groups: list[Outcomes]
) -> tuple[tuple[float, ...], dict[tuple[str, str], Sheet]]:
    values, laid = sheets(groups)
    return values, {one.name: found for one, found in zip(entrants, laid, strict=True)}


def ranked(standings: Sequence[Standing], found: Sequence[Comparison]) -> tuple[Standing, ...]:
    """The same with the ranks that the comparisons leave possible, the highest success first.

    An agent ranks below all that are shown to solve the box more often, and above all that are shown to solve it less
    often; between those lie the ranks that it may have.
    """
    between = [one for one in found if one.among == "subjects"]
    group = {name: name[1] for one in between for name in (one.first, one.second)}
    above, below = dict.fromkeys(group, 0), dict.fromkeys(group, 0)
    for one in between:
        if one.verdict:
            better, worse = (one.second, one.first) if one.verdict > 0 else (one.first, one.second)
            below[better] += 1
            above[worse] += 1
    size = {name: sum(other == modality for other in group.values()) for name, modality in group.items()}
    placed = [
        replace(row, ranks=(1 + above[name], size[name] - below[name])) if (name := (row.agent, row.modality)) in group
        else row
        for row in standings
    ]  # fmt: skip
    return tuple(sorted(placed, key=lambda row: -row.success.value if row.success.n else 2.0))
