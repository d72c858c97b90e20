"""The server as a client starts it: kills, hostile lines, and the SDK's own client."""

import asyncio
import json
import os
import random
import signal
import subprocess
import sys
import threading
import time

import pytest

pytest.importorskip("mcp")

import forked
from killed import KILLS
from mcp import Client
from mcp.client.stdio import StdioServerParameters
from mcp_wire import FIRST, Wire
from stored import contents
from tool_player import AGENT, SPEC, Player, plain_records

from lockprobe.interfaces.mcp.stdio import LONGEST_LINE, _lines
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.read_records import load
from lockprobe.studies.records.store import STORE, read
from lockprobe.studies.running.runner import run_study

STUDY = {"p": [0.0, 0.3], "trials": 3, "repetitions": 1, "max_steps": 12}
OPTIONS = ["--p", "0,0.3", "--trials", "3", "--repetitions", "1", "--max-steps", "12"]


def asked(directory):
    return ["flips", *OPTIONS, "--agent-name", "scripted", "--out", str(directory)]


def entries(directory):
    """The kinds of the entries about attempts."""
    with read(directory) as store:
        return [kind for (kind,) in store.rows("select entry ->> 'kind' from attempt order by id")]


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    directory = tmp_path_factory.mktemp("alone")
    run_study(study("flips", agent=[SPEC], **STUDY), directory)
    return plain_records(directory)


@pytest.fixture
def project(tmp_path):
    (tmp_path / "project").mkdir()
    return tmp_path / "project"


def test_killed_at_random_moments_nothing_is_lost_and_nothing_played_twice(tmp_path, project, alone):
    """Server and client are gone at once: the next client knows what ``observe`` says, and no more."""
    luck, out, kept, kills = random.Random(11), tmp_path / "S", [], 0
    while kills < KILLS:
        wire = Wire(*asked(out), cwd=project)
        threading.Timer(luck.uniform(0.0, 0.35), wire.process.kill).start()
        try:
            asyncio.run(Player(wire.call).play())
        except (EOFError, BrokenPipeError):
            kills += 1
        else:
            break
        finally:
            wire.go()
        now = entries(out) if (out / STORE).exists() else []
        assert now[: len(kept)] == kept
        kept = now
    wire = Wire(*asked(out), cwd=project)
    asyncio.run(Player(wire.call).play())
    assert wire.go() == 0
    assert plain_records(out) == alone
    assert entries(out).count("attempt") == sum(len(trial.steps) for trial in load(out))


HOSTILE = [
    b"",
    b"rubbish",
    b"[]",
    b"null",
    b"\xff\xfe",
    b"[" * 10_000,
    b'{"jsonrpc":"2.0"}',
    b'{"jsonrpc":"2.0","id":900,"method":"nothing"}',
    b'{"jsonrpc":"2.0","id":901,"method":"tools/call"}',
    b'{"jsonrpc":"2.0","id":902,"method":"tools/call","params":[]}',
    b'{"jsonrpc":"2.0","id":903,"method":"tools/call","params":{"name":"attempt","arguments":[]}}',
    b'{"jsonrpc":"2.0","id":904,"method":"tools/call","params":{"name":"attempt","arguments":{"joint":{}}}}',
    b'{"jsonrpc":"2.0","id":905,"method":"tools/call","params":{"name":"attempt","arguments":{"joint":"\\ud800"}}}',
    b'{"jsonrpc":"2.0","id":906,"method":"tools/call","params":{"name":"attempt","arguments":{"joint":"A","x":1}}}',
    b'{"jsonrpc":"2.0","id":907,"method":"tools/call","params":{"name":"begin","arguments":{"seed":1}}}',
    b'{"jsonrpc":"2.0","id":908,"method":"tools/call","params":{"name":"../study.json","arguments":{}}}',
    b'{"jsonrpc":"2.0","id":909,"method":"resources/read","params":{"uri":"file:///etc/passwd"}}',
    b'{"jsonrpc":"2.0","method":"notifications/cancelled","params":{"requestId":1}}',
    b'{"jsonrpc":"2.0","id":910,"method":"tools/call","params":{"name":"attempt","arguments":{"joint":"'
    + b"A" * 10**6
    + b'"}}}',
]


