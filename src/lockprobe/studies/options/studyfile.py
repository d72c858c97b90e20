"""From options to a :class:`lockprobe.studies.study.Study`; what is left out follows the paper.

:func:`study` makes a whole one, :func:`trial_study` the one to which a single trial belongs.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from lockprobe.agents.catalogue import is_strategy, resolve
from lockprobe.boxes.box import Lockbox
from lockprobe.boxes.boxfile import box_from_data
from lockprobe.boxes.check import fault_of
from lockprobe.boxes.families import find_box
from lockprobe.boxes.generate import alike_boxes
from lockprobe.foundation.errors import BadValue, UnknownName, UserMistake
from lockprobe.foundation.plugins import allow
from lockprobe.foundation.spec import Spec, spec_name, split_specs
from lockprobe.foundation.validation import check_whole
from lockprobe.interventions.catalogue import shipped
from lockprobe.interventions.conditions import blind, distinct, flips, read_condition, says_modality, sweep
from lockprobe.interventions.flip import DEFAULT, FlipKind, OutcomeFlip, flip_of
from lockprobe.plants.catalogue import PlantSource, resolve_plant
from lockprobe.studies.looks import looks_conditions
from lockprobe.studies.modality import is_pictured, refuse_blind
from lockprobe.studies.options import paper
from lockprobe.studies.options.agent_names import named_agents
from lockprobe.studies.options.as_paper import as_paper
from lockprobe.studies.options.misreadings import with_misreadings
from lockprobe.studies.options.readings import (
    conditions_for_strategies,
    flips_of_readings,
    rates_of_models,
    readings_of,
)
from lockprobe.studies.options.sizes import sizes_of
from lockprobe.studies.options.study_defaults import (
    extent_of,
    layout_by_default,
    plant_of,
    players_by_default,
    shown_by_default,
    shuffle_by_default,
)
from lockprobe.studies.options.study_options import SHIPPED, STUDIES, StudyOptions, read_options_file, study_options
from lockprobe.studies.options.trial_options import trial_options
from lockprobe.studies.study import Study
from lockprobe.studies.why import arm_conditions
from lockprobe.trial.condition import TRUTH, Condition
from lockprobe.trial.doses import DOSES_SAID, can_be_fitted, modality_doses
from lockprobe.trial.plant_change import PLANT
from lockprobe.trial.protocols import Intervention
from lockprobe.trial.record import STATES

LONGEST_SPEC = 1000
"""Characters of the spec of an agent, a condition or a plant."""

MOST_BOXES = 100
"""The most boxes that a study generates."""

AGENT_SWEEP = "agent."
"""How a sweep begins that is over an option of agents."""

_T = TypeVar("_T")


def study(asked: StudyOptions | str | Path = "flips", /, **options: Any) -> Study:
    """The study that options, a TOML file, or a bare name describe.

    >>> [condition.label for condition in study("flips", agent="random", sweep="tremble?p=0,0.1").conditions]
    ['truth', 'tremble?p=0.1']

    With ``as_paper`` the set-up is the paper's, as far as it is known
    (:func:`lockprobe.studies.options.as_paper.as_paper`).

    A request for flips that says nothing of ``p``, ``trials``, ``repetitions`` and ``full`` gets the short extent; as
    soon as it says something, what it leaves out follows the paper. The modality study is always of the paper's
    extent, on a panel that is dealt anew in every trial; on a plant without a camera it has no pictures. The study
    ``why`` has its arms at one flip rate, with ``parts`` those of the parts of a false report too, and other conditions
    after them.

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
    request = asked.model_copy(update={name: getattr(study_options(options), name) for name in options})
    allow(*(spec for specs in request.specs.values() for spec in specs))  # a file that names code was refused
    if request.study not in STUDIES:
        raise UnknownName("study", request.study, [*STUDIES, *SHIPPED, "FILE.toml"])
    _check_lengths(request)
    plant = resolve_plant(plant_of(request))
    if request.as_paper:
        request = as_paper(request, plant)
    modalities = tuple(_given(request.modality, shown_by_default(request, plant)))
    if request.flip == "outcome-only":
        modalities = tuple(map(blind, modalities))
    _check_controls(request)
    extent = extent_of(request)
    written = request.agent if request.agent is not None else players_by_default(request.study, modalities)
    agents, names = named_agents(written)
    for spec in agents:
        resolve(spec)
    for spec in request.sweep or ():
        if spec.startswith(AGENT_SWEEP):
            agents, names = _swept_agents(agents, names, spec)
    allow(*agents)
    conditions = _conditions(request, extent, modalities, plant)
    spared = [*conditions_for_strategies(extent)] if _is_plain(request) and any(map(is_strategy, agents)) else []
    planned = _planned(request, plant, agents, [*conditions, *spared], extent, names)
    spared += [one for one in conditions if one.p not in rates_of_models(extent)] if spared else []
    alone = tuple(one.label for one in spared)
    planned = replace(planned, strategy_conditions=alone, contrasts=request.contrasts or {})
    allow(*planned.plants)
    planned.check_agents()
    planned = with_misreadings(planned)
    _check_played(planned, request)
    for box in planned.boxes:
        _check_kept(box)
    return planned


