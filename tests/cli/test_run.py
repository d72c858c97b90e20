"""``lockprobe run`` as users meet it: what is said before the first trial, on the way and at the end, what is refused."""

import json

import pytest
import typer
from provider_server import completion, counted, failure, truthful
from stored import records

from lockprobe import load
from lockprobe.agents.llm.model_facts import read_facts
from lockprobe.cli.format_cost import money
from lockprobe.cli.run import run
from lockprobe.cli.run_study import BROKE, BUDGET_REACHED
from lockprobe.cli.status import status
from lockprobe.foundation.errors import UserMistake
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.costs.spending import spent_by_agent, total
from lockprobe.studies.records.directory import read_study

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
    return total(spent_by_agent(read_calls(directory)).values()).dollars


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


def test_a_budget_of_less_than_one_call_buys_nothing_and_leaves_nothing(tmp_path, honest, capsys):
    server, _ = honest
    with pytest.raises(typer.Exit) as end:
        play(tmp_path / "s", budget=0.001)
    assert end.value.exit_code == BUDGET_REACHED
    assert "Budget reached: $0.00 of $0.001 spent, too little is left for a call" in capsys.readouterr().out
    assert not (tmp_path / "s").exists()
    assert server.account()["arrived"] == 0


@pytest.mark.parametrize(("status", "machine"), [(402, False), (429, True)])
def test_a_key_that_dies_in_mid_run_is_the_last_line_and_the_exit_status(tmp_path, provider, capsys, machine, status):
    server, answer = provider
    answer(lambda request: failure(status, "no\x1b[2J more") if server.account()["arrived"] > 12 else truthful(request))
    with pytest.raises(typer.Exit) as end:
        play(tmp_path / "s", retries=0, connections=1, agent=["random", SPEC], json=machine)
    assert end.value.exit_code == BROKE
    said = capsys.readouterr().out
    last = said.splitlines()[-1]
    assert "\x1b" not in said
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


def claiming(usage):
    """A provider that counts what it is told to."""

    def answer(request):
        status, content = counted(request)
        return status, content | {"usage": usage}

    return answer


def test_what_cannot_be_is_claimed_not_spent_and_the_run_stops(tmp_path, honest, capsys):
    honest[1](claiming({"prompt_tokens": 10**9, "completion_tokens": 20, "total_tokens": 10**9 + 20}))
    one = {"trials": 1, "connections": 1, "budget": 1.0}
    with pytest.raises(UserMistake, match="its provider claims 1,000,000,000 tokens in and 20 out for a call of at"):
        play(tmp_path / "s", **one)
    (call,) = read_calls(tmp_path / "s")
    assert (call.claimed.input_tokens, call.usage.input_tokens < 10_000) == (10**9, True)
    capsys.readouterr()
    status(tmp_path / "s")
    said = "\nclaimed     1 call: the provider claims an impossible usage; counted above"
    assert said in capsys.readouterr().out
    status(tmp_path / "s", json=True)
    (facts,) = events(capsys)
    assert (facts["claimed"], 0 < facts["dollars"] < 0.5) == (1, True)
    honest[1](counted)  # once its count is mended
    play(tmp_path / "s", **one)
    assert [trial.ending for trial in load(tmp_path / "s")] == ["solved"]


def nonsense(request):
    return completion('{"move": "A"}')


@pytest.fixture
def replied(tmp_path, provider):
    """Plays four trials with the answers that are given."""
    _, answer = provider

    def played(answers, **more):
        answer(answers)
        try:
            run("flips", agent=[f"{SPEC}?repairs=0"], p=["0,0.2"], trials=2, repetitions=1, out=tmp_path / "s", **more)
        except typer.Exit as end:
            return end.exit_code
        return 0

    return played


def refusing(request):
    return completion(None, refusal="I cannot help with opening locks.")


def broken(request):
    return failure(401, "no such key")


@pytest.mark.parametrize(
    ("answers", "status"),
    [
        ([refusing, nonsense, truthful, truthful], 0),
        ([refusing, refusing, nonsense, nonsense], 1),  # not one trial
        ([truthful, truthful, truthful, broken], 1),
    ],
)
def test_the_exit_status_says_whether_trials_are_owed_or_none_is_valid_and_not_which_ended_how(
    tmp_path, replied, answers, status
):
    left = iter(answers)
    now = []

    def answer(request):
        if all(message["role"] != "assistant" for message in request["messages"]):
            now.append(next(left))
        return now[-1](request)

    found = replied(answer, connections=1, retries=0, report=False)
    trials = load(tmp_path / "s")
    assert now == answers
    assert sorted(trial.error is not None for trial in trials) == sorted(one != truthful for one in answers)
    assert found == status
    assert status or not any(trial.owed_again for trial in trials)


