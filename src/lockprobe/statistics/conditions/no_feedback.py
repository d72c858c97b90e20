"""False reports against no feedback at all, as a factor: is a false report worse than none?"""

from __future__ import annotations

from collections.abc import Iterator

from lockprobe.statistics.conditions.design import Design
from lockprobe.statistics.conditions.factors import Factor

NO_FEEDBACK = "no feedback"
"""The name of the factor."""


def no_feedback_factors(design: Design) -> Iterator[Factor]:
    """In each modality the conditions of flips alone, after that in which every report is withheld, if there is one."""
    for modality in design.modalities:
        arms = [arm for arm in design.shown(modality) if len(arm.acting) == 1]
        alone = [(arm.label, arm.specs[arm.acting[0]], arm.dose(arm.acting[0])) for arm in arms]
        none = next((label for label, spec, p in alone if spec.full_name == "drop" and p == 1 == len(spec.options)), "")
        flipped = [label for label, spec, _ in alone if spec.full_name == "flip"]
        if none and flipped:
            kind, option = NO_FEEDBACK.split()
            yield Factor(kind=kind, option=option, modality=modality, groups=((none, *flipped),))
