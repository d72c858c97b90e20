"""Contrasts: what conditions change in the success of one agent, in trials of equal luck.

Trials of equal repetition and trial share their luck under all conditions. A contrast, its interval and its P value use
the blocks of luck that all of its conditions have. Each belongs to one family, and is corrected for its members and for
the agents that are judged together: those that the study is about, or baselines.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import NamedTuple

import numpy as np

from lockprobe.statistics.blocks import block_mean, blocks_of, contrast
from lockprobe.statistics.clustered import share_of
from lockprobe.statistics.course import Cell, is_baseline
from lockprobe.statistics.design import CONDITIONS, LEVELS, Crossed, Design, Family
from lockprobe.statistics.differences import DifferenceAt, each_difference
from lockprobe.statistics.every_look import share_at_every_look
from lockprobe.statistics.misinterpretation import claims
from lockprobe.statistics.outcomes import Outcomes, ended, idle_interventions, plays_alike
from lockprobe.statistics.proportions import Difference
from lockprobe.trial.condition import Contrast

Cells = Mapping[tuple[str, str], Cell]
"""Every agent under every condition that it has trials of."""


class Effect(NamedTuple):
    """Success of an agent under a condition minus success under the control, in the trials that they share.

    Attributes:
        corrected_for: How many differences are judged together: conditions, agents and further groups of conditions.
        family: What these are.
        factor: The option whose levels the two conditions are; empty for other conditions.
    """

    agent: str
    control: str
    condition: str
    difference: DifferenceAt
    corrected_for: int
    family: str
    factor: str = ""


def declared(
    cells: Cells, contrasts: Mapping[str, Contrast], design: Design
) -> Iterator[tuple[str, str, int, list[Difference]]]:
    """What a study asks of each agent that has trials under all conditions of a contrast, in blocks of equal luck.

    All contrasts of all agents that the study is about are one family, and those of baselines another. A condition in
    which nothing was changed is in no contrast; people, whose boxes lie in several blocks, have none.

    Yields:
        Agent, name of the contrast, how many are judged together, and the mean under the conditions of one side minus
        that under those of the other. Of success it is followed by both in the blocks that count; of several conditions
        these are without interval.
    """
    cells = acting(cells, design)
    asked = []
    for agent, (name, one) in product(design.agents, contrasts.items()):
        labels = {*one.of, *one.minus}
        own = {label: cells[agent, label] for label in labels if (agent, label) in cells}
        if own.keys() >= labels and not any(cell.outcomes.ended.crossed for cell in own.values()):
            asked.append((agent, is_baseline(design.spec_of(agent)), name, one, own))
    sizes = Counter(baseline for _, baseline, *_ in asked)
    for agent, baseline, name, one, own in asked:
        if one.measure == "misreading":
            found = [_misread(own, one, sizes[baseline])]
        else:
            groups = {label: cell.outcomes for label, cell in own.items()}
            change = contrast(groups, one, choices=sizes[baseline])
            found = [change, *(_share(groups, side) for side in (one.of, one.minus))] if change.n else [change]
        if found[0].n:
            yield agent, name, sizes[baseline], found


def _misread(cells: Mapping[str, Cell], asked: Contrast, choices: int) -> Difference:
    """Misreading under some conditions less that under others, over the blocks that have statements under all of them.

    With Student's interval and P value over blocks, both corrected (Bonferroni).
    """
    by_block = [
        {(one.repetition, one.trial): [said.false_belief for said in claims(one)] for one in ended(cells[label].trials)}
        for label in (*asked.of, *asked.minus)
    ]
    shared = set.intersection(*map(set, by_block))
    table = [
        [np.mean(own[block]) for own in by_block] for block in sorted(shared) if all(own[block] for own in by_block)
    ]
    if not table:
        return Difference(value=math.nan)
    rates, sides = np.array(table), len(asked.of)
    changes = rates[:, :sides].mean(axis=1) - rates[:, sides:].mean(axis=1)
    found = block_mean(changes[:, None], choices=choices)
    return found if found.p_value is None else replace(found, p_value=min(1.0, choices * found.p_value))


def _share(groups: Mapping[str, Outcomes], names: Sequence[str]) -> Difference:
    """Success under some of the conditions, in blocks that have a trial under all of them."""
    blocks = blocks_of([one.ended for one in groups.values()])
    solved, box = blocks.whole(range(len(groups)))
    some, n = solved[:, [[*groups].index(name) for name in names]], len(solved)
    if len(names) > 1:
        return Difference(value=float(np.mean(some)), n=n, clusters=n)
    share = share_at_every_look(some[:, 0]) if blocks.order else share_of(some[:, 0], (), (), box)
    return Difference(value=share.value, low=share.low, high=share.high, n=n, clusters=n)


def acting(cells: Cells, design: Design, *, wholly: bool = False) -> Cells:
    """The conditions in which something was changed; with ``wholly``, in which no intervention changed nothing.

    A control is to change nothing.
    """
    acts = {arm.label: arm.without() for arm in design.arms if arm.label not in design.controls.values()}

    def idle(label: str, cell: Cell) -> bool:
        found = idle_interventions(cell.trials, acts[label]) if label in acts else []
        return bool(found) if wholly else "" in found

    return {name: cell for name, cell in cells.items() if not idle(name[1], cell)}


def effects(cells: Cells, design: Design) -> Iterator[Effect]:
    """Every condition against the first of its group, in each family of the design.

    Of a factor, such as what becomes of a false report, an agent that plays alike under all levels is compared with
    nothing.
    """
    cells = acting(cells, design)
    for family in design.families:
        heeding, option = _heeding(cells, design, family), family.name.partition(LEVELS)[2]
        sizes = Counter(is_baseline(design.spec_of(agent)) for agent in {agent for agent, _ in heeding})
        for agent, group in product(design.agents, family.groups):
            if (agent, group[0]) not in cells or (option and (agent, group) not in heeding):
                continue
            agents = max(1, sizes[is_baseline(design.spec_of(agent))]) * len(family.groups)
            names = [label for label in group if (agent, label) in cells]
            tested = each_difference([cells[agent, name].outcomes for name in names], agents=agents)
            many = len(tested) * agents
            for place, one in tested:
                yield Effect(agent, group[0], names[place], one, many, family.name, option)


def _heeding(cells: Cells, design: Design, family: Family) -> list[tuple[str, tuple[str, ...]]]:
    """Agent and group, where the first condition and another have trials, in which the agent does not play alike."""
    found = []
    for agent, group in product(design.agents, family.groups):
        own = [cells[agent, name].trials for name in group if (agent, name) in cells]
        several = (agent, group[0]) in cells and len(own) > 1
        if several and not plays_alike([trial for trials in own for trial in trials]):
            found.append((agent, group))
    return found


def interactions(cells: Cells, design: Design) -> Iterator[tuple[str, Crossed, Difference, int]]:
    """Every interaction: agent, what is crossed, the contrast, and how many are judged together.

    Two interventions are left out where their doses have an interaction. None is computed where all must hold at every
    look.
    """
    acted, cells = acting(cells, design, wholly=True), acting(cells, design)
    sizes = Counter(
        (of.modality, is_baseline(design.spec_of(agent)))
        for of in design.families
        if of.name == CONDITIONS
        for agent, _ in _heeding(cells, design, of)
    )

    def found_in(agent: str, crossed: Crossed, choices: int = 1) -> Difference | None:
        asked = crossed.interaction
        if asked is None or not all((agent, name) in acted for name in (*asked.of, *asked.minus)):
            return None
        own = {name: acted[agent, name].outcomes for name in (*asked.of, *asked.minus)}
        found = contrast(own, asked, scale=2, choices=choices)
        return found if found.n else None

    for agent, (modality, control) in product(design.agents, design.controls.items()):
        if (agent, control) not in cells or cells[agent, control].outcomes.order is not None:
            continue
        every = [one for one in design.crossed[modality] if found_in(agent, one)]
        dosed = {name for one in every if one.axes for name in one.conditions.values()}
        every = [one for one in every if one.axes or one.conditions[1, 1] not in dosed]
        choices = max(1, sizes[modality, is_baseline(design.spec_of(agent))]) * max(1, len(every))
        for one in every:
            if found := found_in(agent, one, choices):
                yield agent, one, found, choices
