"""``lockprobe run`` as users meet it: what is said before the first trial, on the way and at the end, what is refused."""

import json
import os

import pytest
import typer
from provider_server import counted, failure, stubborn, truthful
from typed import typed

from lockprobe import load
from lockprobe.agents.llm.model_facts import read_facts
from lockprobe.cli.format_cost import money
from lockprobe.cli.progress import BROKE, BUDGET_REACHED
from lockprobe.cli.run import run
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.costs.spending import Ledger
from lockprobe.studies.records.directory import read_study


def test_pictures_are_played(tmp_path):
    pytest.importorskip("mujoco")
    arguments = ("run", "modalities", "--agent", "viewer", "--agent", "random", "--trials", 1, "--max-steps", 3,
                 "--plant", "fast-twin?width=160&height=120", "--workers", 1, "--no-report", "--out", tmp_path)  # fmt: skip
    done = typed(*arguments)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0] == (
        "Study modalities on chain-4: 3 conditions: rgb; rgbd; truth; 1 repetition of 1 trial of 3 steps; "
        "agents viewer, random; seed 1"
    )
    assert lines[1].startswith("Plant: fast-twin?width=160&height=120; pictures by egl (mujoco ")
    assert lines[2] == "Reports only, since they look at no pictures: random"
    assert any("viewer  3/3 trials · 0 of 3 solved" in line for line in lines)
    trials = load(tmp_path)
    assert [trial.error for trial in trials] == [None] * 4
    assert {trial.plant["renderer"] is None for trial in trials if trial.modality == "symbolic?tell=state"} == {True}
    assert {trial.plant["renderer"].split()[0] for trial in trials if trial.modality.startswith("rgb")} == {"egl"}
    assert len(trials) == read_study(tmp_path).size


SPEC = "llm:openai-api/fake/model"


@pytest.fixture
def provider(provider, prices):
    """A provider of known prices; it can be told to answer otherwise."""
    prices(100, 1000)
    return provider


CHATTY = """
from lockprobe import Decision

class Chatty:
    facts = {}

    async def decide(self, situation, rng):
        print("a thought")
        return Decision(joint="none of them")
"""


def play(out, **more):
    run("flips", **({"agent": [SPEC], "p": ["0"], "trials": 4, "repetitions": 1, "out": out} | more))


def events(capsys):
    return [json.loads(line) for line in capsys.readouterr().out.splitlines()]


def spent_in(directory):
    """US dollars, as the provider counts."""
    return Ledger(read_calls(directory)).total.dollars


@pytest.fixture
def honest(provider, prices):
    """A provider that counts tokens as providers do; a trial takes about six cents."""
    prices(10, 100)
    provider[1](counted)
    return provider


def test_a_budget_stops_a_study_cleanly_and_a_larger_one_goes_on(tmp_path, honest, capsys):
    server, _ = honest
    with pytest.raises(typer.Exit) as end:
        play(tmp_path / "s", budget=0.45, connections=10, trials=12)
    assert end.value.exit_code == BUDGET_REACHED
    said = capsys.readouterr().out
    assert "Budget: $0.45; it may not last: the study then stops, and goes on with a larger one" in said
    calls = list(read_calls(tmp_path / "s"))
    spent, done = spent_in(tmp_path / "s"), load(tmp_path / "s")
    assert 0 < spent < 0.45
    assert server.account()["replied"] == len(calls)
    assert 2 <= len(done) < 12
    assert {call.key for call in calls} >= {trial.key for trial in done}
    assert said.splitlines()[-1] == (
        f"Budget reached: {money(spent)} of $0.45 spent, too little is left for a call; {12 - len(done)} of 12 trials are "
        "owed; the same command with a larger --budget goes on"
    )
    play(tmp_path / "s", budget=50.0, trials=12)
    assert f"Budget: $50.00, of which {money(spent)} is spent" in capsys.readouterr().out
    assert [trial.ending for trial in load(tmp_path / "s")] == ["solved"] * 12
    replies = [call for call in read_calls(tmp_path / "s") if call.reply is not None]
    assert len(replies) == server.account()["replied"] == sum(len(trial.steps) for trial in load(tmp_path / "s"))


