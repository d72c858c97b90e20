"""False reports against no feedback at all, as a factor: is a false report worse than none?"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from lockprobe.statistics.conditions.design import Design
from lockprobe.statistics.conditions.factors import Factor
from lockprobe.statistics.conditions.series import SeriesArm

NO_FEEDBACK = "no feedback"
"""The name of the factor."""


def no_feedback_factors(design: Design) -> Iterator[Factor]:
    """In each modality the conditions of flips alone, after that in which every report is withheld, if there is one."""
    for modality in design.modalities:
        none, flipped = _labels(design.shown(modality))
        if none and flipped:
            kind, option = NO_FEEDBACK.split()
            yield Factor(kind=kind, option=option, modality=modality, groups=((none, *flipped),))


def _labels(arms: Sequence[SeriesArm]) -> tuple[str, list[str]]:
    """The condition in which every report is withheld, empty without one, and those of flips alone."""
    alone = [(arm, arm.specs[arm.acting[0]], arm.dose(arm.acting[0])) for arm in arms if len(arm.acting) == 1]
    none = (arm.label for arm, spec, dose in alone if spec.full_name == "drop" and dose == 1 and len(spec.options) == 1)
    return next(none, ""), [arm.label for arm, spec, _ in alone if spec.full_name == "flip"]
