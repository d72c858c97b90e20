"""Conditions by spec: ``tremble?p=0.1 + rgb``, every value of a dose, every flip rate in every modality."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from itertools import chain, product
from math import prod
from typing import get_args

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.spec import Spec, spec_name, split_specs
from lockprobe.interventions.catalogue import interventions_of
from lockprobe.interventions.flip import DEFAULT, FlipKind, OutcomeFlip, flip_of
from lockprobe.plants.catalogue import plant_change, resolve_plant
from lockprobe.trial.condition import Condition, Recorded
from lockprobe.trial.doses import MODALITY_DOSES, OF_PLAIN_FLIPS, modality_doses
from lockprobe.trial.plant_change import PLANT, PlantChange
from lockprobe.trial.protocols import Intervention
from lockprobe.trial.record import STATES

MODALITIES = ("symbolic", "rgb", "rgbd")
"""The modalities: the ways to show a box. Options follow a question mark."""

_PLANT_OPTION = re.compile(rf"^{PLANT}\.(\w+)=")
"""A sweep over one option of the plant, ``plant.pose_error=0,0.01``."""

_MOST = 1000
"""The most combinations of doses in one sweep."""


def flip_alone(condition: Condition) -> OutcomeFlip | None:
    """The flip if nothing else acts (paper, Sec. 3.2), a flip at p = 0 for the truth, and otherwise None."""
    return _flip_alone(condition.specs)


@cache
def _flip_alone(specs: tuple[str, ...]) -> OutcomeFlip | None:
    if not specs:
        return OutcomeFlip()
    first = Spec.parse(specs[0], "intervention")
    if len(specs) > 1 or first.full_name != OutcomeFlip.name or not first.options.keys() <= OF_PLAIN_FLIPS:
        return None
    (flip,) = interventions_of(specs[0])
    assert isinstance(flip, OutcomeFlip)
    return flip


def interventions_in(condition: Condition) -> tuple[Intervention, ...]:
    """The interventions of a condition; those named in settings are constructed.

    Raises:
        UserMistake: If there is no such intervention here, or settings name a class that no person has named.
    """
    return tuple(_made(one) for one in condition.interventions)


def _made(one: Intervention | Recorded) -> Intervention:
    if not isinstance(one, Recorded):
        return one
    (made,) = interventions_of(one.spec)
    return made


def flips(
    p: Iterable[float], kind: FlipKind | OutcomeFlip = DEFAULT, modalities: Iterable[str] | None = None
) -> tuple[Condition, ...]:
    """The conditions of the paper's studies: every flip rate in every modality, modalities outermost.

    A flip at rate 0 is left out, which leaves the truth, unless it says what false pictures of a modality are
    (``rgb?p=0.4``).

    Args:
        p: Flip probabilities, [0, 1].
        kind: What a false report is: a word, or a flip whose rate does not count.
        modalities: Specs; :data:`lockprobe.trial.record.STATES` if none are given. Under ``outcome-only`` they are
            blind.

    Raises:
        BadValue: If there is no such kind, or a modality cannot be blind.
    """
    like = kind if isinstance(kind, OutcomeFlip) else flip_of(kind)
    made = [like.at_rate(rate) for rate in p]
    shown = (STATES,) if modalities is None and kind != "outcome-only" else tuple(modalities or ("symbolic",))
    return tuple(
        Condition(interventions=() if flip.p == 0 and not _says_more(flip, modality) else (flip,), modality=modality)
        for modality in (map(blind, shown) if kind == "outcome-only" else shown)
        for flip in made
    )


def _says_more(flip: OutcomeFlip, modality: str) -> bool:
    """Whether a flip at rate 0 is more than the truth: false pictures are of its reading."""
    return flip.at_rate(0) != OutcomeFlip() and "p" in modality_doses(_without_zeros(modality))[1]


def blind(modality: str) -> str:
    """The modality without positions, for ``--flip outcome-only``.

    >>> blind("symbolic?form=json")
    'symbolic?form=json&tell=outcome'

    Raises:
        BadValue: If it shows positions in any case: a picture, or words that tell positions alone.
    """
    spec = Spec.parse(modality, "modality")
    if spec.full_name != "symbolic" or spec.options.get("tell", "outcome") != "outcome":
        others = ", ".join(kind for kind in get_args(FlipKind) if kind != "outcome-only")
        raise BadValue("flip", "outcome-only", f"{others}, with {modality}, which shows positions")
    return modality if "tell" in spec.options else str(spec.adding({"tell": "outcome"}))


def tells_positions(modality: str) -> bool:
    """Whether a modality shows or tells positions, or only outcomes.

    >>> tells_positions("symbolic"), tells_positions("rgb"), tells_positions("symbolic?tell=outcome")
    (True, True, False)
    """
    return Spec.parse(modality, "modality").options.get("tell") != "outcome"


def read_condition(spec: str, name: str = "", plant: str = "symbolic") -> Condition:
    """The condition that a spec describes; its last part may be a modality, and one may change the plant.

    >>> read_condition("tremble?p=0.1 + rgb").modality
    'rgb'
    >>> read_condition("plant?pose_error=0.01 + rgb", plant="twin").doses
    {'plant.pose_error': 0.01}

    Args:
        spec: The spec.
        name: The experimenter's name for it; empty for its spec.
        plant: Spec of the study's plant, whose options the part ``plant`` changes.

    Raises:
        UnknownName: As :func:`interventions_of`, or if the plant has no such option.
        BadValue: As :func:`interventions_of`, or as :class:`Condition`.
    """
    parts = split_specs(spec)
    modality = _without_zeros(parts.pop()) if says_modality(spec) else STATES
    changes = [part for part in parts if spec_name(part) == PLANT]
    acting = " + ".join(part for part in parts if part not in changes)
    return Condition(
        interventions=interventions_of(acting), modality=modality, name=name, plant=_changed(changes, plant, spec)
    )


def _changed(parts: Sequence[str], plant: str, spec: str) -> PlantChange:
    """What the parts of a condition change of a plant."""
    asked: dict[str, str] = {}
    for part in parts:
        options = Spec.parse(part, "condition").options
        if not options or options.keys() & asked.keys():
            raise BadValue("condition", spec, "each option of the plant once, for example plant?pose_error=0.01")
        asked |= options
    return plant_change(plant, asked)


def says_modality(spec: str) -> bool:
    """Whether the last part of a condition's spec says how the box is shown.

    >>> says_modality("warn + symbolic?tell=state"), says_modality("warn")
    (True, False)
    """
    return spec_name(split_specs(spec)[-1]) in MODALITIES


def _without_zeros(modality: str) -> str:
    """A modality without doses of 0, so that equal modalities have equal names."""
    spec = Spec.parse(modality, "modality")
    return str(spec.without([dose for dose in MODALITY_DOSES if spec.options.get(dose) in ("0", "0.0")]))


def sweep(spec: str, plant: str = "symbolic") -> tuple[Condition, ...]:
    """One condition for every value of a dose (separated by commas), or for every combination of several doses.

    The doses may be of several interventions or of one. In combinations, interventions at dose 0 are left out, so that
    a combination is named after what acts in it.

    >>> [condition.spec for condition in sweep("nudge?after=2 + tremble?p=0.1,0.2")]
    ['nudge + tremble?p=0.1', 'nudge + tremble?p=0.2']
    >>> [condition.spec for condition in sweep("flip?p=0,0.4 + tremble?p=0,0.1")]
    ['truth', 'tremble?p=0.1', 'flip?p=0.4', 'flip?p=0.4 + tremble?p=0.1']

    A dose of the plant alone may be written ``plant.pose_error=0,0.01``.

    Args:
        spec: The spec.
        plant: Spec of the study's plant.

    Raises:
        UnknownName: As :func:`read_condition`.
        BadValue: As :func:`read_condition`; also if no dose has several values, or if there are too many combinations.
    """
    parts = [_PLANT_OPTION.sub(rf"{PLANT}?\1=", part) for part in split_specs(spec)]
    swept = {at: found for at, part in enumerate(parts) if (found := _several(part))}
    if not swept:
        raise BadValue("sweep", spec, "several values of a dose, separated by commas, for example tremble?p=0,0.1,0.2")
    many = prod(len(values) for found in swept.values() for values in found.values())
    if many > _MOST:
        raise BadValue("sweep", spec, f"at most {_MOST} combinations, not {many}")
    several = {at: _dosed(spec, parts[at], found, plant) for at, found in swept.items()}
    conditions = []
    for chosen in product(*several.values()):
        doses = dict(zip(several, chosen, strict=True))
        acting = [doses.get(at, part) for at, part in enumerate(parts)]
        if len(several) > 1 or any(len(found) > 1 for found in swept.values()):
            acting = [part for at, part in enumerate(acting) if at not in several or not _idle(part, plant)]
        conditions.append(read_condition(" + ".join(acting), plant=plant))
    return distinct(conditions)


def _dosed(spec: str, part: str, swept: Mapping[str, Sequence[str]], plant: str) -> list[str]:
    """A part of a sweep, once for every value of its dose, or every combination of values of its doses."""
    chosen = [dict(zip(swept, values, strict=True)) for values in product(*swept.values())]
    found = [str(Spec.parse(part, "sweep").adding(values)) for values in chosen]
    if spec_name(part) in MODALITIES:
        doses = list(MODALITY_DOSES)
    elif spec_name(part) == PLANT:
        plant_change(plant, Spec.parse(found[0]).options)  # refuses an option that there is not
        doses = list(resolve_plant(plant).doses)
    else:
        doses = list(chain.from_iterable(names for _, names in read_condition(found[0]).acting))
    if wrong := [option for option in swept if option not in doses]:
        known = ", ".join(doses) or "this has none"
        raise BadValue("sweep", spec, f"values of a dose ({known}), not of {', '.join(wrong)}")
    return found


def _idle(part: str, plant: str) -> bool:
    """Whether a part is an intervention, or a change of the plant, that does nothing."""
    return spec_name(part) not in MODALITIES and read_condition(part, plant=plant).does_nothing


def _several(part: str) -> dict[str, list[str]]:
    options = Spec.parse(part, "sweep").options
    return {option: [one.strip() for one in value.split(",")] for option, value in options.items() if "," in value}


def distinct(conditions: Iterable[Condition]) -> tuple[Condition, ...]:
    """The conditions without duplicates."""
    return tuple(dict.fromkeys(conditions))
