"""``lockprobe agents``, ``plants`` and ``interventions``: lists what can be used."""

from __future__ import annotations

import json as json_
from collections.abc import Mapping

from lockprobe.cli import options
from lockprobe.foundation.plugins import Kind, listed_plugins
from lockprobe.foundation.spec import options_of

__all__ = ["agents", "interventions", "list_all", "plants"]


def agents(json: options.AsJson = False) -> None:
    """List the agents by spec."""
    from lockprobe.agents.catalogue import known_specs

    list_all("agent", known_specs(), 24, json=json)


def plants(json: options.AsJson = False) -> None:
    """List the plants by spec: the boxes and robots that agents act on."""
    from lockprobe.plants.catalogue import known_plants

    list_all("plant", known_plants(), 9, json=json)


def interventions(json: options.AsJson = False) -> None:
    """List the interventions by their place in the loop: told, asked, remembered, done."""
    from lockprobe.interventions.catalogue import packaged, shipped
    from lockprobe.trial.condition import PLACES, place_of
    from lockprobe.trial.protocols import InterventionTraits

    found = [(name, kind, "", "") for name, kind in shipped().items()]
    found += [(row.name, row.found, row.package, row.what) for row in packaged()]
    rows: list[dict[str, object]] = []
    for name, kind, package, why in found:
        doses = list(InterventionTraits.of(kind).doses)
        options = [one.name + " (dose)" * (one.field in doses) for one in options_of(kind)] if kind else []
        first = (getattr(kind, "__doc__", None) or "").strip().partition("\n")[0].replace("``", "")
        what = f"{first} Options: {', '.join(options) or 'none'}." if kind else why
        place = place_of(kind) if kind else None
        rows.append({"place": place, "spec": name, "doses": doses, "what": what} | _of(package))
    places = [*PLACES, None]
    for row in sorted(rows, key=lambda row: places.index(row["place"])):  # type: ignore[arg-type]
        _print_row(row, f"{row['place'] or '-':11} {row['spec']:10}", json=json)


def list_all(kind: Kind, known: Mapping[str, str], width: int, *, json: bool, packaged: bool = True) -> None:
    """Print one line for each agent, plant or intervention.

    ``known`` maps Lockprobe's own specs to descriptions; ``width`` is the width of the spec column. ``packaged`` adds
    what installed packages provide.
    """
    rows: list[dict[str, object]] = [{"spec": spec, "what": what} for spec, what in known.items()]
    if packaged:
        added = listed_plugins(kind, known) + (listed_plugins("plant source", known) if kind == "plant" else [])
        rows += [{"spec": row.name, "what": row.what} | _of(row.package) for row in added]
    for row in rows:
        _print_row(row, f"{row['spec']:{width}}", json=json)


def _of(package: str) -> dict[str, object]:
    return {"package": package} if package else {}


def _print_row(row: Mapping[str, object], begin: str, *, json: bool) -> None:
    owner = f" ({row['package']})" if "package" in row else ""
    print(json_.dumps(row) if json else f"{begin}  {row['what']}{owner}")
