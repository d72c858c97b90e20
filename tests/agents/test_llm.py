"""Hosted models over HTTP: the same loop, runner and journal; faults are bounded and attributed."""

import os
import subprocess
import sys

import pytest
from openai_server import Server, completion, refusal, truthful

from lockprobe.errors import BadValue, Missing
from lockprobe.studies.journal import Journal, load
from lockprobe.studies.runner import Limits, run
from lockprobe.studies.studyfile import Request, study

llm = pytest.importorskip("lockprobe.agents.llm")
SPEC = "llm:openai-api/fake/model"


@pytest.fixture(autouse=True)
def no_keys(monkeypatch):
    for name in os.environ:
        if name.endswith(("_API_KEY", "_BASE_URL")):
            monkeypatch.delenv(name)


def played(tmp_path, monkeypatch, answer, spec=SPEC, **settings):
    """Trials of a small study against a server."""
    request = Request(agent=[spec], **({"p": [0, 0.4], "trials": 3, "repetitions": 1} | settings))
    with Server(answer).running() as server:
        for provider in ("FAKE", "OPENAI"):
            monkeypatch.setenv(f"{provider}_BASE_URL", server.url)
            monkeypatch.setenv(f"{provider}_API_KEY", "sk-private-0123456789")
        planned = study(request)
        with Journal.open(tmp_path, planned) as journal:
            run(planned, journal, limits=Limits(connections=4))
        return load(tmp_path), server


@pytest.mark.parametrize("spec", [SPEC, "llm:openai/gpt-4o"])
def test_a_study_over_http(tmp_path, monkeypatch, spec):
    trials, server = played(tmp_path, monkeypatch, truthful, spec)
    assert len(trials) == 6
    assert all(trial.solved for trial in trials)  # in turn: round-robin always solves chain-4
    assert sum(len(trial.steps) for trial in trials) == len(server.requests)
    assert all(trial.facts["model"] == spec.removeprefix("llm:") for trial in trials)
    for trial in trials:
        assert trial.steps[0].decision.claimed is None
        for before, step in zip(trial.steps, trial.steps[1:], strict=False):
            assert step.decision.claimed == ("moved" if before.told_moved else "blocked")
            assert step.decision.hypothesis == "in turn"
            assert (step.decision.usage.calls, step.decision.usage.input_tokens) == (1, 11)


def test_the_schema_is_sent_and_none_is_offered_in_the_first_step_only(tmp_path, monkeypatch):
    _, server = played(tmp_path, monkeypatch, truthful, trials=1, p=[0])
    for turn, request in enumerate(server.requests):
        schema = request["response_format"]["json_schema"]["schema"]
        expected = ["none"] if turn == 0 else ["moved", "did not move"]
        assert schema["properties"]["last_action"]["enum"] == expected
        assert sorted(schema["properties"]["joint"]["enum"]) == list("ABCD")
        assert schema["additionalProperties"] is False


def test_the_key_is_used_and_never_written(tmp_path, monkeypatch):
    _, server = played(tmp_path, monkeypatch, truthful, trials=1)
    assert set(server.keys) == {"Bearer sk-private-0123456789"}
    assert not any(b"private" in path.read_bytes() for path in tmp_path.iterdir())


def test_a_malformed_reply_is_asked_again_and_recorded(tmp_path, monkeypatch):
    def answer(request):
        if len(request["messages"]) == 1:
            return completion("I would try joint A first!")
        if "could not be used" in request["messages"][-1]["content"]:
            listing = request["messages"][0]["content"].split(" joints: ")[1].split(".")[0].split(", ")
            return completion(f'```json\n{{"last_action": "none", "joint": "{listing[0]}"}}\n```')
        return truthful(request)

    trials, server = played(tmp_path, monkeypatch, answer, trials=1, p=[0])
    first = trials[0].steps[0].decision
    assert first.replies[0] == "I would try joint A first!"
    assert len(first.replies) == 2
    assert first.usage.calls == 2
    assert trials[0].solved
    assert "could not be used (not one JSON object)" in server.requests[1]["messages"][-1]["content"]
    assert "could not be used" not in str(server.requests[2])  # the repair is not part of the history


