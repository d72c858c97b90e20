"""The studies that ship: what their names stand for, where a user says nothing else.

Each is a study file in ``lockprobe/presets``, with tables of what is played instead in some cases (``when``), and of
what strategies or models alone play.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from pydantic import Field

from lockprobe.boxes.families import ALIKE
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.inputs import read_preset
from lockprobe.foundation.spec import PEOPLE
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.modality import is_pictured, taken_in
from lockprobe.studies.options.study_options import STUDIES, StudyOptions
from lockprobe.trial.record import STATES


class Preset(StudyOptions):
    """A study that ships.

    Attributes:
        when: Case -> what is played instead: ``short``, where nothing is said of what is played; on ``several_boxes``;
            the paper's ``full`` size; ``as_paper``, as close to the paper as it says (each option cites its section;
            ``docs/as-paper.md`` compares them with the defaults); with the ``parts`` of a false report.
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


def with_defaults(asked: StudyOptions) -> tuple[StudyOptions, set[str]]:
    """A request with what it leaves out as its study has it, but for the study's own conditions. What it says stays.

    Where people play and it names no box, it has several of one difficulty: nobody meets one box twice. With it come
    the cases that hold, among them ``plain``, if nothing is said of what varies.

    Raises:
        BadValue: If its study has no such case.
    """
    own = preset(asked.study)
    plant = resolve_plant((own.plant or "symbolic") if asked.plant is None else asked.plant)
    for case in ("full", "parts", "as_paper"):
        if getattr(asked, case) and case not in own.when:
            having = ", ".join(name for name in STUDIES if case in preset(name).when)
            raise BadValue(case, True, f"none with {asked.study}, but with {having}")
    chosen = asked.box is not None or asked.boxes is not None or asked.as_paper
    if PEOPLE in (asked.agent or ()) and plant.lays_out and not chosen:
        asked = asked.model_copy(update={"box": [*ALIKE]})
    acting = any(one is not None for one in (asked.p, asked.condition, asked.sweep))
    sized = asked.trials is not None or asked.repetitions is not None
    varied = any(one is not None for one in (asked.flip, asked.readings, asked.modality))
    several = bool(len(asked.box or ()) > 1 or asked.boxes) and not (asked.full or asked.as_paper)
    holds = {
        "short": not (asked.full or asked.as_paper or acting or sized),
        "several_boxes": several,
        "full": asked.full,
        "as_paper": asked.as_paper,
        "parts": asked.parts,
        "plain": not (varied or asked.as_paper or several or acting),
    }
    cases, usual = {case for case, held in holds.items() if held}, dict[str, Any](plant=plant.spec)
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
    unsaid = {name: value for name, value in usual.items() if getattr(asked, name) is None}
    return asked.model_copy(update=unsaid), cases
