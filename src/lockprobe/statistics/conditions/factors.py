"""Factors: options that are no numbers, such as what becomes of a false report, and conditions that differ in one.

A dose has an order and a zero, a factor has levels. Every level is compared with the first one, all else equal, in the
trials that share their luck. In each modality the contrasts of one factor are a family, whatever else acts beside it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from lockprobe.foundation.seeds import generator
from lockprobe.statistics.behaviour import heeded_at_most
from lockprobe.statistics.conditions.effects import Effect, Effects
from lockprobe.statistics.conditions.series import SeriesArm
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.inference.difference import each_difference
from lockprobe.statistics.outcomes import Outcomes, broken_off, outcomes
from lockprobe.statistics.sequential.order import NO_ORDERS, BlockOrder
from lockprobe.trial.record import Trial

LEVELS = "levels of "
"""How the names of families of factors begin."""

READING_FACTORS = ("flip others", "flip inverts")
"""Factors that are readings of a false report."""

_Cells = Mapping[tuple[str, str], Sequence[Trial]]
"""The trials of every agent under every condition."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Factor:
    """An option that is no number, and the conditions that differ in it alone.

    Attributes:
        kind: Name of the intervention.
        option: The option.
        modality: How the box is shown in all of them.
        groups: Conditions that differ in the option alone: first the one that does not say it, or else the first of
            the study, then those that are compared with it.
    """

    kind: str
    option: str
    modality: str
    groups: tuple[tuple[str, ...], ...]

    @property
    def name(self) -> str:
        """The intervention and its option, ``flip others``."""
        return f"{self.kind} {self.option}"


def factors_of(arms: Sequence[SeriesArm], controls: Collection[str] = ()) -> tuple[Factor, ...]:
    """Every factor of a study, in the order of its conditions.

    Args:
        arms: Its conditions.
        controls: Labels of conditions that every other one is compared with already.
    """
    levels: dict[tuple[str, str, str], dict[tuple[object, ...], dict[str, str]]] = {}
    options = {(spec.full_name, option) for arm in arms for spec in arm.specs for option in spec.options}
    for arm in arms:
        for place in arm.acting:
            spec = arm.specs[place]
            for kind, option in sorted(options):
                if kind == spec.full_name and option not in arm.doses[place]:
                    groups = levels.setdefault((kind, option, arm.modality), {})
                    own = groups.setdefault(arm.family((place, option)), {})
                    own.setdefault(spec.options.get(option, ""), arm.label)
    found = []
    for (kind, option, modality), groups in levels.items():
        kept = [own for own in groups.values() if len(own) > 1 and not all(map(_is_number, own))]
        without_first = [tuple(own[level] for level in sorted(own, key=bool)) for own in kept]
        apart = tuple(group for group in without_first if group[0] not in controls)
        if apart:
            found.append(Factor(kind=kind, option=option, modality=modality, groups=apart))
    return tuple(found)


def _is_number(text: str) -> bool:
    try:
        float(text or "0")
    except ValueError:
        return False
    return True


def factor_effects(
    cells: _Cells, factor: Factor, agents: Sequence[str], orders: Mapping[str, BlockOrder] = NO_ORDERS
) -> Iterator[Callable[[], Effects | None]]:
    """What computes what the levels of a factor did to each agent, against the first level; it holds no trials.

    Agents that the study is about are one family, and baselines another; each is corrected for its agents, and for all
    contrasts of the factor.

    Args:
        cells: The trials of every agent under every condition.
        factor: The factor.
        agents: The agents.
        orders: Agent -> the order of its blocks, of agents of which everything must hold at every look.
    """
    asked = [(agent, group) for agent in agents for group in factor.groups if _can_differ(cells, agent, group)]
    baseline = {agent: is_baseline(cells[agent, group[0]][0].spec) for agent, group in asked}
    sizes = Counter(baseline.values())
    for agent, group in asked:
        names = [label for label in group if (agent, label) in cells]
        first = cells[agent, names[0]][0]
        yield partial(
            _of_agent,
            agent,
            first.modality,
            names,
            [outcomes(cells[agent, name], order=orders.get(agent)) for name in names],
            [broken_off(cells[agent, name], order=orders.get(agent)) for name in names],
            generator(first.seed, "analysis", first.spec, first.modality, factor.name, *first.specs),
            factor.name,
            sizes[baseline[agent]] * len(factor.groups),
        )


def _of_agent(
    agent: str,
    modality: str,
    names: Sequence[str],
    compared: Sequence[Outcomes],
    broken: Sequence[Outcomes],
    rng: np.random.Generator,
    factor: str,
    many: int,
) -> Effects | None:
    """What the levels of a factor did to one agent; None without a common trial."""
    tested = each_difference(compared, rng, broken=broken, agents=many)
    if not tested:
        return None
    seen = tuple(Effect(condition=names[place], difference=one) for place, one in tested)
    return Effects(
        agent=agent, modality=modality, control=names[0], effects=seen, interplays=(), agents=many, axis=factor,
        family=f"{LEVELS}{factor}",
    )  # fmt: skip


def _can_differ(cells: _Cells, agent: str, group: Sequence[str]) -> bool:
    """Whether the first of these conditions and another have trials, in which the agent does not play alike."""
    found = [cells[agent, label] for label in group if (agent, label) in cells]
    if len(found) < 2 or (agent, group[0]) not in cells:
        return False
    return heeded_at_most([trial for own in found for trial in own]) is None
