"""From what is asked for to a :class:`lockprobe.studies.study.Study`; what is left out is as in the study's preset.

Each study that ships is a file in ``lockprobe/presets``, with tables of what is played instead in some cases
(``when``), and of what strategies or models alone play. Conditions are flip rates, conditions by name and sweeps, each
in every modality. :func:`study` makes a whole study, :func:`trial_study` the one to which a single trial belongs.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import Field, ValidationError

from lockprobe.agents.catalogue import is_strategy, resolve
from lockprobe.boxes.box import data_of
from lockprobe.boxes.boxfile import box_from_data
from lockprobe.boxes.families import ALIKE, DEFAULT_BOX, alike_boxes, find_box
from lockprobe.boxes.solve import fault_of
from lockprobe.foundation.errors import BadValue, Conflict, UnknownName, UserMistake
from lockprobe.foundation.inputs import read_preset
from lockprobe.foundation.plugins import allow
from lockprobe.foundation.spec import PEOPLE, Spec, spec_name, split_specs
from lockprobe.interventions.conditions import blind, flips, read_condition, says_modality, sweep
from lockprobe.interventions.flip import DEFAULT, MisreadFlip, entries_of, flip_of, misread_rates
from lockprobe.interventions.modality import is_pictured, refuse_blind, shows_places, taken_in
from lockprobe.interventions.told import Correction
from lockprobe.plants.catalogue import PlantSource, resolve_plant
from lockprobe.statistics.misinterpretation import claim_counts
from lockprobe.studies.options.study_options import STUDIES, NamedCondition, StudyOptions, read_options, refused
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import load
from lockprobe.studies.study import Study, Until
from lockprobe.trial.condition import Condition
from lockprobe.trial.doses import modality_doses
from lockprobe.trial.protocols import Intervention
from lockprobe.trial.record import STATES

_AS_ASKED = (
    *("repetitions", "trials", "strategy_trials", "max_steps", "seed", "shuffle", "layout", "assessment", "hypothesis"),
    "contrasts",
)
"""The options that a study has as they are."""


class Preset(StudyOptions):
    """A study that ships.

    Attributes:
        when: Case -> what is played instead: ``short``, where nothing is said of what is played; on ``several_boxes``;
            the paper's ``full`` size; ``as_paper``, as close to the paper as it says (each option cites its section;
            ``docs/as-paper.md`` compares them with the defaults).
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


def study(asked: StudyOptions | str | Path = "flips", /, **options: Any) -> Study:
    """The study that options, a TOML file, or a bare name describe.

    >>> [condition.label for condition in study("flips", agent="random", sweep="tremble?p=0,0.1").conditions]
    ['truth', 'tremble?p=0.1']

    What it leaves out is as in the study's file in ``lockprobe/presets``. A study of flips of which nothing is said is
    short; as soon as something is said, what is left out follows the paper.

    Args:
        asked: Options, the path of a TOML file, ``flips``, ``modalities``, ``why`` or ``looks``.
        options: Any of :class:`lockprobe.studies.options.study_options.StudyOptions`, which go before those; an agent
            may also be a class, as in a notebook, and agents a dict of their names.

    Raises:
        UserMistake: If anything in it does not exist or is out of range.
    """
    said = read_options(asked, options)
    allow(*(spec for specs in said.specs.values() for spec in specs))  # a file that names code was refused
    request, cases = _with_defaults(said)
    plant, (agents, names) = resolve_plant(str(request.plant)), request.agents
    for agent in agents:
        resolve(agent)
    conditions, spared = _conditions(said, request, plant), tuple[str, ...]()
    ships, size = preset(said.study), next((one for one in ("full", "short") if {one, "plain"} <= cases), "")
    if size in ships.strategies and any(map(is_strategy, agents)):
        besides, rates = ships.strategies[size], [rate for rate in request.p or () if rate]
        more = [one for kind in besides.flip or [DEFAULT] for one in flips(rates, flip_of(kind))]
        more += [read_condition(one.spec, one.name) for one in besides.condition or ()]
        models = ships.models.get(size, request).p or ()
        spared = tuple(one.label for one in (*more, *(one for one in conditions if one.p not in models)))
        conditions = (*conditions, *more)
    seen = PEOPLE in agents or any(shows_places(one.modality) for one in conditions)
    if request.layout is None and seen and plant.lays_out:  # or whoever sees places need not look at anything else
        request = request.model_copy(update={"layout": "shuffled"})
    planned = _planned(request, agents, conditions, names=names, strategy_conditions=spared)
    planned.check_agents()
    planned = replace(planned, conditions=tuple(_with_rates(one, planned) for one in planned.conditions))
    played = {one.label for agent in planned.agents for one in planned.conditions_of(agent)}
    for one in planned.conditions if request.condition is not None or request.sweep is not None else ():
        if one.label not in played and one.specs and is_pictured(one.modality):
            refuse_blind(planned.agents[0], one.modality)
    for box in planned.boxes:
        try:
            fault = fault_of(box_from_data(data_of(box)))
        except UserMistake as error:
            fault = str(error)
        if fault:
            raise BadValue("box", box.name, f"one that a file can hold and that can be played ({fault})")
    return planned


