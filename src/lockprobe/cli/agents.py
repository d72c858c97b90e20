"""Who can act, on what, and what can be changed between them: ``lockprobe agents``, ``plants``, ``interventions``."""

from __future__ import annotations

import json as json_
from typing import Annotated

import typer

from lockprobe.agents.catalogue import known_specs
from lockprobe.options import options_of

__all__ = ["agents", "interventions", "plants"]

AsJson = Annotated[bool, typer.Option("--json", help="One JSON object a line.")]


def agents(json: AsJson = False) -> None:
    """The agents there are, by spec."""
    for spec, what in known_specs().items():
        print(json_.dumps({"spec": spec, "what": what}) if json else f"{spec:24}  {what}")


def plants(json: AsJson = False) -> None:
    """What can be acted on, by spec."""
    from lockprobe.plants.catalogue import known_plants

    for spec, what in known_plants().items():
        print(json_.dumps({"spec": spec, "what": what}) if json else f"{spec:9}  {what}")


def interventions(json: AsJson = False) -> None:
    """What can be changed, by place of the loop: told, asked, remembered, done."""
    from lockprobe.interventions.catalogue import PLACES, kinds, place_of

    found = [(place_of(kind), name, kind) for name, kind in kinds().items()]
    for place, name, kind in sorted(found, key=lambda one: list(PLACES).index(one[0])):
        dose = getattr(kind, "dose", "")
        options = [option.name + " (dose)" * (option.field == dose) for option in options_of(kind)]
        what = f"{(kind.__doc__ or '').splitlines()[0]} Options: {', '.join(options) or 'none'}."
        row = {"place": place, "spec": name, "dose": dose or None, "what": what}
        print(json_.dumps(row) if json else f"{place:11} {name:10}  {what}")
