"""The conditions that a request asks for: flip rates, conditions by name, sweeps, each in every modality."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

from lockprobe.agents.catalogue import is_strategy
from lockprobe.foundation.errors import BadValue, Conflict
from lockprobe.foundation.spec import Spec, spec_name, split_specs
from lockprobe.foundation.validation import check_choice
from lockprobe.interventions.conditions import blind, flips, read_condition, says_modality, shipped, sweep
from lockprobe.interventions.flip import DEFAULT, FlipKind, OutcomeFlip, flip_of
from lockprobe.interventions.told import Correction
from lockprobe.plants.catalogue import PlantSource
from lockprobe.studies.modality import is_pictured
from lockprobe.studies.options.presets import preset
from lockprobe.studies.options.study_options import NamedCondition, StudyOptions
from lockprobe.trial.condition import TRUTH, Condition
from lockprobe.trial.doses import modality_doses

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