def test_machines_get_estimate_spending_and_the_end_of_the_budget_as_events(tmp_path, honest, capsys):
    with pytest.raises(typer.Exit):
        play(tmp_path / "s", budget=0.45, connections=1, trials=12, json=True)
    found = events(capsys)
    kinds = [event["event"] for event in found]
    assert kinds[:3] == ["begin", "estimate", "agent"]
    assert kinds[-2:] == ["report", "budget"]
    estimate, ended = found[1], found[-1]
    assert (estimate["budget"], estimate["spent"]) == (0.45, 0.0)
    assert estimate["agents"][0]["price"]["date"] == "2026-01-02"
    assert ended["budget"] == 0.45
    assert ended["spent"] == pytest.approx(spent_in(tmp_path / "s"))
    assert ended["spent"] + ended["needed"] > 0.45
    assert (ended["owed"], ended["trials"]) == (12 - len(load(tmp_path / "s")), 12)


def test_a_budget_that_ends_the_first_trial_leaves_no_report(tmp_path, honest, capsys):
    honest[1](lambda request: counted(request, 3, stubborn))
    with pytest.raises(typer.Exit) as end:
        play(tmp_path / "s", budget=0.36, connections=4, trials=6)
    said = capsys.readouterr().out.splitlines()
    assert end.value.exit_code == BUDGET_REACHED
    assert load(tmp_path / "s") == []
    assert len(list(read_calls(tmp_path / "s"))) > 0
    assert said[-2] == "No report: no trial has ended"
    assert "too little is left for a call; 6 of 6 trials are owed" in said[-1]


def test_a_budget_of_less_than_one_call_buys_nothing_and_leaves_nothing(tmp_path, honest, capsys):
    server, _ = honest
    with pytest.raises(typer.Exit) as end:
        play(tmp_path / "s", budget=0.001)
    assert end.value.exit_code == BUDGET_REACHED
    assert "Budget reached: $0.00 of $0.001 spent, too little is left for a call" in capsys.readouterr().out
    assert not (tmp_path / "s").exists()
    assert server.account()["arrived"] == 0


def test_a_run_of_which_every_trial_breaks_says_so_and_fails(tmp_path, provider, capsys):
    _, answer = provider
    answer(lambda request: failure(401, "no such\x1b[2Jkey"))
    with pytest.raises(typer.Exit) as end:
        play(tmp_path / "s", retries=0, trials=2)
    assert end.value.exit_code == BROKE
    said = capsys.readouterr().out
    assert "\x1b" not in said
    last = said.splitlines()[-1]
    assert last.startswith(
        f"2 of 2 trials broke and are owed, of {SPEC}; the first at model: the provider answered 401"
    )
    answer(truthful)
    play(tmp_path / "s", retries=0, trials=2)
    assert sum(not trial.owed_again for trial in load(tmp_path / "s")) == 2


@pytest.mark.parametrize(("status", "machine"), [(402, False), (429, True)])
def test_a_key_that_dies_in_mid_run_is_the_last_line_and_the_exit_status(tmp_path, provider, capsys, machine, status):
    server, answer = provider
    answer(lambda request: failure(status, "no more") if server.account()["arrived"] > 12 else truthful(request))
    with pytest.raises(typer.Exit) as end:
        play(tmp_path / "s", retries=0, connections=1, agent=["random", SPEC], json=machine)
    assert end.value.exit_code == BROKE
    last = capsys.readouterr().out.splitlines()[-1]
    assert [trial.owed_again for trial in load(tmp_path / "s")].count(True) == 3
    if machine:
        said = json.loads(last)
        assert (said["event"], said["trials"], said["ended"], said["agents"]) == ("broke", 3, 5, {SPEC: 3})
    else:
        assert last.startswith(
            f"3 of 8 trials broke and are owed, of {SPEC}; the first at model: the provider answered"
        )
        assert last.endswith("top up the account; the same command plays them again when that is mended")
    answer(truthful)
    play(tmp_path / "s", agent=["random", SPEC])
    assert not any(trial.owed_again for trial in load(tmp_path / "s"))


