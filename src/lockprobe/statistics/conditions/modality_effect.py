"""The effect of the modality on one agent (paper, Sec. 3.1, Fig. 3, Table 1).

Trials of equal repetition and trial share their luck over modalities, so they are clusters or pairs.

False-positive rates of the trend at .05 in 4000 studies of 3 modalities, with luck shared by none and by half of the
trials of ``human-inspired``: .017 and .002 with 10 trials each, .043 and .042 with 30
(``benchmarks/modality_rates.py``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from lockprobe.foundation.grouping import grouped
from lockprobe.statistics.broken_trials import bounded, opposed
from lockprobe.statistics.conditions.axis_trials import AxisTrials
from lockprobe.statistics.conditions.modalities import by_fidelity, fidelity
from lockprobe.statistics.course import is_baseline
from lockprobe.statistics.inference.excess import excess
from lockprobe.statistics.inference.hazard import Hazard, solving, worst
from lockprobe.statistics.inference.holm import holm
from lockprobe.statistics.outcomes import Outcomes, joined, solved_in_pairs
from lockprobe.statistics.proportions import ALPHA, Paired, paired


@dataclass(frozen=True, slots=True, kw_only=True)
class ModalityPair:
    """Two modalities compared; interval and P values hold whatever became of broken trials.

    Attributes:
        first: The modality of lower fidelity.
        second: The other modality.
        hazard_ratio: Of solving, second over first: above 1 if the second is faster; None if undefined.
        p_adjusted: Log-rank, two-sided, clustered by luck, corrected for the pairs (Holm) and agents; None with too few
            clusters.
        final: Final success of the second minus that of the first, over the trials that both have.
    """

    first: str
    second: str
    hazard_ratio: float | None
    p_adjusted: float | None
    final: Paired


@dataclass(frozen=True, slots=True, kw_only=True)
class ModalityEffect:
    """The effect of the modality on one agent at its lowest flip rate.

    Attributes:
        agent: Its name, or its spec if it has none.
        modalities: The modalities, from low to high fidelity.
        direction: 1 if the box is solved sooner at higher fidelity, -1 if later or more rarely, else 0.
        p_value: Log-rank test of a trend over fidelity in equal steps (Tarone 1975), two-sided, clustered by luck,
            corrected for agents. Variants of a modality (``rgbd?depth=gray``) have equal fidelity. None with fewer than
            two fidelities, or with six clusters or fewer.
        pairs: Every two modalities.
        agents: Number of agents that are judged together.
    """

    agent: str
    modalities: tuple[str, ...]
    direction: int
    p_value: float | None
    pairs: tuple[ModalityPair, ...]
    agents: int

    @property
    def detectable(self) -> bool:
        """Whether the trend over fidelity is significant."""
        return self.p_value is not None and self.p_value < ALPHA


def modality_effects(agents: Sequence[AxisTrials]) -> tuple[ModalityEffect, ...]:
    """The effect on every agent with ended trials in several modalities, at the lowest flip rate of all.

    The agents that the study is about are judged together, and so are baselines.
    """
    lowest = [one.lowest for one in agents]
    least = min((one.doses[0] for one in lowest), default=0.0)
    shown = grouped((one for one in lowest if one.doses[0] == least and len(one.outcomes)), lambda one: one.agent)
    several = [sorted(own, key=lambda one: by_fidelity(one.modality)) for own in shown.values() if len(own) > 1]
    kinds = [is_baseline(own[0].spec) for own in several]
    return tuple(_effect(own, kinds.count(kind)) for own, kind in zip(several, kinds, strict=True))


def _effect(shown: Sequence[AxisTrials], agents: int) -> ModalityEffect:
    names, budget = [one.modality for one in shown], max(one.budget for one in shown)
    ended, broken = [one.outcomes for one in shown], [one.broken_off for one in shown]
    found = trend = _trend(names, ended)
    if any(map(len, broken)):  # those that broke at the lowest fidelity against all others
        ranks = [fidelity(name) for name in names]
        gains = [rank is not None and rank > min(one for one in ranks if one is not None) for rank in ranks]
        trend = worst(found, opposed(lambda of: _trend(names, of), ended, broken, gains, budget))
    both = list(combinations(range(len(shown)), 2))
    hazards = [solving([ended[i], ended[j]], [broken[i], broken[j]], budget) for i, j in both]
    return ModalityEffect(
        agent=shown[0].agent,
        modalities=tuple(names),
        direction=found.direction,
        p_value=_corrected(trend.p_value, agents),
        pairs=tuple(
            ModalityPair(
                first=names[i],
                second=names[j],
                hazard_ratio=hazard.ratio,
                p_adjusted=_corrected(adjusted, agents),
                final=_final([ended[i], ended[j]], [broken[i], broken[j]]),
            )
            for (i, j), hazard, adjusted in zip(both, hazards, holm([one.p_value for one in hazards]), strict=True)
        ),
        agents=agents,
    )


def _corrected(p_value: float | None, agents: int) -> float | None:
    return None if p_value is None else min(1.0, agents * p_value)


def _trend(modalities: Sequence[str], groups: Sequence[Outcomes]) -> Hazard:
    """The trend over fidelity; modalities without a rank are left out."""
    ranks = [fidelity(one) for one in modalities]
    ranked = [(rank, group) for rank, group in zip(ranks, groups, strict=True) if rank is not None]
    if len({rank for rank, _ in ranked}) < 2:
        return Hazard(ratio=None, direction=0, p_value=None)
    every = joined([group for _, group in ranked])
    score = np.repeat([float(rank) for rank, _ in ranked], [len(group) for _, group in ranked])
    found = excess(score, every.length, every.solved, every.cluster)
    return Hazard(ratio=None, direction=found.direction, p_value=found.p_value)


def _final(ended: Sequence[Outcomes], broken: Sequence[Outcomes]) -> Paired:
    def final(groups: Sequence[Outcomes]) -> Paired:
        solved = solved_in_pairs(*groups)
        return paired(solved[:, 0], solved[:, 1])

    found = final(ended)
    return bounded(found, *opposed(final, ended, broken, (False, True))) if any(map(len, broken)) else found
