"""Who can act, on what, what can be changed between them and measured: a list of each."""

from __future__ import annotations

import json as json_
from collections.abc import Mapping
from dataclasses import fields
from typing import Annotated

import typer

from lockprobe.plugins import Kind, listed_plugins

__all__ = ["agents", "interventions", "measures", "plants"]

AsJson = Annotated[bool, typer.Option("--json", help="One JSON object a line.")]


def agents(json: AsJson = False) -> None:
    """The agents there are, by spec."""
    from lockprobe.agents.catalogue import known_specs

    _list("agent", known_specs(), 24, json=json)


def plants(json: AsJson = False) -> None:
    """What can be acted on, by spec."""
    from lockprobe.plants.catalogue import known_plants

    _list("plant", known_plants(), 9, json=json)


def measures(json: AsJson = False) -> None:
    """What can be measured of a trial, by name."""
    from lockprobe.analysis.measures import MEASURES

    known = {name: (measure.__doc__ or "").strip().splitlines()[0] for name, measure in MEASURES.items()}
    _list("measure", known, 14, json=json)


def interventions(json: AsJson = False) -> None:
    """What can be changed, by place of the loop: told, asked, remembered, done."""
    from lockprobe.interventions.catalogue import PLACES, SHIPPED, packaged, place_of

    found = [(name, kind, "", "") for name, kind in SHIPPED.items()]
    found += [(row.name, row.found, row.package, row.what) for row in packaged()]
    rows: list[dict[str, object]] = []
    for name, kind, package, why in found:
        dose = getattr(kind, "dose", None)
        options = [field.name + " (dose)" * (field.name == dose) for field in fields(kind)] if kind else []
        first = (getattr(kind, "__doc__", None) or "").strip().partition("\n")[0]
        what = f"{first} Options: {', '.join(options) or 'none'}." if kind else why
        place = place_of(kind) if kind else None
        rows.append({"place": place, "spec": name, "dose": dose, "what": what} | _of(package))
    places = [*PLACES, None]
    for row in sorted(rows, key=lambda row: places.index(row["place"])):  # type: ignore[arg-type]
        _print_row(row, f"{row['place'] or '-':11} {row['spec']:10}", json=json)


def _list(kind: Kind, known: Mapping[str, str], width: int, *, json: bool) -> None:
    """What Lockprobe has itself, and what installed packages add."""
    rows: list[dict[str, object]] = [{"spec": spec, "what": what} for spec, what in known.items()]
    rows += [{"spec": row.name, "what": row.what} | _of(row.package) for row in listed_plugins(kind, known)]
    for row in rows:
        _print_row(row, f"{row['spec']:{width}}", json=json)


def _of(package: str) -> dict[str, object]:
    return {"package": package} if package else {}


def _print_row(row: Mapping[str, object], begin: str, *, json: bool) -> None:
    owner = f" ({row['package']})" if "package" in row else ""
    print(json_.dumps(row) if json else f"{begin}  {row['what']}{owner}")
