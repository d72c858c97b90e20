"""The flip axis of a study: those of its conditions that differ in flip rate and modality alone."""

from __future__ import annotations

from collections.abc import Sequence

from lockprobe.interventions.conditions import flip_alone
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.trial.condition import Condition


def flip_axis(conditions: Sequence[Condition]) -> tuple[Condition, ...]:
    """Flips of one reading and the truth: each rate once in each modality. Of several, that of the first flip."""
    flips = [one for one in conditions if one.p is not None]
    reading = reading_of(flips)
    found: dict[tuple[str, float | None], Condition] = {}
    for one in flips:
        if not one.specs or ((flip := flip_alone(one)) is not None and flip.at_rate(0) == reading):
            found.setdefault((one.modality, one.p), one)
    return tuple(found.values())


def reading_of(flips: Sequence[Condition]) -> OutcomeFlip:
    """What a false report is in the first of these conditions that flips reports: a flip at rate 0."""
    return next(
        (flip.at_rate(0) for one in flips if one.specs and (flip := flip_alone(one)) is not None), OutcomeFlip()
    )
