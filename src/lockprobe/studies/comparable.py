"""Comparability of studies, and the conditions that they share.

Studies are comparable if they play the same task: box, budget of steps, plant, layout and question are equal. They may
differ in agents, prompts, seeds, flip rates, conditions and numbers of trials. Conditions are matched by their
interventions and modality, never by name. A condition is compared if at least two studies have it.
"""

from __future__ import annotations

from collections.abc import Iterable, KeysView, Mapping
from dataclasses import dataclass, replace
from hashlib import sha256
from itertools import chain
from pathlib import Path

from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.foundation.formatting import listed
from lockprobe.foundation.spec import Spec, spec_name
from lockprobe.interventions.asked_and_done import OwnPrompt
from lockprobe.statistics.design import Design, axis_key
from lockprobe.studies.study import Study, arms_of, flip_axis
from lockprobe.trial.condition import Condition, Recorded

_LONGEST = 180
"""The most characters of a spec that names a condition; of a longer one a hash says the rest."""

_ALIKE = {
    "max_steps": "the budget of steps",
    "plant": "the plant",
    "layout": "the layout",
    "shuffle": "how often labels are drawn",
    "assessment": "whether agents are asked what their last action did",
    "hypothesis": "when agents are asked how the box works",
}
"""Settings that have to be equal, in words; so has the box."""


@dataclass(frozen=True, slots=True)
class SharedCondition:
    """A condition as several studies share it.

    Attributes:
        acting: What acts in it, without the prompt and without doses of 0; named only to tell it from others.
        prompt: File of the prompt; empty for the default prompt. It counts as part of the agent, so two prompts are
            compared like two agents.
    """

    acting: Condition
    prompt: str = ""

    @property
    def name(self) -> str:
        """What acts as a spec; ``truth`` if nothing does."""
        return self.acting.label


def check_comparable(studies: Mapping[Path, Study]) -> None:
    """Refuse studies that play different tasks, and a study that shares no condition with any other.

    Args:
        studies: Directory -> its study.

    Raises:
        BadValue: If there are fewer than two studies.
        BadFile: If one differs from the first in its task, or shares no condition.
    """
    if len(studies) < 2:
        raise BadValue("directories", len(studies), "two or more, each with a study")
    (first, ours), *rest = studies.items()
    for directory, theirs in rest:
        if why := _another_task(ours, theirs):
            raise BadFile(directory, f"it cannot be compared with {first}: {why}")
    for directory, study in studies.items():
        others = [_names(other) for place, other in studies.items() if place != directory]
        if not _names(study) & set().union(*others):
            here, there = (listed([*names], named=6) for names in (_names(study), dict.fromkeys(chain(*others))))
            why = f"it shares no condition with the other studies: it has {here}; they have {there}"
            raise BadFile(directory, why)


def _another_task(ours: Study, theirs: Study) -> str:
    """The first difference between the tasks of two studies, in words; empty if there is none."""
    if ours.boxes != theirs.boxes:
        here, there = (listed([box.name for box in one.boxes], named=3) for one in (ours, theirs))
        return f"its boxes, in their order, are {there}, not {here}{', or are others of these names' * (here == there)}"
    if len(ours.boxes) > 1 and ours.seed != theirs.seed:
        seeds = f"the seed is {theirs.seed}, not {ours.seed}"
        return f"{seeds}: studies of several boxes are compared in pairs of equal luck"
    for setting, said in _ALIKE.items():
        there, here = getattr(theirs, setting), getattr(ours, setting)
        if there != here:
            return f"{said} ({setting}) is {there}, not {here}"
    return ""


def _names(study: Study) -> KeysView[str]:
    return dict.fromkeys(one.name for one in shared_names(study).values()).keys()


def shared_names(study: Study) -> dict[Condition, SharedCondition]:
    """The conditions of a study under their shared names."""
    return {condition: _shared(condition) for condition in study.conditions}


def _shared(condition: Condition) -> SharedCondition:
    prompts = [spec for spec in condition.specs if spec_name(spec) == OwnPrompt.name]
    acting = tuple(Recorded(spec=spec, doses=doses) for spec, doses in condition.acting if spec not in prompts)
    files = (Spec.parse(spec, "intervention").options.get("file", spec) for spec in prompts)
    whole = " + ".join((*(one.spec for one in acting), *filter(None, [condition.plant.spec]), condition.modality))
    name = f"{whole[:_LONGEST]}\N{HORIZONTAL ELLIPSIS} {sha256(whole.encode()).hexdigest()[:8]}"
    bare = replace(condition, interventions=acting, name=name if len(whole) > _LONGEST else "")
    return SharedCondition(bare, " + ".join(files))


def families(conditions: Iterable[SharedCondition]) -> dict[str, str]:
    """The family of each shared condition, by name, in the order of the families.

    Flip rates of every modality are one, with the truth; the doses of every other axis are one; all others are one,
    whose name is empty. So a condition more changes nothing that is concluded of another family.
    """
    acting = list(dict.fromkeys(one.acting for one in conditions))
    axis = frozenset(one.label for one in flip_axis(acting))
    design = Design(agents=(), arms=arms_of(acting), axis=axis)
    found = {one.label: "flip rate" for one in acting if one.label in axis}
    for one in design.other_axes:
        name = axis_key(one.axis.name, one.axis.options, one.axis.rest)
        found |= {label: name for label in one.doses if label not in found and label not in design.controls}
    return found | {one.label: "" for one in acting if one.label not in found}
