"""``lockprobe run suite-1`` as it is typed."""

import json
from dataclasses import replace

import pytest
from provider_server import counted

from lockprobe.cli.run_study import BUDGET_REACHED
from lockprobe.studies.costs.budget import Budget
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.costs.spending import Ledger
from lockprobe.studies.options.settings import read_study
from lockprobe.studies.records.journal import load
from lockprobe.studies.suites import SUITES, suite_study
from lockprobe.trial.record import STATES


@pytest.fixture(autouse=True)
def small(monkeypatch, tmp_path):
    monkeypatch.setitem(SUITES, "suite-1", replace(SUITES["suite-1"], trials=2))
    monkeypatch.chdir(tmp_path)


def test_it_is_played_reported_added_to_and_verified(lockprobe, tmp_path):
    status, said, _ = lockprobe("run", "suite-1", "--agent", "random")
    assert status == 0
    lines = said.splitlines()
    assert lines[-1] == "Suite: lockprobe-runs/suite-1/suite.html"
    assert lines[-3].split()[:2] == ["agent", "competence"]
    assert "No report" not in said
    directory = tmp_path / "lockprobe-runs" / "suite-1"
    first = (directory / "suite.json").read_bytes()
    assert lockprobe("run", "suite-1")[0] == 0  # the same agents, nothing owed
    for command in ("measures", "branch"):  # which are of one study
        said = lockprobe(command, directory)[2]
        assert f"{directory}: a suite; its studies are {directory}/chain-4, {directory}/fork, " in said
    assert (directory / "suite.json").read_bytes() == first
    status, said, _ = lockprobe("run", "suite-1", "--agent", "human-inspired", "--json")
    last = json.loads(said.splitlines()[-1])
    assert (status, last["event"], last["page"]) == (0, "suite", "lockprobe-runs/suite-1/suite.html")
    assert sorted(one["agent"] for one in last["agents"]) == ["human-inspired", "random"]
    assert lockprobe("verify", directory)[0] == 0
    status, said, _ = lockprobe("status", directory, "--json")
    assert [json.loads(line)["trials"] for line in said.splitlines()] == [8] * 4
    assert lockprobe("status", directory)[1].count("study ") == 4
    assert lockprobe("report", directory)[1].splitlines()[-1] == f"Suite: {directory / 'suite.html'}"


def test_an_estimate_is_of_all_levels_together(lockprobe):
    status, said, _ = lockprobe("run", "suite-1", "--agent", "llm:openai/gpt-4o-mini", "--estimate", "--json")
    (found,) = json.loads(said)["estimate"]
    assert (status, found["trials"]) == (0, SUITES["suite-1"].looks * 3 * 8)
    assert found["most"]["dollars"] > found["expected"]["dollars"] > 0
    assert lockprobe("run", "suite-1", "--agent", "random", "--estimate")[1].startswith("No cost: no agent")


@pytest.mark.parametrize(
    ("arguments", "refused"),
    [
        (
            ["--trials", "3"],
            "--trials cannot be combined with suite-1: a suite fixes everything except --agent, --until and",
        ),
        (["--box", "chain-5"], "--box cannot be combined with suite-1: a suite fixes everything except --agent"),
        (["--most", "9"], "most: got 9, expected --until with it"),
        (["--until", "±10", "--most", "0"], "most: got 0, expected a whole number from 1"),
        (["--until", "soon"], "until: got 'soon', expected decided"),
        (["--agent", "participant"], "people do not play suite-1"),
        (["--again", "reply"], "again: got 'reply', expected a suite that has been played before"),
    ],
)
def test_mistakes_are_one_line(lockprobe, tmp_path, arguments, refused):
    arguments = arguments if "--agent" in arguments else [*arguments, "--agent", "random"]
    status, _, said = lockprobe("run", "suite-1", *arguments)
    assert (status, len(said.splitlines())) == (2, 1)
    assert refused in said
    assert not (tmp_path / "lockprobe-runs").exists()


def test_a_suite_and_a_study_do_not_share_a_directory(lockprobe, tmp_path):
    assert lockprobe("run", "suite-1", "--agent", "random", "--out", "a", "--no-report")[0] == 0
    status, _, said = lockprobe("run", "flips", "--agent", "random", "--out", "a")
    assert (status, said.strip()) == (2, "lockprobe: a: it holds suite-1; flips needs another directory")
    lockprobe("run", "flips", "--agent", "random", "--p", "0", "--trials", "1", "--out", "b", "--no-report")
    status, _, said = lockprobe("run", "suite-1", "--agent", "random", "--out", "b")
    assert (status, "it holds a study" in said) == (2, True)
    status, _, said = lockprobe("report", "a", "--watch")
    assert (status, len(said.splitlines())) == (2, 1)


