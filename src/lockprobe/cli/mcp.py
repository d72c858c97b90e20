"""``lockprobe mcp``: agents with tools play a study over the Model Context Protocol."""

from __future__ import annotations

import asyncio
import logging
import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

from lockprobe.agents.catalogue import check_outside
from lockprobe.cli import options
from lockprobe.cli.study_options import with_study_options
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.spec import MCP
from lockprobe.foundation.terminal_text import printable
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.directory import extended, read_study
from lockprobe.studies.study import Study

_NAME = "The agent's name in the records: mcp:NAME. Use a different name for each model or program."
_OUT = options.with_brackets(
    options.OUT, "~/.local/share/lockprobe/STUDY-HASH; never in the working directory, where the agent could read"
)
_EACH = "Trials of each client (any number; else at most N each time that this command is started)."


@with_study_options(without=("agent", "boxes"))
def mcp(
    what: Annotated[str, typer.Argument(metavar="flips|modalities|why|looks|FILE.toml", help="The study.")],
    asked: Mapping[str, object],
    agent_name: Annotated[str, typer.Option(metavar="NAME", help=_NAME)] = "agent",
    out: Annotated[Path | None, typer.Option(metavar="DIR", help=_OUT)] = None,
    trials_each: Annotated[int | None, typer.Option(min=1, metavar="N", help=_EACH)] = None,
) -> None:
    """Let an agent with tools play a study: it calls observe and attempt over the Model Context Protocol.

    Every trial is an ordinary record of the agent mcp:NAME, with the same luck as for any other agent. The same command
    resumes the study; an unfinished trial continues at its step. lockprobe status and report read the directory.
    The client starts this command and talks to it over standard input and output.
    """
    agent = check_outside(f"{MCP}:{agent_name}", MCP)
    planned = study(what, **{**asked, "agent": [agent]})
    if planned.attended:
        raise BadValue("plant", planned.plant, "a plant that asks nothing at the terminal, which the client uses")
    data = Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share")
    directory = out or data / "lockprobe" / f"{planned.name}-{planned.identity}"
    working, place = Path.cwd().resolve(), directory.resolve()
    if working != Path("/") and (place.is_relative_to(working) or working.is_relative_to(place)):
        raise BadValue("out", str(directory), f"a directory outside of the working directory {working}")
    planned = extended(planned, directory)
    logging.basicConfig(stream=sys.stderr, level=logging.ERROR, format="lockprobe: %(message)s")
    before = os.umask(0o077)  # what is made from here on is for this user alone
    try:
        asyncio.run(_serve(planned, agent, directory, trials_each))
    finally:
        os.umask(before)


async def _serve(planned: Study, agent: str, directory: Path, trials_each: int | None) -> None:
    from lockprobe.interfaces.mcp import ToolSession, serve_stdio

    async with ToolSession.open(directory, planned, agent, trials_each=trials_each) as session:
        most = f"at most {planned.size}" if planned.until else f"{planned.size}"
        said = (
            f"{agent} plays {planned.name}: {session.owed} of {most} trials are owed; "
            f"hash of the settings {read_study(directory).settings_hash}"
        )
        print(printable(said), file=sys.stderr, flush=True)  # and not where the records lie: a client may read this
        await serve_stdio(session)
