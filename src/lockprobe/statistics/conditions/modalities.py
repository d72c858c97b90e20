"""The effect of the modality on one agent (paper, Sec. 3.1, Fig. 3, Table 1).

The paper orders its modalities by fidelity: RGB, RGB-D, ground truth (true positions in words). Trials of equal
repetition and trial share their luck over modalities, so they are clusters or pairs.

False-positive rates of the trend at .05 in 4000 studies of 3 modalities, with luck shared by none and by half of the
trials of ``human-inspired``: .017 and .002 with 10 trials each, .043 and .042 with 30
(``benchmarks/modality_rates.py``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from lockprobe.foundation.spec import Spec
from lockprobe.statistics.broken_trials import bounded, opposed
from lockprobe.statistics.inference.excess import excess, grid
from lockprobe.statistics.inference.logrank import bounded_speed, holm, solution_logrank
from lockprobe.statistics.outcomes import Outcomes, broken_off, joined, outcomes, solved_in_pairs
from lockprobe.statistics.proportions import ALPHA, Paired, paired
from lockprobe.trial.record import Trial

_SPOKEN: Mapping[str, str] = {"rgb": "RGB", "rgbd": "RGB-D", "symbolic": ""}
"""The paper's modalities from low to high fidelity. Its ground truth is :data:`_CONTENTS` in :data:`_FORMS`."""

_CONTENTS: Mapping[str, str] = {"both": "positions and outcomes", "state": "positions", "outcome": "outcomes"}
"""What a report in words tells."""

_FORMS: Mapping[str, str] = {"words": "in words", "json": "as JSON", "table": "as a table"}
"""The form of a report in words."""

_SOURCES: Mapping[str | None, str] = {"verdict": "verdicts of the arm", "camera": "readings of the camera"}
"""Sources of reports in words that are not the truth; the paper has none of them."""


_Played = tuple[str, Outcomes, Outcomes]
"""A modality, with the trials that ended and those that broke."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ModalityPair:
    """The comparison of two modalities for one agent; intervals and P values hold whatever became of broken trials.

    Attributes:
        first: The modality of lower fidelity.
        second: The other modality.
        hazard_ratio: Hazard ratio of solving, second over first: above 1 if the second is faster; None if undefined.
        p_value: Log-rank, two-sided, clustered by luck; None with too few clusters.
        p_adjusted: Corrected for the number of pairs (Holm) and of agents.
        final: Difference in final success, second minus first, over the trials that both have.
    """

    first: str
    second: str
    hazard_ratio: float | None
    p_value: float | None
    p_adjusted: float | None
    final: Paired


@dataclass(frozen=True, slots=True, kw_only=True)
class ModalityEffect:
    """The effect of the modality on one agent.

    Attributes:
        agent: Its name, or its spec if it has none.
        p: Flip probability, [0, 1].
        modalities: The modalities, from low to high fidelity.
        direction: 1 if the box is solved sooner at higher fidelity, -1 if later or more rarely, else 0.
        p_value: Log-rank test of a trend over fidelity in equal steps, two-sided, clustered by luck. Variants of a
            modality (``rgbd?depth=gray``) have equal fidelity. None with fewer than two fidelities, or with six
            clusters or fewer, which could never be significant.
        p_all: Log-rank test of any difference; None with too few clusters. Where trials broke, the smallest P value of
            ``pairs``.
        pairs: All pairwise comparisons.
        agents: Number of agents that are judged together; P values are corrected for it (Bonferroni).
    """

    agent: str
    p: float
    modalities: tuple[str, ...]
    direction: int
    p_value: float | None
    p_all: float | None
    pairs: tuple[ModalityPair, ...]
    agents: int = 1

    @property
    def differs_in_fidelity(self) -> bool:
        """Whether at least two fidelities are compared, so that a trend is defined."""
        return len({_fidelity(modality) for modality in self.modalities} - {None}) > 1

    @property
    def detectable(self) -> bool:
        """Whether the trend over fidelity is significant."""
        return self.p_value is not None and self.p_value < ALPHA


def spoken(modality: str) -> str:
    """A modality in plain words, with its options. What the paper calls ground truth can be false here.

    >>> spoken("rgbd?depth=height"), spoken("symbolic?tell=state"), spoken("symbolic?form=json")
    ('RGB-D, depth=height', 'positions in words', 'positions and outcomes as JSON')
    """
    spec = Spec.parse(modality, "modality")
    called = _SPOKEN.get(spec.full_name, spec.full_name)
    if (source := spec.options.get("source")) in _SOURCES:
        return ", ".join((_SOURCES[source], *_said(spec.without(["source"]))))
    if spec.full_name == "symbolic":
        content, form = (spec.options.get(one, default) for one, default in (("tell", "both"), ("form", "words")))
        called, spec = f"{_CONTENTS[content]} {_FORMS[form]}", spec.without(["tell", "form"])
    return ", ".join((called, *_said(spec)))


def _said(spec: Spec) -> list[str]:
    return [f"{option}={value}" for option, value in spec.options.items()]


def by_fidelity(modality: str) -> tuple[int, str]:
    """The sort key of a modality, from low to high fidelity."""
    rank = _fidelity(modality)
    return len(_SPOKEN) if rank is None else rank, modality


def _fidelity(modality: str) -> int | None:
    """The rank of a modality's fidelity from 0, equal for all its variants; None if the paper does not rank it."""
    spec = Spec.parse(modality, "modality")
    ranked = spec.full_name in _SPOKEN and spec.options.get("source") not in _SOURCES
    return list(_SPOKEN).index(spec.full_name) if ranked else None


