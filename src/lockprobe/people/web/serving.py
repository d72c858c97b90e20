"""The participants' server, from its directory to Ctrl-C. It logs on standard error what is refused and what fails."""

from __future__ import annotations

import contextlib
import logging
import time
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager
from dataclasses import replace
from pathlib import Path

from lockprobe.foundation.http_server import listen, running, stop_signals
from lockprobe.foundation.terminal_text import printable
from lockprobe.people.experiment import Experiment, Words
from lockprobe.people.server_state import ServerState
from lockprobe.people.web import app
from lockprobe.people.web.address import Address
from lockprobe.studies.study import Study

SECONDS_TO_FINISH = 10
"""Time for requests that are under way when the server stops."""


class _Line(logging.Formatter):
    """One line with the time; of a library's error the first line without arguments, which could say who asked."""

    converter = staticmethod(time.gmtime)

    def format(self, record: logging.LogRecord) -> str:
        said = record.getMessage()
        if record.name != app.__name__:
            first, *_ = str(record.msg).splitlines() or [""]
            said = f"error {record.name} {first}"
        return f"{self.formatTime(record, '%Y-%m-%dT%H:%M:%SZ')} {printable(said)}"


@contextmanager
def _logged() -> Iterator[None]:
    """Errors of the application, uvicorn and asyncio are a line each, on standard error alone."""
    handler = logging.StreamHandler()
    handler.setLevel(logging.ERROR)
    handler.setFormatter(_Line())
    loggers = [logging.getLogger(name) for name in (app.__name__, "uvicorn.error", "asyncio")]
    for logger in loggers:
        logger.addHandler(handler)
        logger.propagate = False
    try:
        yield
    finally:
        for logger in loggers:
            logger.removeHandler(handler)
            logger.propagate = True


@asynccontextmanager
async def opened(
    directory: Path, study: Study, experiment: Experiment, words: Words, address: Address
) -> AsyncIterator[tuple[Address, ServerState]]:
    """A server that participants can use: its address and state. On exit it finishes the requests under way."""
    with contextlib.closing(listen(address.host, address.port)) as listening:
        address = replace(address, port=listening.getsockname()[1])
        async with ServerState.open(directory, study, experiment, words, page=app.page_version()) as state:
            site = app.application(state, words, address)
            with _logged():
                async with running(site, listening, seconds_to_finish=SECONDS_TO_FINISH):
                    yield address, state


async def serve(
    directory: Path,
    study: Study,
    experiment: Experiment,
    words: Words,
    address: Address,
    *,
    announce: Callable[[Address, ServerState], None],
) -> None:
    """Run the server of :func:`opened` until Ctrl-C or SIGTERM. Calls ``announce`` as soon as participants can come."""
    async with opened(directory, study, experiment, words, address) as (where, state):
        with stop_signals() as ended:
            announce(where, state)
            await ended.wait()
