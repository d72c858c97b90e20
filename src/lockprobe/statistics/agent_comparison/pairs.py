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
from lockprobe.statistics.agent_comparison.paired import (
    ONE_BOX,
    TIE,
    Array,
    BlockMean,
    Labels,
    Sheet,
    at_one_dose,
    block_mean,
    crossed_mean,
    mean_at_every_look,
    paired_success,
    people_of,
    sheets,
    two_way,
)
from lockprobe.statistics.boxes import mean_over_boxes
from lockprobe.statistics.broken_trials import bounded, completed
from lockprobe.statistics.conditions.axis_trials import AxisTrials
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.inference.mean_steps import rare_block
from lockprobe.statistics.proportions import ALPHA

BASELINES = ("human-inspired", "random")
"""Kinds of agents that every agent is compared with, if they were played."""

FLIPS = 4000

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
        of: Specs of the condition under which they are compared, which name random streams; empty over flip rates.
    """

    first: AxisTrials
    second: AxisTrials
    baseline: bool
    doses: Sequence[float]
    laid: Sequence[tuple[Sheet, Sheet]]
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

    @property
    def copies(self) -> bool:
        """Whether each of the two plays identically at every dose, so that all doses are equal."""
        columns = [of for one in self.laid[0] for of in (one.solved, one.steps)]
        return len(self.doses) > 1 and all(
            np.array_equal(of, np.broadcast_to(of[:, :1], of.shape), equal_nan=True) for of in columns
        )

    @cached_property
    def alike(self) -> frozenset[float]:
        """Doses at which no trial broke and the two act the same in every trial; nothing is tested there."""
        one, two = (
            {(dose, trial.repetition, trial.trial): trial for dose, trial in zip(by.doses, by.trials, strict=True)}
            for by in (self.first, self.second)
        )
        both = one.keys() & two.keys()
        apart = {key[0] for key in both if one[key].actions != two[key].actions}
        broke = {key[0] for trials in (one, two) for key, trial in trials.items() if trial.error is not None}
        return frozenset({key[0] for key in both} - apart - broke)

    @property
    def plays_alike(self) -> bool:
        """Whether the two act the same in every trial."""
        return self.alike >= {*self.at(SUCCESS)}

    @property
    def bounded(self) -> bool:
        """Whether trials broke, so that intervals and P values hold whatever became of these."""
        return len(self.laid) > 1

    @cached_property
    def shares(self) -> tuple[float, float]:
        """What the first and the second solved of the trials that both finished."""
        one, two = (sheet.solved for sheet in self.laid[0])
        both = ~np.isnan(two - one)
        return float(one[both].mean()), float(two[both].mean())

    def at(self, quantity: str) -> dict[float, BlockMean]:
        """Each dose with its mean, ascending; those of a change are corrected for the doses, no others for anything.

        There is no change for a baseline, at a single dose, and where what is said must hold at every look.
        """
        return {dose: mean for (name, dose), mean in self.means.items() if name == quantity and dose is not None}

    @property
    def change_p(self) -> float | None:
        """The P value of a change at any dose, corrected for the doses."""
        return min((one.p_value for one in self.at(CHANGE).values() if one.p_value is not None), default=None)

    @cached_property
    def means(self) -> Mapping[tuple[str, float | None], BlockMean]:
        """The mean of each quantity over all doses (None) and at each; none without a trial that both finished.

        Intervals and P values hold whatever became of broken trials.
        """
        found, *ends = map(self._means, range(len(self.laid)))
        return {key: bounded(mean, *(end[key] for end in ends)) if ends else mean for key, mean in found.items()}

    def _means(self, end: int) -> dict[tuple[str, float | None], BlockMean]:
        one, two = self.laid[end]
        solved, steps, person = two.solved - one.solved, two.steps - one.steps, people_of(one, two)
        budget, found = float(max(self.first.budget, self.second.budget)), dict[tuple[str, float | None], BlockMean]()
        for place, dose in enumerate((None, *self.doses)):
            here = slice(None) if dose is None else slice(place - 1, place)
            if not (both := ~np.isnan(solved[:, here])).any():
                continue
            first, second = (sheet.steps[:, here][both] for sheet in (one, two))
            shortest = float(min(first.min(), second.min()))
            rare = rare_block(float(first.mean()), float(second.mean()), budget, shortest)
            who = None if person is None else person[:, here][both]
            rows = np.flatnonzero(both.any(axis=1))[: len(one.box)]  # none where all are of one box
            for quantity, of, unit, wider in ((SUCCESS, solved, 1.0, None), (STEPS, steps, budget, rare)):
                apart = of[:, here]
                if self.every_look:
                    mean = mean_at_every_look(apart, bound=unit)
                elif quantity == SUCCESS and dose is not None:
                    mean = paired_success(one.solved[:, here][both], two.solved[:, here][both], who, one.box[rows])
                elif who is None:
                    mean = block_mean(apart, unit=unit, rare=wider)
                    mean = mean_over_boxes(mean, np.nanmean(apart[rows], axis=1), one.box[rows])
                elif dose is None:
                    mean = crossed_mean(apart[both], np.nonzero(both)[0], who, unit=unit, rare=wider)
                else:
                    mean = at_one_dose(apart[both], who, unit=unit, rare=wider)
                found[quantity, dose] = mean
        if found and not self.baseline and len(self.doses) > 1 and not self.every_look:
            # at the lowest dose success of the first counts for the change, so its broken trials end the other way
            turned = self.laid[-end][1].solved - self.laid[-end][0].solved
            streams = self.first.spec, self.first.modality, self.second.spec, self.second.modality
            rng = generator(self.first.seed, "analysis", *streams, "comparison", *self.of)
            changes = changes_of(self.doses, np.column_stack([turned[:, :1], solved[:, 1:]]), person, rng, one.box)
            found |= {(CHANGE, dose): mean for dose, mean in changes.items()}
        return found


def compared(players: Sequence[AxisTrials], of: Sequence[str] = ()) -> list[AgentPair]:
    """Every two agents that the study is about, and each of them with the baselines, that both finished a trial.

    Two agents are compared if they saw the boxes in the same modality. Baselines read reports and are compared with
    all.

    Args:
        players: The agents, in the order of the study.
        of: Specs of the condition under which they are compared; empty over flip rates.
    """
    ended, broken = [one.outcomes for one in players], [one.broken_off for one in players]
    doses, laid = sheets(ended)
    failed, solved = laid, laid
    if any(map(len, broken)):
        off = [one.at(np.isin(one.dose, doses)) for one in broken]
        failed, solved = (
            sheets([completed(one, two, soon, by.budget) for one, two, by in zip(ended, off, players, strict=True)])[1]
            for soon in (False, True)
        )
    others = [i for i, one in enumerate(players) if not is_baseline(one.spec)]
    baselines = [i for i, one in enumerate(players) if others and is_baseline(one.spec) and one.kind in BASELINES]
    subjects = others or range(len(players))
    pairs = [(first, second, False) for second, first in combinations(subjects, 2)]
    pairs += [(first, second, True) for second, first in product(subjects, baselines)]
    found = []
    for i, j, baseline in pairs:
        first, second = players[i], players[j]
        if not baseline and (first.modality != second.modality or first.agent == second.agent):
            continue
        ends = [(laid[i], laid[j])]
        if len(broken[i]) or len(broken[j]):
            ends += [(solved[i], failed[j]), (failed[i], solved[j])]
        pair = AgentPair(first=first, second=second, baseline=baseline, doses=doses, laid=ends, of=of)
        if pair.means:
            found.append(pair)
    return found


def changes_of(
    doses: Sequence[float],
    apart: Array,
    person: Labels | None,
    rng: np.random.Generator,
    box: Labels = ONE_BOX,
    flips: int = FLIPS,
) -> dict[float | None, BlockMean]:
    """How much more each dose changes the success of one agent than of another, and the mean of all changes (None).

    P values and intervals of doses are corrected for all doses: by Westfall and Young's maximum of absolute t, and by
    Bonferroni. There is none with too few blocks, or people, that have both doses of a change.

    Args:
        doses: The doses, ascending.
        apart: Success of the second agent minus that of the first, shape (blocks, doses), NaN without a pair.
        person: The person of each trial, if one of the two is people: they meet no luck twice, so the two trials of a
            change belong to different people, and Student's t is corrected by Bonferroni.
        rng: The stream of the flips.
        box: The box of each block; no rows if all are of one.
        flips: Number of flips.
    """
    changes = apart[:, 1:] - apart[:, :1]
    met = [i for i in range(changes.shape[1]) if not np.isnan(changes[:, i]).all()]
    level, found = 1 - ALPHA / max(1, len(met)), dict[float | None, BlockMean]()
    if person is not None:
        for i in met:
            here = ~np.isnan(changes[:, i])
            low, high, who = apart[here, 0], apart[here, i + 1], np.concatenate([person[here, 0], person[here, i + 1]])
            rest, luck = np.concatenate([low.mean() - low, high - high.mean()]), np.tile(np.arange(len(low)), 2)
            value, pairs = float(high.mean() - low.mean()), len(low)
            mean = two_way(value, rest, luck, who, pairs=pairs, unit=1.0, most=2.0, level=level)
            if mean.p_value is not None:
                found[doses[i + 1]] = mean
        found = {dose: replace(one, p_value=min(1.0, len(found) * (one.p_value or 0.0))) for dose, one in found.items()}
        if found:  # the blocks of the mean share people
            found[None] = replace(block_mean(changes, unit=2.0), low=None, high=None, p_value=None)
        return found
    played = ~np.isnan(changes).all(axis=1)
    blocks = changes[played][:, met]
    if len(blocks) < 2:
        return found

    def over(mean: BlockMean, values: Array) -> BlockMean:
        here = ~np.isnan(values).all(axis=1)
        own = box[played][here] if len(box) else box
        return mean_over_boxes(mean, np.nanmean(values[here], axis=1), own, choices=len(met))

    table = np.nan_to_num(blocks)
    scale = np.sqrt(np.sum(table**2, axis=0))
    scale = np.where(scale > 0, scale, np.inf)
    signs = rng.integers(0, 2, size=(flips, len(table))) * 2.0 - 1.0
    largest = (np.abs(signs @ table) / scale).max(axis=1)
    for place, value in enumerate(np.abs(table.sum(axis=0)) / scale):
        p_value = (1 + int(np.sum(largest >= value - TIE))) / (1 + flips)
        mean = block_mean(blocks[:, [place]], unit=2.0, choices=len(met))
        found[doses[met[place] + 1]] = over(replace(mean, p_value=p_value), blocks[:, [place]])
    found[None] = replace(over(block_mean(blocks, unit=2.0), blocks), p_value=None)
    return found
