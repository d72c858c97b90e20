"""Connections that keep the server waiting: they are closed, capped, and lock nobody out."""

import asyncio
import os
import signal
import socket
import time
from contextlib import asynccontextmanager, suppress

import httpx
import pytest
from served import logged, served

from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.http_server import connections
from lockprobe.foundation.http_server.connections import (
    FILES_KEPT_BACK,
    ConnectionLimits,
    Connections,
    raise_file_limit,
)
from lockprobe.foundation.http_server.listening import is_loopback, listen
from lockprobe.foundation.http_server.running import running, stop_signals
from lockprobe.people.server_state import ServerState
from lockprobe.people.web.serving import ServerOptions


@asynccontextmanager
async def place(directory, **limits):
    door = ServerOptions(port=0, limits=ConnectionLimits(**limits))
    async with served(directory, door=door) as found:
        found.port = int(found.url.rstrip("/").rpartition(":")[2])
        found.writers = []
        try:
            yield found
        finally:
            for writer in found.writers:
                writer.close()
                with suppress(OSError):
                    await writer.wait_closed()


async def connected(there, local="127.0.0.1"):
    reader, writer = await asyncio.open_connection("127.0.0.1", there.port, local_addr=(local, 0))
    there.writers.append(writer)
    return reader, writer


async def ended(reader, within):
    """Whether the other end closes within so many seconds."""
    try:
        return await asyncio.wait_for(reader.read(1), within) == b""
    except ConnectionError:
        return True
    except TimeoutError:
        return False


async def head_of(reader):
    return (await asyncio.wait_for(reader.readuntil(b"\r\n\r\n"), 5)).split()[1]


def request(port, method="GET", path="/healthz", more=b""):
    return f"{method} {path} HTTP/1.1\r\nhost: 127.0.0.1:{port}\r\n".encode() + more + b"\r\n"


def opening(port):
    return request(port, "POST", "/api/open", b"content-type: application/json\r\ncontent-length: 2\r\n") + b"{}"


def idle(port, number):
    found = []
    for _ in range(number):
        one = socket.create_connection(("127.0.0.1", port))
        one.setblocking(False)
        found.append(one)
    return found


@pytest.mark.parametrize(
    "sent",
    [
        b"",
        b"GET / HTTP/1.1\r\nx: ",
        b"POST /api/open HTTP/1.1\r\nhost: {}\r\ncontent-type: application/json\r\ncontent-length: 99\r\n\r\n[",
    ],
    ids=["nothing", "half a head", "half a body"],
)
def test_hundreds_of_connections_that_wait_lock_nobody_out(tmp_path, capfd, sent):
    async def visit():
        async with place(tmp_path, most=50) as there:
            begun = time.perf_counter()
            waiting = []
            for _ in range(6):
                waiting += idle(there.port, 50)
                for one in waiting[-50:]:
                    one.send(sent.replace(b"{}", f"127.0.0.1:{there.port}".encode()))
                await asyncio.sleep(0.01)
                answer = await there.http.post("/api/open", json={})
                assert answer.status_code == 200
            gone = sum(not still_open(one) for one in waiting)
            for one in waiting:
                one.close()
            return gone, time.perf_counter() - begun

    gone, seconds = asyncio.run(visit())
    assert gone >= 250
    assert seconds < 9
    assert len(capfd.readouterr().err) < 15_000


def still_open(one):
    try:
        return one.recv(1) != b""
    except BlockingIOError:
        return True
    except ConnectionError:
        return False


def test_a_head_has_its_time_however_it_drips(tmp_path):
    async def visit():
        async with place(tmp_path, head=0.3, idle=5) as there:
            reader, writer = await connected(there)
            silent, _ = await connected(there)
            writer.write(request(there.port))
            assert await head_of(reader) == b"200"
            await reader.readexactly(2)
            writer.write(b"GET / HTTP/1.1\r\nx-slow: ")
            for _ in range(4):
                await asyncio.sleep(0.05)
                writer.write(b"a")
            return await ended(silent, 0.5), await ended(reader, 0.5)

    assert asyncio.run(visit()) == (True, True)