def test_hostile_lines_change_no_file_and_stop_no_server(tmp_path, project):
    out = tmp_path / "S"
    wire = Wire(*asked(out), cwd=project)
    player = Player(wire.call)
    asyncio.run(player.begin())
    asyncio.run(player.step())
    before = contents(out)
    for line in HOSTILE:
        wire.send(line)
    while (said := asyncio.run(wire.call("observe", {}))) is None:
        pass  # others are still being answered
    assert said.endswith(player.told[-1])
    assert contents(out) == before
    assert asyncio.run(player.step())
    assert wire.go() == 0


def test_attempts_that_are_sent_at_once_are_one_step(tmp_path, project):
    out = tmp_path / "S"
    wire = Wire(*asked(out), cwd=project)
    player = Player(wire.call)
    asyncio.run(player.begin())
    for _ in range(3):
        joint = player.joints[0]
        given = {"joint": joint, **({"last_action": "moved"} if player.chosen else {})}
        numbers = [wire.post("tools/call", {"name": "attempt", "arguments": given}) for _ in range(4)]
        got = {}
        while len(got) < len(numbers):
            found = json.loads(wire.process.stdout.readline())
            got[found["id"]] = found["result"]["isError"]
        assert sorted(got.values()) == [False, True, True, True]
        player.chosen.append(joint)
    assert entries(out).count("attempt") == 3
    assert wire.go() == 0


def test_a_client_that_goes_ends_the_server_and_leaves_its_trial_owed(tmp_path, project):
    out = tmp_path / "S"
    wire = Wire(*asked(out), cwd=project)
    player = Player(wire.call)
    asyncio.run(player.begin())
    asyncio.run(player.step())
    began = time.monotonic()
    assert wire.go() == 0
    assert time.monotonic() - began < 5
    assert load(out) == []
    wire = Wire(*asked(out), cwd=project)
    later = Player(wire.call)
    asyncio.run(later.begin())
    assert (later.told, later.chosen) == (player.told, player.chosen)
    assert wire.go() == 0


def test_the_own_client_of_the_sdk_plays_it(tmp_path, project, alone):
    """In a fresh interpreter, as a client starts it."""
    out = tmp_path / "S"
    command = StdioServerParameters(
        command=sys.executable, args=["-m", "lockprobe", "mcp", *asked(out)], cwd=project, env=dict(os.environ)
    )

    async def play():
        async with Client(command) as client:

            async def call(tool, given):
                result = await client.call_tool(tool, given)
                return None if result.is_error else result.content[0].text

            return await Player(call).play()

    assert asyncio.run(play()) == 6
    assert plain_records(out) == alone
    assert {trial.agent for trial in load(out)} == {AGENT}


def test_ctrl_c_ends_a_server_whose_client_is_silent(tmp_path, project):
    wire = Wire(*asked(tmp_path / "S"), cwd=project)
    player = Player(wire.call)
    asyncio.run(player.begin())
    wire.process.send_signal(signal.SIGINT)
    assert wire.process.wait(20) == 130
    wire.go()


@pytest.mark.parametrize("parts", [1, 3, 1000])
def test_messages_are_lines_however_they_arrive(parts):
    said = b"one\n\ntwo\n" + b"x" * (3 * LONGEST_LINE) + b"\nthree\n" + b"torn"

    async def read():
        reader = asyncio.StreamReader()
        size = len(said) // parts + 1
        for begin in range(0, len(said), size):
            reader.feed_data(said[begin : begin + size])
        reader.feed_eof()
        return [line async for line in _lines(reader)]

    assert asyncio.run(read()) == ["one", "", "two", "x" * LONGEST_LINE, "three"]


def test_standard_input_is_no_file(tmp_path, project):
    (tmp_path / "file").write_text("{}\n")
    with (tmp_path / "file").open() as file:
        done = forked.start(
            ["mcp", *asked(tmp_path / "S")], first=FIRST, stdin=file, stderr=subprocess.PIPE, cwd=project
        )
        assert done.wait(60) == 2
        assert "a pipe from the client" in done.stderr.read()
        done.stderr.close()
    assert not (tmp_path / "S").exists()
