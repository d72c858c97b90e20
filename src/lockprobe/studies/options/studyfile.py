"""From options to a :class:`lockprobe.studies.study.Study`; what is left out is as in the study's preset.

:func:`study` makes a whole one, :func:`trial_study` the one to which a single trial belongs.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from lockprobe.agents.catalogue import resolve
from lockprobe.boxes.boxfile import box_from_data
from lockprobe.boxes.families import DEFAULT_BOX, find_box
from lockprobe.boxes.generate import alike_boxes
from lockprobe.boxes.state_space import fault_of
from lockprobe.foundation.errors import BadValue, UnknownName, UserMistake
from lockprobe.foundation.plugins import allow
from lockprobe.foundation.spec import PEOPLE, spec_name
from lockprobe.foundation.validation import check_whole
from lockprobe.interventions.conditions import flips, read_condition, says_modality
from lockprobe.interventions.flip import DEFAULT, OutcomeFlip
from lockprobe.interventions.misread_flip import MisreadFlip, entries_of
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.statistics.misinterpretation import claim_counts, misread_rates
from lockprobe.studies.modality import is_pictured, refuse_blind, shows_places
from lockprobe.studies.options.asked import conditions_of, with_defaults
from lockprobe.studies.options.study_options import StudyOptions, read_options
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import load
from lockprobe.studies.study import LIMITS, Study, Until
from lockprobe.trial.condition import Condition
from lockprobe.trial.protocols import Intervention
from lockprobe.trial.record import STATES

_MOST_BOXES = 100
"""The most boxes that a study generates."""

_MOST = 300
"""Trials under each condition at most of a study that stops when it is decided, unless ``--most`` says otherwise."""


def study(asked: StudyOptions | str | Path = "flips", /, **options: Any) -> Study:
    """The study that options, a TOML file, or a bare name describe.

    >>> [condition.label for condition in study("flips", agent="random", sweep="tremble?p=0,0.1").conditions]
    ['truth', 'tremble?p=0.1']

    What it leaves out is as in the study's file in ``lockprobe/presets``
    (:func:`lockprobe.studies.options.asked.with_defaults`). A study of flips of which nothing is said is short; as
    soon as something is said, what is left out follows the paper.

    Args:
        asked: Options, the path of a TOML file, ``flips``, ``modalities``, ``why`` or ``looks``.
        options: Any of :class:`lockprobe.studies.options.study_options.StudyOptions`, which go before those.

    Raises:
        UserMistake: If anything in it does not exist or is out of range.
    """
    said = read_options(asked, options)
    allow(*(spec for specs in said.specs.values() for spec in specs))  # a file that names code was refused
    request, cases = with_defaults(said)
    plant, (agents, names) = resolve_plant(str(request.plant)), request.agents
    for agent in agents:
        resolve(agent)
    conditions, spared = conditions_of(said, request, cases, plant)
    seen = PEOPLE in agents or any(shows_places(one.modality) for one in conditions)
    if request.layout is None and seen and plant.lays_out:  # or whoever sees places need not look at anything else
        request = request.model_copy(update={"layout": "shuffled"})
    planned = _planned(request, agents, conditions, names=names, strategy_conditions=spared)
    planned.check_agents()
    planned = replace(planned, conditions=tuple(_with_rates(one, planned) for one in planned.conditions))
    played = {one.label for agent in planned.agents for one in planned.conditions_of(agent)}
    for one in planned.conditions if request.condition is not None or request.sweep is not None else ():
        if one.label not in played and one.specs and is_pictured(one.modality):
            refuse_blind(planned.agents[0], one.modality, "words")
    for box in planned.boxes:
        try:
            box_from_data(box.as_data())
        except UserMistake as error:
            raise BadValue("box", box.name, f"one that a file can hold ({error})") from None
        if fault := fault_of(box):
            raise BadValue("box", box.name, f"one that can be played ({fault})")
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
    several = isinstance(condition, Sequence) and all(isinstance(one, Intervention) for one in condition)
    if not (several or isinstance(condition, str | Condition | None)):
        raise BadValue("condition", condition, "specs with plus signs between, a Condition, or a list of interventions")
    allow(*(spec for spec in (agent, given.get("plant"), condition) if isinstance(spec, str)))
    asked = {one: value for one, value in given.items() if value is not None}
    asked |= {"repetitions": asked.pop("repetition", 1), "trials": asked.pop("trial", 1), "name": name}
    request = read_options(StudyOptions(), asked)
    for one in ("p", "modality", "box"):
        if len(getattr(request, one) or ()) > 1:
            raise BadValue(one, given[one], "one for one trial")
    (p,), shown = request.p or [0.0], request.modality
    found = like = flips((p,), request.flip or DEFAULT, shown)[0]
    if condition:
        says = isinstance(condition, str) and says_modality(condition)
        if isinstance(condition, str):
            condition = read_condition(condition, plant=request.plant or "symbolic")
        found = condition if isinstance(condition, Condition) else Condition(interventions=tuple(condition))
        itself = any(spec_name(spec) == OutcomeFlip.name for spec in found.specs)
        if (p and itself) or (request.flip is not None and not p):
            raise BadValue("p", p, "0 with a condition that flips reports itself, and a flip rate with flip")
        if p:
            found = replace(found, interventions=(*like.interventions, *found.interventions))
        if not says and found.modality == STATES:
            found = replace(found, modality=like.modality)
        elif shown not in (None, [found.modality]):
            raise BadValue("modality", shown, f"none with a condition that says {found.modality} itself")
    return _planned(request, [agent], [found])


def _planned(request: StudyOptions, agents: Sequence[str], conditions: Sequence[Condition], **more: Any) -> Study:
    """The study of a request."""
    named = request.box or [DEFAULT_BOX]
    boxes = tuple(find_box(one) for one in named) if request.boxes is None else ()
    if request.boxes is not None:
        family = ", ".join(map(str, request.box or ["random-4"]))
        if not (drawn := re.fullmatch(r"random-([4-8])", family)):
            raise BadValue("boxes", request.boxes, f"none with the box {family}, but with random-4 to random-8")
        check_whole("boxes", request.boxes, 2, _MOST_BOXES)
        boxes = alike_boxes(int(drawn[1]), request.boxes)
    sizes: dict[str, Any] = {one: getattr(request, one) for one in ("repetitions", "trials", "strategy_trials")}
    if request.until is None:
        if request.most is not None:
            raise BadValue("most", request.most, "--until with it; --trials says how many trials are played")
        sizes = {
            one: value * (1 if one == "repetitions" else len(boxes))
            for one, value in sizes.items()
            if value is not None
        }
    else:
        if request.study == "looks":
            raise BadValue("until", request.until, f"none with {request.study}, whose answer holds for one look")
        for one, value in {**sizes, "full": request.full or None}.items():
            if value is not None:
                raise BadValue(one, value, f"none with --until {request.until}; --most says how many trials at most")
        most = _MOST if request.most is None else request.most
        check_whole("most", most, 1, LIMITS["trials"])
        sizes = {"repetitions": 1, "trials": most, "until": Until.parse(request.until)}
    said = ("max_steps", "seed", "shuffle", "layout", "assessment", "hypothesis", "contrasts")
    planned = Study(
        name=request.study if request.name is None else request.name,
        agents=tuple(agents),
        boxes=boxes,
        conditions=tuple(conditions),
        plant=resolve_plant("symbolic" if request.plant is None else request.plant).spec,
        **sizes,
        **{one: value for one in said if (value := getattr(request, one)) is not None},
        **more,
    )
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
