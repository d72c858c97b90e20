"""Contrasts: what conditions change in the success of one agent, in trials of equal luck.

Trials of equal repetition and trial share their luck under all conditions. A contrast, its interval and its P value use
the blocks of luck that all of its conditions have. Each belongs to one family, and is corrected for its members and for
the agents that are judged together: those that the study is about, or baselines.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Protocol

import numpy as np

from lockprobe.foundation.seeds import generator
from lockprobe.statistics.agent_comparison.paired import BlockMean, columns, mean_of_blocks
from lockprobe.statistics.broken_trials import bounded, opposed
from lockprobe.statistics.clustered import share_of
from lockprobe.statistics.conditions.crossed import Crossed
from lockprobe.statistics.conditions.design import Design
from lockprobe.statistics.conditions.factors import Factor
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.idle import idle_interventions
from lockprobe.statistics.inference.difference import DifferenceAt, each_difference
from lockprobe.statistics.outcomes import Outcomes, heeded_at_most
from lockprobe.statistics.sequential.contrasts import share_at_every_look
from lockprobe.trial.condition import Contrast
from lockprobe.trial.record import Trial

CONDITIONS, CONTROLS = "conditions against the control", "modalities against the first"
"""Families of comparisons beside those of axes and options: conditions, and the controls of all modalities."""

LEVELS = "levels of "
"""How the names of families of factors begin."""


class _Cell(Protocol):
    """One agent under one condition."""

    @property
    def trials(self) -> Sequence[Trial]: ...
    @property
    def ended(self) -> Outcomes: ...
    @property
    def broke(self) -> Outcomes: ...


Cells = Mapping[tuple[str, str], _Cell]
"""Every agent under every condition that it has trials of."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Effect:
    """Success of an agent under a condition minus success under the control, in the trials that they share.

    Attributes:
        modality: How the box was shown under the control.
        corrected_for: How many differences are judged together: conditions, agents and further groups of conditions.
        family: What these are.
        axis: The dose or the option whose levels the two conditions are; empty for other conditions.
    """

    agent: str
    modality: str
    control: str
    condition: str
    difference: DifferenceAt
    corrected_for: int
    family: str
    axis: str = ""


def contrast(
    cells: Sequence[_Cell], weights: Sequence[int], *, factor: float = 1.0, choices: int = 1
) -> BlockMean | None:
    """A weighted sum of success of one agent under conditions; None if no block of luck has a trial in each.

    The P value is from sign flips of whole blocks. If trials broke, it and the interval hold whatever became of them.

    The weights sum to 0, ``factor`` scales the sum, and ``choices`` contrasts are judged together (Bonferroni).
    """
    groups, broken = [one.ended for one in cells], [one.broke for one in cells]
    most = sum(weight for weight in weights if weight > 0)

    def of(trials: Sequence[Outcomes]) -> BlockMean:
        laid = columns(trials)
        sums = np.asarray(sum(weight * one.solved for weight, one in zip(weights, laid, strict=True)))
        return mean_of_blocks(sums, laid[0].box, planned=laid[0].planned, unit=most, factor=factor, choices=choices)

    if not all(map(len, groups)) or not (found := of(groups)).pairs:
        return None
    if any(map(len, broken)):
        found = bounded(found, *opposed(of, groups, broken, [weight > 0 for weight in weights]))
    return found


@dataclass(frozen=True, slots=True, kw_only=True)
class Declared:
    """A contrast that a study declares, of one agent.

    Attributes:
        modality: How the box was shown under the first condition.
        change: Mean success under the conditions of one side minus that under those of the other.
        of: Success under the conditions of one side, in the blocks that count; of several its mean, without interval.
        minus: That under those of the other side.
        choices: How many contrasts of how many agents are judged together.
    """

    agent: str
    modality: str
    name: str
    change: BlockMean
    of: BlockMean
    minus: BlockMean
    choices: int


def declared(cells: Cells, contrasts: Mapping[str, Contrast], design: Design) -> Iterator[Declared]:
    """What a study asks of each agent that has trials under all conditions of a contrast, in blocks of equal luck.

    All contrasts of all agents that the study is about are one family, and those of baselines another. A condition in
    which nothing was changed is in no contrast; people, whose boxes lie in several blocks, have none.
    """
    cells = acting(cells, design)
    asked = [
        (agent, is_baseline(design.spec_of(agent)), name, one, own)
        for agent in design.agents
        for name, one in contrasts.items()
        for own in [[cells[agent, label] for label in (*one.of, *one.minus) if (agent, label) in cells]]
        if len(own) == len(one.of) + len(one.minus) and not any(cell.ended.crossed for cell in own)
    ]
    sizes = Counter(baseline for _, baseline, *_ in asked)
    for agent, baseline, name, one, own in asked:
        weights = [len(one.minus)] * len(one.of) + [-len(one.of)] * len(one.minus)
        change = contrast(own, weights, factor=1 / (len(one.of) * len(one.minus)), choices=sizes[baseline])
        if change is not None:
            of, minus = _success_on_sides([cell.ended for cell in own], len(one.of))
            yield Declared(
                agent=agent, modality=own[0].trials[0].modality, name=name, change=change, of=of, minus=minus,
                choices=sizes[baseline],
            )  # fmt: skip