def trial_study(agent: str, *, name: str = "trial", condition: Any = None, **given: Any) -> Study:
    """The study of which a given trial is the last. It has one condition and no control.

    >>> trial_study("random", condition="tremble?p=0.1", trial=3).conditions[0].label
    'tremble?p=0.1'

    Args:
        agent: Who plays it; it is not looked up.
        name: Its name, with which the key of the record begins.
        condition: What acts, as in :func:`lockprobe.studies.running.single.run_trial`.
        given: Options of a study, each with one value, and its ``repetition`` and ``trial``. A value of None counts as
            left out.

    Raises:
        UserMistake: If anything in it does not exist or is out of range.
    """
    allow(*(spec for spec in (agent, given.get("plant"), condition) if isinstance(spec, str)))
    asked = {one: value for one, value in given.items() if value is not None}
    asked |= {"repetitions": asked.pop("repetition", 1), "trials": asked.pop("trial", 1), "name": name}
    request = read_options(StudyOptions(), asked)
    for one in ("p", "flip", "modality", "box"):
        if len(getattr(request, one) or ()) > 1:
            raise BadValue(one, given[one], "one for one trial")
    if request.flip is not None and request.p is None:
        raise BadValue("flip", request.flip[0], "a flip rate p with it")
    (p,), (kind,), shown = request.p or [0.0], request.flip or [DEFAULT], request.modality
    own, like = condition or (), flips((p,), kind, shown)[0]
    if isinstance(own, str):
        own = read_condition(own, plant=request.plant or "symbolic")
    elif isinstance(own, Sequence) and all(isinstance(one, Intervention) for one in own):
        own = Condition(interventions=tuple(own))
    elif not isinstance(own, Condition):
        raise BadValue("condition", own, "specs with plus signs, a Condition, or a list of interventions")
    if own.modality == STATES:
        own = replace(own, modality=like.modality)
    elif shown not in (None, [own.modality]):
        raise BadValue("modality", shown, f"none with a condition that says {own.modality} itself")
    return _planned(request, [agent], [replace(own, interventions=(*like.interventions, *own.interventions))])


def _with_defaults(asked: StudyOptions) -> tuple[StudyOptions, set[str]]:
    """A request with what it leaves out as its study has it, but for the study's own conditions. What it says stays.

    Where people play and it names no box, it has several of one difficulty: nobody meets one box twice. With it come
    the cases that hold, among them ``plain``, if nothing is said of what varies.
    """
    own = preset(asked.study)
    plant = resolve_plant((own.plant or "symbolic") if asked.plant is None else asked.plant)
    for case in ("full", "as_paper"):
        if getattr(asked, case) and case not in own.when:
            having = ", ".join(name for name in STUDIES if case in preset(name).when)
            raise BadValue(case, True, f"none with {asked.study}, but with {having}")
    chosen = asked.box is not None or asked.boxes is not None or asked.as_paper
    if PEOPLE in (asked.agent or ()) and plant.lays_out and not chosen:
        asked = asked.model_copy(update={"box": [*ALIKE]})
    said = {name for name, value in asked if value is not None}
    paper, acting = asked.full or asked.as_paper, said & {"p", "condition", "sweep"}
    several = not paper and (len(asked.box or ()) > 1 or asked.boxes)
    holds = {
        "short": not (paper or acting or said & {"trials", "repetitions"}),
        "several_boxes": several,
        "full": asked.full,
        "as_paper": asked.as_paper,
        "plain": not (asked.as_paper or several or acting or said & {"flip", "modality"}),
    }
    cases, usual = {case for case, held in holds.items() if held}, dict[str, Any](plant=plant.spec)
    for part in (own, *(found for case, found in own.when.items() if case in cases)):
        usual |= {name: getattr(part, name) for name in part.model_fields_set & StudyOptions.model_fields.keys()}
    usual |= {"repetitions": 1, "trials": 300} if asked.until else {}  # the most, unless something else is said
    dropped = {"condition"}
    if asked.trials is not None or asked.until is not None:  # strategies play as many
        dropped.add("strategy_trials")
    if not plant.lays_out:
        dropped.add("layout")
    if usual.get("shuffle") == "never" and not plant.photographs:
        dropped.add("shuffle")
    shown = usual.get("modality", [STATES])
    shown = [one for one in shown if plant.has_camera or not is_pictured(one)] or shown
    usual["modality"] = ["symbolic" if one == STATES and asked.flip == ["outcome-only"] else one for one in shown]
    seen = asked.modality or usual["modality"]
    usual["agent"] = [one for one in usual["agent"] if taken_in(one, seen)] or usual["agent"]
    unsaid = {name: value for name, value in usual.items() if name not in dropped and getattr(asked, name) is None}
    return asked.model_copy(update=unsaid), cases


