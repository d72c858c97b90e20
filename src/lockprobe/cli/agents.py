"""Who can act, and on what: ``lockprobe agents`` and ``plants``."""

from __future__ import annotations

import json as json_
from typing import Annotated

import typer

from lockprobe.agents.catalogue import known_specs

__all__ = ["agents", "plants"]

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
