"""The one place where options become a :class:`lockprobe.studies.study.Study`: the paper's where nothing is said."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from lockprobe.agents.catalogue import resolve
from lockprobe.errors import BadValue, UnknownName
from lockprobe.interventions.condition import (
    SYMBOLIC,
    Condition,
    distinct,
    flips,
    modality_doses,
    read_condition,
    sweep,
)
from lockprobe.interventions.flip import FlipKind
from lockprobe.lockbox.families import find_box
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies import paper
from lockprobe.studies.modality import taken_in
from lockprobe.studies.study import Study
from lockprobe.studies.study_options import SHIPPED, StudyOptions, read_options_file, study_options

__all__ = ["STUDIES", "study"]

STUDIES = ("flips", "modalities")

LONGEST_SPEC = 1000
"""Characters of the spec of an agent, a plant or a modality."""

AGENT_SWEEP = "agent."
"""How a sweep begins that is over an option of agents."""

_T = TypeVar("_T")


def study(asked: StudyOptions | str = "flips", /, **options: Any) -> Study:
    """The study that options, a TOML file, or a bare name describe.

    >>> [condition.label for condition in study("flips", agent="random", sweep="tremble?p=0,0.1").conditions]
    ['truth', 'tremble?p=0.1']

    A request for flips that says nothing of ``p``, ``trials``, ``repetitions`` and ``full`` gets the short extent; as
    soon as it says something, what it leaves out follows the paper. The modality study is always of the paper's
    extent, on a panel that is dealt anew in every trial; on a plant without a camera it has no pictures.

    Args:
        asked: Options, the path of a TOML file, ``flips`` or ``modalities``.
        options: Any of :class:`lockprobe.studies.study_options.StudyOptions`, which go before those.

    Raises:
        UserMistake: If anything in it does not exist or is out of range.
    """
    if isinstance(asked, str):
        asked = read_options_file(Path(asked)) if asked.endswith(".toml") else StudyOptions(study=asked)
    request = asked.model_copy(update={name: getattr(study_options(options), name) for name in options})
    if request.study not in STUDIES:
        raise UnknownName("study", request.study, [*STUDIES, *SHIPPED, "FILE.toml"])
    modal = request.study == "modalities"
    plant = _given(request.plant, paper.ROBOT if modal else "symbolic")
    modalities = tuple(_given(request.modality, _shown_by_default(plant, modal=modal)))
    extent = paper.MODALITY_TRIALS if modal else _flips_extent(request)
    agents = request.agent if request.agent is not None else _players_by_default(modalities, modal=modal)
    for what, specs in (
        ("agent", agents),
        ("plant", [plant]),
        ("modality", modalities),
        ("condition", request.acting),
        ("sweep", request.sweep or ()),
    ):
        _check_lengths(what, specs)
    for spec in agents:
        resolve(spec)
    for spec in request.sweep or ():
        if spec.startswith(AGENT_SWEEP):
            agents = _swept_agents(agents, spec)
    planned = Study(
        name=_given(request.name, request.study),
        agents=tuple(agents),
        box=find_box(_given(request.box, paper.BOX)),
        conditions=_conditions(request, extent, modalities),
        repetitions=_given(request.repetitions, extent.repetitions),
        trials=_given(request.trials, extent.trials),
        max_steps=_given(request.max_steps, paper.MAX_STEPS),
        seed=_given(request.seed, 1),
        shuffle=_given(request.shuffle, True),
        plant=plant,
        layout=_given(request.layout, paper.MODALITY_PANEL if modal else "fixed"),
        assessment=_given(request.assessment, True),
    )
    planned.check_agents()
    return planned


def _swept_agents(agents: Sequence[str], spec: str) -> list[str]:
    """Agents with every value of one of their options: ``agent.temperature=0,0.5,1``. Those without it stay."""
    option, _, values = spec.removeprefix(AGENT_SWEEP).partition("=")
    if not option or "," not in values:
        raise BadValue("sweep", spec, "several values with commas between, for example agent.temperature=0,0.5,1")
    found, refused = [], ""
    for agent in agents:
        mark = "&" if "?" in agent else "?"
        several = [f"{agent}{mark}{option}={value.strip()}" for value in values.split(",")]
        try:
            found += [one for one in several if resolve(one)]
        except UnknownName as error:
            refused = refused or str(error)
            found.append(agent)
    if len(found) == len(agents):
        raise BadValue("sweep", spec, f"an option that one of the agents has ({refused})")
    return found


def _conditions(request: StudyOptions, extent: paper.Extent, modalities: Sequence[str]) -> tuple[Condition, ...]:
    """Flip rates and modalities, or other conditions with the truth before them; those that say no modality in each."""
    flip: FlipKind = _given(request.flip, "transient")
    p = extent.p if request.p is None else tuple(request.p)
    for what, values in (("p", p), ("modality", tuple(modalities))):
        if not values or len(set(values)) != len(values):
            raise BadValue(what, list(values), "at least one, and every one once")
    if request.condition is None and request.sweep is None:
        return flips(p, flip, modalities)
    found = [
        *(flips(p, flip) if request.p is not None else ()),
        *(read_condition(one.spec, one.name) for one in request.conditions_named),
        *(one for spec in request.sweep or () if not spec.startswith(AGENT_SWEEP) for one in sweep(spec)),
    ]
    return _with_controls(found, modalities)


def _with_controls(found: Sequence[Condition], modalities: Sequence[str]) -> tuple[Condition, ...]:
    """Conditions shown in every way, those that say their own only in that, each way with the truth as its control."""
    own = [one for one in found if one.modality != "symbolic"]
    acting = [one for one in found if one not in own and (one.name or not one.does_nothing)]
    named = [one for one in acting if one.does_nothing]
    controls = named or [Condition()]
    everywhere = [*controls, *(one for one in acting if one not in named)]
    _check_names([*everywhere, *own])
    return distinct(
        [
            *(replace(one, modality=modality) for modality in modalities for one in everywhere),
            *(replace(controls[0], modality=modality_doses(one.modality)[0]) for one in own),
            *own,
        ]
    )


def _check_names(conditions: Sequence[Condition]) -> None:
    """Refuse one condition under two names, which would be compared as if it were two."""
    seen: dict[tuple[object, ...], str] = {}
    for one in conditions:
        what = (() if one.does_nothing else one.specs, one.modality)
        if (first := seen.setdefault(what, one.label)) != one.label:
            raise BadValue("condition", one.label, f"another condition than {first}, which is the same")


def _check_lengths(what: str, specs: Sequence[str]) -> None:
    for spec in specs:
        if len(spec) > LONGEST_SPEC:
            raise BadValue(what, f"{spec[:40]}…", f"at most {LONGEST_SPEC} characters; these are {len(spec)}")


def _flips_extent(request: StudyOptions) -> paper.Extent:
    said = (request.p, request.trials, request.repetitions, request.condition, request.sweep)
    asked = request.full or any(given is not None for given in said)
    return paper.FULL if asked else paper.SHORT


def _shown_by_default(plant: str, *, modal: bool) -> tuple[str, ...]:
    """The paper's modalities in the modality study, as far as the plant has a camera; reports in others."""
    return paper.MODALITIES if modal and resolve_plant(plant).has_camera else SYMBOLIC


def _players_by_default(modalities: tuple[str, ...], *, modal: bool) -> tuple[str, ...]:
    """Those that the study has by default; of the modality study's only those that have something to play."""
    if not modal:
        return ("llm:local", *paper.REFERENCES)
    return tuple(agent for agent in paper.LOOKERS if taken_in(agent, modalities))


def _given(value: _T | None, default: _T) -> _T:
    return default if value is None else value
