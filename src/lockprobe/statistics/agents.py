"""Two agents, trial by trial on the same boxes: who solves more, how soon, and whether false reports change one more.

*Change.* The difference of two agents in a block of luck at one dose, less the same at the lowest dose, has a mean of 0
if false reports change the success of both alike, in points. The test flips the signs of whole blocks, which keeps what
trials of a block have in common; it assumes that a change is as likely as its opposite. Where one of the two is people
Student's t replaces the flips. The mean of the changes at all doses has no P value: where agents seldom differ it is
too skewed for flips of signs, which then reject in up to 15 % of studies.

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

from lockprobe.foundation.seeds import generator
from lockprobe.foundation.spec import spec_kind
from lockprobe.statistics.blocks import (
    TIE,
    Array,
    Blocks,
    Labels,
    at_one_dose,
    block_mean,
    blocks_of,
    crossed_mean,
    mean_of_blocks,
    over_boxes,
    rare_block,
    success_in_pairs,
    two_way,
)
from lockprobe.statistics.broken_trials import bounded, ends_of
from lockprobe.statistics.course import Course
from lockprobe.statistics.proportions import Difference

BASELINES = ("human-inspired", "random")
"""Kinds of agents that every agent is compared with, if they were played."""

FLIPS, _AT_ONCE = 4000, 100
"""Flips of the signs of all blocks, for the test of a change at any dose, and how many are made at once."""

SUCCESS, STEPS, CHANGE = "success_difference", "steps_difference", "success_interaction"
"""Difference in success; in steps, an unsolved trial with its whole budget; in what a dose changes in success."""


@dataclass(frozen=True, kw_only=True)
class AgentPair:
    """Two agents over the doses of an axis, in trials that both finished. Differences are second minus first.

    Attributes:
        baseline: Whether the first is a baseline that the second is compared with.
        doses: The doses of the axis at which one of all agents finished a trial, ascending.
        of: Specs of the condition under which they are compared, which name random streams; empty over flip rates.
    """

    first: Course
    second: Course
    baseline: bool
    doses: tuple[float, ...]
    of: Sequence[str]

    def _laid(self, *gains: bool) -> list[Blocks]:
        """Blocks of the first agent at every dose, then of the second; if trials broke also at both ends."""
        trials = [one.outcomes.at(one.outcomes.dose == at) for one in (self.first, self.second) for at in self.doses]
        return [blocks_of(of) for of in ends_of(trials, gains)]

    @cached_property
    def laid(self) -> list[Blocks]:
        """The trials of both; if some broke, also as if all of the one had been solved, and none of the other."""
        n = len(self.doses)
        return self._laid(*[False] * n, *[True] * n)

    def _two(self, table: Array) -> tuple[Array, Array]:
        """The columns of the first and of the second agent, each of shape (blocks, doses)."""
        return table[:, : len(self.doses)], table[:, len(self.doses) :]

    @cached_property
    def _both(self) -> Array:
        """Whether both finished their trial, shape (blocks, doses)."""
        one, two = self._two(self.laid[0].solved)
        return ~np.isnan(two - one)

    @property
    def family(self) -> tuple[bool, str, str]:
        """What is judged together with it: pairs of its kind that saw the box in the same ways."""
        return self.baseline, self.first.modality, self.second.modality

    @property
    def people(self) -> bool:
        """Whether one side is people, whose trials are clustered by person too."""
        return bool(self.laid[0].person.size)

    @property
    def every_look(self) -> bool:
        """Whether intervals and P values hold at every look; people come as they please, so theirs hold at one."""
        return self.laid[0].order is not None and not self.people

    @cached_property
    def met(self) -> tuple[float, ...]:
        """The doses at which both finished a trial."""
        return tuple(np.array(self.doses)[self._both.any(axis=0)].tolist())

    @cached_property
    def copies(self) -> bool:
        """Whether each of the two plays identically at every dose, so that all doses are equal."""
        columns = [of for table in (self.laid[0].solved, self.laid[0].steps) for of in self._two(table)]
        alike = (np.array_equal(of, np.broadcast_to(of[:, :1], of.shape), equal_nan=True) for of in columns)
        return len(self.doses) > 1 and all(alike)

    @cached_property
    def alike(self) -> frozenset[float]:
        """Doses at which no trial broke and the two act the same in every trial; nothing is tested there."""
        one, two = self.first.acted, self.second.acted
        both = one.keys() & two.keys()
        apart = {place[0] for place in both if one[place] != two[place]}
        apart |= {place[0] for own in (one, two) for place, did in own.items() if did is None}
        return frozenset({place[0] for place in both} - apart)

    @property
    def plays_alike(self) -> bool:
        """Whether the two act the same in every trial."""
        return self.alike >= {*self.met}

    @property
    def bounded(self) -> bool:
        """Whether trials broke, so that intervals and P values hold whatever became of these."""
        return len(self.laid) > 1

    @property
    def shares(self) -> tuple[float, float]:
        """What the first and the second solved of the trials that both finished."""
        one, two = (own[self._both].mean() for own in self._two(self.laid[0].solved))
        return float(one), float(two)

    def mean(self, quantity: str, dose: float | None = None) -> Difference:
        """The difference in success or in steps over all doses, or at one at which both finished a trial.

        Interval and P value hold whatever became of broken trials, and are corrected for nothing.
        """
        found, *ends = (self._mean(quantity, dose, blocks) for blocks in self.laid)
        return bounded(found, *ends) if ends else found

    def _mean(self, quantity: str, dose: float | None, blocks: Blocks) -> Difference:
        at, n = None if dose is None else self.doses.index(dose), len(self.doses)
        if at is not None and quantity == SUCCESS and not self.every_look:
            return success_in_pairs(blocks, at, n + at)
        here = slice(None) if at is None else [at]
        one, two = (own[:, here] for own in self._two(blocks.steps if quantity == STEPS else blocks.solved))
        apart, both, unit, rare = two - one, ~np.isnan(two - one), 1.0, None
        if quantity == STEPS:
            unit = float(max(self.first.outcomes.budget, self.second.outcomes.budget))
            rare = rare_block(one[both], two[both], unit)
        if not self.people:
            return mean_of_blocks(apart, blocks, unit=unit, rare=rare)
        person = blocks.people(range(n), range(n, 2 * n))[:, here][both]
        if at is None:
            return crossed_mean(apart[both], np.nonzero(both)[0], person, unit=unit, rare=rare)
        return at_one_dose(apart[both], person, unit=unit, rare=rare)

    @property
    def change_p(self) -> float | None:
        """The P value of a change at any dose, corrected for the doses."""
        return min((one.p_value for one in self.changes.values() if one.p_value is not None), default=None)

    @cached_property
    def changes(self) -> Mapping[float | None, Difference]:
        """How much more each dose changes the success of the second, and the mean of all changes (None).

        P values and intervals of doses are corrected for the doses. There are none for a baseline, at a single dose,
        where what is said must hold at every look, and with too few blocks, or people, that have both doses.
        """
        if self.baseline or len(self.doses) < 2 or self.every_look:
            return {}
        # at the lowest dose success of the first counts for the change, so its broken trials end the other way
        higher = [dose > self.doses[0] for dose in self.doses]
        found, *ends = map(self._changes, self._laid(*[not one for one in higher], *higher))
        return {dose: bounded(mean, *(end[dose] for end in ends)) if ends else mean for dose, mean in found.items()}

    def _changes(self, blocks: Blocks) -> dict[float | None, Difference]:
        (one, two), n = self._two(blocks.solved), len(self.doses)
        if self.people:
            return changes_beside_people(self.doses, two - one, blocks.people(range(n), range(n, 2 * n)))
        who = self.first.spec, self.first.modality, self.second.spec, self.second.modality
        rng = generator(self.first.trials[0].seed, "analysis", *who, "comparison", *self.of)
        return changes_of(self.doses, two - one, rng, blocks)


def compared(players: Sequence[Course], of: Sequence[str] = ()) -> list[AgentPair]:
    """Every two agents that the study is about, and each of them with the baselines, that both finished a trial.

    Two agents are compared if they saw the boxes in the same modality. Baselines read reports and are compared with
    all. ``of`` is that of the pairs.
    """
    doses = tuple(sorted({dose for one in players for dose in one.outcomes.ended.dose.tolist()}))
    others = [one for one in players if not one.baseline]
    baselines = [one for one in players if others and spec_kind(one.spec) in BASELINES]
    pairs = [
        (one, two, False)
        for two, one in combinations(others or players, 2)
        if one.modality == two.modality and one.agent != two.agent
    ]
    pairs += [(one, two, True) for two, one in product(others, baselines)]
    made = [AgentPair(first=one, second=two, baseline=baseline, doses=doses, of=of) for one, two, baseline in pairs]
    return [pair for pair in made if pair.met]


def changes_beside_people(doses: Sequence[float], apart: Array, person: Labels) -> dict[float | None, Difference]:
    """The changes of :func:`changes_of` where one of two agents is people, with Student's t and Bonferroni.

    ``person`` is that of each trial, shape (blocks, doses). They meet no luck twice, so the two trials of a change
    belong to different people.
    """
    changes = apart[:, 1:] - apart[:, :1]
    met = np.flatnonzero(~np.isnan(changes).all(axis=0)).tolist()
    found = dict[float | None, Difference]()
    for i in met:
        here = ~np.isnan(changes[:, i])
        low, high, who = apart[here, 0], apart[here, i + 1], person[here][:, [0, i + 1]].T.ravel()
        rest, luck = np.concatenate([low.mean() - low, high - high.mean()]), np.tile(np.arange(len(low)), 2)
        value = float(high.mean() - low.mean())
        mean = two_way(value, rest, luck, who, pairs=len(low), unit=1.0, most=2.0, choices=len(met))
        if mean.p_value is not None:
            found[doses[i + 1]] = mean
    found = {dose: replace(one, p_value=min(1.0, len(found) * (one.p_value or 0.0))) for dose, one in found.items()}
    every = replace(block_mean(changes, unit=2.0), low=None, high=None, p_value=None)  # its blocks share people
    return found | {None: every} if found else found


def changes_of(
    doses: Sequence[float], apart: Array, rng: np.random.Generator, blocks: Blocks
) -> dict[float | None, Difference]:
    """How much more each dose changes the success of one agent than of another, and the mean of all changes (None).

    P values and intervals of doses are corrected for all doses: by Westfall and Young's maximum of absolute t, and by
    Bonferroni. There is none with too few blocks that have both doses of a change.

    Args:
        doses: Ascending.
        apart: Success of the second agent minus that of the first, shape (blocks, doses), NaN without a pair.
        rng: The stream of the flips.
        blocks: Say of which boxes the blocks are.
    """
    changes = apart[:, 1:] - apart[:, :1]
    met = np.flatnonzero(~np.isnan(changes).all(axis=0)).tolist()
    table = np.nan_to_num(changes[~np.isnan(changes).all(axis=1)][:, met])
    count = len(table)
    if count < 2:
        return {}
    scale = np.sqrt(np.sum(table**2, axis=0))
    scale[scale == 0] = np.inf
    own, largest = table.astype(np.float32), []
    for _ in range(FLIPS // _AT_ONCE):
        bits = rng.bit_generator.random_raw(_AT_ONCE * count // 2).view(np.uint32)  # two draws a number
        plus = (bits >= 2**31).reshape(_AT_ONCE, count).astype(np.float32)
        flipped = 2 * (plus @ own) - own.sum(axis=0)  # whole numbers, so exact
        largest += (np.abs(flipped) / scale).max(axis=1).tolist()
    found = dict[float | None, Difference]()
    for i, value in zip(met, np.abs(table.sum(axis=0)) / scale, strict=True):
        p_value = (1 + int(np.sum(np.array(largest) >= value - TIE))) / (1 + FLIPS)
        mean = replace(block_mean(changes[:, [i]], unit=2.0, choices=len(met)), p_value=p_value)
        found[doses[i + 1]] = over_boxes(mean, changes[:, [i]], blocks, len(met))
    mean = over_boxes(block_mean(changes, unit=2.0), changes, blocks, len(met))
    return found | {None: replace(mean, p_value=None)}
