"""Factors: options that are no numbers, such as what becomes of a false report, and conditions that differ in one.

A dose has an order and a zero, a factor has levels. Every level is compared with the first one, all else equal. In each
modality the contrasts of one factor are a family, whatever else acts beside it.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import NamedTuple

from lockprobe.statistics.conditions.axis import SeriesArm

READING_FACTORS = ("flip others", "flip inverts")
"""Factors that are readings of a false report."""

NO_FEEDBACK = "no feedback"
"""The factor of false reports against no report at all."""


class Factor(NamedTuple):
    """An option that is no number, and the conditions that differ in it alone.

    The name is that of the intervention and the option, ``flip others``. First of each group comes the condition that
    does not say it, or else the first of the study, then those that are compared with it.
    """

    name: str
    groups: tuple[tuple[str, ...], ...]


def factors_of(arms: Sequence[SeriesArm], controls: Collection[str] = ()) -> tuple[Factor, ...]:
    """Every factor of a study, in the order of its conditions; with ``controls`` others are compared already."""
    levels: dict[tuple[str, str], dict[tuple[object, ...], dict[str, str]]] = {}
    options = {(spec.full_name, option) for arm in arms for spec in arm.specs for option in spec.options}
    for arm in arms:
        for place in arm.acting:
            spec = arm.specs[place]
            for kind, option in sorted(options):
                if kind == spec.full_name and option not in arm.doses[place]:
                    groups = levels.setdefault((f"{kind} {option}", arm.modality), {})
                    own = groups.setdefault(arm.family((place, option)), {})
                    own.setdefault(spec.options.get(option, ""), arm.label)
    found = []
    for (name, _), groups in levels.items():
        kept = [own for own in groups.values() if len(own) > 1 and not all(map(_is_number, own))]
        without_first = [tuple(own[level] for level in sorted(own, key=bool)) for own in kept]
        apart = tuple(group for group in without_first if group[0] not in controls)
        if apart:
            found.append(Factor(name, apart))
    return tuple(found)


def _is_number(text: str) -> bool:
    try:
        float(text or "0")
    except ValueError:
        return False
    return True


def no_feedback_factor(arms: Sequence[SeriesArm]) -> list[Factor]:
    """The conditions of flips alone after that in which every report is withheld, of one modality; none without one."""
    alone = [(arm.label, arm.specs[arm.acting[0]], arm.dose(arm.acting[0])) for arm in arms if len(arm.acting) == 1]
    none = next((label for label, spec, p in alone if spec.full_name == "drop" and p == 1 == len(spec.options)), "")
    flipped = [label for label, spec, _ in alone if spec.full_name == "flip"]
    return [Factor(NO_FEEDBACK, ((none, *flipped),))] if none and flipped else []
