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
from lockprobe.statistics.agent_comparison.paired import (
    TIE,
    Array,
    Labels,
    Sheet,
    at_one_dose,
    block_mean,
    both_played,
    crossed_mean,
    mean_of_blocks,
    over_boxes,
    paired_success,
    people_of,
    sheets,
    two_way,
)
from lockprobe.statistics.broken_trials import bounded, completed
from lockprobe.statistics.course import Course
from lockprobe.statistics.inference.mean_steps import rare_block
from lockprobe.statistics.proportions import Difference

BASELINES = ("human-inspired", "random")
"""Kinds of agents that every agent is compared with, if they were played."""

FLIPS = 4000
"""Flips of the signs of all blocks, for the test of a change at any dose."""

_AT_ONCE = 1 << 24
"""Signs that are flipped at once."""

SUCCESS, STEPS, CHANGE = "success_difference", "steps_difference", "success_interaction"
"""Difference in success; in steps, an unsolved trial with its whole budget; in what a dose changes in success."""


@dataclass(frozen=True, kw_only=True)
class AgentPair:
    """Two agents over the doses of an axis, in trials that both finished. Differences are second minus first.

    Attributes:
        baseline: Whether the first is a baseline that the second is compared with.
        doses: The doses of the axis, ascending.
        laid: The trials of both. If some broke, also as if those of the first had been solved and those of the second
            had failed, and the reverse.
        alike: Doses at which no trial broke and the two act the same in every trial; nothing is tested there.
        of: Specs of the condition under which they are compared, which name random streams; empty over flip rates.
    """

    first: Course
    second: Course
    baseline: bool
    doses: Sequence[float]
    laid: Sequence[tuple[Sheet, Sheet]]
    alike: frozenset[float]
    of: Sequence[str]

    @property
    def family(self) -> tuple[bool, str, str]:
        """What is judged together with it: pairs of its kind that saw the box in the same ways."""
        return self.baseline, self.first.modality, self.second.modality

    @property
    def people(self) -> bool:
        """Whether one side is people, whose trials are clustered by person too."""
        return people_of(*self.laid[0]) is not None

    @property
    def every_look(self) -> bool:
        """Whether intervals and P values hold at every look; people come as they please, so theirs hold at one."""
        return self.laid[0][0].planned and not self.people

    @cached_property
    def met(self) -> tuple[float, ...]:
        """The doses at which both finished a trial."""
        return tuple(np.array(self.doses)[both_played(*self.laid[0]).any(axis=0)].tolist())

    @cached_property
    def copies(self) -> bool:
        """Whether each of the two plays identically at every dose, so that all doses are equal."""
        columns = [of for one in self.laid[0] for of in (one.solved, one.steps)]
        return len(self.doses) > 1 and all(
            np.array_equal(of, np.broadcast_to(of[:, :1], of.shape), equal_nan=True) for of in columns
        )

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
        one, two = (sheet.solved[both_played(*self.laid[0])].mean() for sheet in self.laid[0])
        return float(one), float(two)

    def mean(self, quantity: str, dose: float | None = None) -> Difference:
        """The difference in success or in steps over all doses, or at one at which both finished a trial.

        Interval and P value hold whatever became of broken trials, and are corrected for nothing.
        """
        found, *ends = (self._mean(quantity, dose, *laid) for laid in self.laid)
        return bounded(found, *ends) if ends else found

    def _mean(self, quantity: str, dose: float | None, one: Sheet, two: Sheet) -> Difference:
        if dose is not None and quantity == SUCCESS and not self.every_look:
            return paired_success(one, two, self.doses.index(dose))
        here = slice(None) if dose is None else [self.doses.index(dose)]
        both, people = both_played(one, two)[:, here], people_of(one, two)
        unit, rare, apart = 1.0, None, (two.solved - one.solved)[:, here]
        if quantity == STEPS:
            unit, apart = float(max(self.first.budget, self.second.budget)), (two.steps - one.steps)[:, here]
            first, second = (sheet.steps[:, here][both] for sheet in (one, two))
            shortest = float(min(first.min(), second.min()))
            rare = rare_block(float(first.mean()), float(second.mean()), unit, shortest)
        if people is None:
            return mean_of_blocks(apart, one.box, planned=one.planned, unit=unit, rare=rare)
        if dose is None:
            return crossed_mean(apart[both], np.nonzero(both)[0], people[both], unit=unit, rare=rare)
        return at_one_dose(apart[both], people[:, here][both], unit=unit, rare=rare)

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
        found, *ends = map(self._changes, range(len(self.laid)))
        return {dose: bounded(mean, *(end[dose] for end in ends)) if ends else mean for dose, mean in found.items()}

    def _changes(self, end: int) -> dict[float | None, Difference]:
        # at the lowest dose success of the first counts for the change, so its broken trials end the other way
        (one, two), turned = self.laid[end], self.laid[-end]
        apart = np.column_stack([(turned[1].solved - turned[0].solved)[:, :1], (two.solved - one.solved)[:, 1:]])
        who = self.first.spec, self.first.modality, self.second.spec, self.second.modality
        rng = generator(self.first.trials[0].seed, "analysis", *who, "comparison", *self.of)
        return changes_of(self.doses, apart, people_of(one, two), rng, one.box)