def _check_played(planned: Study, request: StudyOptions) -> None:
    """Refuse a condition that was asked for and that no agent of the study plays."""
    if request.condition is None and request.sweep is None:
        return
    played = {one.label for agent in planned.agents for one in planned.conditions_of(agent)}
    for one in planned.conditions:
        if one.label not in played and one.specs and is_pictured(one.modality):
            refuse_blind(planned.agents[0], one.modality, "words")


def trial_study(given: Mapping[str, Any], *, agent: str, name: str = "trial") -> Study:
    """The study of which the given trial is the last. It has one condition and no control.

    >>> trial_study({"condition": "tremble?p=0.1", "trial": 3}, agent="random").conditions[0].label
    'tremble?p=0.1'

    Args:
        given: Any of :class:`lockprobe.studies.options.trial_options.TrialOptions`.
        agent: Who plays it; it is not looked up.
        name: Its name, with which the key of the record begins.

    Raises:
        UserMistake: If anything in it does not exist or is out of range.
    """
    allow(*(spec for option in ("agent", "plant", "condition") if isinstance(spec := given.get(option), str)))
    request = trial_options(given).model_copy(update={"name": name})
    _check_lengths(request)
    plant = resolve_plant(plant_of(request))
    condition = _one_condition(given.get("condition"), request, plant)
    planned = _planned(request, plant, [agent], [condition], paper.ONE_TRIAL, {})
    if len(planned.boxes) > 1:
        raise BadValue("box", ", ".join(box.name for box in planned.boxes), "one box for one trial")
    allow(*planned.plants)
    return planned


def _planned(
    request: StudyOptions,
    plant: PlantSource,
    agents: Sequence[str],
    conditions: Sequence[Condition],
    extent: paper.Extent,
    names: Mapping[str, str],
) -> Study:
    boxes = find_boxes(request)
    return Study(
        name=_given(request.name, request.study),
        agents=tuple(agents),
        boxes=boxes,
        conditions=tuple(conditions),
        **sizes_of(request, extent, len(boxes))._asdict(),
        max_steps=_given(request.max_steps, paper.MAX_STEPS),
        seed=_given(request.seed, 1),
        shuffle=_given(request.shuffle, shuffle_by_default(request.study, plant)),
        plant=plant.spec,
        layout=_given(request.layout, layout_by_default(request.study, plant)),
        assessment=_given(request.assessment, True),
        hypothesis=_given(request.hypothesis, "before"),
        names=names,
    )