def _conditions(asked: StudyOptions, request: StudyOptions, plant: PlantSource) -> tuple[Condition, ...]:
    """Flip rates and modalities, or other conditions with the truth before them, shown in each modality.

    Args:
        asked: What the user said.
        request: The same with its defaults.
        plant: The study's plant.
    """
    kinds, p, modalities = asked.flip or [DEFAULT], request.p or [], request.modality or []
    for what, values in (("p", p), ("modality", modalities)):
        if not values or len(set(values)) != len(values):
            raise BadValue(what, values, "at least one, and every one once")
    if asked.flip == ["outcome-only"]:
        modalities = [*map(blind, modalities)]
    own, lies = preset(asked.study).condition or [], asked.flip not in (None, ["outcome-only"])
    if lies and asked.p is None and not (own or any(p)):
        raise BadValue("flip", asked.flip, "a flip rate with it (--p)")
    if not own and request.condition is None and request.sweep is None:
        others = [one for kind in kinds[1:] for one in flips([rate for rate in p if rate], kind, modalities)]
        return (*flips(p, kinds[0], modalities), *others)
    if own:
        _check_own(asked, own, {"modality": modalities, "p": p, "flip": kinds}, plant)
    said = [(_acting(one, plant), one.spec) for one in request.condition or ()]
    said += [(one, spec) for spec in request.sweep or () for one in sweep(spec, plant.spec)]
    shown = [one for one, spec in said if says_modality(spec)]
    if own and any(one.modality != modalities[0] for one in shown):
        expected = f"none that is shown otherwise than all others, {modalities[0]}"
        raise BadValue("condition", shown[0].spec, expected)
    reading = flips((1.0,), flip_of(kinds[0]))[0].specs[0].removeprefix("flip?p=1")
    rates = not own and (asked.p is not None or lies)
    everywhere = [
        *(one for kind in kinds if rates for one in flips(p, flip_of(kind))),
        *(read_condition(one.spec.format(p=f"{p[0]:g}", reading=reading), one.name, plant.spec) for one in own),
        *(one for one, spec in said if own or not says_modality(spec)),
    ]
    return _with_controls(everywhere, [] if own else shown, modalities)


def _check_own(
    asked: StudyOptions, own: Sequence[NamedCondition], same: dict[str, Sequence[Any]], plant: PlantSource
) -> None:
    """Refuse what a study with conditions of its own would leave out, or could not vary."""
    if asked.until and asked.study == "looks":
        raise BadValue("until", asked.until, f"none with {asked.study}, whose answer holds for one look")
    for what, values in same.items():
        if len(values) > 1:
            raise BadValue(what, values, f"one, which all conditions of {asked.study} have")
    if is_pictured(same["modality"][0]) and any(spec_name(one.spec) == Correction.name for one in own):
        expected = "symbolic, with or without options: pictures cannot be corrected"
        raise BadValue("modality", same["modality"][0], expected)
    varied = () if any("{p}" in one.spec for one in own) else ("p", "condition", "sweep", "flip")
    if given := [f"--{name}" for name in varied if getattr(asked, name) is not None]:
        raise Conflict(", ".join(given), asked.study, "it has its own conditions")
    options = {option for one in own for option in Spec.parse(one.spec).options}
    if options & Spec.parse(plant.spec).options.keys():
        raise BadValue("plant", plant.spec, f"one without {', '.join(sorted(options))}, which {asked.study} varies")


def _acting(said: NamedCondition, plant: PlantSource) -> Condition:
    """A condition that was asked for; one that does nothing is refused, unless a dose of 0 says so."""
    found = read_condition(said.spec, said.name, plant.spec)
    if found.specs and found.does_nothing:
        options = {option for part in split_specs(said.spec) for option in Spec.parse(part, "intervention").options}
        doses = [names[0] for _, names in found.acting if names]
        if options.isdisjoint(doses):
            expected = f"one that does something; without {doses[0]}= it is the truth"
            raise BadValue("condition", said.spec, expected)
    return found


