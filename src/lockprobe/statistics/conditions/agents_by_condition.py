"""Agents compared under each condition beside the flip rates, and in how much the condition changes each of them.

The difference between two agents under a condition uses the trials that both finished under it. How much more the
condition changes the one than the other uses the blocks in which both played it and its control. The pairs of one kind
under the doses of an axis are a family, and under all other conditions of a modality another one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from operator import call

from lockprobe.foundation.parallel import Each
from lockprobe.statistics.agent_comparison.interaction import Interaction
from lockprobe.statistics.agent_comparison.pair import AgentComparison, ComparisonAt
from lockprobe.statistics.agent_comparison.pairs import comparisons
from lockprobe.statistics.conditions.axis_trials import Place, on_axis
from lockprobe.statistics.conditions.design import Design
from lockprobe.statistics.conditions.series import SeriesArm
from lockprobe.statistics.inference.holm import holm_by_family
from lockprobe.statistics.sequential.order import NO_ORDERS, BlockOrder
from lockprobe.statistics.summary import entrant
from lockprobe.trial.record import Trial

_CONTROL, _CONDITION = 0.0, 1.0
"""Places of a condition and its control in a comparison of two agents."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparisonUnder:
    """Two agents under one condition.

    Attributes:
        condition: Its label.
        control: Label of its control.
        axis: Name of the axis whose dose it is; empty for all other conditions.
        pair: The two agents, under the control and under the condition.
        at: Their difference under the condition, its P value corrected for the family (Holm).
        change: How much more the condition changes the success of the second than of the first; None for a baseline,
            for the control itself, and without common blocks.
        change_adjusted: Its P value, corrected for the family (Holm).
        tests: Differences in the family.
        changes: Changes in the family.
    """

    condition: str
    control: str
    axis: str
    pair: AgentComparison
    at: ComparisonAt
    change: Interaction | None
    change_adjusted: float | None = None
    tests: int = 1
    changes: int = 1

    @property
    def family(self) -> tuple[str, ...]:
        """What is judged together with it."""
        return self.axis, *self.pair.family


def agents_by_condition(
    cells: Mapping[tuple[str, str], Sequence[Trial]],
    design: Design,
    orders: Mapping[str, BlockOrder] = NO_ORDERS,
    *,
    each: Each = map,
) -> tuple[ComparisonUnder, ...]:
    """Compare the agents under every condition that is no flip rate.

    Two agents that play a condition and its control alike are compared under the control alone.

    Args:
        cells: The trials of every agent under every condition in which something was changed.
        design: The design of the study.
        orders: Agent -> the order of its blocks, of agents of which everything must hold at every look.
        each: A map function over conditions, sequential or parallel.
    """
    arms = [arm for arm in design.arms if arm.label not in design.axis]
    made = each(call, [_comparisons(cells, design, arm, orders) for arm in arms])
    found = [one for arm, pairs in zip(arms, made, strict=True) for one in _under(design, arm, pairs)]
    families = [one.family for one in found]
    tested = holm_by_family(families, [one.at.success.p_value for one in found])
    changes = [None if one.change is None else one.change.p_value for one in found]
    return tuple(
        replace(
            one,
            at=replace(one.at, p_adjusted=tested[i]),
            change_adjusted=changed,
            tests=families.count(one.family),
            changes=sum(other.change is not None for other in found if other.family == one.family),
        )
        for i, (one, changed) in enumerate(zip(found, holm_by_family(families, changes), strict=True))
    )


def _comparisons(
    cells: Mapping[tuple[str, str], Sequence[Trial]], design: Design, arm: SeriesArm, orders: Mapping[str, BlockOrder]
) -> Callable[[], tuple[AgentComparison, ...]]:
    """What compares the agents under a condition and its control. It holds columns and no trials."""
    label, control = arm.label, design.control(arm.label)
    played = [(name, own) for name, own in cells.items() if name[1] in (label, control) and (name[0], label) in cells]
    trials = [trial for _, own in played for trial in own]
    by_agent = on_axis(trials, _place(control if control != label else ""), orders)
    seed, of = trials[0].seed if trials else 0, [str(spec) for spec in arm.specs]
    return partial(comparisons, [entrant(members) for members in by_agent], seed, of)


def _under(design: Design, arm: SeriesArm, pairs: Sequence[AgentComparison]) -> Iterator[ComparisonUnder]:
    label, control = arm.label, design.control(arm.label)
    axes = (series.axis for series in design.other_axes if label in series.doses and label != control)
    axis = next((" ".join(filter(None, (one.name, one.options, one.rest))) for one in axes), "")
    for pair in pairs:
        at = next((one for one in pair.at if one.dose == _CONDITION), None)
        if at is not None and not pair.copies:
            yield ComparisonUnder(
                condition=label, control=control, axis=axis, pair=pair, at=at, change=pair.interaction
            )


def _place(control: str) -> Callable[[Trial], Place]:
    def place(trial: Trial) -> Place:
        return Place(trial.group, trial.modality, _CONTROL if trial.condition == control else _CONDITION)

    return place
