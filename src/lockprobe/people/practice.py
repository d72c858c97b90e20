"""Boxes that people meet beside those of the study: the practice box, and the example of the instructions."""

from __future__ import annotations

from dataclasses import replace

from lockprobe.interventions.condition import flips
from lockprobe.lockbox.box import Lockbox
from lockprobe.lockbox.families import box as named_box
from lockprobe.people.experiment import Experiment
from lockprobe.plan import Plan
from lockprobe.seeds import integer_seed
from lockprobe.spec import PEOPLE
from lockprobe.studies.study import Study

__all__ = ["plan_beside", "practice_plan"]


def practice_plan(study: Study, experiment: Experiment) -> Plan | None:
    """The practice box as a trial: the same for everybody, and all that is told of it is true; None without.

    Raises:
        UnknownName: If there is no such box.
    """
    if not experiment.practice:
        return None
    return plan_beside(study, "practice", named_box(experiment.practice), study.modalities_of(PEOPLE)[0])


def plan_beside(study: Study, name: str, box: Lockbox, modality: str) -> Plan:
    """One trial that is no part of the study but is shown as its trials are, and told truly.

    Args:
        study: The study.
        name: What it is for; its luck depends on it.
        box: The box.
        modality: How it is shown.
    """
    alone = replace(
        study,
        name=name,
        agents=(PEOPLE,),
        box=box,
        conditions=flips((0.0,), study.flip, (modality,)),
        repetitions=1,
        trials=1,
        seed=integer_seed(study.seed, "people", name),
        layout="fixed",
    )
    return alone.plan(PEOPLE, alone.conditions[0], 1, 1)
