"""A server answers what has come in time, also at its end, and whoever keeps it waiting locks nobody out."""

import asyncio
import os
import resource
import signal

import httpx2 as httpx
import pytest

from lockprobe.foundation import http_server
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.http_server import listen, running, stop_signals

REQUEST = b"GET / HTTP/1.1\r\nhost: x\r\n\r\n"


async def hello(scope, receive, send):
    await send({"type": "http.response.start", "status": 200, "headers": [(b"content-length", b"5")]})
    await send({"type": "http.response.body", "body": b"hello"})


@pytest.mark.parametrize("sent", [b"", b"GET / HTTP/1.1\r\nx: ", REQUEST + b"GET / HTTP/1.1\r\nx: "])
def test_hundreds_that_wait_or_drip_are_closed_in_time(monkeypatch, sent):
    monkeypatch.setattr(http_server, "SECONDS_FOR_A_HEAD", 0.5)
    monkeypatch.setattr(http_server, "_SECONDS_IDLE", 1)

    async def drip(writer):
        while not writer.is_closing():
            writer.write(sent and b"a")
            await asyncio.sleep(0.05)

    async def visit():
        with listen("127.0.0.1", 0) as listening:
            port = listening.getsockname()[1]
            async with running(hello, listening, print, seconds_to_finish=5):
                waiting = [await asyncio.open_connection("127.0.0.1", port) for _ in range(300)]
                for _, writer in waiting:
                    writer.write(sent)
                dripping = [asyncio.create_task(drip(writer)) for _, writer in waiting[:3]]
                # it comes to its end only when every one of them is closed
                await asyncio.gather(*(reader.read() for reader, _ in waiting), return_exceptions=True)
                for task in dripping:
                    task.cancel()
                for _, writer in waiting:
                    writer.close()

    asyncio.run(visit())


def test_files_are_kept_back_from_connections_and_those_that_are_there_go_on(monkeypatch):
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    files = 65_536 if hard == resource.RLIM_INFINITY else min(hard, 65_536)
    monkeypatch.setattr(http_server, "_FILES_KEPT_BACK", files - 20)

    async def visit():
        with listen("127.0.0.1", 0) as listening:
            port = listening.getsockname()[1]
            async with running(hello, listening, print, seconds_to_finish=5):
                opened = [await asyncio.open_connection("127.0.0.1", port) for _ in range(30)]
                await asyncio.gather(*(reader.read() for reader, _ in opened[20:]), return_exceptions=True)
                for reader, writer in opened[:20]:
                    writer.write(REQUEST)
                    assert (await reader.readline()).split()[1] == b"200"
                for _, writer in opened:
                    writer.close()

    asyncio.run(visit())


def test_what_is_under_way_at_the_end_is_answered_however_long_it_takes_and_those_that_wait_are_not_waited_for():
    async def visit():
        asked, go_on, loop = asyncio.Event(), asyncio.Event(), asyncio.get_running_loop()
        time = loop.time

        async def slowly(scope, receive, send):
            asked.set()
            await go_on.wait()
            await hello(scope, receive, send)

        with listen("127.0.0.1", 0) as listening:
            port = listening.getsockname()[1]
            async with httpx.AsyncClient(trust_env=False, timeout=None) as http:
                async with running(slowly, listening, print, seconds_to_finish=10**6):
                    under_way = asyncio.create_task(http.get(f"http://127.0.0.1:{port}/"))
                    await asked.wait()
                    loop.time = lambda: time() + 2 * http_server.SECONDS_FOR_A_HEAD
                    _, silent = await asyncio.open_connection("127.0.0.1", port)
                    loop.call_later(0.2, go_on.set)
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
    with pytest.raises(BadValue, match="a free port"):
        listen("192.0.2.1", 0)
    with pytest.raises(BadValue, match="host"):
        listen("no such host", 0)
    listen("localhost", 0).close()


def test_a_server_has_as_many_open_files_as_the_system_lets():
    async def files():
        with listen("127.0.0.1", 0) as listening:
            async with running(hello, listening, print, seconds_to_finish=1):
                return resource.getrlimit(resource.RLIMIT_NOFILE)[0]

    before = soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    try:
        resource.setrlimit(resource.RLIMIT_NOFILE, (min(soft, 512), hard))
        assert asyncio.run(files()) == min(hard, 65_536)
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, before)