def _with_controls(
    everywhere: Sequence[Condition], own: Sequence[Condition], modalities: Collection[str]
) -> tuple[Condition, ...]:
    """Conditions shown in every way, and those with a way of their own; each way has the truth as its control."""
    acting = [one for one in everywhere if one.name or not one.does_nothing]
    truth = next((one for one in acting if one.does_nothing), Condition())
    known = {one.modality: one for one in own if one.name and one.does_nothing}

    def control(modality: str) -> Condition:
        return known.get(modality, replace(truth, modality=modality))

    found = list[Condition]()
    for modality in modalities:
        found += [control(modality), *(replace(one, modality=modality) for one in acting if one is not truth)]
    found += [control(modality_doses(one.modality)[0]) for one in own]
    found += [one for one in own if one.name or not one.does_nothing or modality_doses(one.modality)[1]]
    found, called = [*dict.fromkeys(found)], dict[tuple[object, ...], str]()
    for one in found:  # under two names it would be compared as if it were two
        what = (() if one.does_nothing else one.specs, one.modality)
        if (first := called.setdefault(what, one.label)) != one.label:
            raise BadValue("condition", one.label, f"another condition than {first}, which is the same")
    return tuple(found)


def _planned(request: StudyOptions, agents: Sequence[str], conditions: Sequence[Condition], **more: Any) -> Study:
    """The study of a request."""
    if request.boxes is None:
        boxes = tuple(map(find_box, request.box or [DEFAULT_BOX]))
    else:
        family = ", ".join(map(str, request.box or ["random-4"]))
        if not (drawn := re.fullmatch(r"random-([4-8])", family)):
            raise BadValue("boxes", request.boxes, f"none with the box {family}, but with random-4 to random-8")
        boxes = alike_boxes(int(drawn[1]), request.boxes)
    settings: dict[str, Any] = {one: value for one in _AS_ASKED if (value := getattr(request, one)) is not None}
    settings |= {one: settings[one] * len(boxes) for one in ("trials", "strategy_trials") if one in settings}
    settings |= {
        "name": request.study if request.name is None else request.name,
        "agents": tuple(agents),
        "boxes": boxes,
        "conditions": tuple(conditions),
        "plant": resolve_plant("symbolic" if request.plant is None else request.plant).spec,
        "until": request.until and Until.parse(request.until),
    }
    try:
        planned = Study(**settings, **more)
    except ValidationError as error:
        raise refused(error, settings) from None
    allow(*planned.plants)
    return planned


def _with_rates(condition: Condition, study: Study) -> Condition:
    """A condition with the rates that it takes from a finished study (``flip?like=DIR/CONDITION``)."""
    name, acting = condition.name, list(condition.interventions)
    for i, one in enumerate(acting):
        if not isinstance(one, MisreadFlip) or one.rates:
            continue
        directory, _, label = one.like.rpartition("/")
        if not directory:
            raise BadValue("like", one.like, "DIR/CONDITION, with the directory of a finished study")
        other, there = read_study(directory), load(Path(directory))
        trials = [trial for trial in there if trial.condition == label]
        if not trials:
            known = dict.fromkeys(trial.condition for trial in there)
            raise UnknownName(f"condition in {directory}", label, known or ["none, since no trial has ended there"])
        agents = list(dict.fromkeys(trial.group for trial in trials))
        if (chosen := one.of or (agents[0] if len(agents) == 1 else "")) not in agents:
            raise BadValue("of", chosen, f"an agent of {directory}: {', '.join(agents)}")
        said = claim_counts([trial for trial in trials if trial.group == chosen])
        if not said:
            raise BadValue("like", one.like, "a condition whose agent said what its attempts did")
        if one.by == "joint" and other.boxes != study.boxes:
            expected = f"a study of {study.box.name}, not of {other.box.name}; by=direction and by=total fit any box"
            raise BadValue("like", one.like, expected)
        joints = dict.fromkeys(joint for box in study.boxes for joint in box.names)
        rates = entries_of(misread_rates(said, [*joints], one.by))
        acting[i] = replace(one, like=f"{other.name}@{other.identity}/{label}", rates=rates, size=said.total())
        name = (name or condition.spec).replace(one.like, f"{other.name}/{label}")
    changed = acting != [*condition.interventions]
    return replace(condition, interventions=tuple(acting), name=name) if changed else condition
