"""What there is: ``lockprobe agents``, ``plants``, ``models`` and ``doctor``."""

from __future__ import annotations

import json as json_
from typing import Annotated

import typer

from lockprobe.agents import weights
from lockprobe.agents.catalogue import known_specs
from lockprobe.cli.health import examine
from lockprobe.plants.catalogue import known_plants

__all__ = ["agents", "doctor", "list_models", "models", "plants", "pull"]

AsJson = Annotated[bool, typer.Option("--json", help="One JSON object a line.")]

models = typer.Typer(invoke_without_command=True)


def agents(json: AsJson = False) -> None:
    """The agents there are, by spec."""
    for spec, what in known_specs().items():
        print(json_.dumps({"spec": spec, "what": what}) if json else f"{spec:24}  {what}")


def plants(json: AsJson = False) -> None:
    """What can be acted on, by spec."""
    for spec, what in known_plants().items():
        print(json_.dumps({"spec": spec, "what": what}) if json else f"{spec:9}  {what}")


@models.callback()
def list_models(context: typer.Context, json: AsJson = False) -> None:
    """The language models that can play without a key, and which of them are here."""
    if context.invoked_subcommand is not None:
        return
    for model in weights.KNOWN.values():
        path = weights.find(model)
        if json:
            print(
                json_.dumps(
                    {
                        "name": model.name,
                        "spec": model.spec,
                        "here": path is not None,
                        "path": str(path) if path else None,
                        "megabytes": model.megabytes,
                        "sha256": model.sha256,
                        "quantisation": model.quantisation,
                    }
                )
            )
        else:
            where = str(path) if path else f"not here; lockprobe models pull {model.name}"
            print(f"{model.name}  {model.quantisation}, {model.megabytes} MB  {model.spec}\n  {where}")


@models.command("pull")
def pull(name: Annotated[str, typer.Argument(help="Name from `lockprobe models`.")]) -> None:
    """Fetch a model's file from its publisher, checked by its hash."""
    print(weights.pull(name))


def doctor(json: AsJson = False) -> None:
    """What works on this machine, and what to do about the rest."""
    for finding in examine():
        if json:
            print(json_.dumps({"what": finding.what, "ok": finding.ok, "detail": finding.detail}))
        else:
            print(f"{'ok     ' if finding.ok else 'missing'}  {finding.what}: {finding.detail}")
