"""The studies that ship: what their names stand for, where a user says nothing else.

Each is a study file in ``lockprobe/presets``, with tables of what is played instead in some cases (``when``), and of
what strategies or models alone play.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from pydantic import Field

from lockprobe.boxes.families import ALIKE
from lockprobe.foundation.errors import Conflict
from lockprobe.foundation.inputs import read_preset
from lockprobe.foundation.spec import PEOPLE
from lockprobe.plants.catalogue import PlantSource, resolve_plant
from lockprobe.studies.modality import is_pictured, taken_in
from lockprobe.studies.options.study_options import NamedCondition, StudyOptions
from lockprobe.trial.record import STATES


class Preset(StudyOptions):
    """A study that ships.

    Attributes:
        when: Case -> what is played instead: ``short``, where nothing is said of what is played; on ``several_boxes``;
            ``as_paper``, as close to the paper as it says (each option cites its section; ``docs/as-paper.md`` compares
            them with the defaults); with the ``parts`` of a false report.
        strategies: ``short`` or ``full`` -> what strategies play besides, since it costs nothing.
        models: The same -> what alone models play beside strategies.
    """

    when: dict[str, StudyOptions] = Field(default_factory=dict)
    strategies: dict[str, StudyOptions] = Field(default_factory=dict)
    models: dict[str, StudyOptions] = Field(default_factory=dict)


@cache
def preset(name: str) -> Preset:
    """The study of a name."""
    return Preset.model_validate(read_preset(name))


def is_short(asked: StudyOptions) -> bool:
    """Whether nothing is said of what is played, so that a study is as short as it can be."""
    said = (asked.p, asked.trials, asked.repetitions, asked.condition, asked.sweep)
    return not (asked.full or asked.as_paper) and all(given is None for given in said)


def on_several_boxes(asked: StudyOptions) -> bool:
    """Whether a study is on several boxes, and says no more of its size."""
    return bool(len(asked.boxes_named) > 1 or asked.boxes) and not (asked.full or asked.as_paper)


def with_boxes_of_people(asked: StudyOptions) -> StudyOptions:
    """A request on several boxes of one difficulty where people play and it names none: nobody meets one box twice."""
    if PEOPLE not in (asked.agent or ()) or asked.box is not None or asked.boxes is not None or asked.as_paper:
        return asked
    return asked.model_copy(update={"box": ", ".join(ALIKE)}) if plant_of(asked).lays_out else asked


def plant_of(asked: StudyOptions) -> PlantSource:
    """The plant that is asked for, or that of its study.

    Raises:
        UnknownName: If there is none such.
    """
    own = preset(asked.study).plant or "symbolic"
    return resolve_plant(own if asked.plant is None else asked.plant)


def with_defaults(asked: StudyOptions) -> StudyOptions:
    """A request with what it leaves out as its study has it, but for :func:`own_conditions`. What it says stays.

    Raises:
        Conflict: If it is to be as in the paper and is none of its studies, or its labels can give the interlock away.
    """
    own, plant = preset(asked.study), plant_of(asked)
    if asked.as_paper:
        _check_as_paper(asked, plant)
    cases = {
        "short": is_short(asked),
        "several_boxes": on_several_boxes(asked),
        "as_paper": asked.as_paper,
        "parts": asked.parts,
    }
    usual = dict[str, Any]()
    for part in (own, *(own.when[case] for case, holds in cases.items() if holds and case in own.when)):
        usual |= {name: getattr(part, name) for name in part.model_fields_set & StudyOptions.model_fields.keys()}
    usual.pop("condition", None)
    if asked.trials is not None or asked.until is not None:  # strategies play as many
        usual.pop("strategy_trials", None)
    if asked.until is not None:
        usual = {name: value for name, value in usual.items() if name not in ("repetitions", "trials")}
    if not plant.lays_out:
        usual.pop("layout", None)
    if usual.get("shuffle") == "never" and not plant.painted_labels:
        usual.pop("shuffle")
    usual["modality"] = shown = _shown(usual.get("modality", [STATES]), asked, plant)
    usual["agent"] = [one for one in usual["agent"] if taken_in(one, asked.modality or shown)] or usual["agent"]
    return asked.model_copy(update={name: value for name, value in usual.items() if getattr(asked, name) is None})


def own_conditions(asked: StudyOptions) -> list[NamedCondition]:
    """The conditions that a study has by its name, which are played before those that are asked for."""
    own = preset(asked.study)
    parts = own.when["parts"].conditions_named if asked.parts and "parts" in own.when else []
    return own.conditions_named + parts


def _shown(usual: list[str], asked: StudyOptions, plant: PlantSource) -> list[str]:
    """How the box is shown, as far as the plant has a camera, and with outcomes where these alone are false."""
    seen = [one for one in usual if plant.has_camera or not is_pictured(one)] or usual
    return ["symbolic" if one == STATES and asked.flip == "outcome-only" else one for one in seen]


def _check_as_paper(asked: StudyOptions, plant: PlantSource) -> None:
    own = preset(asked.study)
    if "as_paper" not in own.when:
        raise Conflict("--as-paper", asked.study, "the studies of the paper are flips and modalities")
    if asked.shuffle == "never":
        raise Conflict("--as-paper", "--shuffle never", "labels along the panel can give the interlock away")
    shown = asked.modality or own.when["as_paper"].modality or ()
    if plant.painted_labels and any(map(is_pictured, shown)):
        raise Conflict("--as-paper", f"pictures of {plant.spec}", "painted labels stand along the panel of its box")
