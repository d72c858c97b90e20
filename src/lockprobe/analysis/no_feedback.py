"""False reports against no feedback at all: is a false report worse than none?

Every condition in which reports are flipped alone is compared with the one in which every report is withheld, in the
trials that share their luck. In each modality these contrasts are a family, for the agents that the study is about and
for baselines apart.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

from lockprobe.analysis.behaviour import heeded_at_most
from lockprobe.analysis.design import Design
from lockprobe.analysis.effects import Effect, Effects
from lockprobe.analysis.inference.difference import each_difference
from lockprobe.analysis.outcomes import outcomes
from lockprobe.analysis.series import SeriesArm
from lockprobe.analysis.summary import is_reference
from lockprobe.record import Trial
from lockprobe.seeds import generator

__all__ = ["NO_FEEDBACK", "against_no_feedback"]

NO_FEEDBACK = "no feedback"
"""The family of these contrasts."""

_Cells = Mapping[tuple[str, str], Sequence[Trial]]


def against_no_feedback(cells: _Cells, design: Design) -> Iterator[Effects]:
    """What false reports did to each agent, against no feedback; nothing without such a condition.

    Args:
        cells: The trials of every agent under every condition in which something was changed.
        design: The design of the study.
    """
    asked = [
        (agent, [none, *flipped])
        for modality in design.modalities
        for none, flipped in [_labels(design.shown(modality))]
        for agent in design.agents
        if none and flipped and _can_differ(cells, agent, [none, *flipped])
    ]
    sizes = Counter(_family(cells, agent, names) for agent, names in asked)
    for agent, names in asked:
        present = [name for name in names if (agent, name) in cells]
        first = cells[agent, present[0]][0]
        rng = generator(first.seed, "analysis", first.spec, first.modality, NO_FEEDBACK)
        tested = each_difference(
            [outcomes(cells[agent, name]) for name in present], rng, agents=sizes[_family(cells, agent, names)]
        )
        if tested:
            yield Effects(
                agent=agent,
                modality=first.modality,
                control=present[0],
                effects=tuple(Effect(condition=present[place], difference=one) for place, one in tested),
                interplays=(),
                agents=sizes[_family(cells, agent, names)],
                axis=NO_FEEDBACK,
                family=NO_FEEDBACK,
            )


def _labels(arms: Sequence[SeriesArm]) -> tuple[str, list[str]]:
    """The condition in which every report is withheld, empty without one, and those of flips alone."""
    alone = [(arm, arm.specs[arm.acting[0]], arm.dose(arm.acting[0])) for arm in arms if len(arm.acting) == 1]
    none = (arm.label for arm, spec, dose in alone if spec.full_name == "drop" and dose == 1 and len(spec.options) == 1)
    return next(none, ""), [arm.label for arm, spec, _ in alone if spec.full_name == "flip"]


def _can_differ(cells: _Cells, agent: str, names: Sequence[str]) -> bool:
    """Whether there is something to compare, in which the agent does not play alike."""
    found = [cells[agent, name] for name in names if (agent, name) in cells]
    if len(found) < 2 or (agent, names[0]) not in cells:
        return False
    return heeded_at_most([trial for own in found for trial in own]) is None


def _family(cells: _Cells, agent: str, names: Sequence[str]) -> tuple[str, bool]:
    return names[0], is_reference(cells[agent, names[0]][0].spec)
