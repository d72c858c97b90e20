"""The effects of interventions on one agent: against the control, crossed, and as dose grids.

Trials of equal repetition and trial share their luck under all conditions. A difference, its interval and its P value
use the trials that both conditions have, and are corrected for the number of comparisons with the control and for the
agents of the study. Interactions are a second family: they are corrected for their number and for the agents.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lockprobe.foundation.seeds import generator
from lockprobe.statistics.agent_comparison.paired import BlockMean, block_mean, sheets
from lockprobe.statistics.broken_trials import bounded, opposed
from lockprobe.statistics.conditions.dose_grid import Grid, GridSummary, grid_summary
from lockprobe.statistics.conditions.series import Crossing
from lockprobe.statistics.inference.difference import DifferenceAt, each_difference
from lockprobe.statistics.outcomes import Outcomes, broken_off, outcomes
from lockprobe.statistics.proportions import ALPHA
from lockprobe.statistics.sequential.order import BlockOrder
from lockprobe.trial.record import Trial

CONDITIONS, CONTROLS = "conditions against the control", "modalities against the first"
"""Families of comparisons beside those of axes and options: conditions, and the controls of all modalities."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Effect:
    """The difference in success between one condition and the control.

    Attributes:
        condition: Its name.
        difference: Success under the condition minus success under the control, in one sample of trials.
    """

    condition: str
    difference: DifferenceAt

    @property
    def detectable(self) -> bool:
        """Whether it is significant after correction for the number of conditions and of agents."""
        return self.difference.p_value < ALPHA


@dataclass(frozen=True, slots=True, kw_only=True)
class Interplay:
    """The interaction of two crossed interventions.

    Attributes:
        crossing: The four conditions.
        change: The effect of the second with the first, minus its effect alone, over blocks of equal luck, [-2, 2].
            The P value is from sign flips of whole blocks; P value and interval are corrected for ``choices``.
        choices: Number of interactions of all agents that are judged together.
    """

    crossing: Crossing
    change: BlockMean
    choices: int = 1

    @property
    def detectable(self) -> bool:
        """Whether the test rejects and the interval excludes 0."""
        return self.change.p_value is not None and self.change.p_value < ALPHA and self.change.clear


@dataclass(frozen=True, slots=True, kw_only=True)
class Effects:
    """The effects of the conditions of one modality on one agent.

    Attributes:
        agent: Its name, or its spec if it has none.
        modality: How the box was shown.
        control: The condition that the others are compared with.
        effects: The other conditions, in the order of the study, if they share a trial with the control.
        interplays: Every crossing of two interventions that was played and is part of no grid with an interaction.
        grids: Every pair of interventions with several crossed doses.
        agents: Number of agents (and ways of showing the box) that are judged together.
        axis: Name of the dose whose levels they are: a family of their own; empty for all others.
        family: What is judged together.
    """

    agent: str
    modality: str
    control: str
    effects: tuple[Effect, ...]
    interplays: tuple[Interplay, ...]
    grids: tuple[GridSummary, ...] = ()
    agents: int = 1
    axis: str = ""
    family: str = CONDITIONS


def effects(
    trials: Mapping[str, Sequence[Trial]],
    control: str,
    crossed: Sequence[Crossing] = (),
    gridded: Sequence[Grid] = (),
    idle: Collection[str] = (),
    *,
    axis: Collection[str] = (),
    agents: int = 1,
    family: str = CONDITIONS,
    order: BlockOrder | None = None,
) -> Effects | None:
    """Compare the conditions of one agent in one modality with the control.

    Args:
        trials: Condition -> its trials, in the order of the study.
        control: The condition that the others are compared with; a key of ``trials``.
        crossed: Crossings of four conditions each; incomplete ones are left out.
        gridded: Grids of crossed doses; those without a trial are left out.
        idle: Conditions in which an intervention changed nothing: they are in no crossing and in no grid.
        axis: Conditions that an axis compares with the control, in a family of their own: crossings and grids use them.
        agents: Number of agents that are judged together.
        family: What is judged together.
        order: The order of the blocks, if differences must hold at every look. Interactions are left out then.

    Returns:
        None if no other condition shares a trial with the control, and none are crossed.
    """
    found = {name: outcomes(members, order=order) for name, members in trials.items()}
    broken = {name: broken_off(members, order=order) for name, members in trials.items()}
    first = next((one for one in trials.get(control, ())), None)
    if first is None:
        return None
    others = [name for name in found if name != control and name not in axis]
    names = [control, *others]
    rng = generator(first.seed, "analysis", first.spec, first.modality, "conditions")
    tested = each_difference(
        [found[name] for name in names], rng, broken=[broken[name] for name in names], agents=agents
    )
    acting = {name: one for name, one in found.items() if name not in idle}
    interplays, summaries = interactions(crossed, gridded, acting, broken, agents) if order is None else ((), ())
    if not (tested or interplays or summaries):
        return None
    seen = [Effect(condition=names[place], difference=one) for place, one in tested]
    return Effects(
        agent=first.group,
        modality=first.modality,
        control=control,
        effects=tuple(seen),
        interplays=interplays,
        grids=summaries,
        agents=agents,
        family=family,
    )


def interactions(
    crossed: Sequence[Crossing],
    gridded: Sequence[Grid],
    found: Mapping[str, Outcomes],
    broken: Mapping[str, Outcomes],
    agents: int,
) -> tuple[tuple[Interplay, ...], tuple[GridSummary, ...]]:
    """Every interaction once, in a grid where there is one; corrected for their number and the agents (Bonferroni)."""
    summaries = [one for grid in gridded if (one := grid_summary(grid, found, broken)).cells]
    tested = [one for one in summaries if one.interaction is not None]
    in_grid = {name for one in tested for name in one.grid.conditions.values()}
    alone = [one for one in crossed if one.both not in in_grid and _interaction(one, found, broken) is not None]
    choices = agents * max(1, len(alone) + len(tested))
    return (
        tuple(made for crossing in alone if (made := _interaction(crossing, found, broken, choices))),
        tuple(grid_summary(one.grid, found, broken, choices) for one in summaries),
    )


def _interaction(
    crossing: Crossing, found: Mapping[str, Outcomes], broken: Mapping[str, Outcomes], choices: int = 1
) -> Interplay | None:
    names = (crossing.neither, crossing.first, crossing.second, crossing.both)
    if not all(name in found and len(found[name]) for name in names):
        return None

    def change(groups: Sequence[Outcomes]) -> BlockMean:
        _, made = sheets([replace(one, dose=np.zeros(len(one))) for one in groups])
        neither, first, second, both = (one.solved[:, :1] for one in made)
        mean = block_mean((both - first) - (second - neither), unit=2.0, choices=choices)
        return replace(mean, p_value=None if mean.p_value is None else min(1.0, choices * mean.p_value))

    own = [found[name] for name in names]
    seen = change(own)
    if not seen.pairs:
        return None
    if any(len(broken[name]) for name in names):
        gains = (True, False, False, True)
        seen = bounded(seen, *opposed(change, own, [broken[name] for name in names], gains))
    return Interplay(crossing=crossing, change=seen, choices=choices)