def find_boxes(request: StudyOptions) -> tuple[Lockbox, ...]:
    """The boxes of a request, one or several.

    Raises:
        UserMistake: If one does not exist or cannot be played, or so many are asked for by number and others by name.
    """
    named = request.boxes_named or [paper.BOX]
    if request.boxes is None:
        return tuple(find_box(one) for one in named)
    family = ", ".join(map(str, request.boxes_named)) or "random-4"
    if not (drawn := re.fullmatch(r"random-([4-8])", family)):
        raise BadValue("boxes", request.boxes, f"none with the box {family}, but with random-4 to random-8")
    check_whole("boxes", request.boxes, 2, MOST_BOXES)
    return alike_boxes(int(drawn[1]), request.boxes)


def _is_plain(request: StudyOptions) -> bool:
    """Whether it asks for the flip study as it is, the short one or the paper's, and nothing that varies otherwise."""
    varied = (request.p, request.flip, request.readings, request.modality, request.condition, request.sweep)
    whole = request.full or (request.trials is None and request.repetitions is None)
    return request.study == "flips" and whole and all(given is None for given in varied)


def _readings(request: StudyOptions) -> tuple[FlipKind, ...]:
    """The readings of a false report, the first of which is that of the flip axis."""
    if request.readings is None:
        return (_flip(request),)
    if request.flip is not None:
        raise BadValue("readings", ",".join(request.readings), f"none with --flip {request.flip}: each names readings")
    if request.study != "flips":
        raise BadValue("readings", ",".join(request.readings), f"none with {request.study}; flips plays them")
    return readings_of(request.readings)


def _flip(request: StudyOptions) -> FlipKind:
    return _given(request.flip, DEFAULT)


def _check_kept(box: Lockbox) -> None:
    """Refuse a box that cannot be played, or that the settings of a study on disk could not hold."""
    try:
        box_from_data(box.as_data())
    except UserMistake as error:
        raise BadValue("box", box.name, f"one that a file can hold ({error})") from None
    if fault := fault_of(box):
        raise BadValue("box", box.name, f"one that can be played ({fault.reason})")


def _swept_agents(agents: Sequence[str], names: Mapping[str, str], spec: str) -> tuple[list[str], dict[str, str]]:
    """Agents with every value of one of their options: ``agent.temperature=0,0.5,1``. Those without it stay.

    A name gets the option too: ``small`` is ``small?temperature=0``.
    """
    option, _, values = spec.removeprefix(AGENT_SWEEP).partition("=")
    if not option or "," not in values:
        raise BadValue("sweep", spec, "several values with commas between, for example agent.temperature=0,0.5,1")
    for value in values.split(","):
        if not _can_be_dose(value):
            raise BadValue(f"sweep, {option}", value, DOSES_SAID)
    found, called, refused = list[str](), dict(names), ""
    for agent in agents:
        said = [value.strip() for value in values.split(",")]
        several = [Spec.parse(agent).appending(option, value) for value in said]
        try:
            found += [str(one) for one in several if resolve(one)]
            if name := names.get(agent):
                here = [str(Spec.parse(name).appending(option, value)) for value in said]
                called |= dict(zip(map(str, several), here, strict=True))
        except UnknownName as error:
            refused = refused or str(error)
            found.append(agent)
    if len(found) == len(agents):
        raise BadValue("sweep", spec, f"an option that one of the agents has ({refused})")
    return found, called


def _can_be_dose(text: str) -> bool:
    """Whether a value of an option is a word, or a number that can be a dose."""
    try:
        return can_be_fitted(float(text))
    except ValueError:
        return True


def _conditions(
    request: StudyOptions, extent: paper.Extent, modalities: Sequence[str], plant: PlantSource
) -> tuple[Condition, ...]:
    """Flip rates and modalities, or other conditions with the truth before them; those that say no modality in each."""
    kinds = _readings(request)
    p = extent.p if request.p is None else tuple(request.p)
    for what, values in (("p", p), ("modality", tuple(modalities))):
        if not values or len(set(values)) != len(values):
            raise BadValue(what, list(values), "at least one, and every one once")
    if request.study == "why":
        return _arms(request, p, modalities, plant)
    if request.study == "looks":
        return _looks(request, modalities, plant)
    if request.condition is None and request.sweep is None:
        return flips_of_readings(p, kinds, modalities)
    asked = request.p is not None or request.readings is not None
    rates = [one for kind in kinds for one in flips(p, flip_of(kind))] if asked else ()
    return _with_controls([*(_Asked(one, shown=False) for one in rates), *_asked(request, plant)], modalities)


