"""``lockprobe mcp``: agents with tools play a study over the Model Context Protocol."""

from __future__ import annotations

import asyncio
import json as jsonlib
import logging
import os
import secrets
import sys
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Literal

import typer

from lockprobe.agents.mcp_client import client_spec
from lockprobe.cli import options
from lockprobe.cli.study_options import with_study_options
from lockprobe.foundation.errors import BadValue, Conflict, Missing
from lockprobe.foundation.terminal_text import printable
from lockprobe.interfaces.mcp.isolation import Isolation, check_isolation, client_of_stdio, named_client
from lockprobe.interfaces.mcp.session import SessionOptions, ToolSession
from lockprobe.studies.extension import extended
from lockprobe.studies.options.settings import read_study
from lockprobe.studies.options.study_options import StudyOptions, read_options_file
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.study import Study

__all__ = ["mcp", "records_directory"]

_NAME = "The agent's name in the records: mcp:NAME. Use a different name for each model or program."
_OUT = options.with_brackets(
    options.OUT, "~/.local/share/lockprobe/STUDY-HASH; never in the working directory, where the agent could read"
)
_TRANSPORT = "stdio: the client starts this command; http: clients connect to an address on this machine."
_ISOLATION = (
    "checked: refuse a client that could read the records; declared: you state that it cannot read them; "
    "none: it may be able to. Every record says which."
)
_USER = "The user, by name or number, that an HTTP client runs as; for --isolation checked."
_EACH = options.with_brackets(options.TRIALS_EACH, "any number; else at most N in one connection")

TransportOption = Annotated[Literal["stdio", "http"], typer.Option(help=_TRANSPORT)]
IsolationOption = Annotated[Isolation, typer.Option(help=_ISOLATION)]


@with_study_options(without=("agent",))
def mcp(
    what: Annotated[str, typer.Argument(metavar="flips|modalities|why|FILE.toml", help="The study.")],
    asked: Mapping[str, object],
    agent_name: Annotated[str, typer.Option(metavar="NAME", help=_NAME)] = "agent",
    out: Annotated[Path | None, typer.Option(metavar="DIR", help=_OUT)] = None,
    transport: TransportOption = "stdio",
    port: options.Port = 8766,
    isolation: IsolationOption = "checked",
    client_user: Annotated[str | None, typer.Option(metavar="USER", help=_USER)] = None,
    trials_each: Annotated[int | None, typer.Option(min=1, metavar="N", help=_EACH)] = None,
    json: options.AsJson = False,
) -> None:
    """Let an agent with tools play a study: it calls begin, attempt and observe over the Model Context Protocol.

    Every trial is an ordinary record of the agent mcp:NAME, with the same luck as for any other agent. The same command
    resumes the study; an unfinished trial continues at its step. lockprobe status and report read the directory.
    With --transport http, --json prints url, token and directory.
    """
    if find_spec("mcp") is None or find_spec("uvicorn") is None:
        raise Missing("lockprobe mcp needs the package mcp", "pip install 'lockprobe[mcp]'")
    if client_user is not None and transport == "stdio":
        raise Conflict("--client-user", "--transport stdio", "over stdio the client's user is known")
    agent = client_spec(agent_name)
    request = read_options_file(Path(what)) if what.endswith(".toml") else StudyOptions(study=what)
    planned = study(request, **{**asked, "agent": [agent]})
    if planned.attended:
        raise BadValue("plant", planned.plant, "a plant that asks nothing at the terminal, which the client uses")
    directory = out or records_directory(planned)
    over_http = None if client_user is None else named_client(client_user)
    client = client_of_stdio() if transport == "stdio" else over_http
    planned = extended(planned, directory)
    found = check_isolation(directory, isolation, client)
    token = _token() if transport == "http" else ""
    logging.basicConfig(stream=sys.stderr, level=logging.ERROR, format="lockprobe: %(message)s")
    given = SessionOptions(transport=transport, isolation=found, trials_each=trials_each)
    before = os.umask(0o077)  # what is made from here on is for this user alone
    try:
        asyncio.run(_serve(planned, agent, directory, given, port, token, json=json))
    finally:
        os.umask(before)


def records_directory(planned: Study) -> Path:
    """The default directory for the records of a study, outside any project."""
    data = Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share")
    return data / "lockprobe" / f"{planned.name}-{planned.identity}"


def _token() -> str:
    """The token of HTTP clients, from the environment or new.

    Raises:
        BadValue: If the token from the environment is too easy to guess.
    """
    from lockprobe.foundation.http_server.listening import check_token
    from lockprobe.interfaces.mcp.http import TOKEN

    if own := os.environ.get(TOKEN, ""):
        check_token(TOKEN, own)
    return own or secrets.token_urlsafe(24)


async def _serve(
    planned: Study, agent: str, directory: Path, given: SessionOptions, port: int, token: str, *, json: bool
) -> None:
    async with ToolSession.open(directory, planned, agent, given) as session:
        most = f"at most {planned.size}" if planned.until else f"{planned.size}"
        said = (
            f"{agent} plays {planned.name}: {session.owed} of {most} trials are owed; "
            f"hash of the settings {read_study(directory).settings_hash}"
        )
        print(printable(said), file=sys.stderr, flush=True)  # and not where the records lie: a client may read this
        if given.transport == "stdio":
            from lockprobe.interfaces.mcp.stdio import serve_stdio

            await serve_stdio(session)
            return
        from lockprobe.foundation.http_server.listening import listen
        from lockprobe.interfaces.mcp.http import HOST, serve_http

        with listen(HOST, port) as listening:
            await serve_http(session, listening, token, lambda url: _announce(url, token, directory, json=json))


def _announce(url: str, token: str, directory: Path, *, json: bool) -> None:
    from lockprobe.interfaces.mcp.http import TOKEN

    if json:
        print(jsonlib.dumps({"url": url, "token": token, "directory": str(directory)}), flush=True)
        return
    lines = (
        f"Address  {url}",
        f"Token    {f'that of {TOKEN}' if os.environ.get(TOKEN) else token}",
        f"Kept in  {directory}",
        "Ctrl-C stops; the same command resumes.",
    )
    print("\n".join(map(printable, lines)), flush=True)
