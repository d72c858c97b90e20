"""A run whose replies cannot be used says why, and its exit status whether trials are owed or none is valid."""

import pytest
import typer
from provider_server import completion, failure, truthful
from stored import records

from lockprobe import load
from lockprobe.cli.run import run
from lockprobe.cli.status import status

SPEC = "llm:openai-api/fake/model?repairs=0"


def nonsense(request):
    return completion('{"move": "A"}')


@pytest.fixture
def play(tmp_path, provider):
    """Plays four trials with the answers that are given."""
    _, answer = provider

    def played(answers, **more):
        answer(answers)
        try:
            run("flips", agent=[SPEC], p=["0,0.2"], trials=2, repetitions=1, out=tmp_path / "s", **more)
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
        ([refusing, truthful, refusing, truthful], 0),  # all under one condition
        ([refusing, refusing, nonsense, nonsense], 1),  # not one trial
        ([truthful, truthful, truthful, broken], 1),
        ([broken] * 4, 1),
    ],
)
def test_the_exit_status_says_whether_trials_are_owed_or_none_is_valid_and_not_which_ended_how(
    tmp_path, play, answers, status
):
    left = iter(answers)
    now = []

    def answer(request):
        if all(message["role"] != "assistant" for message in request["messages"]):
            now.append(next(left))
        return now[-1](request)

    found = play(answer, connections=1, retries=0, report=False)
    trials = load(tmp_path / "s")
    assert now == answers
    assert sorted(trial.error is not None for trial in trials) == sorted(one != truthful for one in answers)
    assert found == status
    assert status or not any(trial.owed_again for trial in trials)


@pytest.mark.parametrize(
    ("answer", "at", "why"),
    [
        (nonsense, "reply", "no usable reply in 1 turn: joint: Field required"),
        (refusing, "refusal", "refused: I cannot help with opening locks."),
    ],
)
def test_without_a_valid_trial_the_run_says_why_and_plays_none_of_them_again(tmp_path, play, capsys, answer, at, why):
    for _ in range(2):
        play(answer)
        expected = (
            f"No valid trial: all ended as an error, the first at {at}: {why}; when that is mended, another --out"
        )
        assert f"{expected} plays them anew" in capsys.readouterr().out.splitlines()
    assert len(records(tmp_path / "s")) == 4
    status(tmp_path / "s")
    told = capsys.readouterr().out
    assert "trials      4 of 4 done, 0 owed, 0 solved" in told
    assert f"errors      4 errors: {at} 4" in told
    assert f"first at {at}: {why}" in told
