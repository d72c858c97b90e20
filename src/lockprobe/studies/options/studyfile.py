"""From options to a :class:`lockprobe.studies.study.Study`; what is left out is as in the study's preset.

:func:`study` makes a whole one, :func:`trial_study` the one to which a single trial belongs.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from lockprobe.agents.catalogue import is_strategy, resolve
from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.boxfile import box_from_data
from lockprobe.boxes.families import DEFAULT_BOX, find_box
from lockprobe.boxes.generate import alike_boxes
from lockprobe.boxes.state_space import fault_of
from lockprobe.foundation.errors import BadValue, UnknownName, UserMistake
from lockprobe.foundation.plugins import allow
from lockprobe.foundation.spec import PEOPLE, spec_name
from lockprobe.foundation.validation import check_whole
from lockprobe.interventions.conditions import blind, flips, read_condition, says_modality
from lockprobe.interventions.flip import DEFAULT, OutcomeFlip, flip_of
from lockprobe.interventions.misread_flip import MisreadFlip, entries_of
from lockprobe.plants.catalogue import PlantSource, resolve_plant
from lockprobe.statistics.misinterpretation import claim_counts, misread_rates
from lockprobe.studies.modality import is_pictured, refuse_blind, shows_places
from lockprobe.studies.options.agent_names import named_agents
from lockprobe.studies.options.asked_conditions import alone_with_strategies, conditions_of
from lockprobe.studies.options.presets import cases_of, plant_of, preset, with_boxes_of_people, with_defaults
from lockprobe.studies.options.study_options import (
    SHIPPED,
    STUDIES,
    StudyOptions,
    read_options_file,
    refusal_of,
    study_options,
)
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import load
from lockprobe.studies.study import LIMITS, Study
from lockprobe.studies.until import MOST, Until
from lockprobe.trial.condition import Condition
from lockprobe.trial.protocols import Intervention
from lockprobe.trial.record import STATES, Trial

MOST_BOXES = 100
"""The most boxes that a study generates."""

OF_A_TRIAL = frozenset(
    {"box", "p", "flip", "condition", "modality", "plant", "layout", "shuffle", "max_steps", "assessment", "hypothesis"}
    | {"seed", "repetition", "trial"}
)
"""The options of a trial: those of a study, each with one value, and its place in the study."""

_PLURAL = {"repetition": "repetitions", "trial": "trials"}
"""The place of a trial -> the extent of the shortest study that has it."""


def study(asked: StudyOptions | str | Path = "flips", /, **options: Any) -> Study:
    """The study that options, a TOML file, or a bare name describe.

    >>> [condition.label for condition in study("flips", agent="random", sweep="tremble?p=0,0.1").conditions]
    ['truth', 'tremble?p=0.1']

    What it leaves out is as in the study's file in ``lockprobe/presets``
    (:func:`lockprobe.studies.options.presets.with_defaults`). A study of flips of which nothing is said is short; as
    soon as something is said, what is left out follows the paper.

    Args:
        asked: Options, the path of a TOML file, ``flips``, ``modalities`` or ``why``.
        options: Any of :class:`lockprobe.studies.options.study_options.StudyOptions`, which go before those.

    Raises:
        UserMistake: If anything in it does not exist or is out of range.
    """
    if isinstance(asked, str | Path):
        asked = read_options_file(Path(asked)) if str(asked).endswith(".toml") else StudyOptions(study=str(asked))
    if not isinstance(asked, StudyOptions):
        raise BadValue("study", asked, f"options, the path of a TOML file, or one of {', '.join(STUDIES)}")
    said = asked.model_copy(update={name: getattr(study_options(options), name) for name in options})
    allow(*(spec for specs in said.specs.values() for spec in specs))  # a file that names code was refused
    if said.study not in STUDIES:
        raise UnknownName("study", said.study, [*STUDIES, *SHIPPED, "FILE.toml"])
    said = with_boxes_of_people(said)
    request, plant = with_defaults(said), plant_of(said)
    agents, names = named_agents(request.agent or ())
    for agent in agents:
        resolve(agent)
    allow(*agents)
    conditions, spared = conditions_of(said, request, plant), tuple[Condition, ...]()
    cases, own = cases_of(said), preset(said.study)
    case = ("full" if said.full else "short" if "short" in cases else "") if "plain" in cases else ""
    if any(map(is_strategy, agents)) and (besides := own.strategies.get(case)):
        spared = alone_with_strategies(besides.model_copy(update={"p": request.p}))
        models = own.models.get(case, request).p or ()
        conditions, spared = (*conditions, *spared), (*spared, *(one for one in conditions if one.p not in models))
    seen = PEOPLE in agents or any(shows_places(one.modality) for one in conditions)
    if request.layout is None and seen and plant.lays_out:  # or whoever sees places need not look at anything else
        request = request.model_copy(update={"layout": "shuffled"})
    planned = _planned(request, plant, agents, conditions, names)
    planned = replace(planned, strategy_conditions=tuple(one.label for one in spared))
    allow(*planned.plants)
    planned.check_agents()
    planned = _with_misreadings(planned)
    _check_kept_and_played(planned, asked_for=request.condition is not None or request.sweep is not None)
    return planned


def _check_kept_and_played(planned: Study, *, asked_for: bool) -> None:
    """Refuse a condition that was asked for and nobody plays, and a box that cannot be played or that no file holds."""
    played = {one.label for agent in planned.agents for one in planned.conditions_of(agent)}
    for one in planned.conditions:
        if asked_for and one.label not in played and one.specs and is_pictured(one.modality):
            refuse_blind(planned.agents[0], one.modality, "words")
    for box in planned.boxes:
        try:
            box_from_data(box.as_data())
        except UserMistake as error:
            raise BadValue("box", box.name, f"one that a file can hold ({error})") from None
        if fault := fault_of(box):
            raise BadValue("box", box.name, f"one that can be played ({fault})")


def trial_study(given: Mapping[str, Any], *, agent: str, name: str = "trial") -> Study:
    """The study of which the given trial is the last. It has one condition and no control.

    >>> trial_study({"condition": "tremble?p=0.1", "trial": 3}, agent="random").conditions[0].label
    'tremble?p=0.1'

    Args:
        given: Any of :data:`OF_A_TRIAL`, as in :func:`lockprobe.studies.running.single.run_trial`. A value of None
            counts as left out.
        agent: Who plays it; it is not looked up.
        name: Its name, with which the key of the record begins.

    Raises:
        UserMistake: If anything in it does not exist or is out of range.
    """
    condition = given.get("condition")
    several = isinstance(condition, Sequence) and all(isinstance(one, Intervention) for one in condition)
    if not (several or isinstance(condition, str | Condition | None)):
        raise BadValue("condition", condition, "specs with plus signs between, a Condition, or a list of interventions")
    allow(*(spec for spec in (agent, given.get("plant"), condition) if isinstance(spec, str)))
    asked = {"repetitions": 1, "trials": 1, "p": [0.0], "name": name} | {
        _PLURAL.get(name, name): [value] if name in ("p", "modality") else value
        for name, value in given.items()
        if name != "condition" and value is not None
    }
    try:
        request = StudyOptions.model_validate(asked)
    except ValidationError as error:
        where = str(error.errors()[0]["loc"][0])
        said = next(name for name in given if _PLURAL.get(name, name) == where)
        raise refusal_of(error, said, given[said]) from None
    for one, extent in _PLURAL.items():
        check_whole(one, getattr(request, extent), 1, LIMITS[extent])
    plant = resolve_plant("symbolic" if request.plant is None else request.plant)
    planned = _planned(request, plant, [agent], [_one_condition(condition, request, plant)], {})
    if len(planned.boxes) > 1:
        raise BadValue("box", ", ".join(box.name for box in planned.boxes), "one box for one trial")
    allow(*planned.plants)
    return planned


def _planned(
    request: StudyOptions,
    plant: PlantSource,
    agents: Sequence[str],
    conditions: Sequence[Condition],
    names: Mapping[str, str],
) -> Study:
    boxes = find_boxes(request)
    said = ("max_steps", "seed", "shuffle", "layout", "assessment", "hypothesis", "contrasts")
    return Study(
        name=request.study if request.name is None else request.name,
        agents=tuple(agents),
        names=names,
        boxes=boxes,
        conditions=tuple(conditions),
        plant=plant.spec,
        **_sizes(request, len(boxes)),
        **{name: value for name in said if (value := getattr(request, name)) is not None},
    )


def _sizes(request: StudyOptions, boxes: int) -> dict[str, Any]:
    """How much a request plays on so many boxes, in the fields of :class:`lockprobe.studies.study.Study`."""
    sizes = {name: getattr(request, name) for name in ("repetitions", "trials", "strategy_trials")}
    if request.until is None:
        if request.most is not None:
            raise BadValue("most", request.most, "--until with it; --trials says how many trials are played")
        many = {"repetitions": 1, "trials": boxes, "strategy_trials": boxes}
        return {name: value * many[name] for name, value in sizes.items() if value is not None}
    if request.study == "looks":
        raise BadValue("until", request.until, f"none with {request.study}, whose answer holds for one look")
    for name, given in sizes.items():
        if given is not None:
            raise BadValue(name, given, f"none with --until {request.until}; --most says how many trials at most")
    if request.full:
        rates = "--p 0,0.1,0.2,0.3,0.4,0.5,0.6 plays the paper's flip rates"
        raise BadValue("full", True, f"none with --until {request.until}; {rates}")
    most = MOST if request.most is None else request.most
    check_whole("most", most, 1, LIMITS["trials"])
    return {"repetitions": 1, "trials": most, "until": Until.parse(request.until)}


def find_boxes(request: StudyOptions) -> tuple[Lockbox, ...]:
    """The boxes of a request, one or several."""
    named = request.boxes_named or [DEFAULT_BOX]
    if request.boxes is None:
        return tuple(find_box(one) for one in named)
    family = ", ".join(map(str, request.boxes_named)) or "random-4"
    if not (drawn := re.fullmatch(r"random-([4-8])", family)):
        raise BadValue("boxes", request.boxes, f"none with the box {family}, but with random-4 to random-8")
    check_whole("boxes", request.boxes, 2, MOST_BOXES)
    return alike_boxes(int(drawn[1]), request.boxes)


def _one_condition(
    asked: str | Condition | Sequence[Intervention] | None, request: StudyOptions, plant: PlantSource
) -> Condition:
    """A condition that stands alone: a flip rate acts first, a modality shows it."""
    (p,), kind = request.p or [0.0], request.flip or DEFAULT
    if not asked:
        return flips((p,), kind, request.modality)[0]
    blinded = kind == "outcome-only"
    said = isinstance(asked, str) and says_modality(asked)
    if isinstance(asked, str):
        asked = read_condition(asked, plant=plant.spec)
    found = asked if isinstance(asked, Condition) else Condition(interventions=tuple(asked))
    if p and any(spec_name(spec) == OutcomeFlip.name for spec in found.specs):
        raise BadValue("p", p, "0 with a condition that flips reports itself")
    if request.flip is not None and not p:
        raise BadValue("flip", request.flip, "a flip rate p with it, where a condition says what else acts")
    unsaid = not said and found.modality == STATES
    if p:
        found = replace(found, interventions=(flip_of(kind, p), *found.interventions))
    if unsaid:
        (shown,) = request.modality or ["symbolic" if blinded else STATES]
        return replace(found, modality=blind(shown) if blinded else shown)
    if request.modality is not None and request.modality != [found.modality]:
        raise BadValue("modality", request.modality[0], f"none with a condition that says {found.modality} itself")
    return found


def _with_misreadings(study: Study) -> Study:
    """A study whose conditions hold the rates that they take from finished ones (``flip?like=DIR/CONDITION``)."""
    return replace(study, conditions=tuple(_with_rates(one, study) for one in study.conditions))


def _with_rates(condition: Condition, study: Study) -> Condition:
    name, acting = condition.name, list(condition.interventions)
    for i, one in enumerate(acting):
        if isinstance(one, MisreadFlip) and not one.rates:
            other, label, trials = _read(one)
            unlike = any(_joints(theirs) != _joints(own) for theirs, own in product(other.boxes, study.boxes))
            if one.by == "joint" and unlike:
                expected = (
                    f"a study of {study.box.name}, not of {other.box.name}; by=direction and by=total fit any box"
                )
                raise BadValue("like", one.like, expected)
            said = claim_counts(trials)
            names = dict.fromkeys(name for box in study.boxes for name in box.names)
            rates = entries_of(misread_rates(said, [*names], one.by))
            acting[i] = replace(one, like=f"{other.name}@{other.identity}/{label}", rates=rates, size=said.total())
            name = (name or condition.spec).replace(one.like, f"{other.name}/{label}")
    changed = acting != [*condition.interventions]
    return replace(condition, interventions=tuple(acting), name=name) if changed else condition


def _joints(box: Lockbox) -> tuple[object, ...]:
    """What boxes share whose joints have the same rates: their names, the target, and what holds each."""
    return box.target, *((name, box.alternatives(name)) for name in sorted(box.names))


def _read(one: MisreadFlip) -> tuple[Study, str, list[Trial]]:
    """The study that a flip names, its condition there, and the trials of the agent."""
    directory, _, label = one.like.rpartition("/")
    if not directory:
        raise BadValue("like", one.like, "DIR/CONDITION, with the directory of a finished study")
    there = load(Path(directory))
    trials = [trial for trial in there if trial.condition == label]
    if not trials:
        known = dict.fromkeys(trial.condition for trial in there)
        raise UnknownName(f"condition in {directory}", label, known or ["none, since no trial has ended there"])
    agents = list(dict.fromkeys(trial.group for trial in trials))
    if (chosen := one.of or (agents[0] if len(agents) == 1 else "")) not in agents:
        raise BadValue("of", chosen, f"an agent of {directory}: {', '.join(agents)}")
    own = [trial for trial in trials if trial.group == chosen]
    if not claim_counts(own):
        raise BadValue("like", one.like, "a condition whose agent said what its attempts did")
    return read_study(directory), label, own
