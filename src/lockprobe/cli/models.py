"""``lockprobe models``: language models on this machine, and facts about others."""

from __future__ import annotations

import json as json_
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from textwrap import fill
from typing import Annotated

import typer

from lockprobe.agents import weights
from lockprobe.agents.llm.model_facts import facts_of
from lockprobe.agents.llm.settings import read_settings
from lockprobe.cli import options
from lockprobe.cli.headings import Headed
from lockprobe.cli.study_options import Name, with_study_options
from lockprobe.studies.options.study_options import StudyOptions, read_options_file
from lockprobe.studies.options.studyfile import study

__all__ = ["list_models", "models", "prompt", "pull", "show"]

_WIDTH = 118
"""Characters of a line."""

models = typer.Typer(invoke_without_command=True)


@models.callback()
def list_models(context: typer.Context, json: options.AsJson = False) -> None:
    """List the language models that can play without a key, and say which are installed."""
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
            where = str(path) if path else f"not installed; lockprobe models pull {model.name} downloads it"
            print(f"{model.name}  {model.quantisation}, {model.megabytes} MB  {model.spec}\n  {where}")


@models.command("pull")
def pull(name: Annotated[str, typer.Argument(help="Name from `lockprobe models`.")]) -> None:
    """Download a model's file from its publisher and check its hash."""
    print(weights.pull(name))


@models.command("show")
def show(
    spec: Annotated[str, typer.Argument(help="A spec as for --agent, for example llm:openai/o3?effort=low.")],
    json: options.AsJson = False,
) -> None:
    """Show the known facts of a hosted model and the options sent to it. This needs no key and makes no call."""
    name, settings = read_settings(spec)
    facts = facts_of(name)
    known = {what: value for what, value in asdict(facts).items() if what != "known"}
    if json:
        print(json_.dumps({"model": name, "known": facts.known, "facts": known, "sent": settings.sent(facts)}))
        return
    print(name if facts.known else f"{name}: no facts are known; requests are sent as below")
    for title, found in (("sent", settings.sent(facts)), ("known", known if facts.known else {})):
        for what, value in found.items():
            print(f"  {title:5}  {what:14}  {_in_words(value)}")


@models.command("prompt", cls=Headed)
@with_study_options(without=("agent",))
def prompt(what: Name, asked: Mapping[str, object], json: options.AsJson = False) -> None:
    """Show what hosted models read in each modality of a study, side by side; nothing is asked or played."""
    from lockprobe.studies.prompts import prompt_parts, side_by_side

    request = read_options_file(Path(what)) if what.endswith(".toml") else StudyOptions(study=what)
    for part, prompts in prompt_parts(study(request, **asked)).items():
        if json:
            print(json_.dumps({"part": part, "modalities": prompts}))
            continue
        print(f"{part}:")
        for passage in side_by_side(prompts):
            who = "all" if len(passage.modalities) == len(prompts) else ", ".join(passage.modalities)
            print(fill(f"{who}: {passage.text}", _WIDTH, initial_indent="  ", subsequent_indent="    "))


def _in_words(value: object) -> str:
    if isinstance(value, dict):  # the price
        return ", ".join(f"{name} {part}" for name, part in value.items() if part is not None)
    if isinstance(value, tuple):
        return ", ".join(value) or "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return "not known" if value is None else str(value)