def compared(players: Sequence[Course], of: Sequence[str] = ()) -> list[AgentPair]:
    """Every two agents that the study is about, and each of them with the baselines, that both finished a trial.

    Two agents are compared if they saw the boxes in the same modality. Baselines read reports and are compared with
    all. ``of`` is that of the pairs.
    """
    doses, laid = sheets([one.outcomes for one in players])
    ended = failed = solved = dict(zip(players, laid, strict=True))
    if any(len(one.broken_off) for one in players):
        off = {one: one.broken_off.at(np.isin(one.broken_off.dose, doses)) for one in players}
        failed, solved = (
            dict(zip(players, sheets(every)[1], strict=True))
            for soon in (False, True)
            for every in [[completed(one.outcomes, off[one], soon, one.budget) for one in players]]
        )
    acted = {player: _acted(player) for player in players}
    others = [one for one in players if not one.baseline]
    baselines = [one for one in players if others and spec_kind(one.spec) in BASELINES]
    pairs = [
        (one, two, False)
        for two, one in combinations(others or players, 2)
        if one.modality == two.modality and one.agent != two.agent
    ]
    pairs += [(one, two, True) for two, one in product(others, baselines)]
    found = []
    for one, two, baseline in pairs:
        ends = [(ended[one], ended[two])]
        if len(one.broken_off) or len(two.broken_off):
            ends += [(solved[one], failed[two]), (failed[one], solved[two])]
        both = acted[one].keys() & acted[two].keys()
        apart = {place[0] for place in both if acted[one][place] != acted[two][place]}
        apart |= {place[0] for of_one in (acted[one], acted[two]) for place, did in of_one.items() if did is None}
        alike = frozenset({place[0] for place in both} - apart)
        pair = AgentPair(first=one, second=two, baseline=baseline, doses=doses, laid=ends, alike=alike, of=of)
        if pair.met:
            found.append(pair)
    return found


def _acted(player: Course) -> dict[tuple[float, int, int], int | None]:
    """Dose, repetition and trial -> a number that is equal for equal actions; None of trials that broke."""
    pairs = zip(player.doses, player.trials, strict=True)
    return {(dose, one.repetition, one.trial): hash(one.actions) if one.error is None else None for dose, one in pairs}


def changes_of(
    doses: Sequence[float],
    apart: Array,
    person: Labels | None,
    rng: np.random.Generator,
    box: Labels,
) -> dict[float | None, Difference]:
    """How much more each dose changes the success of one agent than of another, and the mean of all changes (None).

    P values and intervals of doses are corrected for all doses: by Westfall and Young's maximum of absolute t, and by
    Bonferroni. There is none with too few blocks, or people, that have both doses of a change.

    Args:
        doses: Ascending.
        apart: Success of the second agent minus that of the first, shape (blocks, doses), NaN without a pair.
        person: The person of each trial, if one of the two is people: they meet no luck twice, so the two trials of a
            change belong to different people, and Student's t is corrected by Bonferroni.
        rng: The stream of the flips.
        box: As in :class:`~lockprobe.statistics.agent_comparison.paired.Sheet`.
    """
    changes = apart[:, 1:] - apart[:, :1]
    met = np.flatnonzero(~np.isnan(changes).all(axis=0)).tolist()
    found = dict[float | None, Difference]()
    if person is not None:
        for i in met:
            here = ~np.isnan(changes[:, i])
            low, high, who = apart[here, 0], apart[here, i + 1], person[here][:, [0, i + 1]].T.ravel()
            rest, luck = np.concatenate([low.mean() - low, high - high.mean()]), np.tile(np.arange(len(low)), 2)
            value = float(high.mean() - low.mean())
            mean = two_way(value, rest, luck, who, pairs=len(low), unit=1.0, most=2.0, choices=len(met))
            if mean.p_value is not None:
                found[doses[i + 1]] = mean
        found = {dose: replace(one, p_value=min(1.0, len(found) * (one.p_value or 0.0))) for dose, one in found.items()}
        # the blocks of the mean share people
        every = replace(block_mean(changes, unit=2.0, exchange=False), low=None, high=None, p_value=None)
        return found | {None: every} if found else found
    table = np.nan_to_num(changes[~np.isnan(changes).all(axis=1)][:, met]).T
    if table.shape[1] < 2:
        return found
    scale = np.sqrt(np.sum(table**2, axis=1))
    scale[scale == 0] = np.inf
    own, blocks, largest = table.astype(np.float32), table.shape[1], []
    rows = max(2, _AT_ONCE // blocks // 2 * 2)
    for first in range(0, FLIPS, rows):
        some = min(rows, FLIPS - first)
        bits = rng.bit_generator.random_raw(some * blocks // 2).view(np.uint32)  # two draws a number
        plus = (bits >= 2**31).reshape(some, blocks).astype(np.float32)
        flipped = 2 * (plus @ own.T) - own.sum(axis=1)  # whole numbers, so exact
        largest += (np.abs(flipped) / scale).max(axis=1).tolist()
    for i, value in zip(met, np.abs(table.sum(axis=1)) / scale, strict=True):
        p_value = (1 + int(np.sum(np.array(largest) >= value - TIE))) / (1 + FLIPS)
        mean = block_mean(changes[:, [i]], unit=2.0, choices=len(met), exchange=False)
        found[doses[i + 1]] = over_boxes(replace(mean, p_value=p_value), changes[:, [i]], box, len(met))
    mean = over_boxes(block_mean(changes, unit=2.0, exchange=False), changes, box, len(met))
    return found | {None: replace(mean, p_value=None)}
