"""``lockprobe doctor``: reports what works on this machine, or with a model."""

from __future__ import annotations

import asyncio
import importlib.metadata
import importlib.util
import json as json_
import os
import platform
from collections.abc import Callable, Iterator
from typing import Annotated, NamedTuple

import typer

from lockprobe.agents import local
from lockprobe.agents.catalogue import resolve
from lockprobe.cli import options
from lockprobe.foundation.errors import BadValue, UserMistake, advice
from lockprobe.foundation.plugins import robot_plugin


class Finding(NamedTuple):
    """One thing that works or does not.

    Attributes:
        what: The thing examined.
        ok: Whether it works.
        detail: Its version or path, or what to do.
    """

    what: str
    ok: bool
    detail: str


def examine() -> Iterator[Finding]:
    """Examine everything that a study may need."""
    yield Finding("python", ok=True, detail=f"{platform.python_version()}, {os.cpu_count()} cores")
    yield _found("runtime of local models", _runtime)
    yield _found("embedded model", lambda: f"{local.locate('llm:local').name}, hash as expected")
    yield _found("participants' page", lambda: _version("starlette", "pip install 'lockprobe[web]'"))
    yield _found("agents with tools", lambda: _version("mcp", "pip install 'lockprobe[mcp]'"))
    try:
        yield from robot_plugin("tool", "doctor", "physical boxes need").load()()
    except UserMistake as mistake:
        yield Finding("physical lockbox", ok=False, detail=str(mistake))


def _found(what: str, look: Callable[[], str]) -> Finding:
    try:
        return Finding(what, ok=True, detail=look())
    except UserMistake as mistake:
        return Finding(what, ok=False, detail=str(mistake))


def _runtime() -> str:
    version = _version("xllamacpp", "pip install 'lockprobe[local]'")
    local.runtime()  # it may not load
    return version


def _version(package: str, remedy: str) -> str:
    if importlib.util.find_spec(package) is None:
        raise UserMistake(advice(remedy))
    return f"{package} {importlib.metadata.version(package)}"


def _asked(model: str) -> Iterator[Finding]:
    if resolve(model).engine != "network":
        raise BadValue("model", model, "a model that is served, such as llm:openai/gpt-4o or llm:ollama/llama3.2")
    from lockprobe.agents.llm.probe import probe

    for what, ok, detail in asyncio.run(probe(model)):
        yield Finding(what, ok=ok, detail=detail)


def doctor(
    model: Annotated[str, typer.Argument(metavar="[MODEL]", help="A model, as for --agent: llm:openai/gpt-4o.")] = "",
    json: options.AsJson = False,
) -> None:
    """Check what works on this machine, and how to repair the rest; or ask a model once, and say what it shows."""
    for finding in _asked(model) if model else examine():
        if json:
            print(json_.dumps({"what": finding.what, "ok": finding.ok, "detail": finding.detail}))
        else:
            print(f"{'ok     ' if finding.ok else 'wrong  ' if model else 'missing'}  {finding.what}: {finding.detail}")
