"""The participants' server, from its directory to Ctrl-C."""

from __future__ import annotations

import contextlib
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import replace
from pathlib import Path

from lockprobe.foundation.http_server import listen, running, stop_signals
from lockprobe.people.experiment import Experiment, Words
from lockprobe.people.server_state import ServerState
from lockprobe.people.web import app
from lockprobe.people.web.address import Address
from lockprobe.studies.study import Study

SECONDS_TO_FINISH = 10
"""Time for requests that are under way when the server stops."""


@asynccontextmanager
async def opened(
    directory: Path, study: Study, experiment: Experiment, words: Words, address: Address
) -> AsyncIterator[tuple[Address, ServerState]]:
    """A server that participants can use: its address and state. On exit it finishes the requests under way."""
    with contextlib.closing(listen(address.host, address.port)) as listening:
        address = replace(address, port=listening.getsockname()[1])
        async with ServerState.open(directory, study, experiment, words, page=app.page_version()) as state:
            site = app.application(state, words, address)
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
