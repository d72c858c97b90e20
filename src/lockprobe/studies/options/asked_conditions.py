"""The conditions that a request asks for: flip rates, conditions by name, sweeps, each in every modality."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.spec import Spec, spec_name, split_specs
from lockprobe.foundation.validation import check_choice
from lockprobe.interventions.conditions import blind, flips, read_condition, says_modality, shipped, sweep
from lockprobe.interventions.flip import DEFAULT, FlipKind, OutcomeFlip, flip_of
from lockprobe.interventions.told import Correction
from lockprobe.plants.catalogue import PlantSource
from lockprobe.studies.modality import is_pictured
from lockprobe.studies.options.presets import own_conditions
from lockprobe.studies.options.study_options import NamedCondition, StudyOptions
from lockprobe.trial.condition import TRUTH, Condition
from lockprobe.trial.doses import modality_doses

READINGS: tuple[FlipKind, ...] = ("re-observed", "integrated", "memoryless", "latched")
"""The readings of a false report that the paper leaves open, the default first."""

_WORDS: dict[str, tuple[FlipKind, ...]] = {
    "fresh": ("re-observed",),
    "kept": ("integrated",),
    "transient": ("memoryless",),
    "sticky": ("latched",),
    "all": READINGS,
    **{word: (word,) for word in READINGS},
}


def conditions_of(asked: StudyOptions, request: StudyOptions, plant: PlantSource) -> tuple[Condition, ...]:
    """Flip rates and modalities, or other conditions with the truth before them; those that say no modality in each.

    Args:
        asked: What the user said.
        request: The same with its defaults.
        plant: The study's plant.

    Raises:
        UserMistake: If a condition does not exist, cannot be played, or is asked for twice.
    """
    kinds, p, modalities = _readings(asked), request.p or [], request.modality or []
    for what, values in (("p", p), ("modality", modalities)):
        if not values or len(set(values)) != len(values):
            raise BadValue(what, values, "at least one, and every one once")
    if asked.flip == "outcome-only":
        modalities = [*map(blind, modalities)]
    own = own_conditions(asked)
    if not own and request.condition is None and request.sweep is None:
        others = [one for kind in kinds[1:] for one in flips([rate for rate in p if rate], kind, modalities)]
        return (*flips(p, kinds[0], modalities), *others)
    if own:
        _check_own(asked, own, p, modalities, plant)
    rates = not own and (asked.p is not None or asked.readings is not None)
    said = [(_acting(one, plant), one.spec) for one in request.conditions_named]
    said += [(one, spec) for spec in request.sweep or () for one in sweep(spec, plant.spec)]
    shown = [one for one, spec in said if says_modality(spec)]
    if own and any(one.modality != modalities[0] for one in shown):
        expected = f"none that is shown otherwise than all others, {modalities[0]}"
        raise BadValue("condition", shown[0].spec, expected)
    everywhere = [
        *(one for kind in kinds if rates for one in flips(p, flip_of(kind))),
        *(_filled(one, p[0], kinds[0], plant) for one in own),
        *(one for one, spec in said if own or not says_modality(spec)),
    ]
    return _with_controls(everywhere, [] if own else shown, modalities)


def alone_with_strategies(request: StudyOptions) -> tuple[Condition, ...]:
    """The conditions that are asked for strategies besides, without a control."""
    rates = [rate for rate in request.p or () if rate > 0]
    named = [read_condition(one.spec, one.name) for one in request.conditions_named]
    return (*(one for kind in _readings(request) for one in flips(rates, flip_of(kind))), *named)


def _readings(asked: StudyOptions) -> tuple[FlipKind, ...]:
    """The readings of a false report, the first of which is that of the flip axis."""
    if asked.readings is None:
        return (asked.flip or DEFAULT,)
    said = ",".join(asked.readings)
    if asked.flip is not None:
        raise BadValue("readings", said, f"none with --flip {asked.flip}: each names readings")
    if asked.study != "flips":
        raise BadValue("readings", said, f"none with {asked.study}; flips plays them")
    for word in asked.readings:
        check_choice("readings", word, _WORDS)
    found = [kind for word in asked.readings for kind in _WORDS[word]]
    if not found or len({*found}) < len(found):
        raise BadValue("readings", said, "at least one, and every one once")
    return tuple(found)


def _check_own(
    asked: StudyOptions,
    own: Sequence[NamedCondition],
    p: Sequence[float],
    modalities: Sequence[str],
    plant: PlantSource,
) -> None:
    """Refuse what a study with conditions of its own would leave out, or would play twice."""
    study, specs = asked.study, [one.spec for one in own]
    if len(modalities) > 1:
        raise BadValue("modality", modalities, f"one, which all conditions of {study} have")
    if is_pictured(modalities[0]) and any(spec_name(spec) == Correction.name for spec in specs):
        raise BadValue("modality", modalities[0], "symbolic, with or without options: pictures cannot be corrected")
    if not any("{p}" in spec for spec in specs):
        for name in ("p", "condition", "sweep", "flip"):
            if (given := getattr(asked, name)) is not None:
                raise BadValue(name, given, f"none with {study}, which has its own conditions")
    elif len(p) > 1:
        raise BadValue("p", p, "one, which all arms have")
    varied = {option for spec in specs for option in Spec.parse(spec).options}
    if named := [f"{name}={value}" for name, value in Spec.parse(plant.spec).options.items() if name in varied]:
        raise BadValue("plant", plant.spec, f"one without {', '.join(named)}, which this study varies")


def _filled(own: NamedCondition, p: float, kind: FlipKind, plant: PlantSource) -> Condition:
    """A condition of a preset with the flip rate and what a false report is."""
    like, plain = flip_of(kind), OutcomeFlip()
    options = {name: getattr(like, name) for name in ("inverts", "others")}
    reading = "".join(f"&{name}={value}" for name, value in options.items() if value != getattr(plain, name))
    return read_condition(own.spec.format(p=f"{p:g}", reading=reading), own.name, plant.spec)


def _acting(said: NamedCondition, plant: PlantSource) -> Condition:
    """A condition that was asked for.

    Raises:
        BadValue: If it does nothing because no dose was given, or is called what another condition is.
    """
    asked = read_condition(said.spec, said.name, plant.spec)
    if asked.specs and asked.does_nothing:
        options = {option for part in split_specs(said.spec) for option in Spec.parse(part, "intervention").options}
        doses = [names[0] for _, names in asked.acting if names]
        if options.isdisjoint(doses):
            expected = f"one that does something; without {doses[0]}= it is the truth"
            raise BadValue("condition", said.spec, expected)
    first = spec_name(asked.specs[0]) if asked.specs and not asked.does_nothing else TRUTH
    if {*"?+"} & {*asked.name} or (asked.name in (TRUTH, *shipped()) and asked.name != first):
        raise BadValue("condition", f"{asked.name}={asked.spec}", f"another name: {asked.name} is a condition itself")
    return asked


def _with_controls(
    everywhere: Sequence[Condition], own: Sequence[Condition], modalities: Sequence[str]
) -> tuple[Condition, ...]:
    """Conditions shown in every way, and those with a way of their own; each way has the truth as its control."""
    acting = [one for one in everywhere if one.name or not one.does_nothing]
    controls = [one for one in acting if one.does_nothing] or [Condition()]
    known = {one.modality: one for one in own if one.name and one.does_nothing}

    def control(modality: str) -> Condition:
        return known.get(modality, replace(controls[0], modality=modality))

    found = list[Condition]()
    for modality in modalities:
        others = [*controls[1:], *(one for one in acting if not one.does_nothing)]
        found += [control(modality), *(replace(one, modality=modality) for one in others)]
    found += [control(modality_doses(one.modality)[0]) for one in own]
    found += [one for one in own if one.name or not one.does_nothing or modality_doses(one.modality)[1]]
    planned = tuple(dict.fromkeys(found))
    _check_names(planned)
    return planned


def _check_names(conditions: Iterable[Condition]) -> None:
    """Refuse one condition under two names, which would be compared as if it were two, and two under one name."""
    called, known = dict[tuple[object, ...], str](), dict[str, Condition]()
    for one in conditions:
        what = (() if one.does_nothing else one.specs, one.modality)
        if (first := called.setdefault(what, one.label)) != one.label:
            raise BadValue("condition", one.label, f"another condition than {first}, which is the same")
        if (other := known.setdefault(one.label, one)) is not one:
            raise BadValue("condition", f"{one.label}={one.spec}", f"another name: {one.label} is {other.spec}")
