"""The server over HTTP: a token on loopback, several clients, and requests that are refused before they are read."""

import asyncio
import json
import socket

import httpx
import pytest

pytest.importorskip("mcp")

from mcp import Client
from mcp.client.streamable_http import create_mcp_http_client, streamable_http_client
from mcp_wire import HELLO, served
from tool_player import SPEC, Player, plain_records

from lockprobe.interfaces.mcp.client_sessions import MOST_SESSIONS
from lockprobe.interfaces.mcp.http import LARGEST_BODY
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import load
from lockprobe.studies.running.runner import run_study

OPTIONS = ["--p", "0.3", "--trials", "3", "--repetitions", "1", "--max-steps", "12"]


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    directory = tmp_path_factory.mktemp("http")
    (directory / "project").mkdir()
    with served(directory / "S", directory / "project", OPTIONS) as found:
        yield directory / "S", *found


def player(url, headers, do, mode="auto"):
    async def run():
        async with (
            create_mcp_http_client(headers=headers) as http,
            Client(streamable_http_client(url, http_client=http), mode=mode) as client,
        ):

            async def call(tool, given):
                result = await client.call_tool(tool, given)
                return None if result.is_error else result.content[0].text

            return await do(Player(call))

    return asyncio.run(run())


@pytest.mark.parametrize("mode", ["auto", "legacy"])
def test_clients_one_after_another_play_a_study(tmp_path, mode):
    (tmp_path / "project").mkdir()
    out = tmp_path / "S"
    with served(out, tmp_path / "project", OPTIONS) as (url, headers):

        async def some(one):
            await one.begin()
            await one.step()

        player(url, headers, some, mode)
        assert player(url, headers, lambda one: one.play(), mode) == 3
    run_study(study("flips", agent=[SPEC], p=[0.3], trials=3, repetitions=1, max_steps=12), tmp_path / "alone")
    assert plain_records(out) == plain_records(tmp_path / "alone")
    assert [trial.facts["transport"] for trial in load(out)] == ["http"] * 3


def test_attempts_that_are_sent_at_once_are_one_step(tmp_path):
    (tmp_path / "project").mkdir()

    async def some(one):
        await one.begin()
        got = await asyncio.gather(*(one.call("attempt", {"joint": joint}) for joint in "ABCD"))
        assert len([text for text in got if text is not None]) == 1

    with served(tmp_path / "S", tmp_path / "project", OPTIONS) as (url, headers):
        player(url, headers, some)
    assert (tmp_path / "S" / "attempts.jsonl").read_text().count('"kind":"attempt"') == 1


def post(url, headers, body, **more):
    own = {"Accept": "application/json, text/event-stream", "Content-Type": "application/json"}
    content = body if isinstance(body, bytes) else json.dumps(body).encode()
    return httpx.post(url, headers={**own, **headers, **more}, content=content, timeout=30)


INITIALIZE = {"jsonrpc": "2.0", "id": 1, "method": "initialize", "params": HELLO}


def files(directory):
    return {path: path.read_bytes() for path in directory.iterdir()}


@pytest.mark.parametrize(
    "headers", [{}, {"Authorization": "Bearer"}, {"Authorization": "Bearer wrong"}, {"Authorization": "Basic eDp5"}]
)
def test_without_the_token_nothing_is_answered(server, headers):
    directory, url, _ = server
    before = files(directory)
    assert post(url, headers, INITIALIZE).status_code == 401
    assert httpx.get(url, headers=headers).status_code == 401
    assert files(directory) == before


def test_requests_that_are_hostile_change_no_file(server):
    directory, url, headers = server
    before = files(directory)
    attempt = {"jsonrpc": "2.0", "id": 2, "method": "tools/call"}
    attempt["params"] = {"name": "attempt", "arguments": {"joint": "A"}}
    for body, more, status in (
        (b"x" * (LARGEST_BODY + 1), {}, {413}),
        (b"rubbish", {}, {400}),
        (b"[" * 10_000, {}, {400}),
        (INITIALIZE, {"Host": "evil.example"}, {421}),
        (INITIALIZE, {"Origin": "https://evil.example"}, {403}),
        (INITIALIZE, {"Content-Type": "text/plain"}, {400, 415}),
        (attempt, {"Mcp-Session-Id": "0" * 32}, {404}),
        (attempt, {}, {400}),
        (attempt, {"Mcp-Protocol-Version": "2999-01-01"}, {400}),
    ):
        assert post(url, headers, body, **more).status_code in status
    assert httpx.get(url.replace("/mcp", "/study.json"), headers=headers).status_code == 404
    assert files(directory) == before
    assert post(url, headers, INITIALIZE).status_code == 200


def test_idle_connections_without_a_token_lock_nobody_out(server):
    _, url, headers = server
    place = ("127.0.0.1", httpx.URL(url).port)
    idle = [socket.create_connection(place) for _ in range(80)]
    half = [socket.create_connection(place) for _ in range(80)]
    try:
        for one in half:
            one.sendall(b"POST /mcp HTTP/1.1\r\nhost: 127.0.0.1\r\ncontent-length: 99\r\n\r\n{")
        assert post(url, headers, INITIALIZE).status_code == 200
        for one in half:  # refused without a token, and closed
            one.settimeout(10)
            answer = b""
            while part := one.recv(4096):
                answer += part
            assert answer.startswith(b"HTTP/1.1 401 ")
    finally:
        for one in (*idle, *half):
            one.close()


def test_clients_that_go_without_ending_their_session_lock_nobody_out(server):
    _, url, headers = server
    opened = [post(url, headers, INITIALIZE) for _ in range(MOST_SESSIONS + 6)]
    assert {answer.status_code for answer in opened} == {200}
    ask = {"jsonrpc": "2.0", "id": 2, "method": "tools/list"}
    sessions = [answer.headers["mcp-session-id"] for answer in opened]
    again = [post(url, headers, ask, **{"Mcp-Session-Id": one}).status_code for one in sessions]
    assert again == [404] * 6 + [200] * MOST_SESSIONS


def test_a_slash_at_the_end_of_the_address_changes_nothing(tmp_path):
    (tmp_path / "project").mkdir()
    with served(tmp_path / "S", tmp_path / "project", OPTIONS) as (url, headers):
        assert httpx.post(f"{url}/", json=INITIALIZE).status_code == 401
        assert player(f"{url}/", headers, lambda one: one.play(), "legacy") == 3
