"""What a condition changes of a study's plant, by the options that the plant says it has."""

from __future__ import annotations

from collections.abc import Mapping

from lockprobe.foundation.errors import UnknownName
from lockprobe.foundation.spec import Spec
from lockprobe.plants.catalogue import PlantSource, resolve_plant
from lockprobe.trial.plant_change import PlantChange


def plant_change(plant: str | PlantSource, asked: Mapping[str, str]) -> PlantChange:
    """The options that differ from those of a plant, each written in one way.

    >>> plant_change("twin", {"pose_error": "0.010", "looks": "plain"}).options
    {'pose_error': '0.01'}

    Args:
        plant: The study's plant, or its spec.
        asked: Option -> its value in the condition.

    Raises:
        UnknownName: If the plant has no such option.
        BadValue: If an option has a value that it cannot have.
    """
    if not asked:
        return PlantChange()
    own = plant if isinstance(plant, PlantSource) else resolve_plant(plant)
    spec = Spec.parse(own.spec, "plant")
    if own.options is None:  # a plant of another package, which does not say what it has
        known: Mapping[str, str] = spec.options
        there = dict(asked)
    else:
        known = own.options
        for option in asked:
            if option not in known:
                raise UnknownName(f"option of {spec.full_name}", option, known or ["none"])
        there = dict(resolve_plant(spec.adding(asked)).options or {})
    changed = {option: there[option] for option in sorted(asked) if there[option] != known.get(option)}
    return PlantChange(options=changed, own={option: float(known[option]) for option in changed if option in own.doses})
