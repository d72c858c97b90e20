"""A server answers what is under way, also at its end, stops at a signal, and says what it cannot listen to."""

import asyncio
import os
import signal

import httpx2 as httpx
import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.people.web.app import listen, running, stop_signals


def test_what_is_under_way_at_the_end_is_answered_and_those_that_wait_are_not_waited_for():
    async def visit():
        asked, go_on = asyncio.Event(), asyncio.Event()

        async def slowly(scope, receive, send):
            asked.set()
            await go_on.wait()
            await send({"type": "http.response.start", "status": 200, "headers": [(b"content-length", b"5")]})
            await send({"type": "http.response.body", "body": b"hello"})

        with listen("127.0.0.1", 0) as listening:
            port = listening.getsockname()[1]
            async with httpx.AsyncClient(trust_env=False, timeout=None) as http:
                async with running(slowly, listening, seconds_to_finish=10**6):
                    under_way = asyncio.create_task(http.get(f"http://127.0.0.1:{port}/"))
                    await asked.wait()
                    _, silent = await asyncio.open_connection("127.0.0.1", port)
                    asyncio.get_running_loop().call_later(0.2, go_on.set)
                silent.close()
                return (await under_way).text

    assert asyncio.run(visit()) == "hello"


@pytest.mark.parametrize("name", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_stops_and_is_no_exception(name):
    async def wait():
        with stop_signals() as stopped:
            os.kill(os.getpid(), name)
            await stopped.wait()

    asyncio.run(wait())


def test_a_port_in_use_and_a_foreign_host_are_said():
    with listen("127.0.0.1", 0) as first:
        port = first.getsockname()[1]
        with pytest.raises(BadValue, match=rf"port: got {port}.*in use"):
            listen("127.0.0.1", port)
    with pytest.raises(BadValue, match="host: got .*a name or IP address of this machine"):
        listen("192.0.2.1", 0)
    with pytest.raises(BadValue, match="host"):
        listen("no such host", 0)
