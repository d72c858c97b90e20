"""The studies that ship: what their names stand for, where a user says nothing else.

Each is a study file in ``lockprobe/presets``, with tables of what is played instead in some cases (``when``), and of
what strategies or models alone play.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from pydantic import Field

from lockprobe.boxes.families import ALIKE
from lockprobe.foundation.errors import BadValue, Conflict
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


def cases_of(asked: StudyOptions) -> set[str]:
    """The cases that hold for a request; ``full`` too, and ``plain`` if nothing is said of what varies."""
    paper = asked.full or asked.as_paper
    sized = any(one is not None for one in (asked.p, asked.trials, asked.repetitions, asked.condition, asked.sweep))
    varied = any(one is not None for one in (asked.flip, asked.readings, asked.modality))
    several = bool(len(asked.boxes_named) > 1 or asked.boxes) and not paper
    holds = {
        "short": not (paper or sized),
        "several_boxes": several,
        "as_paper": asked.as_paper,
        "parts": asked.parts,
        "full": asked.full,
        "plain": not (varied or asked.as_paper or several or asked.p or asked.condition or asked.sweep),
    }
    return {case for case, held in holds.items() if held}


def plant_of(asked: StudyOptions) -> PlantSource:
    """The plant that is asked for, or that of its study."""
    own = preset(asked.study).plant or "symbolic"
    return resolve_plant(own if asked.plant is None else asked.plant)


def with_defaults(asked: StudyOptions) -> StudyOptions:
    """A request with what it leaves out as its study has it, but for :func:`own_conditions`. What it says stays.

    Where people play and it names no box, it has several of one difficulty: nobody meets one box twice.

    Raises:
        BadValue: If the study has no such case.
        Conflict: If it is to be as in the paper and is none of its studies.
    """
    own, plant, usual = preset(asked.study), plant_of(asked), dict[str, Any]()
    if asked.full and asked.study in ("why", "looks"):
        raise BadValue("full", True, f"none with {asked.study}, which has trials of its own; --trials says how many")
    if asked.parts and "parts" not in own.when:
        raise BadValue("parts", True, f"none with {asked.study}; why plays the parts of a false report")
    if asked.as_paper and "as_paper" not in own.when:
        raise Conflict("--as-paper", asked.study, "the studies of the paper are flips and modalities")
    cases = cases_of(asked)
    for part in (own, *(found for case, found in own.when.items() if case in cases)):
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
    shown = usual.get("modality", [STATES])
    shown = [one for one in shown if plant.has_camera or not is_pictured(one)] or shown
    usual["modality"] = ["symbolic" if one == STATES and asked.flip == "outcome-only" else one for one in shown]
    seen = asked.modality or usual["modality"]
    usual["agent"] = [one for one in usual["agent"] if taken_in(one, seen)] or usual["agent"]
    return asked.model_copy(update={name: value for name, value in usual.items() if getattr(asked, name) is None})


def with_boxes_of_people(asked: StudyOptions) -> StudyOptions:
    """A request on several boxes of one difficulty where people play and it names none: nobody meets one box twice."""
    if PEOPLE not in (asked.agent or ()) or asked.box is not None or asked.boxes is not None or asked.as_paper:
        return asked
    return asked.model_copy(update={"box": ", ".join(ALIKE)}) if plant_of(asked).lays_out else asked


def own_conditions(asked: StudyOptions) -> list[NamedCondition]:
    """The conditions that a study has by its name, which are played before those that are asked for."""
    own = preset(asked.study)
    parts = own.when["parts"].conditions_named if asked.parts and "parts" in own.when else []
    return own.conditions_named + parts
