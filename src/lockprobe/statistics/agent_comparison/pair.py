"""Comparison of two agents, trial by trial on the same boxes with the same false reports."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lockprobe.statistics.agent_comparison.crossed_clusters import at_one_p, crossed_mean, people_of
from lockprobe.statistics.agent_comparison.interaction import Interaction, interaction
from lockprobe.statistics.agent_comparison.paired import Array, BlockMean, Sheet, block_mean, mean_at_every_look
from lockprobe.statistics.inference.holm import holm_by_family
from lockprobe.statistics.proportions import ALPHA, Paired, paired
from lockprobe.statistics.rare_long_trials import RareBlock, rare_block

Among = Literal["subjects", "reference"]
"""Kind of pair: two agents that the study is about, or one of them and a baseline."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparisonAt:
    """Two agents at one p.

    Attributes:
        dose: Flip probability, [0, 1].
        success: Difference in the share solved, second minus first, over the trials that both finished, with McNemar's
            test. Where one person has several trials, agents are exchanged within whole people, and the interval is
            over people.
        steps: Difference in mean steps, second minus first; an unsolved trial counts with its whole budget.
        p_adjusted: McNemar's P value corrected for all pairs of agents and all p (Holm); None before that.
    """

    dose: float
    success: Paired
    steps: BlockMean
    p_adjusted: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentComparison:
    """Two agents over all p in one modality. Differences are second minus first.

    Attributes:
        first: Agent and modality of the reference.
        second: Agent and modality of the other.
        among: Kind of pair; P values are corrected within a kind.
        first_share: Share that the first solved of the trials that both finished, [0, 1].
        second_share: Share that the second solved of them.
        success: Difference of these shares.
        success_adjusted: The P value of ``success``, corrected for the number of pairs (Holm).
        steps: Difference in mean steps, an unsolved trial counted with its whole budget.
        steps_adjusted: The P value of ``steps``, corrected in the same way.
        at: The comparison at each p, ascending.
        copies: Whether both play each block identically at every p, so that all entries of ``at`` are equal.
        people: Whether one side is people, whose trials are clustered by person too.
        every_look: Whether intervals and P values hold at every look.
        bounded: Whether trials broke, so that intervals and P values hold whatever became of these.
        alone: Trials that only one of the two finished; no other number counts them.
        interaction: Whether false reports change both alike; None for a baseline, with a single p, or where what is
            said must hold at every look.
    """

    first: tuple[str, str]
    second: tuple[str, str]
    among: Among
    first_share: float
    second_share: float
    success: BlockMean
    steps: BlockMean
    at: tuple[ComparisonAt, ...]
    alone: int
    interaction: Interaction | None
    copies: bool = False
    people: bool = False
    every_look: bool = False
    bounded: bool = False
    success_adjusted: float | None = None
    steps_adjusted: float | None = None

    @property
    def family(self) -> tuple[Among, str, str]:
        """What is judged together with it: pairs of its kind that saw the box in the same ways."""
        return self.among, self.first[1], self.second[1]

    @property
    def verdict(self) -> int:
        """1 if the second is shown to solve the box more often, -1 if less often, else 0.

        The corrected test must reject that the two play exchangeably, and the interval must exclude 0. The test alone
        is not enough: it also detects agents that play differently and solve the box equally often.
        """
        return _told(self.success, self.success_adjusted)

    @property
    def steps_verdict(self) -> int:
        """-1 if the second is shown to need fewer steps, 1 if more, else 0; by the rule of :attr:`verdict`."""
        return _told(self.steps, self.steps_adjusted)


def _told(found: BlockMean, adjusted: float | None) -> int:
    return int(np.sign(found.value)) if found.clear and adjusted is not None and adjusted < ALPHA else 0


def compare(
    names: tuple[tuple[str, str], tuple[str, str]],
    values: tuple[float, ...],
    laid: tuple[Sheet, Sheet],
    among: Among,
    rng: np.random.Generator,
    *,
    budget: int,
    lowest: tuple[Sheet, Sheet] | None = None,
) -> AgentComparison | None:
    """Compare two agents over the trials that both finished; None if there are none.

    Args:
        names: Agent and modality of the first (the reference) and of the second.
        values: The values of p, ascending.
        laid: The sheets of both.
        among: Kind of pair.
        rng: The stream of the flips.
        budget: Steps of a trial.
        lowest: The sheets of both for the lowest p in their interaction, where trials broke; else ``laid``.
    """
    first, second = laid
    solved, steps = second.solved - first.solved, second.steps - first.steps
    both: NDArray[np.bool_] = ~np.isnan(solved)
    if not both.any():
        return None
    played = ~np.isnan(first.solved) | ~np.isnan(second.solved)
    most, person = float(budget), people_of(laid)
    order = first.order if person is None else first.order[:0]
    rare = _rare(first.steps[both], second.steps[both], most)
    return AgentComparison(
        first=names[0],
        second=names[1],
        among=among,
        first_share=float(first.solved[both].mean()),
        second_share=float(second.solved[both].mean()),
        success=_mean(solved, person, 1.0, order),
        steps=_mean(steps, person, most, order, rare),
        at=tuple(
            ComparisonAt(
                dose=p,
                success=paired_difference(
                    first.solved[both[:, i], i], second.solved[both[:, i], i], _of(person, both, i)
                ),
                steps=_steps_at(first.steps[both[:, i], i], second.steps[both[:, i], i], _of(person, both, i), most),
            )
            if not len(order)
            else _at_every_look(p, laid, i, most)
            for i, p in enumerate(values)
            if both[:, i].any()
        ),
        alone=int(np.sum(played & ~both)),
        copies=len(values) > 1 and all(_same_at_every_p(one) for one in laid),
        interaction=interaction(values, *_with_lowest(laid, lowest or laid), rng)
        if among == "subjects" and len(values) > 1 and not len(order)
        else None,
        people=person is not None,
        every_look=bool(len(order)),
    )