def test_without_a_valid_trial_the_run_says_why_and_plays_none_of_them_again(tmp_path, replied, capsys):
    at, why = "refusal", "refused: I cannot help with opening locks."
    for broken_now in (4, 0):
        assert replied(refusing) == BROKE
        assert capsys.readouterr().out.count(f"  error at {at}: {why}") == broken_now
    assert len(records(tmp_path / "s")) == 4
    status(tmp_path / "s")
    told = capsys.readouterr().out
    assert "trials      4 of 4 done, 0 owed, 0 solved" in told
    assert f"errors      4 errors: {at} 4" in told
    assert f"first at {at}: {why}" in told


def test_an_estimate_alone_plays_nothing_and_writes_nothing(tmp_path, provider, capsys, monkeypatch):
    server, _ = provider
    monkeypatch.delenv("FAKE_API_KEY")
    play(tmp_path / "s", estimate=True)
    first, second = capsys.readouterr().out.splitlines()
    assert first.startswith(f"{SPEC}: 4 trials, about ")
    assert second.endswith("; prices of 2026-01-02")
    play(tmp_path / "s", estimate=True, json=True)
    assert events(capsys)[0]["estimate"][0]["high"]["calls"] == 80
    play(tmp_path / "s", estimate=True, agent=["random"])
    assert capsys.readouterr().out == "No cost: no trial that asks a provider is owed.\n"
    assert not (tmp_path / "s").exists()
    assert server.account()["arrived"] == 0


def test_a_model_without_a_price_comes_with_the_four_lines_that_give_it_one(tmp_path, lockprobe, monkeypatch):
    name = 'vllm/Qwen/a"b?temperature=0'
    arguments = ("run", "flips", "--agent", f"llm:{name}", "--trials", 1, "--out", tmp_path / "s")
    status, _, refused = lockprobe(*arguments, "--budget", 5)
    assert (status, refused.count("\n")) == (2, 1)
    assert refused.endswith("whose price is not known; --estimate prints what gives it one\n")
    *_, before, first, second, third, fourth = lockprobe(*arguments, "--estimate")[1].splitlines()
    lines = [first, second, third, fourth]
    assert before.endswith("(set it with LOCKPROBE_MODEL_FACTS=FILE.toml)")
    (tmp_path / "own.toml").write_text("\n".join(lines))
    (facts,) = read_facts(tmp_path / "own.toml")
    assert facts.match == (name.partition("?")[0],)
    assert facts.price.input > 0  # where nobody corrects it, the budget ends early
    monkeypatch.setenv("LOCKPROBE_MODEL_FACTS", str(tmp_path / "own.toml"))
    assert "prices of" in lockprobe(*arguments, "--estimate")[1]
    assert not (tmp_path / "s").exists()


def test_what_an_agent_prints_is_no_json_line(tmp_path, monkeypatch, capsys):
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "chatty.py").write_text(CHATTY)
    with pytest.raises(typer.Exit):
        play(tmp_path / "s", agent=["python:chatty:Chatty"], trials=1, json=True, report=False)
    printed = capsys.readouterr()
    assert {json.loads(line)["event"] for line in printed.out.splitlines()} >= {"begin", "trial"}
    assert printed.err.splitlines() == ["a thought"]


def test_people_are_invited_and_not_run(tmp_path, lockprobe):
    asked = "--agent participant --box chain-4 --p 0,0.4 --trials 2 --repetitions 1 --max-steps 5 --no-report --out"
    invited = "People: 0 of 4 trials played; they are not run but invited, by lockprobe serve"
    status, said, _ = lockprobe("run", "flips", *asked.split(), tmp_path / "s")
    assert (status, said.splitlines()) == (0, [f"{invited} {tmp_path / 's'}"])
    assert read_study(tmp_path / "s").agents == ("participant",)
    mixed = lockprobe("run", "flips", "--agent", "random", *asked.split(), tmp_path / "s")[1]
    assert f"{invited} {tmp_path / 's'}" in mixed.splitlines()
    assert "random: 4 trials to play" in mixed
    assert {trial.agent for trial in load(tmp_path / "s")} == {"random"}