def test_a_model_that_never_gives_a_usable_reply_ends_as_error_and_is_not_owed_again(tmp_path, monkeypatch):
    trials, server = played(tmp_path, monkeypatch, lambda request: completion("no"), trials=2, p=[0])
    assert len(server.requests) == 2 * (1 + llm.REPAIRS)
    for trial in trials:
        assert (trial.ending, trial.error.boundary) == ("error", "reply")
        assert trial.error.message == "no usable reply in 3 turns: not one JSON object"
        assert trial.error.replies == ("no", "no", "no")
    played(tmp_path, monkeypatch, truthful, trials=2, p=[0])
    assert len(load(tmp_path)) == 2
    assert all(trial.ending == "error" for trial in load(tmp_path))


def test_a_provider_that_refuses_ends_as_error_and_is_owed_again(tmp_path, monkeypatch):
    def answer(request):
        return refusal(401, "Incorrect API key provided: sk-private-0123456789")

    trials, _ = played(tmp_path, monkeypatch, answer, trials=1)
    assert [trial.error.boundary for trial in trials] == ["model", "model"]
    assert "Incorrect API key provided: [secret]" in trials[0].error.message
    assert b"private" not in (tmp_path / "trials.jsonl").read_bytes()
    again, _ = played(tmp_path, monkeypatch, truthful, trials=1)
    assert [trial.ending for trial in again] == ["solved", "solved"]
    assert len((tmp_path / "trials.jsonl").read_bytes().splitlines()) == 4


def test_a_provider_that_answers_rubbish_loses_and_repeats_no_finished_trial(tmp_path, monkeypatch):
    asked = []

    def answer(request):
        asked.append(request)
        return (200, b'{"choices": [') if len(asked) in (3, 30) else truthful(request)

    trials, _ = played(tmp_path, monkeypatch, answer)
    broken = [trial for trial in trials if trial.ending == "error"]
    assert [trial.error.boundary for trial in broken] == ["model", "model"]
    finished = {trial.key: trial for trial in trials if trial.ending == "solved"}
    assert len(finished) == 4
    again, server = played(tmp_path, monkeypatch, truthful)
    assert {trial.key: trial for trial in again if trial.key in finished} == finished
    assert [trial.ending for trial in again] == ["solved"] * 6
    assert len(server.requests) == sum(len(t.steps) for t in again if t.key not in finished)


def test_a_run_in_which_only_errors_come_stops_and_says_why(tmp_path, monkeypatch):
    with pytest.raises(Missing, match=r"broke 10 trials in a row \(.*out of credit.*nothing finished is lost"):
        played(tmp_path, monkeypatch, lambda request: refusal(403, "out of credit"), trials=30)


def test_what_cannot_be_asked_is_one_line():
    with pytest.raises(
        Missing, match=r"^llm:openai/gpt-4o needs OPENAI_API_KEY: export OPENAI_API_KEY=… and run again$"
    ):
        llm.check("openai/gpt-4o")
    with pytest.raises(Missing, match=r"^llm:anthropic/x needs the package anthropic: pip install anthropic$"):
        llm.check("anthropic/x")
    with pytest.raises(
        BadValue, match=r"^language model: got 'nosuch/x', expected PROVIDER/MODEL as Inspect AI names it"
    ):
        llm.check("nosuch/x")


def test_a_missing_key_is_one_clear_line_on_the_command_line(tmp_path):
    command = [
        sys.executable,
        "-m",
        "lockprobe",
        "run",
        "flips",
        "--agent",
        "llm:openai/gpt-4o",
        "--out",
        str(tmp_path),
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr == "lockprobe: llm:openai/gpt-4o needs OPENAI_API_KEY: export OPENAI_API_KEY=… and run again\n"
