"""A run whose replies cannot be used fails and says why; ``--again reply`` plays those trials anew."""

import json

import pytest
import typer
from provider_server import completion, truthful

from lockprobe import load
from lockprobe.cli.run import run
from lockprobe.cli.run_study import NO_VALID_TRIAL
from lockprobe.cli.status import status
from lockprobe.foundation.errors import BadValue

SPEC = "llm:openai-api/fake/model?repairs=0"
CELLS = [f"flips/llm:openai-api%2Ffake%2Fmodel?repairs=0/{one}" for one in ("truth", "flip?p=0.2")]


def nonsense(request):
    return completion('{"move": "A"}')


@pytest.fixture
def play(tmp_path, provider):
    """Plays four trials with the answers that are given."""
    _, answer = provider

    def played(answers, **more):
        answer(answers)
        run("flips", agent=[SPEC], p=["0,0.2"], trials=2, repetitions=1, out=tmp_path / "s", **more)

    return played


def failed(play, *given, **more):
    with pytest.raises(typer.Exit) as end:
        play(*given, **more)
    return end.value.exit_code == NO_VALID_TRIAL


def test_without_a_valid_trial_the_run_fails_and_the_same_command_says_so_again(tmp_path, play, capsys):
    expected = (
        f"No valid trial of {CELLS[0]} and 1 more condition: all 4 trials ended as an error, the first at reply: "
        "no usable reply in 1 turn: joint: Field required; the same command with --again reply plays them anew"
    )
    for _ in range(2):
        assert failed(play, nonsense)
        assert expected in capsys.readouterr().out.splitlines()
    status(tmp_path / "s")
    assert f"invalid     {expected}" in capsys.readouterr().out.splitlines()
    status(tmp_path / "s", json=True)
    assert json.loads(capsys.readouterr().out)["without_valid_trial"] == CELLS


def test_again_plays_them_anew_and_what_came_before_stays(tmp_path, play, capsys):
    assert failed(play, nonsense)
    before = (tmp_path / "s" / "trials.jsonl").read_bytes()
    play(truthful, again="reply")
    said = capsys.readouterr().out
    assert "Owed anew: 4 trials that ended as an error at reply; the earlier records stay" in said
    assert [(trial.ending, trial.replays) for trial in load(tmp_path / "s")] == [("solved", 1)] * 4
    assert (tmp_path / "s" / "trials.jsonl").read_bytes().startswith(before)
    status(tmp_path / "s", json=True)
    facts = json.loads(capsys.readouterr().out)
    assert (facts["done"], facts["owed"], facts["without_valid_trial"]) == (4, 0, [])
    assert facts["calls"] == 4 + sum(len(trial.steps) for trial in load(tmp_path / "s"))


def refusing(request):
    return completion(None, refusal="I cannot help with opening locks.")


def test_refusals_are_counted_as_such_and_played_anew_only_if_they_are_meant(tmp_path, play, capsys):
    assert failed(play, refusing)
    expected = "first at refusal: refused: I cannot help with opening locks."
    said = capsys.readouterr().out
    assert "the same command with --again refusal plays them anew" in said
    status(tmp_path / "s")
    told = capsys.readouterr().out
    assert "trials      4 of 4 done, 0 owed, 0 solved" in told
    assert "errors      4 errors: refusal 4" in told
    assert expected in told
    assert failed(play, truthful, again="reply")
    assert "Owed anew: 0 trials" in capsys.readouterr().out
    play(truthful, again="refusal")
    assert "Owed anew: 4 trials that ended as an error at refusal" in capsys.readouterr().out
    assert [(trial.ending, trial.replays) for trial in load(tmp_path / "s")] == [("solved", 1)] * 4


@pytest.mark.parametrize(("more", "line"), [({}, "again: got 'model'"), ({"estimate": True}, "no --estimate")])
def test_what_cannot_be_owed_anew_is_refused(tmp_path, play, more, line):
    with pytest.raises(BadValue, match=line):
        play(truthful, again="model", **more)
