"""``lockprobe mcp`` from the command line: what is refused, where records lie, and what other commands say of them."""

import asyncio
import json
import re
import tomllib
from pathlib import Path

import pytest

pytest.importorskip("mcp")

from mcp_wire import Wire
from tool_player import Player

from lockprobe.cli.mcp import records_directory
from lockprobe.statistics.course import courses
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.read_records import load

SMALL = ["--p", "0", "--trials", "2", "--repetitions", "1", "--max-steps", "8"]
PAGE = (Path(__file__).parents[2] / "docs" / "mcp.md").read_text("utf-8")


@pytest.fixture
def project(tmp_path, monkeypatch):
    """The working directory of a client, and a home elsewhere."""
    (tmp_path / "project").mkdir()
    monkeypatch.chdir(tmp_path / "project")
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    return tmp_path


REFUSED = {
    "outside of the working directory": ["--out", "S"],
    "mcp:NAME with at most 64": ["--agent-name", "a b"],
    "a plant that asks nothing at the terminal": ["--plant", "manual"],
    "a client keeps its conversation itself": ["--condition", "history"],
    "No such option: --agent": ["--agent", "random"],
}


@pytest.mark.parametrize("why", REFUSED)
def test_a_mistake_is_one_line_and_makes_no_file(lockprobe, project, why):
    status, out, err = lockprobe("mcp", "flips", *REFUSED[why])
    assert (status, out) == (2, "")
    (line,) = err.splitlines()
    assert why in line
    assert [path for path in project.rglob("*") if path.is_file()] == []


def test_records_lie_with_the_user_s_data_by_default(project):
    planned = study("flips", agent=["mcp:agent"])
    assert records_directory(planned) == project / "data" / "lockprobe" / f"flips-{planned.identity}"


def test_the_other_commands_read_what_was_played(lockprobe, project):
    out = project / "S"
    wire = Wire("flips", *SMALL, "--out", str(out), cwd=project / "project")
    player = Player(wire.call)
    asyncio.run(player.play(1))
    asyncio.run(player.begin())
    assert wire.go() == 0
    assert out.stat().st_mode & 0o077 == 0
    assert "1 of 2 done, 1 owed" in lockprobe("status", out)[1]
    assert "holds  luck" in lockprobe("verify", out)[1]
    assert "mcp:agent" in lockprobe("export", out, "--format", "jsonl", "--out", "-")[1]
    status, _, err = lockprobe("branch", out)
    assert status == 2
    assert "clients and people cannot be asked" in err
    status, _, err = lockprobe("run", "flips", *SMALL, "--out", out)
    assert status == 2
    assert "lockprobe mcp" in err


def test_a_model_with_tools_is_never_pooled_with_the_model_that_chats(lockprobe, project):
    out = project / "S"
    assert lockprobe("run", "flips", *SMALL, "--agent", "random", "--out", out, "--no-report")[0] == 0
    wire = Wire("flips", *SMALL, "--agent-name", "random", "--out", str(out), cwd=project / "project")
    asyncio.run(Player(wire.call).play())
    assert wire.go() == 0
    trials = load(out)
    assert len({(trial.trial, trial.labels) for trial in trials}) == 2  # both share their luck
    found = {one.agent: len(one.ended) for one in courses(trials)}
    assert found == {"random": 2, "mcp:random": 2}


def test_the_configurations_of_the_page_start_the_server():
    (claude,), (codex,) = (
        re.findall(rf"^```{kind}\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE) for kind in ("json", "toml")
    )
    server = json.loads(claude)["mcpServers"]["lockprobe"]
    assert server == tomllib.loads(codex)["mcp_servers"]["lockprobe"]
    assert (server["command"], server["args"][:2]) == ("lockprobe", ["mcp", "flips"])