MODEL = "llm:openai-api/fake/model"


def test_a_budget_is_that_of_all_levels_together(lockprobe, provider, prices, monkeypatch, tmp_path):
    """Without pictures, which take seconds here and cost the same tokens at this provider."""
    server, answer = provider
    monkeypatch.setattr("lockprobe.studies.options.paper.MODALITIES", (STATES,))
    monkeypatch.setattr("lockprobe.studies.options.paper.ROBOT", "symbolic")
    monkeypatch.setitem(SUITES, "suite-1", replace(SUITES["suite-1"], looks=2))
    prices(10, 100)
    answer(counted)
    asked = ("run", "suite-1", "--agent", MODEL, "--connections", 1)

    def cost(out):
        there = [tmp_path / out / f"{name}-pictures" for name in SUITES["suite-1"].boxes]
        found = [Ledger(read_study(one), read_calls(one)).total for one in there if one.exists()]
        return sum(one.dollars or 0.0 for one in found)

    assert lockprobe(*asked, "--out", "a")[0] == 0
    levels = {name: len(load(tmp_path / "a" / f"{name}-pictures")) for name in SUITES["suite-1"].boxes}
    assert set(levels.values()) == {4}
    whole = cost("a")
    first = suite_study(SUITES["suite-1"], "fork-pictures", [MODEL])
    allowed = round(0.5 * whole + Budget(first, 1.0).least[0], 4)
    before = server.account()["replied"]
    status, said, _ = lockprobe(*asked, "--out", "b", "--budget", allowed)
    assert status == BUDGET_REACHED
    assert 0.3 * whole < cost("b") <= allowed
    assert said.count("Budget reached: ") == 1
    done = sum(len(load(path.parent)) for path in (tmp_path / "b").glob("*/trials.jsonl"))
    assert 4 < done < 16
    assert said.splitlines()[-2] == "Suite: b/suite.html"
    ended = said.splitlines()[-1]
    assert ended.startswith("Not finished: ")
    assert ended.endswith("-pictures (the budget), as said above; the same command goes on")
    status, said, _ = lockprobe(*asked, "--out", "b", "--budget", 500)
    assert (status, "16" in said.splitlines()[-2].split()) == (0, True)
    assert cost("b") == pytest.approx(whole)
    assert server.account()["replied"] == 2 * before  # no call was made twice


def test_it_stops_when_it_is_decided_and_says_so(lockprobe, tmp_path):
    asked = ("run", "suite-1", "--out", "a", "--no-report")
    assert lockprobe(*asked, "--until", "±40", "--most", 12, "--agent", "round-robin")[0] == 0
    studies = [read_study(tmp_path / "a" / name) for name in SUITES["suite-1"].boxes]
    assert {(str(one.until), one.trials, one.repetitions) for one in studies} == {("±40", 12, 1)}
    status, said, _ = lockprobe("run", "suite-1", "--out", "a")
    assert (status, said.count("; 0 are owed")) == (0, 4)
    scores = json.loads((tmp_path / "a" / "suite.json").read_text())
    assert (scores["until"], scores["most"]) == ("±40", 12)
    page = (tmp_path / "a" / "suite.html").read_text()
    assert "stops when the effect of false reports is known to ±40 points, or after 12 trials of a kind" in page
    assert "Partial:" not in page
    assert lockprobe("verify", "a")[0] == 0
    for refused in (["--until", "decided"], ["--until", "±40", "--most", 13]):
        status, _, said = lockprobe(*asked, *refused)
        assert (status, len(said.splitlines())) == (2, 1)
        assert "a: it holds suite-1 until ±40 (at most 12 trials), not suite-1 until " in said
    records = tmp_path / "a" / "reset" / "trials.jsonl"
    records.write_bytes(b"".join(records.read_bytes().splitlines(keepends=True)[:-1]))
    assert lockprobe("report", "a")[0] == 0
    assert "of at most 96 trials of round-robin" in (tmp_path / "a" / "suite.html").read_text()
    assert lockprobe("run", "suite-1", "--out", "a", "--until", "±40", "--no-report")[0] == 0
    assert len(records.read_bytes().splitlines()) == len(load(records.parent))
