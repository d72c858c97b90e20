"""Conditions by spec: ``tremble?p=0.1 + rgb``, every value of a dose, every flip rate in every modality."""

from __future__ import annotations

import re
from collections.abc import Iterable
from itertools import chain, product
from math import prod
from typing import get_args

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.spec import Spec, spec_name, split_specs, with_options
from lockprobe.interventions.catalogue import interventions_of
from lockprobe.interventions.flip import DEFAULT, FlipKind, OutcomeFlip, flip_of
from lockprobe.plants.catalogue import plant_change, resolve_plant
from lockprobe.trial.condition import PLANT, Condition, Recorded
from lockprobe.trial.doses import MODALITY_DOSES, OF_PLAIN_FLIPS, modality_doses
from lockprobe.trial.protocols import Intervention
from lockprobe.trial.record import STATES

MODALITIES = ("symbolic", "rgb", "rgbd")
"""The modalities: the ways to show a box. Options follow a question mark."""

_MOST = 1000
"""The most combinations of doses in one sweep."""


def flip_alone(condition: Condition) -> OutcomeFlip | None:
    """The flip if nothing else acts (paper, Sec. 3.2), a flip at p = 0 for the truth, and otherwise None."""
    if not condition.specs:
        return OutcomeFlip()
    first = Spec.parse(condition.specs[0], "intervention")
    if len(condition.specs) > 1 or first.full_name != OutcomeFlip.name or not first.options.keys() <= OF_PLAIN_FLIPS:
        return None
    return with_options(OutcomeFlip, OutcomeFlip.name, first.options)


def interventions_in(condition: Condition) -> tuple[Intervention, ...]:
    """The interventions of a condition; those named in settings are constructed."""
    made = (interventions_of(one.spec) if isinstance(one, Recorded) else (one,) for one in condition.interventions)
    return tuple(chain.from_iterable(made))


def flips(
    p: Iterable[float], kind: FlipKind | OutcomeFlip = DEFAULT, modalities: Iterable[str] | None = None
) -> tuple[Condition, ...]:
    """The conditions of the paper's studies: every flip rate in every modality, modalities outermost.

    A flip at rate 0 is left out, which leaves the truth, unless it says what false pictures of a modality are
    (``rgb?p=0.4``). A false report is a word, or a flip whose rate does not count. Modalities are specs,
    :data:`lockprobe.trial.record.STATES` if none are given; under ``outcome-only`` they are blind.
    """
    like = kind if isinstance(kind, OutcomeFlip) else flip_of(kind)
    rates = list(p)
    shown = (STATES,) if modalities is None and kind != "outcome-only" else tuple(modalities or ("symbolic",))
    found = []
    for modality in map(blind, shown) if kind == "outcome-only" else shown:
        says_more = like.at_rate(0) != OutcomeFlip() and "p" in modality_doses(_without_zeros(modality))[1]
        for rate in rates:
            acting = (like.at_rate(rate),) if rate or says_more else ()
            found.append(Condition(interventions=acting, modality=modality))
    return tuple(found)


def blind(modality: str) -> str:
    """The modality without positions, for ``--flip outcome-only``; one that shows them in any case is refused."""
    spec = Spec.parse(modality, "modality")
    if spec.full_name != "symbolic" or spec.options.get("tell", "outcome") != "outcome":
        others = ", ".join(kind for kind in get_args(FlipKind) if kind != "outcome-only")
        raise BadValue("flip", "outcome-only", f"{others}, with {modality}, which shows positions")
    return modality if "tell" in spec.options else str(spec.adding({"tell": "outcome"}))


def tells_positions(modality: str) -> bool:
    """Whether a modality shows or tells positions, or only outcomes."""
    return Spec.parse(modality, "modality").options.get("tell") != "outcome"