class _Asked(NamedTuple):
    """A condition that was asked for, and whether its text says how the box is shown."""

    condition: Condition
    shown: bool


def _asked(request: StudyOptions, plant: PlantSource) -> list[_Asked]:
    """The conditions and sweeps that are named."""
    named = [
        (_acting(read_condition(one.spec, one.name, plant.spec), one.spec), one.spec)
        for one in request.conditions_named
    ]
    doses = [spec for spec in request.sweep or () if not spec.startswith(AGENT_SWEEP)]
    swept = [(one, spec) for spec in doses for one in sweep(spec, plant.spec)]
    return [_Asked(one, says_modality(spec)) for one, spec in (*named, *swept)]


def _acting(asked: Condition, text: str) -> Condition:
    """A condition that was asked for, if it does what it says.

    Raises:
        BadValue: If its dose is 0 although it has a name, or because none was given; or if it is called what another
            condition is.
    """
    if asked.specs and asked.does_nothing:
        said = {option for part in split_specs(text) for option in Spec.parse(part, "intervention").options}
        doses = [names[0] for _, names in asked.acting if names]
        if said.isdisjoint(doses):
            expected = f"one that does something; without {doses[0]}= it is the truth"
            raise BadValue("condition", text, expected)
        if asked.name and asked.p is None:
            raise BadValue("condition", asked.spec, "one that does something; at dose 0 it is the truth")
    if not asked.specs and not asked.name and any(spec_name(part) == PLANT for part in split_specs(text)):
        raise BadValue("condition", text, "one that changes the plant; the plant of the study is so already")
    if asked.name == TRUTH and not asked.does_nothing:
        raise BadValue("condition", f"{TRUTH}={asked.spec}", "another name: truth is the control")
    if asked.name in shipped() and asked.specs and spec_name(asked.specs[0]) != asked.name:
        raise BadValue("condition", f"{asked.name}={asked.spec}", f"another name: {asked.name} is an intervention")
    if any(mark in asked.name for mark in "?+"):
        raise BadValue("condition", asked.name, "a name without ? and +, which are of specs")
    return asked


def _arms(
    request: StudyOptions, p: Sequence[float], modalities: Sequence[str], plant: PlantSource
) -> tuple[Condition, ...]:
    """The arms of the study ``why``, and the conditions that are named after them."""
    for what, values in (("p", p), ("modality", modalities)):
        if len(values) > 1:
            raise BadValue(what, list(values), "one, which all arms have")
    like = flip_of(_flip(request))
    if request.parts and like != OutcomeFlip():
        raise BadValue("flip", request.flip, f"{DEFAULT} with --parts, whose parts they are")
    (shown,) = modalities
    arms, asked = arm_conditions(p[0], shown, like, parts=request.parts), _asked(request, plant)
    for condition, says_own in asked:
        if says_own and condition.modality != shown:
            raise BadValue("condition", condition.spec, f"none that is shown otherwise than all arms, {shown}")
    more = [replace(condition, modality=shown) for condition, _ in asked]
    for one in more:
        if same := next((arm for arm in arms if arm.specs == one.specs), None):
            raise BadValue("condition", one.label, f"another condition than the arm {same.label}, which is the same")
        if same := next((arm for arm in arms if arm.label == one.label), None):
            raise BadValue("condition", f"{one.label}={one.spec}", f"another name: {one.label} is the arm {same.spec}")
    found = distinct([*arms, *more])
    _check_names(found)
    return found