def _with_lowest(laid: tuple[Sheet, Sheet], lowest: tuple[Sheet, Sheet]) -> tuple[Sheet, Sheet]:
    first, second = (
        replace(one, solved=np.column_stack([other.solved[:, :1], one.solved[:, 1:]]))
        for one, other in zip(laid, lowest, strict=True)
    )
    return first, second


def _at_every_look(p: float, laid: tuple[Sheet, Sheet], column: int, budget: float) -> ComparisonAt:
    """Two agents at one p, with what holds at every look."""
    first, second = laid
    solved = (second.solved - first.solved)[first.order, column : column + 1]
    steps = (second.steps - first.steps)[first.order, column : column + 1]
    both = ~np.isnan(second.solved[:, column] - first.solved[:, column])
    fixed, found = paired(first.solved[both, column] > 0, second.solved[both, column] > 0), mean_at_every_look(solved)
    assert found.low is not None
    assert found.high is not None
    success = replace(fixed, low=found.low, high=found.high, p_value=1.0 if found.p_value is None else found.p_value)
    return ComparisonAt(dose=p, success=success, steps=mean_at_every_look(steps, bound=budget))


def _mean(
    differences: Array,
    person: NDArray[np.str_] | None,
    unit: float,
    order: NDArray[np.int64],
    rare: RareBlock | None = None,
) -> BlockMean:
    """Over all p, clustered by luck, and where one side is people also by person.

    With an order of the blocks it holds at every look.
    """
    if len(order):
        return mean_at_every_look(differences[order], bound=unit)
    if person is None:
        return block_mean(differences, unit=unit, rare=rare)
    both = ~np.isnan(differences)
    return crossed_mean(differences[both], np.nonzero(both)[0], person[both], unit=unit, rare=rare)


def _rare(first: Array, second: Array, budget: float) -> RareBlock:
    shortest = float(min(first.min(), second.min()))
    return rare_block(float(first.mean()), float(second.mean()), budget, shortest)


def _steps_at(first: Array, second: Array, person: NDArray[np.str_] | None, budget: float) -> BlockMean:
    rare = _rare(first, second, budget)
    if person is None:
        return block_mean((second - first)[:, None], unit=budget, rare=rare)
    return at_one_p(second - first, person, unit=budget, rare=rare)


def paired_difference(first: Array, second: Array, person: NDArray[np.str_] | None) -> Paired:
    """The difference in success of two agents at one p, over trials of equal luck that both finished.

    Args:
        first: 1 where the first solved its trial, else 0, shape (pairs,).
        second: The same for the second agent.
        person: The person of each pair, if one side is people. Agents are then exchanged within whole people, and the
            interval is over people.
    """
    found = paired(first > 0, second > 0)
    if person is None or len(np.unique(person)) == len(person):
        return found
    by_person = at_one_p(second - first, person, unit=1.0)
    low, high = (-1.0, 1.0) if by_person.low is None or by_person.high is None else (by_person.low, by_person.high)
    return replace(found, low=low, high=high, p_value=1.0 if by_person.p_value is None else by_person.p_value)


def _of(person: NDArray[np.str_] | None, both: NDArray[np.bool_], i: int) -> NDArray[np.str_] | None:
    return None if person is None else person[both[:, i], i]


def _same_at_every_p(laid: Sheet) -> bool:
    return all(
        bool(np.array_equal(of, np.repeat(of[:, :1], of.shape[1], axis=1), equal_nan=True))
        for of in (laid.solved, laid.steps)
    )


def corrected(found: Sequence[AgentComparison]) -> tuple[AgentComparison, ...]:
    """The comparisons with P values corrected for the number of pairs of their family and of doses (Holm).

    Two agents that play identically at every p count as one test, not one for each p.
    """
    success = _holm(found, lambda one: one.success.p_value)
    steps = _holm(found, lambda one: one.steps.p_value)
    moved = _holm(found, lambda one: one.interaction.p_value if one.interaction else None)
    everywhere = [(one, at) for one in found for at in (one.at[:1] if one.copies else one.at)]
    adjusted = dict(
        zip(
            [(id(one), at.dose) for one, at in everywhere],
            holm_by_family([one.family for one, _ in everywhere], [at.success.p_value for _, at in everywhere]),
            strict=True,
        )
    )
    return tuple(
        replace(
            one,
            success_adjusted=success[i],
            steps_adjusted=steps[i],
            at=tuple(
                replace(at, p_adjusted=adjusted[id(one), one.at[0].dose if one.copies else at.dose]) for at in one.at
            ),
            interaction=replace(one.interaction, p_adjusted=moved[i]) if one.interaction else None,
        )
        for i, one in enumerate(found)
    )


def _holm(found: Sequence[AgentComparison], of: Callable[[AgentComparison], float | None]) -> list[float | None]:
    return holm_by_family([one.family for one in found], [of(one) for one in found])
