"""Two agents, trial by trial on the same boxes: who solves more, how soon, and whether false reports change one more.

*Interaction.* The difference of two agents in a block of luck at one dose, less the same at the lowest dose, has a mean
of 0 if false reports change the success of both alike, in points. The test flips the signs of whole blocks, which keeps
what trials of a block have in common; it assumes that a change is as likely as its opposite. Where one of the two is
people Student's t replaces the flips.

*Broken trials.* A trial that broke for one agent is dropped together with its pair. If an agent's long trials break,
the remaining ones overstate its success. So such comparisons hold at both ends: with the broken trials of the one agent
solved in the step in which they broke and those of the other unsolved, and the reverse
(:mod:`lockprobe.statistics.broken_trials`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations, product
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.seeds import generator
from lockprobe.statistics.agent_comparison.paired import (
    Array,
    BlockMean,
    Labels,
    Sheet,
    at_one_dose,
    block_mean,
    crossed_change,
    crossed_mean,
    mean_at_every_look,
    paired_success,
    people_of,
    sheets,
)
from lockprobe.statistics.broken_trials import bounded, completed
from lockprobe.statistics.conditions.axis_trials import AxisTrials
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.inference.holm import holm_by_family
from lockprobe.statistics.proportions import ALPHA
from lockprobe.statistics.rare_long_trials import RareBlock, rare_block

BASELINES = ("human-inspired", "random")
"""Kinds of agents that every agent is compared with, if they were played."""

FLIPS = 4000
_TIE = 1e-9

Among = Literal["subjects", "reference"]
"""Kind of pair: two agents that the study is about, or one of them and a baseline."""


class Apart(NamedTuple):
    """Two agents at one dose: the differences in success and in steps, an unsolved trial with its whole budget."""

    success: BlockMean
    steps: BlockMean


class ChangeAt(NamedTuple):
    """How much more the second agent's success changes from the lowest dose than the first's.

    Its P value and its interval are corrected for all doses: by Westfall and Young's maximum and by Bonferroni.
    """

    dose: float
    change: BlockMean


@dataclass(frozen=True, slots=True, kw_only=True)
class Interaction:
    """Whether false reports change the success of two agents differently, at each dose beside the lowest.

    The P value is that of the largest absolute t over doses; ``p_adjusted`` is corrected for the pairs (Holm). The mean
    of the changes has none: where agents seldom differ it is too skewed for flips of signs, which then reject in up to
    15 % of studies.
    """

    lowest: float
    at: tuple[ChangeAt, ...]
    mean: BlockMean
    p_value: float
    p_adjusted: float | None = None

    @property
    def clearest(self) -> ChangeAt:
        """The change with the smallest P value; of equal ones the largest."""
        return min(self.at, key=lambda at: (at.change.p_value or 0.0, -abs(at.change.value)))


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentComparison:
    """Two agents over all doses in one modality, on trials that both finished. Differences are second minus first.

    Attributes:
        first, second: Agent and modality.
        among: Kind of pair; P values are corrected within a kind.
        shares: What the first and the second solved of these trials.
        success, steps: The differences over all doses. P values are corrected once pairs are judged together.
        at: Dose -> the same there.
        interaction: None for a baseline, with a single dose, where what is said must hold at every look, and once pairs
            are judged of two that play alike.
        alike: Doses at which no trial broke and the two act the same in every trial; nothing is tested there.
        copies: Whether each of the two plays identically at every dose, so that all entries of ``at`` are equal.
        people: Whether one side is people, whose trials are clustered by person too.
        every_look: Whether intervals and P values hold at every look.
        bounded: Whether trials broke, so that intervals and P values hold whatever became of these.
    """

    first: tuple[str, str]
    second: tuple[str, str]
    among: Among
    shares: tuple[float, float]
    success: BlockMean
    steps: BlockMean
    at: Mapping[float, Apart]
    interaction: Interaction | None
    alike: frozenset[float] = field(default_factory=frozenset)
    copies: bool
    people: bool
    every_look: bool
    bounded: bool = False

    @property
    def family(self) -> tuple[Among, str, str]:
        """What is judged together with it: pairs of its kind that saw the box in the same ways."""
        return self.among, self.first[1], self.second[1]

    @property
    def plays_alike(self) -> bool:
        """Whether the two act the same in every trial."""
        return self.alike >= self.at.keys()

    @property
    def verdict(self) -> int:
        """1 if the second is shown to solve the box more often, -1 if less often, else 0.

        The corrected test must reject that the two play exchangeably, and the interval must exclude 0. The test alone
        is not enough: it also detects agents that play differently and solve the box equally often.
        """
        p_value = self.success.p_value
        return int(np.sign(self.success.value)) if self.success.clear and p_value is not None and p_value < ALPHA else 0


def comparisons(players: Sequence[AxisTrials]) -> tuple[AgentComparison, ...]:
    """Every pair of agents, judged together: see :func:`compared` and :func:`judged`."""
    return judged(compared(players))


def compared(players: Sequence[AxisTrials], of: Sequence[str] = ()) -> list[AgentComparison]:
    """Compare every two agents that the study is about, and each of them with the baselines; nothing is corrected.

    Two agents are compared if they saw the boxes in the same modality. Baselines read reports and are compared with
    all.

    Args:
        players: The agents, in the order of the study.
        of: Specs of the condition under which they are compared, which name random streams; empty over flip rates.
    """
    others = [one for one in players if not is_baseline(one.spec)]
    subjects = others or list(players)
    baselines = [one for one in players if others and is_baseline(one.spec) and one.kind in BASELINES]
    pairs: list[tuple[AxisTrials, AxisTrials, Among]] = [
        (first, second, "subjects")
        for second, first in combinations(subjects, 2)
        if first.modality == second.modality and first.agent != second.agent
    ]
    pairs += [(baseline, subject, "reference") for subject, baseline in product(subjects, baselines)]
    ended, broken = [one.outcomes for one in players], [one.broken_off for one in players]
    values, laid = sheets(ended)
    names = [_name(one) for one in players]
    every = dict(zip(names, laid, strict=True))
    broke, ends = {name for name, off in zip(names, broken, strict=True) if len(off)}, [every, every]
    if broke:
        off = [one.at(np.isin(one.dose, values)) for one in broken]
        whole = [
            [completed(one, two, soon, by.budget) for one, two, by in zip(ended, off, players, strict=True)]
            for soon in (False, True)
        ]
        ends = [dict(zip(names, sheets(groups)[1], strict=True)) for groups in whole]
    found = []
    for first, second, among in pairs:
        if (pair := _pair(first, second, among, of, values, every, every)) is None:
            continue
        if {_name(first), _name(second)} & broke:
            failed, solved = ends
            low = _pair(first, second, among, of, values, solved, failed)
            pair = _bounded(pair, low, _pair(first, second, among, of, values, failed, solved))
        found.append(replace(pair, alike=_alike(first, second) & pair.at.keys()))
    return found


def _name(one: AxisTrials) -> tuple[str, str]:
    return one.agent, one.modality


def _alike(first: AxisTrials, second: AxisTrials) -> frozenset[float]:
    """The doses at which no trial of either broke and both act the same in every trial that both played."""
    one, two = (
        {(dose, trial.repetition, trial.trial): trial for dose, trial in zip(by.doses, by.trials, strict=True)}
        for by in (first, second)
    )
    differ = {key[0] for key in one.keys() & two.keys() if one[key].actions != two[key].actions}
    broke = {key[0] for trials in (one, two) for key, trial in trials.items() if trial.error is not None}
    return frozenset({key[0] for key in one.keys() & two.keys()} - differ - broke)


_Sheets = Mapping[tuple[str, str], Sheet]
"""The sheet of each agent."""


def _pair(
    first: AxisTrials,
    second: AxisTrials,
    among: Among,
    of: Sequence[str],
    values: Sequence[float],
    ones: _Sheets,
    others: _Sheets,
) -> AgentComparison | None:
    """Two agents, the first with its sheet of ``ones``, the second with that of ``others``; None without a pair.

    In their interaction the lowest dose has the sheets the other way round: there success of the first agent counts for
    the change, and that of the second against it.
    """
    names = _name(first), _name(second)
    one, two = ones[names[0]], others[names[1]]
    solved = two.solved - one.solved
    both = ~np.isnan(solved)
    if not both.any():
        return None
    person = people_of((one, two))
    every_look = len(one.order) > 0 and person is None
    budget = float(max(first.budget, second.budget))
    interaction = None
    if among == "subjects" and len(values) > 1 and not every_look:
        lowest = ones[names[1]].solved[:, :1] - others[names[0]].solved[:, :1]
        streams = (first.spec, first.modality, second.spec, second.modality)
        rng = generator(first.seed, "analysis", *streams, "comparison", *of)
        interaction = interaction_of(values, np.column_stack([lowest, solved[:, 1:]]), person, rng)
    return AgentComparison(
        first=names[0],
        second=names[1],
        among=among,
        shares=(float(one.solved[both].mean()), float(two.solved[both].mean())),
        success=_over_all(solved, person, one.order, 1.0),
        steps=_over_all(two.steps - one.steps, person, one.order, budget, _rare(one, two, both, budget)),
        at={p: _at(one, two, i, person, budget) for i, p in enumerate(values) if both[:, i].any()},
        interaction=interaction,
        copies=len(values) > 1 and _same_at_every_dose(one) and _same_at_every_dose(two),
        people=person is not None,
        every_look=every_look,
    )


def _over_all(
    differences: Array, person: Labels | None, order: NDArray[np.int64], unit: float, rare: RareBlock | None = None
) -> BlockMean:
    """Over all doses, clustered by luck, and where one side is people also by person; with an order at every look."""
    if person is not None:
        both = ~np.isnan(differences)
        return crossed_mean(differences[both], np.nonzero(both)[0], person[both], unit=unit, rare=rare)
    if len(order):
        return mean_at_every_look(differences[order], bound=unit)
    return block_mean(differences, unit=unit, rare=rare)


def _at(one: Sheet, two: Sheet, column: int, person: Labels | None, budget: float) -> Apart:
    solved, steps = (two.solved - one.solved)[:, column], (two.steps - one.steps)[:, column]
    if len(one.order) and person is None:
        by_plan = one.order, slice(column, column + 1)
        means = ((two.solved - one.solved)[by_plan], 1.0), ((two.steps - one.steps)[by_plan], budget)
        return Apart(*(mean_at_every_look(values, bound=bound) for values, bound in means))
    both = ~np.isnan(solved)
    here = np.zeros_like(one.solved, dtype=bool)
    here[both, column] = True
    rare, of = _rare(one, two, here, budget), None if person is None else person[both, column]
    return Apart(
        paired_success(one.solved[both, column], two.solved[both, column], of),
        block_mean(steps[both, None], unit=budget, rare=rare)
        if of is None
        else at_one_dose(steps[both], of, unit=budget, rare=rare),
    )


def _rare(one: Sheet, two: Sheet, both: NDArray[np.bool_], budget: float) -> RareBlock:
    first, second = one.steps[both], two.steps[both]
    return rare_block(float(first.mean()), float(second.mean()), budget, float(min(first.min(), second.min())))


def _same_at_every_dose(laid: Sheet) -> bool:
    columns = ((of, np.repeat(of[:, :1], of.shape[1], axis=1)) for of in (laid.solved, laid.steps))
    return all(bool(np.array_equal(of, first, equal_nan=True)) for of, first in columns)


def interaction_of(
    values: Sequence[float], apart: Array, person: Labels | None, rng: np.random.Generator, flips: int = FLIPS
) -> Interaction | None:
    """Test whether a dose changes two agents' success differently; None if too few blocks have both doses of a change.

    Args:
        values: The doses, ascending.
        apart: Success of the second agent minus that of the first, shape (blocks, doses), NaN without a pair.
        person: The person of each trial, if one of the two is people: they meet no luck twice, so the two trials of a
            change belong to different people, and Student's t is corrected by Bonferroni.
        rng: The stream of the flips.
        flips: Number of flips.
    """
    changes = apart[:, 1:] - apart[:, :1]
    met = [i for i in range(changes.shape[1]) if not np.isnan(changes[:, i]).all()]
    if person is not None:
        found = []
        for i in met:
            here = ~np.isnan(changes[:, i])
            of = person[here, 0], person[here, i + 1]
            change = crossed_change(apart[here, 0], apart[here, i + 1], of, choices=len(met))
            if change.p_value is not None:
                found.append((values[i + 1], change, change.p_value))
        at = tuple(ChangeAt(dose, replace(one, p_value=min(1.0, len(found) * p))) for dose, one, p in found)
        mean = replace(_mean(changes), low=None, high=None)  # its blocks share people
        return _interaction(values[0], at, mean)
    blocks = changes[~np.isnan(changes).all(axis=1)]
    if len(blocks) < 2:
        return None
    table = np.nan_to_num(blocks[:, met])
    scale = np.sqrt(np.sum(table**2, axis=0))
    scale = np.where(scale > 0, scale, np.inf)
    signs = rng.integers(0, 2, size=(flips, len(table))) * 2.0 - 1.0
    largest = (np.abs(signs @ table) / scale).max(axis=1)
    reached = [(1 + int(np.sum(largest >= value - _TIE))) / (1 + flips) for value in np.abs(table.sum(axis=0)) / scale]
    at = tuple(
        ChangeAt(values[i + 1], replace(_mean(blocks[:, [i]], len(met)), p_value=p_value))
        for i, p_value in zip(met, reached, strict=True)
    )
    return _interaction(values[0], at, _mean(blocks[:, met]))


def _mean(changes: Array, choices: int = 1) -> BlockMean:
    return replace(block_mean(changes, unit=2.0, choices=choices), p_value=None)


def _interaction(lowest: float, at: tuple[ChangeAt, ...], mean: BlockMean) -> Interaction | None:
    tests = [one.change.p_value for one in at if one.change.p_value is not None]
    return Interaction(lowest=lowest, at=at, mean=mean, p_value=min(tests)) if tests else None


def _bounded(found: AgentComparison, low: AgentComparison | None, high: AgentComparison | None) -> AgentComparison:
    """The comparison over the trials that both finished, with what holds at both ends."""
    assert low is not None
    assert high is not None
    moved = None
    if found.interaction and low.interaction and high.interaction:
        ends = [dict(end.interaction.at) for end in (low, high) if end.interaction]
        at = tuple(ChangeAt(p, bounded(change, *(end[p] for end in ends))) for p, change in found.interaction.at)
        mean = bounded(found.interaction.mean, low.interaction.mean, high.interaction.mean)
        moved = _interaction(found.interaction.lowest, at, mean)
    return replace(
        found,
        success=bounded(found.success, low.success, high.success),
        steps=bounded(found.steps, low.steps, high.steps),
        at={
            p: Apart(*(bounded(*three) for three in zip(one, low.at[p], high.at[p], strict=True)))
            for p, one in found.at.items()
        },
        interaction=moved,
        bounded=True,
    )


def judged(found: Sequence[AgentComparison]) -> tuple[AgentComparison, ...]:
    """The comparisons with P values corrected (Holm) for the pairs of their family, at one dose also for the doses.

    Two agents that each play identically at every dose count as one test, not one for each dose. Two that act the same
    in every trial have no P value.
    """
    families = [one.family for one in found]

    def over_pairs(of: Callable[[AgentComparison], float | None]) -> list[float | None]:
        values = holm_by_family(families, [of(one) for one in found])
        return [None if one.plays_alike else value for one, value in zip(found, values, strict=True)]

    success, steps = over_pairs(lambda one: one.success.p_value), over_pairs(lambda one: one.steps.p_value)
    moved = over_pairs(lambda one: one.interaction.p_value if one.interaction else None)
    everywhere = [(i, p) for i, one in enumerate(found) for p in [*one.at][: 1 if one.copies else None]]
    of_doses = holm_by_family(
        [families[i] for i, _ in everywhere], [found[i].at[p].success.p_value for i, p in everywhere]
    )
    at_dose = dict(zip(everywhere, of_doses, strict=True))
    return tuple(
        replace(
            one,
            success=replace(one.success, p_value=success[i]),
            steps=replace(one.steps, p_value=steps[i]),
            at={
                p: untested(apart)
                if p in one.alike
                else Apart(
                    replace(apart.success, p_value=at_dose[i, next(iter(one.at)) if one.copies else p]), apart.steps
                )
                for p, apart in one.at.items()
            },
            interaction=replace(one.interaction, p_adjusted=moved[i])
            if one.interaction and not one.plays_alike
            else None,
        )
        for i, one in enumerate(found)
    )


def untested(apart: Apart) -> Apart:
    """Two agents that play alike: there is nothing to test."""
    return Apart(*(replace(one, p_value=None) for one in apart))
