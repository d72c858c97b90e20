"""Interventions and conditions by spec: ``flip?p=0.4``, ``tremble?p=0.1 + rgb``, every value of a dose.

Plus signs join interventions in the order in which they act. What ships is every class of this package with a ``name``.
An installed package adds to it by an entry point in the group ``lockprobe.interventions``, whose name is the spec's;
``python:module:Name?lag=1`` names a class directly, in Python or on the command line.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from contextlib import nullcontext
from dataclasses import is_dataclass
from functools import cache
from itertools import chain, product
from math import prod
from typing import Any, cast, get_args

from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.foundation.plugins import find_plugin, plugin_names
from lockprobe.foundation.spec import Spec, spec_name, split_specs, with_options
from lockprobe.interventions.flip import DEFAULT, FlipKind, OutcomeFlip, flip_of
from lockprobe.plants.catalogue import plant_change, resolve_plant
from lockprobe.trial.condition import PLANT, TRUTH, Condition, Recorded, place_of
from lockprobe.trial.doses import MODALITY_DOSES
from lockprobe.trial.protocols import Intervention, InterventionTraits
from lockprobe.trial.record import STATES

MODALITIES = ("symbolic", "rgb", "rgbd")
"""The modalities: the ways to show a box. Options follow a question mark."""

_MOST = 1000
"""The most combinations of doses in one sweep."""


@cache
def shipped() -> dict[str, type[Any]]:
    """The interventions of this package, by their names in specs.

    A variant, which an option chooses, has the option behind its name: ``flip?like``.
    """
    from lockprobe.interventions import asked_and_done, flip, told

    found: dict[str, type[Any]] = {}
    for module in (asked_and_done, flip, told):
        for kind in vars(module).values():
            own = isinstance(kind, type) and kind.__module__ == module.__name__
            if own and (traits := InterventionTraits.of(kind)).name:
                found[traits.name + f"?{traits.variant}" * bool(traits.variant)] = kind
    return dict(sorted(found.items()))


def shipped_as(spec: Spec) -> type[Any] | None:
    """The class of this package that a spec names, also by its option (``flip?like=rgb``); None if there is none."""
    name, found = spec.full_name, shipped()
    return next((kind for option in spec.options if (kind := found.get(f"{name}?{option}"))), found.get(name))


def interventions_of(spec: str) -> tuple[Intervention, ...]:
    """The interventions of a condition, in the order in which they act.

    Specs are joined by plus signs; ``truth`` or nothing is the empty condition.
    """
    if spec.strip() in ("", TRUTH):
        return ()
    found = list[Intervention]()
    for part in (Spec.parse(one, "intervention") for one in split_specs(spec)):
        name, kind, plugin = part.full_name, shipped_as(part), None
        if kind is None:
            if (plugin := find_plugin("intervention", str(part))) is None:
                raise UnknownName("intervention", name, [*shipped(), *plugin_names("intervention")])
            kind = checked(name, plugin.load())
        with plugin.guarded() if plugin else nullcontext():
            found.append(cast(Intervention, with_options(kind, name, part.options)))
    return tuple(found)


def checked(spec: str, kind: Any) -> type[Any]:
    """Check that a class of interventions follows the protocol of its place."""
    if not (isinstance(kind, type) and is_dataclass(kind) and getattr(kind, "__dataclass_params__").frozen):  # noqa: B009
        raise BadValue("intervention", spec, "a frozen dataclass")
    place_of(kind)
    return kind


def flip_alone(condition: Condition) -> OutcomeFlip | None:
    """The flip if nothing else acts (paper, Sec. 3.2), a flip at p = 0 for the truth, and otherwise None."""
    if condition.p is None:
        return None
    (flip,) = interventions_in(condition) or (OutcomeFlip(),)
    return cast(OutcomeFlip, flip)


def interventions_in(condition: Condition) -> tuple[Intervention, ...]:
    """The interventions of a condition; those named in settings are constructed."""
    made = (interventions_of(one.spec) if isinstance(one, Recorded) else (one,) for one in condition.interventions)
    return tuple(chain.from_iterable(made))


def flips(
    p: Iterable[float], kind: FlipKind | OutcomeFlip = DEFAULT, modalities: Iterable[str] | None = None
) -> tuple[Condition, ...]:
    """The conditions of the paper's studies: every flip rate in every modality, modalities outermost.

    A flip at rate 0 is left out, which is the truth. A false report is a word, or a flip whose rate does not count.
    Modalities are specs, :data:`lockprobe.trial.record.STATES` if there is none; under ``outcome-only`` they are blind.
    """
    like = kind if isinstance(kind, OutcomeFlip) else flip_of(kind)
    found = (STATES,) if modalities is None and kind != "outcome-only" else tuple(modalities or ("symbolic",))
    return tuple(
        Condition(interventions=(like.at_rate(rate),) if rate else (), modality=modality)
        for modality, rate in product(map(blind, found) if kind == "outcome-only" else found, p)
    )


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
    modality = STATES
    if says_modality(spec):  # without doses of 0, so that equal modalities have equal names
        said = Spec.parse(parts.pop(), "modality")
        modality = str(said.without([dose for dose in MODALITY_DOSES if said.options.get(dose) in ("0", "0.0")]))
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
        one, known = ways[-1][0], MODALITY_DOSES
        if spec_name(one) == PLANT:
            plant_change(plant, Spec.parse(one).options)  # refuses an option that there is not
            known = resolve_plant(plant).doses
        elif swept and spec_name(one) not in MODALITIES:
            known = tuple(name for _, names in read_condition(one).acting for name in names)
        if wrong := [option for option in swept if option not in known]:
            expected = f"values of a dose ({', '.join(known) or 'this has none'}), not of {', '.join(wrong)}"
            raise BadValue("sweep", spec, expected)
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
    return tuple(dict.fromkeys(conditions))
