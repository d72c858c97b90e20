"""The design of a study, for its analysis."""

from __future__ import annotations

from collections.abc import Iterable

from lockprobe.foundation.spec import Spec, spec_name
from lockprobe.statistics.arms import SeriesArm
from lockprobe.statistics.design import Design
from lockprobe.studies.study import Study
from lockprobe.trial.condition import Condition
from lockprobe.trial.doses import modality_doses


def design_of(study: Study) -> Design:
    """What differs between the conditions of a study."""
    return Design(
        agents=study.labels,
        arms=arms_of(study.conditions),
        axis=study.flip_labels,
        specs=dict(zip(study.labels, study.agents, strict=True)),
    )


def arms_of(conditions: Iterable[Condition]) -> tuple[SeriesArm, ...]:
    """Conditions as their specs tell them."""
    return tuple(map(_arm, conditions))


def _arm(condition: Condition) -> SeriesArm:
    """A condition as its specs tell it; the doses of pictures and of the plant stand among those of interventions."""
    shown, doses = modality_doses(condition.modality)
    pictured = [(Spec(spec_name(shown), options={option: value}), (option,)) for option, value in doses.items()]
    told = [(Spec.parse(spec), names) for spec, names in condition.acting]
    parts = (*told, *pictured, *condition.plant.parts)
    return SeriesArm(
        label=condition.label,
        specs=tuple(spec for spec, _ in parts),
        doses=tuple(names for _, names in parts),
        modality=shown,
    )