def _looks(request: StudyOptions, modalities: Sequence[str], plant: PlantSource) -> tuple[Condition, ...]:
    """The conditions of the study ``looks``: pictures of one modality."""
    if len(modalities) > 1:
        raise BadValue("modality", list(modalities), "one, whose pictures looks is about")
    for what in ("p", "condition", "sweep"):
        if getattr(request, what) is not None:
            raise BadValue(what, getattr(request, what), "none with looks, which has its own conditions")
    if request.flip is not None:
        raise BadValue("flip", request.flip, "none with looks, in which no report is false")
    return looks_conditions(modalities[0], plant)


def _one_condition(
    asked: str | Condition | Sequence[Intervention] | None, request: StudyOptions, plant: PlantSource
) -> Condition:
    """A condition that stands alone: a flip rate acts first, a modality shows it."""
    (p,) = _given(request.p, paper.ONE_TRIAL.p)
    if not asked:
        return flips((p,), _flip(request), request.modality)[0]
    blinded = _flip(request) == "outcome-only"
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
        found = replace(found, interventions=(flip_of(_flip(request), p), *found.interventions))
    if unsaid:
        (shown,) = _given(request.modality, ["symbolic" if blinded else STATES])
        return replace(found, modality=blind(shown) if blinded else shown)
    if request.modality is not None and request.modality != [found.modality]:
        raise BadValue("modality", request.modality[0], f"none with a condition that says {found.modality} itself")
    return found


def _with_controls(found: Sequence[_Asked], modalities: Sequence[str]) -> tuple[Condition, ...]:
    """Conditions shown in every way, those that say their own only in that, each way with the truth as its control."""
    own = [one.condition for one in found if one.shown]
    acting = [
        one.condition for one in found if not one.shown and (one.condition.name or not one.condition.does_nothing)
    ]
    named = [one for one in acting if one.does_nothing]
    controls = named or [Condition()]
    everywhere = [*controls, *(one for one in acting if one not in named)]
    known = {one.modality: one for one in own if one.name and one.does_nothing}

    def shown(one: Condition, modality: str) -> Condition:
        """A condition shown in one way; in place of the control that with a name, if there is one."""
        here = replace(one, modality=modality)
        return known.get(modality, here) if one is controls[0] else here

    planned = distinct(
        [
            *(shown(one, modality) for modality in modalities for one in everywhere),
            *(shown(controls[0], modality_doses(one.modality)[0]) for one in own),
            *(one for one in own if one.name or not one.does_nothing or modality_doses(one.modality)[1]),
        ]
    )
    _check_names(planned)
    return planned


def _check_names(conditions: Sequence[Condition]) -> None:
    """Refuse one condition under two names, which would be compared as if it were two."""
    seen: dict[tuple[object, ...], str] = {}
    for one in conditions:
        what = (() if one.does_nothing else one.specs, one.modality)
        if (first := seen.setdefault(what, one.label)) != one.label:
            raise BadValue("condition", one.label, f"another condition than {first}, which is the same")


def _check_lengths(request: StudyOptions) -> None:
    for what, specs in (
        ("agent", request.agent or ()),
        ("plant", [request.plant or ""]),
        ("modality", request.modality or ()),
        ("condition", request.acting),
        ("sweep", request.sweep or ()),
    ):
        for spec in specs:
            if len(spec) > LONGEST_SPEC:
                raise BadValue(what, f"{spec[:40]}…", f"at most {LONGEST_SPEC} characters; these are {len(spec)}")


def _check_controls(request: StudyOptions) -> None:
    """Refuse options of a study of controls with another, and of flips with it."""
    if request.full and request.study in ("why", "looks"):
        raise BadValue("full", True, f"none with {request.study}, which has trials of its own; --trials says how many")
    if request.parts and request.study != "why":
        raise BadValue("parts", True, f"none with {request.study}; why plays the parts of a false report")


def _given(value: _T | None, default: _T) -> _T:
    return default if value is None else value
