"""Comparability of studies, and the conditions that they share.

Studies are comparable if they play the same task: box, budget of steps, plant, layout and question are equal. They may
differ in agents, prompts, seeds, flip rates, conditions and numbers of trials. Conditions are matched by their
interventions and modality, never by name. A condition is compared if at least two studies have it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from itertools import chain
from pathlib import Path

from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.foundation.formatting import listed
from lockprobe.foundation.spec import Spec, spec_name
from lockprobe.interventions.asked_and_done import OwnPrompt
from lockprobe.statistics.design import Design
from lockprobe.studies.study import SIZES, Study, arms_of, flip_axis
from lockprobe.trial.condition import Condition, Recorded

_FREE = ("name", "names", "conditions", "strategy_conditions", *SIZES)
"""Settings that may differ."""


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
    first, ours = next(iter(studies.items()))
    names = {directory: [one.label for one, _ in shared(study).values()] for directory, study in studies.items()}
    for directory, theirs in studies.items():
        free = _FREE if len(ours.boxes) > 1 else (*_FREE, "seed")  # of several, pairs of equal luck are compared
        for name, (there, here) in ours.differences(theirs, but=free).items():
            raise BadFile(directory, f"it cannot be compared with {first}: {name} is {there}, not {here}")
    for directory, own in names.items():
        others = dict.fromkeys(chain(*(names[other] for other in names if other != directory)))
        if others.keys().isdisjoint(own):
            has, have = (listed([*of], named=6) for of in (own, others))
            raise BadFile(directory, f"it shares no condition with the other studies: it has {has}; they have {have}")


def shared(study: Study) -> dict[Condition, tuple[Condition, str]]:
    """The conditions of a study as others share them: what acts, without its name and doses of 0, and the prompt.

    A prompt, by its file, counts as part of the agent, so two prompts are compared like two agents.
    """
    found = {}
    for one in study.conditions:
        prompts = [spec for spec in one.specs if spec_name(spec) == OwnPrompt.name]
        acting = tuple(Recorded(spec=str(spec), doses=doses) for spec, doses in one.acting if str(spec) not in prompts)
        bare = replace(one, interventions=acting, name="")
        files = (Spec.parse(spec, "intervention").options.get("file", spec) for spec in prompts)
        found[one] = bare, " + ".join(files)
    return found


def families(conditions: Iterable[Condition]) -> dict[str, str]:
    """The family of each shared condition, by its label, in the order of the families.

    Flip rates of every modality are one, with the truth; the doses of every other axis are one; all others are one,
    whose name is empty. So a condition more changes nothing that is concluded of another family.
    """
    acting = list(dict.fromkeys(conditions))
    flips = frozenset(one.label for one in flip_axis(acting))
    design = Design(agents=(), arms=arms_of(acting), axis=flips)
    found = {one.label: "flip rate" for one in acting if one.label in flips}
    for axis in filter(None, (one.axis for one in design.against_controls)):
        apart = axis.doses.keys() - found.keys() - {*design.controls.values()}
        found |= {label: axis.key for label in axis.doses if label in apart}
    return found | {one.label: "" for one in acting if one.label not in found}
