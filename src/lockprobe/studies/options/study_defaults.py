"""What a study has by default, by its name: its extent, its plant, its panel, what it shows, and who plays."""

from __future__ import annotations

from dataclasses import replace

from lockprobe.boxes.box import LayoutKind, Shuffle
from lockprobe.plants.catalogue import PlantSource
from lockprobe.studies import looks, why
from lockprobe.studies.modality import taken_in
from lockprobe.studies.options import paper
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.trial.record import STATES

_PICTURED = ("modalities", "looks")
"""The studies that show pictures."""


def plant_of(request: StudyOptions) -> str:
    """The plant that a request names, or that of its study."""
    return request.plant if request.plant is not None else paper.ROBOT if request.study in _PICTURED else "symbolic"


def layout_by_default(study: str, plant: PlantSource) -> LayoutKind:
    """How a study lays its panel out: anew only where the plant says that its joints follow."""
    return paper.MODALITY_PANEL if study in _PICTURED and plant.lays_out else "fixed"


def shuffle_by_default(study: str, plant: PlantSource) -> Shuffle:
    """How often a study draws labels. Those that are painted on a real box stay in a study of its pictures."""
    return "never" if study in _PICTURED and plant.painted_labels else "trial"


def extent_of(request: StudyOptions) -> paper.Extent:
    """How much a study plays, unless the request says more."""
    said = (request.p, request.trials, request.repetitions, request.condition, request.sweep)
    asked = request.full or any(given is not None for given in said)
    extent = {
        "modalities": paper.MODALITY_TRIALS,
        "looks": looks.EXTENT,
        "why": why.EXTENT if request.trials is None else replace(why.EXTENT, strategy_trials=None),
    }.get(request.study, paper.FULL if asked else paper.SHORT)
    if (len(request.boxes_named) > 1 or request.boxes) and not (request.full or request.as_paper):
        more = paper.EACH_BOX.strategy_trials if request.trials is None else None
        return replace(extent, repetitions=1, trials=paper.EACH_BOX.trials, strategy_trials=more)
    return extent


def shown_by_default(request: StudyOptions, plant: PlantSource) -> tuple[str, ...]:
    """The paper's modalities in the modality study, as far as the plant has a camera; reports in words in others."""
    if request.study == "looks":
        return ("rgb",)
    if request.study == "modalities" and plant.has_camera:
        return paper.MODALITIES
    return ("symbolic" if request.flip == "outcome-only" or request.parts else STATES,)


def players_by_default(study: str, modalities: tuple[str, ...]) -> tuple[str, ...]:
    """Those that the study has by default; of the modality study's only those that have something to play."""
    if study == "why":
        return why.AGENTS
    if study == "looks":
        return looks.AGENTS
    if study == "modalities":
        return tuple(agent for agent in paper.LOOKERS if taken_in(agent, modalities))
    return paper.FIRST
