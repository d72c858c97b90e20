"""A box as an example for the instructions, shown as those of the study are, and none of them.

It has another number of joints than the box of the study, and its target is another kind of joint in another place. It
is a trial like any other in which one joint was attempted, told truly: so it looks as the boxes do, in every modality.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from lockprobe.lockbox.box import Joint, JointKind, Lockbox
from lockprobe.people.box_view import panel_to_show
from lockprobe.people.experiment import Experiment
from lockprobe.people.paused_trial import Held
from lockprobe.people.practice import plan_beside
from lockprobe.people.scenes import Panel
from lockprobe.plan import Names
from lockprobe.spec import PEOPLE
from lockprobe.studies.study import Study
from lockprobe.trial import Executor, here

__all__ = ["Shown", "example_box", "examples_of"]

_KINDS: tuple[JointKind, ...] = ("prismatic", "revolute", "prismatic")


class Shown(NamedTuple):
    """One modality.

    Attributes:
        before: The box before the first step.
        after: The same when one joint was attempted.
    """

    before: Panel
    after: Panel


def example_box(study: Study) -> Lockbox:
    """Two or three joints of which none locks another; the last slider is the target.

    >>> from lockprobe.studies.studyfile import study
    >>> example_box(study("flips")).names
    ('joint-1', 'joint-2', 'joint-3')
    """
    kinds = _KINDS if len(study.box.joints) != len(_KINDS) else _KINDS[1:]
    joints = tuple(
        Joint(name=f"joint-{number}", kind=kind, place=(round((number - 0.5) / len(kinds), 3), 0.5))
        for number, kind in enumerate(kinds, 1)
    )
    return Lockbox(name="example", joints=joints, interlock={}, initial=(False,) * len(joints), target=joints[-1].name)


async def examples_of(study: Study, experiment: Experiment, place: Executor = here) -> Mapping[str, Shown]:
    """The example in each modality in which people see the study's boxes; none where the plant breaks.

    Args:
        study: The study.
        experiment: How people take part.
        place: Where plants do their work.
    """
    found: dict[str, Shown] = {}
    for modality in study.modalities_of(PEOPLE):
        plan = plan_beside(study, "example", example_box(study), modality)
        held = await Held.begin(plan, place=place)
        try:
            if held.situation is None:
                continue
            before = panel_to_show(plan, held.situation, experiment.view)
            await held.attempt(Names(plan).labels[0])
            if held.situation is not None:
                found[modality] = Shown(before, panel_to_show(plan, held.situation, experiment.view))
        finally:
            await held.close()
    return found