def slow_opening(monkeypatch):
    """Opening the page takes until the returned event is set."""
    quick, go_on = ServerState.enter, asyncio.Event()

    async def slow(*arguments):
        await go_on.wait()
        return await quick(*arguments)

    monkeypatch.setattr(ServerState, "enter", slow)
    return go_on


async def asked(there, local="127.0.0.1"):
    reader, writer = await connected(there, local)
    writer.write(opening(there.port))
    await asyncio.sleep(0.02)
    return reader


def test_where_all_are_being_answered_another_one_is_told_503(tmp_path, monkeypatch):
    async def visit():
        async with place(tmp_path, most=2, refused=0.2) as there:
            go_on = slow_opening(monkeypatch)
            first, second, third = [await asked(there) for _ in range(3)]
            assert await head_of(third) == b"503"
            assert b'"error": "full"' in await third.read()
            go_on.set()
            return await head_of(first), await head_of(second)

    assert asyncio.run(visit()) == (b"200", b"200")
    assert [line.split(maxsplit=1)[1] for line in logged(tmp_path)] == ["503 full no place for another connection"]


def test_one_address_cannot_take_the_places_of_others(tmp_path, monkeypatch):
    monkeypatch.setattr(connections, "is_loopback", lambda host: False)

    async def visit():
        async with place(tmp_path, each=2, refused=0.2) as there:
            go_on = slow_opening(monkeypatch)
            mine = [await asked(there, "127.0.0.2") for _ in range(3)]
            other = await asked(there, "127.0.0.3")
            assert await head_of(mine[2]) == b"503"
            go_on.set()
            return [await head_of(reader) for reader in (*mine[:2], other)]

    assert asyncio.run(visit()) == [b"200"] * 3


def test_what_is_under_way_at_the_end_is_answered_and_those_that_wait_are_not_waited_for():
    async def visit():
        asked = asyncio.Event()

        async def hello(scope, receive, send):
            asked.set()
            await asyncio.sleep(0.2)
            await send({"type": "http.response.start", "status": 200, "headers": []})
            await send({"type": "http.response.body", "body": b"hello"})

        with listen("127.0.0.1", 0) as listening:
            port = listening.getsockname()[1]
            taken = Connections(ConnectionLimits(most=400), print)
            async with httpx.AsyncClient(trust_env=False) as http:
                async with running(hello, listening, taken, seconds_to_finish=5):
                    waiting = idle(port, 100)
                    under_way = asyncio.create_task(http.get(f"http://127.0.0.1:{port}/"))
                    await asked.wait()
                for one in waiting:
                    one.close()
                return (await under_way).text

    begun = time.perf_counter()
    assert asyncio.run(visit()) == "hello"
    assert time.perf_counter() - begun < 9


@pytest.mark.parametrize("name", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_stops_and_is_no_exception(name):
    async def wait():
        with stop_signals() as stopped:
            os.kill(os.getpid(), name)
            await asyncio.wait_for(stopped.wait(), 5)

    asyncio.run(wait())


def test_a_port_in_use_and_a_foreign_host_are_said_and_loopback_is_known():
    with listen("127.0.0.1", 0) as first:
        port = first.getsockname()[1]
        with pytest.raises(BadValue, match=rf"port: got {port}.*in use"):
            listen("127.0.0.1", port)
    with pytest.raises(BadValue, match="a free port"):
        listen("192.0.2.1", 0)
    with pytest.raises(BadValue, match="host"):
        listen("no such host", 0)
    listen("localhost", 0).close()
    assert all(map(is_loopback, ("127.0.0.1", "127.8.8.8", "::1", "localhost")))
    assert not any(map(is_loopback, ("0.0.0.0", "::", "10.0.0.1", "example.org", "")))


def test_there_are_fewer_connections_than_files_and_as_many_of_these_as_the_system_lets():
    assert ConnectionLimits().within(None) == ConnectionLimits()
    assert ConnectionLimits().within(1024).most == 1024 - FILES_KEPT_BACK
    assert ConnectionLimits().within(100_000).most == ConnectionLimits().most
    assert 1 <= ConnectionLimits().within(64).most < 64
    resource = pytest.importorskip("resource")
    before = soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    try:
        resource.setrlimit(resource.RLIMIT_NOFILE, (min(soft, 512), hard))
        assert raise_file_limit() == min(hard, 65_536)
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, before)