def modality_effect(groups: Sequence[Sequence[Trial]], agents: int = 1) -> ModalityEffect | None:
    """Compare one agent's trials at one p, one group per modality; None if fewer than two groups have ended trials.

    Args:
        groups: The trials of each modality.
        agents: Number of agents that are judged together.
    """
    ordered = sorted((group for group in groups if group), key=lambda group: by_fidelity(group[0].modality))
    played = [(group[0].modality, counted, broken_off(group)) for group in ordered if len(counted := outcomes(group))]
    found = [(modality, counted) for modality, counted, _ in played]
    if len(found) < 2:
        return None
    first, budget = ordered[0][0], max(trial.budget for group in ordered for trial in group)
    direction, p_value = _bounded_trend(played, budget)
    pairs = [_pair(one, two, budget) for one, two in combinations(played, 2)]
    return ModalityEffect(
        agent=first.group,
        p=first.p or 0.0,
        modalities=tuple(modality for modality, _ in found),
        direction=direction,
        p_value=_corrected(p_value, agents),
        p_all=_corrected(
            min(holm([pair.p_value for pair in pairs]), key=lambda one: 1.0 if one is None else one)
            if any(len(broken) for *_, broken in played)
            else solution_logrank(joined([counted for _, counted in found])).p_all,
            agents,
        ),
        pairs=tuple(
            replace(pair, p_adjusted=_corrected(adjusted, agents))
            for pair, adjusted in zip(pairs, holm([pair.p_value for pair in pairs]), strict=True)
        ),
        agents=agents,
    )


def _corrected(p_value: float | None, agents: int) -> float | None:
    return None if p_value is None else min(1.0, agents * p_value)


def _trend(found: Sequence[tuple[str, Outcomes]]) -> tuple[int, float | None]:
    """Direction and P value of the trend over fidelity (Tarone 1975); modalities without a rank are left out."""
    ranked = [(rank, group) for modality, group in found if (rank := _fidelity(modality)) is not None]
    if len({rank for rank, _ in ranked}) < 2:
        return 0, None
    counted = joined([group for _, group in ranked])
    score = np.repeat([float(rank) for rank, _ in ranked], [len(group) for _, group in ranked])
    running, event = grid(counted.length, counted.solved)
    compared = excess(score[None], event, running, cluster=counted.cluster)
    return compared.direction, compared.p_value_t


def _bounded_trend(played: Sequence[_Played], budget: int) -> tuple[int, float | None]:
    """The trend, and its larger P value at both ends: trials that broke at the lowest fidelity against all others."""
    counted, broken = [one for _, one, _ in played], [one for *_, one in played]
    names = [modality for modality, *_ in played]
    direction, p_value = _trend(list(zip(names, counted, strict=True)))
    if p_value is None or not any(map(len, broken)):
        return direction, p_value
    ranks = [_fidelity(name) for name in names]
    gains = [rank is not None and rank > min(one for one in ranks if one is not None) for rank in ranks]
    ends = opposed(lambda of: _trend(list(zip(names, of, strict=True))), counted, broken, gains, budget)
    values = [value for way, value in ends if way == direction and value is not None]
    return direction, max(values) if len(values) == len(ends) else 1.0


def _pair(first: _Played, second: _Played, budget: int) -> ModalityPair:
    both, broken = (first[1], second[1]), (first[2], second[2])

    def final(groups: Sequence[Outcomes]) -> Paired:
        solved = solved_in_pairs(*groups)
        return paired(solved[:, 0], solved[:, 1])

    compared, pairs = bounded_speed(*both, *broken, budget), final(both)
    if any(map(len, broken)):
        pairs = bounded(pairs, *opposed(final, both, broken, (False, True)))
    return ModalityPair(
        first=first[0],
        second=second[0],
        hazard_ratio=compared.hazard_ratio if compared else None,
        p_value=compared.p_value if compared else None,
        p_adjusted=None,
        final=pairs,
    )
