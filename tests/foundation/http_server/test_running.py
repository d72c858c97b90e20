"""A server that runs while a block does."""

import asyncio
import os
import signal

import httpx
import pytest

from lockprobe.foundation.http_server.connections import ConnectionLimits, Connections
from lockprobe.foundation.http_server.listening import listen
from lockprobe.foundation.http_server.running import running, stop_signals


async def hello(scope, receive, send):
    await asyncio.sleep(0.2)
    await send({"type": "http.response.start", "status": 200, "headers": []})
    await send({"type": "http.response.body", "body": b"hello"})


async def asked(app):
    with listen("127.0.0.1", 0) as listening:
        url = f"http://127.0.0.1:{listening.getsockname()[1]}/"
        connections = Connections(ConnectionLimits(), print)
        async with httpx.AsyncClient(trust_env=False) as http:
            async with running(app, listening, connections, seconds_to_finish=5):
                under_way = asyncio.create_task(http.get(url))
                await asyncio.sleep(0.1)
            return (await under_way).text


def test_what_is_under_way_at_the_end_is_answered():
    assert asyncio.run(asked(hello)) == "hello"


@pytest.mark.parametrize("name", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_stops_and_is_no_exception(name):
    async def wait():
        with stop_signals() as stopped:
            os.kill(os.getpid(), name)
            await asyncio.wait_for(stopped.wait(), 5)

    asyncio.run(wait())