def _success_on_sides(groups: Sequence[Outcomes], first: int) -> Iterator[BlockMean]:
    """Success under the first conditions and under the others, in blocks that have a trial under all of them."""
    laid = columns(groups)
    solved = np.hstack([sheet.solved for sheet in laid])
    kept = ~np.isnan(solved).any(axis=1)
    for side in np.split(solved[kept].T, [first]):
        mean = BlockMean(value=float(np.mean(side)), pairs=side.shape[1], blocks=side.shape[1])
        if len(side) == 1:
            box = laid[0].box[kept] if len(laid[0].box) else ()
            share = share_at_every_look(side[0]) if laid[0].planned else share_of(side[0], (), (), box)
            mean = replace(mean, value=share.value, low=share.low, high=share.high)
        yield mean


def acting(cells: Cells, design: Design, *, wholly: bool = False) -> Cells:
    """The conditions in which something was changed; with ``wholly``, in which no intervention changed nothing.

    A control is to change nothing.
    """
    acts = {arm.label: arm.without() for arm in design.arms if arm.label not in design.controls}

    def idle(label: str, cell: _Cell) -> bool:
        found = idle_interventions(cell.trials, acts[label]) if label in acts else []
        return bool(found) if wholly else "" in found

    return {name: cell for name, cell in cells.items() if not idle(name[1], cell)}


def against_control(cells: Cells, design: Design) -> Iterator[Effect]:
    """Each modality's other conditions against its control, and the controls of all modalities against the first."""
    cells = acting(cells, design)
    sizes = _judged_together(cells, design)
    for agent, family, labels in _families(design):
        if (agent, labels[0]) in cells:
            names = [label for label in labels if (agent, label) in cells]
            many = max(1, sizes[family, labels[0], is_baseline(design.spec_of(agent))])
            yield from _against_first(cells, agent, names, "conditions", agents=many, family=family)


def _families(design: Design) -> Iterator[tuple[str, str, tuple[str, ...]]]:
    """Agent, name and conditions of every family of comparisons with a control, which comes first."""
    for agent, of in product(design.agents, design.comparisons.values()):
        yield agent, CONDITIONS, (of.control, *of.others)
        yield agent, CONTROLS, (of.control, *of.controls)


def _judged_together(cells: Cells, design: Design) -> Counter[tuple[str, str, bool]]:
    """How many agents are judged together in a family, by its control: those of which a difference can be found."""
    return Counter(
        (family, labels[0], is_baseline(design.spec_of(agent)))
        for agent, family, labels in _families(design)
        if _can_differ(cells, agent, labels)
    )


def _can_differ(cells: Cells, agent: str, names: Sequence[str]) -> bool:
    """Whether the first condition and another have trials, in which the agent does not play alike."""
    found = [cells[agent, name] for name in names if (agent, name) in cells]
    if len(found) < 2 or (agent, names[0]) not in cells:
        return False
    return heeded_at_most([trial for cell in found for trial in cell.trials]) is None


def against_first(cells: Cells, factors: Iterable[Factor], design: Design) -> Iterator[Effect]:
    """Every level of a factor against the first one; all groups of conditions that differ in it are one family."""
    cells = acting(cells, design)
    for factor in factors:
        asked = [
            (agent, group) for agent in design.agents for group in factor.groups if _can_differ(cells, agent, group)
        ]
        sizes = Counter(is_baseline(design.spec_of(agent)) for agent in {agent for agent, _ in asked})
        for agent, group in asked:
            names = [label for label in group if (agent, label) in cells]
            use = factor.name, *cells[agent, names[0]].trials[0].specs
            many = sizes[is_baseline(design.spec_of(agent))] * len(factor.groups)
            family = LEVELS + factor.name
            yield from _against_first(cells, agent, names, *use, agents=many, family=family, axis=factor.name)


def _against_first(
    cells: Cells, agent: str, names: Sequence[str], *use: str, agents: int, family: str, axis: str = ""
) -> Iterator[Effect]:
    """Conditions of one agent against the first; ``use`` names the stream of the permutations, which people need."""
    own = [cells[agent, name] for name in names]
    first = own[0].trials[0]
    rng = generator(first.seed, "analysis", first.spec, first.modality, *use)
    tested = each_difference([one.ended for one in own], rng, broken=[one.broke for one in own], agents=agents)
    for place, difference in tested:
        yield Effect(
            agent=agent, modality=first.modality, control=names[0], condition=names[place], difference=difference,
            corrected_for=len(tested) * agents, family=family, axis=axis,
        )  # fmt: skip


def interactions(cells: Cells, design: Design) -> Iterator[tuple[str, Crossed, BlockMean, int]]:
    """Every interaction: agent, what is crossed, the contrast, and how many are judged together.

    Two interventions are left out where their doses have an interaction. None is computed where all must hold at every
    look.
    """
    acted = acting(cells, design, wholly=True)
    sizes = _judged_together(acting(cells, design), design)

    def found_in(agent: str, crossed: Crossed, choices: int = 1) -> BlockMean | None:
        own = [acted[agent, name] for name in crossed.weights if (agent, name) in acted]
        if not own or len(own) < len(crossed.weights):
            return None
        return contrast(own, [*crossed.weights.values()], factor=crossed.factor, choices=choices)

    for agent, of in product(design.agents, design.comparisons.values()):
        if (agent, of.control) not in cells or cells[agent, of.control].ended.order is not None:
            continue
        every = [one for one in of.crossed if found_in(agent, one)]
        dosed = {name for one in every if one.axes for name in one.conditions.values()}
        every = [one for one in every if one.axes or one.conditions[1, 1] not in dosed]
        choices = max(1, sizes[CONDITIONS, of.control, is_baseline(design.spec_of(agent))]) * max(1, len(every))
        for one in every:
            if found := found_in(agent, one, choices):
                yield agent, one, found, choices
