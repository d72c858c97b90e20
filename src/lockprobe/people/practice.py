"""The practice box and the example box of the instructions. Neither belongs to the study, and nothing acts in them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from lockprobe.boxes.box import Joint, JointKind, LayoutKind, Lockbox
from lockprobe.boxes.families import box as named_box
from lockprobe.foundation.seeds import integer_seed
from lockprobe.foundation.spec import PEOPLE
from lockprobe.people.box_view import Sentences, panel_to_show
from lockprobe.people.experiment import Experiment
from lockprobe.studies.running.paused_trial import PausedTrial
from lockprobe.studies.study import Study
from lockprobe.trial.condition import Condition
from lockprobe.trial.doses import modality_doses
from lockprobe.trial.loop import Executor, here
from lockprobe.trial.plan import Names, Plan

_KINDS: tuple[JointKind, ...] = ("prismatic", "revolute", "prismatic")

Panels = tuple[dict[str, Any], dict[str, Any]]
"""The example box in one modality, before the first step and after one attempt."""


def practice_plan(study: Study, experiment: Experiment, identity: str = "0") -> Plan | None:
    """The practice box of a participant as a trial, with true reports only; None without practice.

    Everybody has the same box, on a panel and with labels of their own unless the panel of the study is fixed, so that
    no order in space can be learnt.
    """
    if not experiment.practice:
        return None
    own = study.layout != "fixed"
    box, modality = named_box(experiment.practice), _true_modalities(study)[0]
    trial = 1 + int(identity, 16) if own else 1
    return _extra_plan(study, "practice", box, modality, "shuffled" if own else "fixed", trial)


def example_box(study: Study) -> Lockbox:
    """The box of the instructions: two or three joints of which none locks another; the last slider is the target.

    It has another number of joints than the box of the study, and its target is another kind of joint in another place.

    >>> from lockprobe.studies.options.studyfile import study
    >>> example_box(study("flips")).names
    ('joint-1', 'joint-2', 'joint-3')
    """
    kinds = _KINDS if len(study.box.joints) != len(_KINDS) else _KINDS[1:]
    joints = tuple(
        Joint(name=f"joint-{number}", kind=kind, place=(round((number - 0.5) / len(kinds), 3), 0.5))
        for number, kind in enumerate(kinds, 1)
    )
    return Lockbox(name="example", joints=joints, interlock={}, initial=(False,) * len(joints), target=joints[-1].name)


async def examples_of(study: Study, words: Sentences, place: Executor = here) -> Mapping[str, Panels]:
    """The example in each modality of people, without its doses; none where the plant breaks.

    It is a trial like any other in which one joint was attempted, so it looks as the study's boxes do. ``place`` is
    where plants run.
    """
    found: dict[str, Panels] = {}
    for modality in _true_modalities(study):
        plan = _extra_plan(study, "example", example_box(study), modality)
        trial = await PausedTrial.begin(plan, place=place)
        try:
            if trial.situation is None:
                continue
            before = panel_to_show(plan, trial.situation, words)
            await trial.attempt(Names(plan).labels[0])
            if trial.situation is not None:
                found[modality] = before, panel_to_show(plan, trial.situation, words)
        finally:
            await trial.close()
    return found


def true_modality(modality: str) -> str:
    """A modality that shows the truth: no picture in it is false or degraded.

    >>> true_modality("rgb?p=0.4&blur=8"), true_modality("symbolic?tell=state")
    ('rgb', 'symbolic?tell=state')
    """
    return modality_doses(modality)[0]


def _true_modalities(study: Study) -> tuple[str, ...]:
    return tuple(dict.fromkeys(map(true_modality, study.modalities_of(PEOPLE))))


def _extra_plan(
    study: Study, name: str, box: Lockbox, modality: str, layout: LayoutKind = "fixed", trial: int = 1
) -> Plan:
    """One trial outside the study, with true reports only; the random seed depends on ``name``."""
    alone = replace(
        study,
        name=name,
        agents=(PEOPLE,),
        boxes=(box,),
        conditions=(Condition(modality=modality),),
        repetitions=1,
        trials=1,
        seed=integer_seed(study.seed, "people", name),
        layout=layout,
    )
    return alone.plan(PEOPLE, alone.conditions[0], 1, trial)