def test_an_estimate_alone_plays_nothing_and_writes_nothing(tmp_path, provider, capsys, monkeypatch):
    server, _ = provider
    monkeypatch.delenv("FAKE_API_KEY")
    play(tmp_path / "s", estimate=True)
    first, second = capsys.readouterr().out.splitlines()
    assert first.startswith(f"{SPEC}: about ")
    assert second.endswith("; prices of 2026-01-02")
    play(tmp_path / "s", estimate=True, json=True)
    assert events(capsys)[0]["estimate"][0]["high"]["calls"] == 80
    play(tmp_path / "s", estimate=True, agent=["random"])
    assert capsys.readouterr().out == "No cost: no trial that asks a provider is owed.\n"
    assert not (tmp_path / "s").exists()
    assert server.account()["arrived"] == 0


def test_a_model_without_a_price_comes_with_the_four_lines_that_give_it_one(tmp_path):
    name = 'vllm/Qwen/a"b?temperature=0'
    arguments = ("run", "flips", "--agent", f"llm:{name}", "--trials", 1, "--out", tmp_path / "s")
    refused = typed(*arguments, "--budget", 5)
    first, *lines = refused.stderr.splitlines()
    assert (refused.returncode, len(lines)) == (2, 4)
    assert first.endswith("LOCKPROBE_MODEL_FACTS=FILE.toml:")
    (tmp_path / "own.toml").write_text("\n".join(lines))
    (facts,) = read_facts(tmp_path / "own.toml")
    assert facts.match == (name.partition("?")[0],)
    assert facts.price.input > 0  # where nobody corrects it, the budget ends early
    estimated = typed(*arguments, "--estimate").stdout.splitlines()
    assert estimated[-4:] == lines
    own = {**os.environ, "LOCKPROBE_MODEL_FACTS": str(tmp_path / "own.toml")}
    assert "prices of" in typed(*arguments, "--estimate", env=own).stdout
    assert not (tmp_path / "s").exists()


def test_a_call_that_had_to_be_repeated_is_an_event(tmp_path, provider, capsys):
    _, answer = provider
    answer(lambda request: (answer(truthful), failure(500, "try again"))[1])
    play(tmp_path / "s", trials=1, json=True)
    repeated = [event for event in events(capsys) if event["event"] == "call"]
    assert [(event["step"], event["retries"], event["error"]) for event in repeated] == [(1, 1, None)]


def test_what_an_agent_prints_is_no_json_line(tmp_path, monkeypatch, capsys):
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "chatty.py").write_text(CHATTY)
    with pytest.raises(typer.Exit):
        play(tmp_path / "s", agent=["python:chatty:Chatty"], trials=1, json=True, report=False)
    printed = capsys.readouterr()
    assert {json.loads(line)["event"] for line in printed.out.splitlines()} >= {"begin", "trial"}
    assert printed.err.splitlines() == ["a thought"]


def test_people_are_invited_and_not_run(tmp_path):
    asked = "--box chain-4 --p 0,0.4 --trials 2 --repetitions 1 --max-steps 5 --no-report"
    arguments = ("run", "flips", *asked.split())
    mixed = typed(*arguments, "--agent", "participant", "--agent", "random", "--out", tmp_path / "mixed")
    assert mixed.returncode == 0, mixed.stderr
    invited = "People: 0 of 4 trials played; they are not run but invited, by lockprobe serve"
    assert f"{invited} {tmp_path / 'mixed'}" in mixed.stdout.splitlines()
    assert "random: 4 trials to play" in mixed.stdout
    assert {trial.agent for trial in load(tmp_path / "mixed")} == {"random"}
    alone = typed(*arguments, "--agent", "participant", "--out", tmp_path / "alone")
    assert alone.returncode == 0, alone.stderr
    assert alone.stdout.splitlines() == [f"{invited} {tmp_path / 'alone'}"]
    assert read_study(tmp_path / "alone").agents == ("participant",)
    again = typed(*arguments, "--agent", "participant", "--agent", "random", "--out", tmp_path / "mixed")
    assert "4 of 4 trials are done already; 0 are owed" in again.stdout
