"""The effect of the modality on one agent (paper, Sec. 3.1, Fig. 3, Table 1).

Trials of equal repetition and trial share their luck over modalities, so they are clusters or pairs.

False-positive rates of the trend at .05 in 4000 studies of 3 modalities, with luck shared by none and by half of the
trials of ``human-inspired``: .017 and .002 with 10 trials each, .043 and .042 with 30
(``benchmarks/modality_rates.py``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from typing import NamedTuple

import numpy as np

from lockprobe.foundation.grouping import grouped
from lockprobe.statistics.broken_trials import bounded, opposed, worst
from lockprobe.statistics.conditions.modalities import by_fidelity, fidelity
from lockprobe.statistics.course import Course
from lockprobe.statistics.distributions import holm
from lockprobe.statistics.inference.log_rank import Hazard, excess, solving
from lockprobe.statistics.outcomes import Outcomes, joined, solved_in_pairs
from lockprobe.statistics.paired_proportions import Paired, paired


class ModalityPair(NamedTuple):
    """Two modalities, the second, of higher fidelity, over or less the first, whatever became of broken trials.

    Attributes:
        hazard: Of solving; its P value is corrected for the pairs (Holm) and for agents.
        final: The difference in final success over the trials that both have.
    """

    first: str
    second: str
    hazard: Hazard
    final: Paired


class ModalityEffect(NamedTuple):
    """The effect of the modality on one agent at its lowest flip rate.

    Attributes:
        modalities: From low to high fidelity.
        trend: Log-rank test of a trend over fidelity in equal steps (Tarone 1975), corrected for agents. Variants of a
            modality (``rgbd?depth=gray``) have equal fidelity. None with one fidelity or too few clusters.
        pairs: Every two modalities.
        agents: Number of agents that are judged together.
    """

    agent: str
    modalities: tuple[str, ...]
    trend: Hazard
    pairs: tuple[ModalityPair, ...]
    agents: int


def modality_effects(agents: Sequence[Course]) -> tuple[ModalityEffect, ...]:
    """The effect on every agent with ended trials in several modalities, at the lowest flip rate of all.

    The agents that the study is about are judged together, and so are baselines.
    """
    least = min((one.doses[0] for one in agents), default=0.0)
    lowest = (one.lowest for one in agents if one.doses[0] == least)
    shown = grouped((one for one in lowest if len(one.outcomes)), lambda one: one.agent)
    several = [sorted(own, key=lambda one: by_fidelity(one.modality)) for own in shown.values() if len(own) > 1]
    kinds = [own[0].baseline for own in several]
    return tuple(_effect(own, kinds.count(kind)) for own, kind in zip(several, kinds, strict=True))


def _effect(shown: Sequence[Course], agents: int) -> ModalityEffect:
    names, budget = [one.modality for one in shown], max(one.budget for one in shown)
    ranks = [fidelity(name) for name in names]
    ended, broken = [one.outcomes for one in shown], [one.broken_off for one in shown]
    trend = _trend(ranks, ended)
    if any(map(len, broken)):  # those that broke at the lowest fidelity against all others
        gains = [rank is not None and rank > min(one for one in ranks if one is not None) for rank in ranks]
        trend = worst(trend, opposed(lambda of: _trend(ranks, of), ended, broken, gains, budget))

    def corrected(p_value: float | None) -> float | None:
        return None if p_value is None else min(1.0, agents * p_value)

    def final(groups: Sequence[Outcomes]) -> Paired:
        return paired(*solved_in_pairs(*groups).T)

    hazards, finals = [], []
    pairs = [*combinations(zip(names, ended, broken, strict=True), 2)]
    for (_, *one), (_, *two) in pairs:
        own, broke = zip(one, two, strict=True)
        hazards.append(solving(own, broke, budget))
        apart = final(own)
        finals.append(bounded(apart, *opposed(final, own, broke, (False, True))) if any(map(len, broke)) else apart)
    holms = map(corrected, holm([one.p_value for one in hazards]))
    return ModalityEffect(
        agent=shown[0].agent,
        modalities=tuple(names),
        trend=replace(trend, p_value=corrected(trend.p_value)),
        pairs=tuple(
            ModalityPair(one[0], two[0], replace(hazard, p_value=p_value), last)
            for (one, two), hazard, p_value, last in zip(pairs, hazards, holms, finals, strict=True)
        ),
        agents=agents,
    )


def _trend(ranks: Sequence[int | None], groups: Sequence[Outcomes]) -> Hazard:
    """The trend over fidelity; modalities without a rank are left out."""
    ranked = [(rank, group) for rank, group in zip(ranks, groups, strict=True) if rank is not None]
    if len({rank for rank, _ in ranked}) < 2:
        return Hazard()
    every = joined([group for _, group in ranked])
    score = np.repeat([float(rank) for rank, _ in ranked], [len(group) for _, group in ranked])
    return excess(score, every.length, every.solved, every.cluster)
