"""What is asked for and not said: the studies that ship, and the conditions that a request has in the end.

Each study is a file in ``lockprobe/presets``, with tables of what is played instead in some cases (``when``), and of
what strategies or models alone play. Conditions are flip rates, conditions by name and sweeps, each in every modality.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

from pydantic import Field

from lockprobe.agents.catalogue import is_strategy
from lockprobe.boxes.families import ALIKE
from lockprobe.foundation.errors import BadValue, Conflict
from lockprobe.foundation.inputs import read_preset
from lockprobe.foundation.spec import PEOPLE, Spec, spec_name, split_specs
from lockprobe.foundation.validation import check_choice
from lockprobe.interventions.conditions import blind, flips, read_condition, says_modality, shipped, sweep
from lockprobe.interventions.flip import DEFAULT, FlipKind, OutcomeFlip, flip_of
from lockprobe.interventions.told import Correction
from lockprobe.plants.catalogue import PlantSource, resolve_plant
from lockprobe.studies.modality import is_pictured, taken_in
from lockprobe.studies.options.study_options import STUDIES, NamedCondition, StudyOptions
from lockprobe.trial.condition import TRUTH, Condition
from lockprobe.trial.doses import modality_doses
from lockprobe.trial.record import STATES

_READINGS: tuple[FlipKind, ...] = ("re-observed", "integrated", "memoryless", "latched")
"""The readings of a false report that the paper leaves open, the default first."""

_WORDS: dict[str, tuple[FlipKind, ...]] = {
    "fresh": ("re-observed",),
    "kept": ("integrated",),
    "transient": ("memoryless",),
    "sticky": ("latched",),
    "all": _READINGS,
    **{word: (word,) for word in _READINGS},
}


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
    said = {name for name, value in asked if value is not None}
    paper, acting = asked.full or asked.as_paper, said & {"p", "condition", "sweep"}
    several = not paper and (len(asked.box or ()) > 1 or asked.boxes)
    holds = {
        "short": not (paper or acting or said & {"trials", "repetitions"}),
        "several_boxes": several,
        "full": asked.full,
        "as_paper": asked.as_paper,
        "parts": asked.parts,
        "plain": not (asked.as_paper or several or acting or said & {"flip", "readings", "modality"}),
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


def conditions_of(
    asked: StudyOptions, request: StudyOptions, cases: Collection[str], plant: PlantSource
) -> tuple[tuple[Condition, ...], tuple[str, ...]]:
    """The conditions of a study, and the labels of those that strategies alone play.

    They are flip rates and modalities, or other conditions with the truth before them; those that say no modality are
    shown in each.

    Args:
        asked: What the user said.
        request: The same with its defaults.
        cases: Those of its study that hold.
        plant: The study's plant.

    Raises:
        UserMistake: If a condition does not exist, cannot be played, or is asked for twice.
    """
    ships, found = preset(asked.study), _asked(asked, request, plant)
    case = next((one for one in ("full", "short") if {one, "plain"} <= {*cases}), "")
    if not (case in ships.strategies and any(map(is_strategy, request.agents[0]))):
        return found, ()
    besides, rates = ships.strategies[case], [rate for rate in request.p or () if rate]
    spared = [one for kind in _readings(besides) for one in flips(rates, flip_of(kind))]
    spared += [read_condition(one.spec, one.name) for one in besides.condition or ()]
    models = ships.models.get(case, request).p or ()
    alone = (*spared, *(one for one in found if one.p not in models))
    return (*found, *spared), tuple(one.label for one in alone)


def _asked(asked: StudyOptions, request: StudyOptions, plant: PlantSource) -> tuple[Condition, ...]:
    kinds, p, modalities = _readings(asked), request.p or [], request.modality or []
    for what, values in (("p", p), ("modality", modalities)):
        if not values or len(set(values)) != len(values):
            raise BadValue(what, values, "at least one, and every one once")
    if asked.flip == "outcome-only":
        modalities = [*map(blind, modalities)]
    ships = preset(asked.study)
    own = [*(ships.condition or ()), *((ships.when["parts"].condition or ()) if asked.parts else ())]
    if not own and request.condition is None and request.sweep is None:
        others = [one for kind in kinds[1:] for one in flips([rate for rate in p if rate], kind, modalities)]
        return (*flips(p, kinds[0], modalities), *others)
    if own:
        _check_own(asked, own, p, modalities, plant)
    said = [(_acting(one, plant), one.spec) for one in request.condition or ()]
    said += [(one, spec) for spec in request.sweep or () for one in sweep(spec, plant.spec)]
    shown = [one for one, spec in said if says_modality(spec)]
    if own and any(one.modality != modalities[0] for one in shown):
        expected = f"none that is shown otherwise than all others, {modalities[0]}"
        raise BadValue("condition", shown[0].spec, expected)
    rates = not own and (asked.p is not None or asked.readings is not None)
    like, plain = flip_of(kinds[0]), OutcomeFlip()
    changed = [name for name in ("inverts", "others") if getattr(like, name) != getattr(plain, name)]
    reading = "".join(f"&{name}={getattr(like, name)}" for name in changed)
    everywhere = [
        *(one for kind in kinds if rates for one in flips(p, flip_of(kind))),
        *(read_condition(one.spec.format(p=f"{p[0]:g}", reading=reading), one.name, plant.spec) for one in own),
        *(one for one, spec in said if own or not says_modality(spec)),
    ]
    return _with_controls(everywhere, [] if own else shown, modalities)


def _readings(asked: StudyOptions) -> tuple[FlipKind, ...]:
    """The readings of a false report, the first of which is that of the flip axis."""
    if asked.readings is None:
        return (asked.flip or DEFAULT,)
    if asked.flip is not None or asked.study != "flips":
        raise BadValue("readings", ",".join(asked.readings), "none with --flip, nor with a study other than flips")
    for word in asked.readings:
        check_choice("readings", word, _WORDS)
    return tuple(dict.fromkeys(kind for word in asked.readings for kind in _WORDS[word]))


def _check_own(
    asked: StudyOptions,
    own: Sequence[NamedCondition],
    p: Sequence[float],
    modalities: Sequence[str],
    plant: PlantSource,
) -> None:
    """Refuse what a study with conditions of its own would leave out, or would play twice."""
    specs = [one.spec for one in own]
    if len(modalities) > 1:
        raise BadValue("modality", modalities, f"one, which all conditions of {asked.study} have")
    if is_pictured(modalities[0]) and any(spec_name(spec) == Correction.name for spec in specs):
        raise BadValue("modality", modalities[0], "symbolic, with or without options: pictures cannot be corrected")
    if len(p) > 1:
        raise BadValue("p", p, "one, which all arms have")
    if not any("{p}" in spec for spec in specs):
        for name in ("p", "condition", "sweep", "flip"):
            if getattr(asked, name) is not None:
                raise Conflict(f"--{name}", asked.study, "it has its own conditions")
    varied = {option for spec in specs for option in Spec.parse(spec).options}
    if varied & Spec.parse(plant.spec).options.keys():
        raise BadValue("plant", plant.spec, f"one without {', '.join(sorted(varied))}, which {asked.study} varies")


def _acting(said: NamedCondition, plant: PlantSource) -> Condition:
    """A condition that was asked for.

    Raises:
        BadValue: If it does nothing because no dose was given, or is called what another condition is.
    """
    found = read_condition(said.spec, said.name, plant.spec)
    if found.specs and found.does_nothing:
        options = {option for part in split_specs(said.spec) for option in Spec.parse(part, "intervention").options}
        doses = [names[0] for _, names in found.acting if names]
        if options.isdisjoint(doses):
            expected = f"one that does something; without {doses[0]}= it is the truth"
            raise BadValue("condition", said.spec, expected)
    first = spec_name(found.specs[0]) if found.specs and not found.does_nothing else TRUTH
    if {*"?+"} & {*found.name} or (found.name in (TRUTH, *shipped()) and found.name != first):
        raise BadValue("condition", f"{found.name}={found.spec}", f"another name: {found.name} is a condition itself")
    return found


def _with_controls(
    everywhere: Sequence[Condition], own: Sequence[Condition], modalities: Sequence[str]
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
