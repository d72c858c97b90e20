"""``lockprobe doctor``: reports what works on this machine, or with a model."""

from __future__ import annotations

import asyncio
import importlib.metadata
import importlib.util
import json as json_
import os
import platform
from collections.abc import Iterator
from typing import Annotated

import typer

from lockprobe.agents import local
from lockprobe.agents.catalogue import resolve
from lockprobe.cli import options
from lockprobe.foundation.errors import BadValue, UserMistake, advice
from lockprobe.foundation.plugins import robot_plugin

Finding = tuple[str, bool, str]
"""A thing, whether it works, and its version or path, or what to do."""

_PACKAGES = (
    ("runtime of local models", "xllamacpp", "pip install 'lockprobe[local]'"),
    ("participants' page", "starlette", "pip install 'lockprobe[web]'"),
    ("agents with tools", "mcp", "pip install 'lockprobe[mcp]'"),
)
"""What needs a package -> the package, and the command that installs it."""


def examine() -> Iterator[Finding]:
    """Examine everything that a study may need."""
    yield "python", True, f"{platform.python_version()}, {os.cpu_count()} cores"
    for what, package, remedy in _PACKAGES:
        there = importlib.util.find_spec(package) is not None
        detail = f"{package} {importlib.metadata.version(package)}" if there else advice(remedy)
        try:
            if there and package == "xllamacpp":
                local.runtime()  # it may not load
            yield what, there, detail
        except UserMistake as mistake:
            yield what, False, str(mistake)
    try:
        yield "embedded model", True, f"{local.locate('llm:local').name}, hash as expected"
    except UserMistake as mistake:
        yield "embedded model", False, str(mistake)
    try:
        yield from robot_plugin("tool", "doctor", "physical boxes need").load()()
    except UserMistake as mistake:
        yield "physical lockbox", False, str(mistake)


def doctor(
    model: Annotated[str, typer.Argument(metavar="[MODEL]", help="A model, as for --agent: llm:openai/gpt-4o.")] = "",
    json: options.AsJson = False,
) -> None:
    """Check what works on this machine, and how to repair the rest; or ask a model once, and say what it shows.

    Exit status 1: something is wrong with the model.
    """
    if model and resolve(model).engine != "network":
        raise BadValue("model", model, "a model that is served, such as llm:openai/gpt-4o or llm:ollama/llama3.2")
    if model:
        from lockprobe.agents.llm.probe import probe

        found = asyncio.run(probe(model))
    for what, ok, detail in found if model else examine():
        if json:
            print(json_.dumps({"what": what, "ok": ok, "detail": detail}))
        else:
            print(f"{'ok     ' if ok else 'wrong  ' if model else 'missing'}  {what}: {detail}")
    if model and not all(ok for _, ok, _ in found):
        raise typer.Exit(1)
