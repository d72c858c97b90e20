"""Contrasts: what conditions change in the success of one agent, in trials of equal luck.

Trials of equal repetition and trial share their luck under all conditions. A contrast, its interval and its P value use
the blocks of luck that all of its conditions have. Each belongs to one family, and is corrected for its members and for
the agents that are judged together: those that the study is about, or baselines.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Protocol

import numpy as np

from lockprobe.foundation.seeds import generator
from lockprobe.statistics.blocks import Blocks, Played, blocks_of, contrast
from lockprobe.statistics.clustered import share_of
from lockprobe.statistics.conditions.crossed import Crossed
from lockprobe.statistics.conditions.design import Design
from lockprobe.statistics.conditions.factors import Factor
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.idle import idle_interventions
from lockprobe.statistics.inference.difference import DifferenceAt, each_difference
from lockprobe.statistics.outcomes import heeded_at_most
from lockprobe.statistics.proportions import Difference
from lockprobe.statistics.sequential.contrasts import share_at_every_look
from lockprobe.trial.condition import Contrast
from lockprobe.trial.record import Trial

CONDITIONS, CONTROLS = "conditions against the control", "modalities against the first"
"""Families of comparisons beside those of axes and options: conditions, and the controls of all modalities."""

LEVELS = "levels of "
"""How the names of families of factors begin."""


class _Cell(Played, Protocol):
    """One agent under one condition."""

    @property
    def trials(self) -> Sequence[Trial]: ...


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


def declared(
    cells: Cells, contrasts: Mapping[str, Contrast], design: Design
) -> Iterator[tuple[str, str, int, tuple[Difference, Difference, Difference]]]:
    """What a study asks of each agent that has trials under all conditions of a contrast, in blocks of equal luck.

    All contrasts of all agents that the study is about are one family, and those of baselines another. A condition in
    which nothing was changed is in no contrast; people, whose boxes lie in several blocks, have none.

    Yields:
        Agent, name of the contrast, how many are judged together, and mean success under the conditions of one side
        minus that under those of the other, followed by both in the blocks that count; of several conditions these are
        without interval.
    """
    cells = acting(cells, design)
    asked = [
        (agent, is_baseline(design.spec_of(agent)), name, one, own)
        for agent in design.agents
        for name, one in contrasts.items()
        for own in [{label: cells[agent, label] for label in (*one.of, *one.minus) if (agent, label) in cells}]
        if own.keys() >= {*one.of, *one.minus} and not any(cell.ended.crossed for cell in own.values())
    ]
    sizes = Counter(baseline for _, baseline, *_ in asked)
    for agent, baseline, name, one, own in asked:
        blocks, choices, of, minus = blocks_of(own), sizes[baseline], {*one.of}, {*one.minus}
        weights = dict.fromkeys(of, len(minus)) | dict.fromkeys(minus, -len(of))
        change = contrast(blocks, weights, factor=1 / (len(of) * len(minus)), choices=choices)
        if change.n:
            yield agent, name, choices, (change, _share(blocks, one.of), _share(blocks, one.minus))


def _share(blocks: Blocks, names: Sequence[str]) -> Difference:
    """Success under some of the conditions, in blocks that have a trial under all of them."""
    whole = ~np.isnan([*blocks.solved.values()]).any(axis=0)
    solved, n = np.array([blocks.solved[name][whole] for name in names]), int(whole.sum())
    if len(names) > 1:
        return Difference(value=float(np.mean(solved)), n=n, clusters=n)
    box = blocks.box[whole] if len(blocks.box) else ()
    share = share_at_every_look(solved[0]) if blocks.planned else share_of(solved[0], (), (), box)
    return Difference(value=share.value, low=share.low, high=share.high, n=n, clusters=n)


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


def interactions(cells: Cells, design: Design) -> Iterator[tuple[str, Crossed, Difference, int]]:
    """Every interaction: agent, what is crossed, the contrast, and how many are judged together.

    Two interventions are left out where their doses have an interaction. None is computed where all must hold at every
    look.
    """
    acted = acting(cells, design, wholly=True)
    sizes = _judged_together(acting(cells, design), design)

    def found_in(agent: str, crossed: Crossed, choices: int = 1) -> Difference | None:
        own = {name: acted[agent, name] for name in crossed.weights if (agent, name) in acted}
        if not own or len(own) < len(crossed.weights):
            return None
        found = contrast(blocks_of(own), crossed.weights, factor=crossed.factor, choices=choices)
        return found if found.n else None

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
