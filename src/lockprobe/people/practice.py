"""The practice box. It does not belong to the study, and nothing acts in it."""

from __future__ import annotations

from dataclasses import replace

from lockprobe.boxes.families import box as named_box
from lockprobe.foundation.seeds import integer_seed
from lockprobe.foundation.spec import PEOPLE
from lockprobe.people.experiment import Experiment
from lockprobe.studies.study import Study
from lockprobe.trial.condition import Condition
from lockprobe.trial.doses import modality_doses
from lockprobe.trial.plan import Plan


def practice_plan(study: Study, experiment: Experiment, identity: str = "0") -> Plan:
    """The practice box of a participant as a trial, with true reports only, in a modality of the study.

    Everybody has the same box, on a panel and with labels of their own unless the panel of the study is fixed, so that
    no order in space can be learnt. No picture in it is false or degraded.
    """
    modality, _ = modality_doses(study.modalities_of(PEOPLE)[0])
    own = study.layout != "fixed"
    alone = replace(
        study,
        name="practice",
        agents=(PEOPLE,),
        boxes=(named_box(experiment.practice),),
        conditions=(Condition(modality=modality),),
        repetitions=1,
        trials=1,
        seed=integer_seed(study.seed, "people", "practice"),
        layout="shuffled" if own else "fixed",
    )
    return alone.plan(PEOPLE, alone.conditions[0], 1, 1 + int(identity, 16) if own else 1)
