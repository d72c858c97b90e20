"""``lockprobe mcp`` as a client starts it: what is refused, kills, hostile lines, and what other commands say."""

import asyncio
import json
import os
import random
import signal
import subprocess
import threading
import time

import pytest

pytest.importorskip("mcp")

import forked
from stored import contents
from tool_player import SPEC, Player, plain_records

from lockprobe.interfaces.mcp import LONGEST_LINE
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.read_records import load
from lockprobe.studies.records.store import STORE, read
from lockprobe.studies.running.runner import run_study

KILLS = int(os.environ.get("LOCKPROBE_KILLS", "2"))

STUDY = {"p": [0.0, 0.3], "trials": 3, "repetitions": 1, "max_steps": 12}
OPTIONS = ["flips", "--p", "0,0.3", "--trials", "3", "--repetitions", "1", "--max-steps", "12"]

HELLO = {"protocolVersion": "2025-06-18", "capabilities": {}, "clientInfo": {"name": "wire", "version": "1"}}


class Wire:
    """A server in a process of its own, and the pipes to it: a client that can be malformed, in a hurry, or gone."""

    def __init__(self, *asked, cwd=None, hello=True):
        reads, writes = os.pipe()
        self.process = forked.start(
            ["mcp", *asked], stdin=reads, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, cwd=cwd
        )
        os.close(reads)
        self._to = os.fdopen(writes, "wb", buffering=0)
        self._number = 0
        if hello:
            self.ask("initialize", HELLO)
            self.send({"jsonrpc": "2.0", "method": "notifications/initialized"})

    def send(self, message):
        """Write one line: an object, or bytes as they are."""
        line = message if isinstance(message, bytes) else json.dumps(message).encode()
        self._to.write(line + b"\n")

    def ask(self, method, params):
        """Ask, and wait for the answer to this question."""
        self._number += 1
        self.send({"jsonrpc": "2.0", "id": self._number, "method": method, "params": params})
        return self.answer(self._number)

    def answer(self, number):
        """The answer to a question; EOFError if the server is gone."""
        while line := self.process.stdout.readline():
            found = json.loads(line)
            if found.get("id") == number:
                return found
        raise EOFError

    async def call(self, tool, given):
        """As :class:`tool_player.Player` calls a tool."""
        result = self.ask("tools/call", {"name": tool, "arguments": given})["result"]
        return None if result["isError"] else result["content"][0]["text"]

    def go(self):
        """Close the pipes, as a client that ends; the exit status of the server."""
        self._to.close()
        status = self.process.wait(60)
        self.process.stdout.close()
        return status


@pytest.fixture
def project(tmp_path, monkeypatch):
    """The working directory of a client, and a home elsewhere."""
    (tmp_path / "project").mkdir()
    monkeypatch.chdir(tmp_path / "project")
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    return tmp_path


def started(project):
    return Wire(*OPTIONS, "--agent-name", "scripted", "--out", str(project / "S"), cwd=project / "project")


def entries(directory):
    """The kinds of the entries about attempts."""
    with read(directory) as store:
        return [kind for (kind,) in store.rows("select kind from attempt order by id")]


def test_killed_at_random_moments_nothing_is_lost_and_nothing_played_twice(project):
    """Server and client are gone at once: the next client knows what ``observe`` says, and no more."""
    luck, out, kept, kills = random.Random(11), project / "S", [], 0
    while kills < KILLS:
        wire = started(project)
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
    wire = started(project)
    asyncio.run(Player(wire.call).play())
    assert wire.go() == 0
    run_study(study("flips", agent=[SPEC], **STUDY), project / "alone")
    assert plain_records(out) == plain_records(project / "alone")
    assert entries(out).count("attempt") == sum(len(trial.steps) for trial in load(out))


CALL = b'{"jsonrpc":"2.0","id":9,"method":"tools/call","params":'
HOSTILE = [
    *(b"", b"rubbish", b"[]", b"null", b"\xff\xfe", b"[" * 10_000, b'{"jsonrpc":"2.0"}'),
    b'{"jsonrpc":"2.0","id":9,"method":"resources/read","params":{"uri":"file:///etc/passwd"}}',
    b'{"jsonrpc":"2.0","method":"notifications/cancelled","params":{"requestId":1}}',
    CALL + b"[]}",
    CALL + b'{"name":"attempt","arguments":[]}}',
    CALL + b'{"name":"attempt","arguments":{"joint":{}}}}',
    CALL + b'{"name":"attempt","arguments":{"joint":"\\ud800"}}}',
    CALL + b'{"name":"../study.json","arguments":{}}}',
    CALL + b'{"name":"attempt","arguments":{"joint":"' + b"A" * (3 * LONGEST_LINE) + b'"}}}',
]


def test_hostile_lines_change_no_file_and_stop_no_server(project):
    wire = started(project)
    player = Player(wire.call)
    asyncio.run(player.begin())
    asyncio.run(player.step())
    before = contents(project / "S")
    for line in HOSTILE:
        wire.send(line)
    while (said := asyncio.run(wire.call("observe", {}))) is None:
        pass  # others are still being answered
    assert said.endswith(player.told[-1])
    assert contents(project / "S") == before
    assert (project / "S").stat().st_mode & 0o077 == 0  # for the user alone
    given = json.dumps({"joint": player.joints[0], "last_action": "moved"})  # as some models write it
    assert asyncio.run(wire.call("attempt", given)).startswith(f"You attempted {player.joints[0]}.")
    assert wire.go() == 0


def test_a_client_that_goes_ends_the_server_and_leaves_its_trial_owed(project):
    wire = started(project)
    player = Player(wire.call)
    asyncio.run(player.begin())
    asyncio.run(player.step())
    began = time.monotonic()
    assert wire.go() == 0
    assert time.monotonic() - began < 5
    assert load(project / "S") == []
    wire = started(project)
    later = Player(wire.call)
    asyncio.run(later.begin())
    assert (later.told, later.chosen) == (player.told, player.chosen)
    wire.process.send_signal(signal.SIGINT)  # while its client is silent
    assert wire.process.wait(20) == 130
    wire.go()
