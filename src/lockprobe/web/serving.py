"""The server as a whole: the doors open, participants come, and at Ctrl-C what is under way is finished."""

from __future__ import annotations

import asyncio
import contextlib
import secrets
import signal
import socket
from collections.abc import AsyncIterator, Callable, Coroutine, Iterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from math import ceil
from pathlib import Path

import uvicorn

from lockprobe.people.diary import PEOPLE_DIRECTORY
from lockprobe.people.experiment import Experiment
from lockprobe.people.server_state import ServerState
from lockprobe.people.texts import Words
from lockprobe.studies.study import Study
from lockprobe.web.address import QUEUE, Address, check_exposure, check_token, listen
from lockprobe.web.admin import AdminApi, AdminPage
from lockprobe.web.app import application
from lockprobe.web.connections import ConnectionLimits, Connections, raise_file_limit
from lockprobe.web.files import page_version
from lockprobe.web.log import ServerLog

__all__ = ["RunningServer", "ServerOptions", "opened", "serve"]

SECONDS_BETWEEN_CHECKS = 1.0
"""How often the server looks whether the records are as it left them."""

SECONDS_TO_FINISH = 10
"""For requests that are under way when the server is to end."""

_ACCEPTED_AT_ONCE = 64
"""Connections that are accepted before one of them is looked at: each is an open file."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ServerOptions:
    """How the server is reached.

    Attributes:
        host: What is listened on.
        port: The port; 0 for any that is free.
        public: Origin under which participants come through a proxy; empty where there is none.
        allowed: More names of this machine.
        token: Of the admin page; None has one made up.
        limits: How many connections there may be, and for how long.

    Raises:
        Missing: If other machines are let in, and it is not said how, or there is no token.
        BadValue: If the token could be guessed.
    """

    host: str = "127.0.0.1"
    port: int = 8765
    public: str = ""
    allowed: tuple[str, ...] = ()
    token: str | None = None
    limits: ConnectionLimits = field(default_factory=ConnectionLimits)

    def __post_init__(self) -> None:
        check_exposure(self.host, self.token, self.public, self.allowed)
        if self.token is not None:
            check_token(self.token)


@dataclass(frozen=True, slots=True, kw_only=True)
class RunningServer:
    """Where it is.

    Attributes:
        url: Where participants go.
        admin_url: Where the experimenter goes; with a token that was made up.
        directory: Of the study.
        check: Raises BadFile where somebody else has changed the records while they were being written.
    """

    url: str
    admin_url: str
    directory: Path
    check: Callable[[], None] = lambda: None


@asynccontextmanager
async def opened(
    directory: Path,
    study: Study,
    experiment: Experiment,
    words: Words,
    door: ServerOptions,
    desk: AdminPage | None = None,
) -> AsyncIterator[RunningServer]:
    """The server while participants can come; afterwards what is under way has been finished.

    Args:
        directory: Of the study.
        study: What is played.
        experiment: How people take part.
        words: What they read.
        door: How it is reached.
        desk: What the admin page gets besides.

    Raises:
        UserMistake: If the port cannot be had, or the directory not be used.
    """
    listening = listen(door.host, door.port)
    with contextlib.closing(listening):
        port = listening.getsockname()[1]
        address = Address(host=door.host, port=port, public=door.public, allowed=door.allowed)
        token = door.token or secrets.token_urlsafe(24)
        async with ServerState.open(directory, study, experiment, words, page=page_version()) as state:
            with ServerLog.open(directory / PEOPLE_DIRECTORY) as log, log.hears("uvicorn.error", "asyncio"):
                app = application(state, words, address, log, admin=AdminApi(state, token, address.url, desk))
                limits = door.limits.within(raise_file_limit())
                server = _Server(app, Connections(limits, log, proxied=bool(door.public)))
                async with _running(server, server.serve(sockets=[listening])):
                    listening.listen(QUEUE)
                    fragment = "" if door.token else f"#token={token}"
                    admin = f"{address.url}admin{fragment}"
                    state.invite()
                    yield RunningServer(url=address.url, admin_url=admin, directory=directory, check=state.check)


async def serve(
    directory: Path,
    study: Study,
    experiment: Experiment,
    words: Words,
    door: ServerOptions,
    *,
    announce: Callable[[RunningServer], None],
    desk: AdminPage | None = None,
) -> None:
    """The same until Ctrl-C or SIGTERM, or until somebody else changes the records.

    Args:
        directory: Of the study.
        study: What is played.
        experiment: How people take part.
        words: What they read.
        door: How it is reached.
        announce: Called as soon as participants can come.
        desk: What the admin page gets besides.

    Raises:
        UserMistake: As :func:`opened`.
    """
    ended = asyncio.Event()
    loop = asyncio.get_running_loop()
    async with opened(directory, study, experiment, words, door, desk) as where:
        for name in (signal.SIGINT, signal.SIGTERM):
            loop.add_signal_handler(name, ended.set)
        try:
            announce(where)
            while not ended.is_set():
                where.check()
                with contextlib.suppress(TimeoutError):
                    await asyncio.wait_for(ended.wait(), SECONDS_BETWEEN_CHECKS)
        finally:
            for name in (signal.SIGINT, signal.SIGTERM):
                loop.remove_signal_handler(name)


class _Server(uvicorn.Server):
    """Says when it is ready. Signals are heard by whoever runs it."""

    def __init__(self, app: object, connections: Connections) -> None:
        super().__init__(_config(app, connections))
        self.ready = asyncio.Event()
        self._connections = connections

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """From now on requests are answered."""
        await super().startup(sockets)
        self.ready.set()

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """What is under way is finished, and nobody else is let in."""
        self._connections.end()
        await super().shutdown(sockets)

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Nothing is captured."""
        yield


@asynccontextmanager
async def _running(server: _Server, work: Coroutine[None, None, None]) -> AsyncIterator[None]:
    task = asyncio.create_task(work)
    await server.ready.wait()
    try:
        yield
    finally:
        server.should_exit = True
        await task


def _config(app: object, connections: Connections) -> uvicorn.Config:
    return uvicorn.Config(
        app,  # type: ignore[arg-type] # an ASGI application
        http=connections.protocol,  # type: ignore[arg-type] # makes protocols, as the class does
        ws="none",
        lifespan="off",
        log_config=None,
        access_log=False,
        proxy_headers=False,
        server_header=False,
        date_header=False,
        timeout_keep_alive=ceil(connections.limits.idle),
        backlog=_ACCEPTED_AT_ONCE,
        timeout_graceful_shutdown=SECONDS_TO_FINISH,
    )
