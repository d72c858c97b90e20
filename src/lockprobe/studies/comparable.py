"""Comparability of studies, and the conditions that they share.

Studies are comparable if they play the same task: box, budget of steps, plant, layout and question are equal. They may
differ in agents, prompts, seeds, flip rates, conditions and numbers of trials. Conditions are matched by their
interventions and modality, not by name. A condition is compared if at least two studies have it.
"""

from __future__ import annotations

from collections.abc import Iterable, KeysView, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from lockprobe.errors import BadFile, BadValue
from lockprobe.interventions.condition import Condition, Recorded
from lockprobe.interventions.prompt import OwnPrompt
from lockprobe.spec import Spec, spec_name
from lockprobe.studies.study import Study

__all__ = ["SharedCondition", "check_comparable", "shared_names"]

_FEWEST = 2
"""Studies that a comparison needs."""

_SAID = 6
"""Names of conditions that a message lists."""

_ALIKE = {
    "max_steps": "the budget of steps",
    "plant": "the plant",
    "layout": "the layout",
    "shuffle": "the shuffling of labels",
    "assessment": "whether agents are asked what their last action did",
}
"""Settings that have to be equal, in words; so has the box."""


@dataclass(frozen=True, slots=True)
class SharedCondition:
    """A condition under the name that several studies share.

    Attributes:
        name: Its interventions as a spec without the prompt; ``truth`` without interventions.
        prompt: File of the prompt; empty for the default prompt. It counts as part of the agent, so two prompts are
            compared like two agents.
    """

    name: str
    prompt: str = ""


def check_comparable(studies: Mapping[Path, Study]) -> None:
    """Refuse studies that play different tasks, and a study that shares no condition with any other.

    Args:
        studies: Directory -> its study.

    Raises:
        BadValue: If there are fewer than two studies.
        BadFile: If one differs from the first in its task, or shares no condition.
    """
    if len(studies) < _FEWEST:
        raise BadValue("directories", len(studies), "two or more, each with a study")
    (first, ours), *others = studies.items()
    for directory, theirs in others:
        if why := _another_task(ours, theirs):
            raise BadFile(directory, f"it cannot be compared with {first}: {why}")
    for directory, study in studies.items():
        rest = [other for place, other in studies.items() if place != directory]
        if not _names(study) & set().union(*map(_names, rest)):
            raise BadFile(directory, f"it shares no condition with the other studies: {_apart(study, rest)}")


def _another_task(ours: Study, theirs: Study) -> str:
    """The first difference between the tasks of two studies, in words; empty if there is none."""
    if ours.box.name != theirs.box.name:
        return f"the box is {theirs.box.name}, not {ours.box.name}"
    if ours.box.as_data() != theirs.box.as_data():
        return f"{theirs.box.name} is another box there under the same name"
    for setting, said in _ALIKE.items():
        there, here = getattr(theirs, setting), getattr(ours, setting)
        if there != here:
            return f"{said} ({setting}) is {there}, not {here}"
    return ""


def _apart(study: Study, rest: Sequence[Study]) -> str:
    """The reason why a study shares no condition: other modalities, or other interventions."""
    shown, elsewhere = dict.fromkeys(study.modalities), dict.fromkeys(m for one in rest for m in one.modalities)
    if not shown.keys() & elsewhere.keys():
        return f"the modality is {_listed(shown)}, not {_listed(elsewhere)}"
    names = dict.fromkeys(name for one in rest for name in _names(one))
    return f"it has {_listed(_names(study))}; they have {_listed(names)}"


def _listed(names: Iterable[str]) -> str:
    listed = list(names)
    return ", ".join(listed[:_SAID]) + (f" and {len(listed) - _SAID} more" if len(listed) > _SAID else "")


def _names(study: Study) -> KeysView[str]:
    return dict.fromkeys(one.name for one in shared_names(study).values()).keys()


def shared_names(study: Study) -> dict[Condition, SharedCondition]:
    """The conditions of a study under their shared names.

    Conditions of one study that differ only in name keep their names.
    """
    found: dict[Condition, SharedCondition] = {}
    for condition in study.conditions:
        shared = _shared(condition)
        if shared in found.values():
            shared = SharedCondition(f"{shared.name} ({condition.label})", shared.prompt)
        found[condition] = shared
    return found


def _shared(condition: Condition) -> SharedCondition:
    prompts = [spec for spec in condition.specs if spec_name(spec) == OwnPrompt.name]
    acting = [spec for spec in condition.specs if spec not in prompts]
    bare = Condition(interventions=tuple(Recorded(spec=spec) for spec in acting), modality=condition.modality)
    if bare.flip is not None and bare.flip.p == 0 and bare.tells_positions:
        bare = Condition(modality=condition.modality)  # a flip that never acts is the truth
    files = (Spec.parse(spec, "intervention").options.get("file", spec) for spec in prompts)
    return SharedCondition(bare.spec, " + ".join(files))
