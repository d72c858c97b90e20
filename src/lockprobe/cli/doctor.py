"""``lockprobe doctor``: reports what works on this machine, or with a model."""

from __future__ import annotations

import asyncio
import importlib.metadata
import importlib.util
import json as json_
import os
import platform
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

import typer

from lockprobe.agents import weights
from lockprobe.agents.catalogue import resolve
from lockprobe.cli import options
from lockprobe.foundation.errors import BadValue, UserMistake, advice
from lockprobe.foundation.plugins import robot_plugin


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
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
    yield Finding(what="python", ok=True, detail=f"{platform.python_version()}, {os.cpu_count()} cores")
    yield _runtime()
    yield _embedded()
    yield _package("starlette", "starlette", "participants' page", "pip install 'lockprobe[web]'")
    yield _package("mcp", "mcp", "agents with tools", "pip install 'lockprobe[mcp]'")
    yield from _physical()


def _runtime() -> Finding:
    what = "runtime of local models"
    if importlib.util.find_spec("xllamacpp") is None:
        return Finding(what=what, ok=False, detail=advice("pip install 'lockprobe[local]'"))
    try:
        import lockprobe.agents.engine  # noqa: F401
    except UserMistake as mistake:
        return Finding(what=what, ok=False, detail=str(mistake))
    return Finding(what=what, ok=True, detail=f"xllamacpp {importlib.metadata.version('xllamacpp')}")


def _physical() -> Iterator[Finding]:
    try:
        of_robot = robot_plugin("tool", "doctor", "physical boxes need").load()
        examined: Iterator[Finding] = of_robot()
    except UserMistake as mistake:
        yield Finding(what="physical lockbox", ok=False, detail=str(mistake))
        return
    yield from examined


def _embedded() -> Finding:
    try:
        path = weights.locate("llm:local")
    except UserMistake as mistake:
        return Finding(what="embedded model", ok=False, detail=str(mistake))
    return Finding(what="embedded model", ok=True, detail=f"{path.name}, hash as expected")


def _package(module: str, package: str, what: str, remedy: str) -> Finding:
    if importlib.util.find_spec(module) is None:
        return Finding(what=what, ok=False, detail=advice(remedy))
    return Finding(what=what, ok=True, detail=f"{package} {importlib.metadata.version(package)}")


def _asked(model: str) -> Iterator[Finding]:
    if resolve(model).engine != "network":
        raise BadValue("model", model, "a model that is served, such as llm:openai/gpt-4o or llm:ollama/llama3.2")
    from lockprobe.agents.llm.probe import probe

    for shown in asyncio.run(probe(model)):
        yield Finding(what=shown.what, ok=shown.ok, detail=shown.detail)


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
