"""``lockprobe list``: what can be used, a line each: agents, plants, interventions, models, measures."""

from __future__ import annotations

import json as json_
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Annotated, Any

import typer

from lockprobe.cli import options
from lockprobe.cli.printing import print_rows
from lockprobe.foundation.errors import advice
from lockprobe.foundation.plugins import Listed, first_line, listed_plugins
from lockprobe.foundation.spec import options_of
from lockprobe.foundation.terminal_text import printable

_DIRECTORY = "The directory of a study; without it, the measures are listed."
_MEASURE = "Only this measure, or python:module:name; may be repeated."
_SPEC = "A model, as for --agent: llm:openai/o3?effort=low."

app = typer.Typer(no_args_is_help=True, rich_markup_mode=None)


@app.command()
def agents(json: options.AsJson = False) -> None:
    """List the agents by spec."""
    from lockprobe.agents.catalogue import KNOWN

    _list(KNOWN, listed_plugins("agent", KNOWN), json=json)


@app.command()
def plants(json: options.AsJson = False) -> None:
    """List the plants by spec: the boxes and robots that agents act on."""
    from lockprobe.plants.catalogue import known_plants

    known = known_plants()
    _list(known, listed_plugins("plant", known) + listed_plugins("plant source", known), json=json)


@app.command()
def interventions(json: options.AsJson = False) -> None:
    """List the interventions by their place in the loop: told, asked, remembered, done."""
    from lockprobe.interventions.conditions import checked, shipped
    from lockprobe.trial.condition import PLACES, place_of
    from lockprobe.trial.protocols import InterventionTraits

    packaged = listed_plugins("intervention", shipped(), checked)
    found: list[tuple[str, Any, dict[str, str]]] = [(name, kind, {}) for name, kind in shipped().items()]
    found += [(row.name, row.found, {"what": row.what, "package": row.package}) for row in packaged]
    places, rows = [*PLACES, None], list[dict[str, object]]()
    for name, kind, more in found:
        doses = list(InterventionTraits.of(kind).doses)
        if kind:
            taken = [option + " (dose)" * (one.name in doses) for option, one in options_of(kind).items()]
            more["what"] = f"{first_line(kind).replace('``', '')} Options: {', '.join(taken) or 'none'}."
        rows.append({"place": place_of(kind) if kind else None, "spec": name, "doses": doses, **more})
    _print(sorted(rows, key=lambda row: places.index(row["place"])), json=json)  # type: ignore[arg-type]


@app.command()
def measures(
    directory: Annotated[Path | None, typer.Argument(metavar="[DIR]", help=_DIRECTORY)] = None,
    measure: Annotated[list[str] | None, typer.Option(help=_MEASURE)] = None,
    json: options.AsJson = False,
) -> None:
    """List the measures of a trial, or print a study's means of them for every condition, with 95 % intervals.

    Without --measure these are all measures: those of Lockprobe and those of installed packages.
    """
    from lockprobe.foundation.plugins import plugin_names
    from lockprobe.statistics.measures import MEASURES, find_measure, measured

    if directory is None:
        known = {one.name: one.what for one in map(find_measure, measure or MEASURES)}
        _list(known, () if measure else listed_plugins("measure", known), json=json)
        return
    from lockprobe.studies.records.read_records import load

    cells = defaultdict(list)
    for trial in load(directory):
        cells[trial.group, trial.condition].append(trial)
    chosen = [find_measure(name) for name in measure or (*MEASURES, *plugin_names("measure"))]
    table = [("agent", "condition", "measure", "value", "95 % interval", "trials", "left out")]
    for (agent, condition), trials in cells.items():
        for row in (measured(trials, one) for one in chosen):
            if json:
                cell = {"agent": agent, "condition": condition, "doses": trials[0].doses}
                print(json_.dumps(cell | asdict(row)))
                continue
            value = "-" if row.value is None else f"{row.value:.3f}"
            interval = "-" if row.low is None or row.high is None else f"{row.low:.3f} to {row.high:.3f}"
            table.append((agent, condition, row.name, value, interval, str(row.n), str(row.left_out)))
    if not json:
        print_rows(table)


@app.command()
def models(
    spec: Annotated[str, typer.Argument(metavar="[SPEC]", help=_SPEC)] = "", json: options.AsJson = False
) -> None:
    """List the embedded model and the models of which facts ship; of one model what is known and what it is sent.

    This needs no key and makes no call.
    """
    from lockprobe.agents.llm.model_facts import SHIPPED, price_of, read_facts
    from lockprobe.agents.llm.settings import Model
    from lockprobe.agents.local import EMBEDDED, REMEDY, embedded

    if not spec:
        what = f"{EMBEDDED}, 98 MB, {embedded() or f'not installed: {advice(REMEDY)}'}"
        known = {"llm:local": what, "llm:gguf:PATH": "Any GGUF file, run by llama.cpp in this process."}
        for entry in read_facts(SHIPPED):
            price = price_of(entry.match[0])
            cost = f"{price.input:g} in, {price.output:g} out" if price else "not known"
            known[f"llm:{entry.match[0]}"] = f"US dollars per million tokens: {cost}."
        _list(known, (), json=json)
        return
    model = Model.parse(spec)
    facts = asdict(replace(model.facts, price=price_of(model.name)))
    if json:
        print(json_.dumps({"model": model.name, "facts": facts, "sent": model.sent()}))
        return
    print(model.name)
    for title, found in (("sent", model.sent()), ("known", facts)):
        for what, value in found.items():
            said = value if isinstance(value, str) else "not known" if value is None else json_.dumps(value)
            print(f"  {title:5}  {what:14}  {said}")


def _list(known: Mapping[str, str], added: Iterable[Listed], *, json: bool) -> None:
    """Print a line for each: Lockprobe's own specs with what they are, and what installed packages add."""
    rows: list[dict[str, object]] = [{"spec": spec, "what": what} for spec, what in known.items()]
    _print(rows + [{"spec": row.name, "what": row.what, "package": row.package} for row in added], json=json)


def _print(rows: Sequence[Mapping[str, object]], *, json: bool) -> None:
    wide = max(len(str(row["spec"])) for row in rows)
    for row in rows:
        place = f"{row['place'] or '-':11} " if "place" in row else ""
        owner = f" ({row['package']})" if "package" in row else ""
        print(json_.dumps(row) if json else printable(f"{place}{row['spec']:{wide}}  {row['what']}{owner}"))
