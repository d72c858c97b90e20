"""Two agents, trial by trial on the same boxes: who solves more, how soon, and whether false reports change one more.

*Change.* The difference of two agents in a block of luck at one dose, less the same at the lowest dose, has a mean of 0
if false reports change the success of both alike, in points. The test flips the signs of whole blocks, which keeps what
trials of a block have in common; it assumes that a change is as likely as its opposite. Where one of the two is people
Student's t replaces the flips. Each dose has its own test: where agents seldom differ the mean of the changes at all
doses is too skewed for flips of signs, which then reject in up to 15 % of studies.

*Broken trials.* A trial that broke for one agent is dropped together with its pair. If an agent's long trials break,
the remaining ones overstate its success. So such comparisons hold at both ends: with the broken trials of the one agent
solved in the step in which they broke and those of the other unsolved, and the reverse
(:mod:`lockprobe.statistics.broken_trials`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, product

import numpy as np

from lockprobe.foundation.spec import spec_kind
from lockprobe.statistics.blocks import (
    Array,
    Blocks,
    Labels,
    blocks_of,
    crossed_mean,
    mean_of_blocks,
    rare_block,
    two_way,
)
from lockprobe.statistics.broken_trials import bounded, ends_of
from lockprobe.statistics.course import Course
from lockprobe.statistics.proportions import Difference

COMPARED_BASELINES = ("human-inspired", "random")
"""Kinds of agents that every agent is compared with, if they were played."""

SUCCESS, STEPS, CHANGE = "success_difference", "steps_difference", "success_interaction"
"""Difference in success; in steps, an unsolved trial with its whole budget; in what a dose changes in success."""


@dataclass(frozen=True, kw_only=True)
class AgentPair:
    """Two agents over the doses of an axis, in trials that both finished. Differences are second minus first.

    Attributes:
        baseline: Whether the first is a baseline that the second is compared with.
        doses: The doses of the axis, or numbers of conditions, at which one of all agents finished a trial, ascending.
    """

    first: Course
    second: Course
    baseline: bool
    doses: tuple[float, ...]

    def _laid(self, *gains: bool) -> list[Blocks]:
        """Blocks of the first agent at every dose, then of the second; if trials broke also at both ends.

        ``gains`` says at which of these success counts for the difference.
        """
        trials = [one.outcomes.at(one.outcomes.dose == at) for one in (self.first, self.second) for at in self.doses]
        return [blocks_of(of) for of in ends_of(trials, gains)]

    @cached_property
    def laid(self) -> list[Blocks]:
        """The trials of both; if some broke, also as if all of the one had been solved, and none of the other."""
        return self._laid(*[False] * len(self.doses), *[True] * len(self.doses))

    def _two(self, table: Labels) -> tuple[Labels, Labels]:
        """The columns of the first and of the second agent, each of shape (blocks, doses)."""
        return table[:, : len(self.doses)], table[:, len(self.doses) :]

    @cached_property
    def solved(self) -> tuple[Array, Array]:
        """Whether the first and the second solved each trial that both finished, shape (pairs,)."""
        one, two = self._two(self.laid[0].solved)
        both = ~np.isnan(two - one)
        return one[both], two[both]

    @property
    def people(self) -> bool:
        """Whether one side is people, whose trials are clustered by person too."""
        return bool(self.laid[0].person.size)

    @property
    def every_look(self) -> bool:
        """Whether intervals and P values hold at every look; people come as they please, so theirs hold at one."""
        return self.laid[0].order is not None and not self.people

    @property
    def plays_alike(self) -> bool:
        """Whether no trial broke and the two act the same in every trial; then nothing is tested."""
        one, two = self.first.acted, self.second.acted
        whole = None not in (*one.values(), *two.values())
        return whole and all(one[place] == two[place] for place in one.keys() & two.keys())

    def mean(self, quantity: str) -> Difference:
        """The difference in success or in steps over all doses.

        Interval and P value hold whatever became of broken trials, and are corrected for nothing.
        """

        def of(blocks: Blocks) -> Difference:
            one, two = self._two(blocks.steps if quantity == STEPS else blocks.solved)
            apart, both, unit, rare = two - one, ~np.isnan(two - one), 1.0, None
            if quantity == STEPS:
                unit = float(max(self.first.outcomes.budget, self.second.outcomes.budget))
                rare = rare_block(one[both], two[both], unit)
            if not self.people:
                return mean_of_blocks(apart, blocks, unit=unit, rare=rare)
            return crossed_mean(apart[both], np.nonzero(both)[0], self._person(blocks)[both], unit=unit, rare=rare)

        found, *ends = map(of, self.laid)
        return bounded(found, *ends) if ends else found

    def _person(self, blocks: Blocks) -> Labels:
        """Who of the people on one side played, shape (blocks, doses)."""
        one, two = self._two(blocks.person)
        return np.where(one == "", two, one)

    @cached_property
    def changes(self) -> Mapping[float, Difference]:
        """How much more each dose changes the success of the second; P values and intervals are corrected for doses.

        There are none for a baseline, at a single dose, where what is said must hold at every look, and with too few
        blocks, or people, that have both doses.
        """
        if self.baseline or len(self.doses) < 2 or self.every_look:
            return {}
        # at the lowest dose success of the first counts for the change, so its broken trials end the other way
        higher = [dose > self.doses[0] for dose in self.doses]
        laid = self._laid(*[not one for one in higher], *higher)
        one, two = self._two(laid[0].solved)
        places = [i for i in range(1, len(self.doses)) if not np.isnan((two - one)[:, [0, i]]).any(axis=1).all()]
        found = {}
        for i in places:
            change, *ends = (self._change(i, blocks, len(places)) for blocks in laid)
            if change.low is not None and change.p_value is not None:
                found[self.doses[i]] = bounded(change, *ends) if ends else change
        return found

    def _change(self, i: int, blocks: Blocks, choices: int) -> Difference:
        """How much more the dose at this place changes the success of the second than the lowest dose does."""
        one, two = self._two(blocks.solved)
        apart = (two - one)[:, [0, i]]
        if not self.people:
            return mean_of_blocks(apart[:, 1:] - apart[:, :1], blocks, unit=2.0, choices=choices)
        both = ~np.isnan(apart).any(axis=1)  # people meet no luck twice: the two trials belong to different people
        low, high = apart[both].T
        person = self._person(blocks)[both][:, [0, i]].T.ravel()
        rest, luck = np.concatenate([low.mean() - low, high - high.mean()]), np.tile(np.arange(len(low)), 2)
        value = float(high.mean() - low.mean())
        found = two_way(value, rest, luck, person, pairs=len(low), unit=1.0, most=2.0, choices=choices)
        return found if found.p_value is None else replace(found, p_value=min(1.0, choices * found.p_value))


def compared(players: Sequence[Course]) -> list[AgentPair]:
    """Every two agents that the study is about, and each of them with the baselines, that both finished a trial.

    Two agents are compared if they saw the boxes in the same modality. Baselines read reports and are compared with
    all.
    """
    doses = tuple(sorted({dose for one in players for dose in one.outcomes.ended.dose.tolist()}))
    others = [one for one in players if not one.baseline]
    baselines = [one for one in players if others and spec_kind(one.spec) in COMPARED_BASELINES]
    pairs = [
        (one, two, False)
        for two, one in combinations(others or players, 2)
        if one.modality == two.modality and one.agent != two.agent
    ]
    pairs += [(one, two, True) for two, one in product(others, baselines)]
    made = [AgentPair(first=one, second=two, baseline=baseline, doses=doses) for one, two, baseline in pairs]
    return [pair for pair in made if len(pair.solved[0])]