def read_condition(spec: str, name: str = "", plant: str = "symbolic") -> Condition:
    """The condition that a spec describes; its last part may be a modality, and one may change the study's plant.

    >>> read_condition("plant?pose_error=0.01 + rgb", plant="twin").doses
    {'plant.pose_error': 0.01}
    """
    parts = split_specs(spec)
    modality = _without_zeros(parts.pop()) if says_modality(spec) else STATES
    changes = [Spec.parse(part, "condition").options for part in parts if spec_name(part) == PLANT]
    acting = " + ".join(part for part in parts if spec_name(part) != PLANT)
    asked = dict(chain.from_iterable(options.items() for options in changes))
    if not all(changes) or len(asked) < sum(map(len, changes)):
        raise BadValue("condition", spec, "each option of the plant once, for example plant?pose_error=0.01")
    return Condition(
        interventions=interventions_of(acting), modality=modality, name=name, plant=plant_change(plant, asked)
    )


def says_modality(spec: str) -> bool:
    """Whether the last part of a condition's spec says how the box is shown."""
    return spec_name(split_specs(spec)[-1]) in MODALITIES


def _without_zeros(modality: str) -> str:
    """A modality without doses of 0, so that equal modalities have equal names."""
    spec = Spec.parse(modality, "modality")
    return str(spec.without([dose for dose in MODALITY_DOSES if spec.options.get(dose) in ("0", "0.0")]))


def sweep(spec: str, plant: str = "symbolic") -> tuple[Condition, ...]:
    """One condition for every value of a dose (separated by commas), or for every combination of several doses.

    The doses may be of several interventions or of one. In combinations, interventions at dose 0 are left out, so that
    a combination is named after what acts in it.

    >>> [condition.spec for condition in sweep("flip?p=0,0.4 + tremble?p=0,0.1")]
    ['truth', 'tremble?p=0.1', 'flip?p=0.4', 'flip?p=0.4 + tremble?p=0.1']

    A dose of the plant alone may be written ``plant.pose_error=0,0.01``.
    """
    ways, doses = list[list[str]](), list[list[str]]()
    for text in split_specs(spec):
        part = Spec.parse(re.sub(rf"^{PLANT}\.(\w+)=", rf"{PLANT}?\1=", text), "sweep")
        swept = {option: value.split(",") for option, value in part.options.items() if "," in value}
        doses += swept.values()
        if (many := prod(map(len, doses))) > _MOST:
            raise BadValue("sweep", spec, f"at most {_MOST} combinations, not {many}")
        found = [dict(zip(swept, map(str.strip, values), strict=True)) for values in product(*swept.values())]
        ways.append([str(part.adding(values)) for values in found] if swept else [str(part)])
        if swept:
            _check_doses(spec, ways[-1][0], [*swept], plant)
    if not doses:
        raise BadValue("sweep", spec, "several values of a dose, separated by commas, for example tremble?p=0,0.1,0.2")
    conditions = []
    for parts in product(*ways):
        acting = [
            part
            for part, way in zip(parts, ways, strict=True)
            if 1 in (len(doses), len(way))
            or spec_name(part) in MODALITIES
            or not read_condition(part, plant=plant).does_nothing
        ]
        conditions.append(read_condition(" + ".join(acting), plant=plant))
    return distinct(conditions)


def _check_doses(spec: str, part: str, swept: list[str], plant: str) -> None:
    """Refuse options of a part of a sweep, with one value of each, that are no doses."""
    if spec_name(part) in MODALITIES:
        doses = list(MODALITY_DOSES)
    elif spec_name(part) == PLANT:
        plant_change(plant, Spec.parse(part).options)  # refuses an option that there is not
        doses = list(resolve_plant(plant).doses)
    else:
        doses = list(chain.from_iterable(names for _, names in read_condition(part).acting))
    if wrong := [option for option in swept if option not in doses]:
        known = ", ".join(doses) or "this has none"
        raise BadValue("sweep", spec, f"values of a dose ({known}), not of {', '.join(wrong)}")


def distinct(conditions: Iterable[Condition]) -> tuple[Condition, ...]:
    """The conditions without duplicates."""
    return tuple(dict.fromkeys(conditions))
