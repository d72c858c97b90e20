"""The conditions that a request asks for: flip rates, conditions by name, sweeps, each in every modality."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.spec import Spec, spec_name, split_specs
from lockprobe.foundation.validation import check_choice
from lockprobe.interventions.catalogue import shipped
from lockprobe.interventions.conditions import blind, distinct, flips, read_condition, says_modality, sweep
from lockprobe.interventions.flip import DEFAULT, FlipKind, OutcomeFlip, flip_of
from lockprobe.plants.catalogue import PlantSource
from lockprobe.studies.modality import is_pictured
from lockprobe.studies.options.presets import own_conditions
from lockprobe.studies.options.study_options import NamedCondition, StudyOptions
from lockprobe.trial.condition import TRUTH, Condition
from lockprobe.trial.doses import modality_doses
from lockprobe.trial.plant_change import PLANT

AGENT_SWEEP = "agent."
"""How a sweep begins that is over an option of agents."""

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


class _Asked(NamedTuple):
    """A condition that was asked for, and whether its text says how the box is shown."""

    condition: Condition
    shown: bool


def conditions_of(asked: StudyOptions, request: StudyOptions, plant: PlantSource) -> tuple[Condition, ...]:
    """Flip rates and modalities, or other conditions with the truth before them; those that say no modality in each.

    Args:
        asked: What the user said.
        request: The same with its defaults.
        plant: The study's plant.

    Raises:
        UserMistake: If a condition does not exist, cannot be played, or is asked for twice.
    """
    kinds = _readings(asked)
    p, modalities = request.p or [], request.modality or []
    for what, values in (("p", p), ("modality", modalities)):
        if not values or len(set(values)) != len(values):
            raise BadValue(what, values, "at least one, and every one once")
    if asked.flip == "outcome-only":
        modalities = [*map(blind, modalities)]
    own = own_conditions(asked)
    if own and len(modalities) > 1:
        raise BadValue("modality", modalities, f"one, which all conditions of {asked.study} have")
    if asked.study == "looks":
        _check_looks(asked, own, modalities[0], plant)
    elif asked.study == "why":
        _check_why(asked, p, modalities[0])
    elif request.condition is None and request.sweep is None:
        return flips_of_readings(p, kinds, modalities)
    rates = asked.p is not None or asked.readings is not None
    flipped = [one for kind in kinds for one in flips(p, flip_of(kind))] if rates and not own else []
    swept = [spec for spec in request.sweep or () if not spec.startswith(AGENT_SWEEP)]
    found = [
        *(_Asked(one, shown=False) for one in flipped),
        *(_Asked(_filled(one, p[0], kinds[0], plant), shown=False) for one in own),
        *(_Asked(_acting(one, plant), says_modality(one.spec)) for one in request.conditions_named),
        *(_Asked(one, says_modality(spec)) for spec in swept for one in sweep(spec, plant.spec)),
    ]
    if own and (elsewhere := next((one.condition for one in found if one.shown), None)):
        if elsewhere.modality != modalities[0]:
            raise BadValue(
                "condition", elsewhere.spec, f"none that is shown otherwise than all others, {modalities[0]}"
            )
        found = [one._replace(shown=False) for one in found]
    return _with_controls(found, modalities)


def alone_with_strategies(request: StudyOptions) -> tuple[Condition, ...]:
    """The conditions that are asked for strategies besides, without a control."""
    rates = [rate for rate in request.p or () if rate > 0]
    named = [read_condition(one.spec, one.name) for one in request.conditions_named]
    return (*(one for kind in _readings(request) for one in flips(rates, flip_of(kind))), *named)


def flips_of_readings(
    p: Sequence[float], kinds: Sequence[FlipKind], modalities: Sequence[str] | None = None
) -> tuple[Condition, ...]:
    """Every flip rate under every reading; the truth, which they share, comes once. Arguments as those of ``flips``."""
    rates = [rate for rate in p if rate > 0]
    others = [one for kind in kinds[1:] for one in flips(rates, kind, modalities)]
    return (*flips(p, kinds[0], modalities), *others)


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


def _check_looks(asked: StudyOptions, own: Sequence[NamedCondition], shown: str, plant: PlantSource) -> None:
    """Refuse what the study ``looks`` cannot have."""
    for what in ("p", "condition", "sweep", "flip"):
        if (given := getattr(asked, what)) is not None:
            raise BadValue(what, given, "none with looks, which has its own conditions")
    if not is_pictured(shown):
        raise BadValue("modality", shown, "pictures, rgb or rgbd, whose looks vary")
    if not plant.has_camera:
        raise BadValue("plant", plant.spec, "one whose camera takes pictures: fast-twin, twin, or manual with --camera")
    varied = {option for one in own for option in Spec.parse(one.spec).options}
    if named := [f"{name}={value}" for name, value in Spec.parse(plant.spec).options.items() if name in varied]:
        raise BadValue("plant", plant.spec, f"one without {', '.join(named)}, which this study varies")


def _check_why(asked: StudyOptions, p: Sequence[float], shown: str) -> None:
    """Refuse what the study ``why`` cannot have."""
    like = flip_of(asked.flip or DEFAULT)
    if len(p) > 1:
        raise BadValue("p", p, "one, which all arms have")
    if not 0 < p[0] <= 1:
        raise BadValue("p", p[0], "a rate above 0 and up to 1, at which the reports of all arms are hit")
    if asked.parts and like != OutcomeFlip():
        raise BadValue("flip", asked.flip, f"{DEFAULT} with --parts, whose parts they are")
    if spec_name(shown) != "symbolic":
        raise BadValue("modality", shown, "symbolic, with or without options: pictures cannot be corrected")
    if like.others == "noisy":
        raise BadValue("flip", "independent", "another kind: noise on all joints is no single statement to correct")


def _filled(own: NamedCondition, p: float, kind: FlipKind, plant: PlantSource) -> Condition:
    """A condition of a preset with the flip rate and what a false report is."""
    like, plain = flip_of(kind), OutcomeFlip()
    options = {name: getattr(like, name) for name in ("inverts", "others")}
    reading = "".join(f"&{name}={value}" for name, value in options.items() if value != getattr(plain, name))
    return read_condition(own.spec.format(p=f"{p:g}", reading=reading), own.name, plant.spec)


def _acting(said: NamedCondition, plant: PlantSource) -> Condition:
    """A condition that was asked for, if it does what it says.

    Raises:
        BadValue: If its dose is 0 although it has a name, or because none was given; or if it is called what another
            condition is.
    """
    asked = read_condition(said.spec, said.name, plant.spec)
    if asked.specs and asked.does_nothing:
        options = {option for part in split_specs(said.spec) for option in Spec.parse(part, "intervention").options}
        doses = [names[0] for _, names in asked.acting if names]
        if options.isdisjoint(doses):
            expected = f"one that does something; without {doses[0]}= it is the truth"
            raise BadValue("condition", said.spec, expected)
        if asked.name and asked.p is None:
            raise BadValue("condition", asked.spec, "one that does something; at dose 0 it is the truth")
    if not asked.specs and not asked.name and any(spec_name(part) == PLANT for part in split_specs(said.spec)):
        raise BadValue("condition", said.spec, "one that changes the plant; the plant of the study is so already")
    if asked.name == TRUTH and not asked.does_nothing:
        raise BadValue("condition", f"{TRUTH}={asked.spec}", "another name: truth is the control")
    if asked.name in shipped() and asked.specs and spec_name(asked.specs[0]) != asked.name:
        raise BadValue("condition", f"{asked.name}={asked.spec}", f"another name: {asked.name} is an intervention")
    if any(mark in asked.name for mark in "?+"):
        raise BadValue("condition", asked.name, "a name without ? and +, which are of specs")
    return asked


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


def _check_names(conditions: Iterable[Condition]) -> None:
    """Refuse one condition under two names, which would be compared as if it were two, and two under one name."""
    called, known = dict[tuple[object, ...], str](), dict[str, Condition]()
    for one in conditions:
        what = (() if one.does_nothing else one.specs, one.modality)
        if (first := called.setdefault(what, one.label)) != one.label:
            raise BadValue("condition", one.label, f"another condition than {first}, which is the same")
        if (other := known.setdefault(one.label, one)) is not one:
            raise BadValue("condition", f"{one.label}={one.spec}", f"another name: {one.label} is {other.spec}")
