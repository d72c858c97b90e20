"""A trial inside an eval is the trial that our own runner plays: the same requests, the same record."""

import json
from dataclasses import replace

import pytest
from inspected import IN_EVALS, MODEL, SPEC, evaluated
from provider_server import Manner, completion, failure, here, truthful, words

from lockprobe.foundation.errors import BadValue, ChannelFault, ModelFault, PlantFault
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import load
from lockprobe.studies.running.runner import run_study
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.trial.record import TrialError

playing = pytest.importorskip("lockprobe.interfaces.inspect.solver")

from inspect_ai.model import GenerateConfig  # noqa: E402

from lockprobe.interfaces.inspect.read_log import read_log  # noqa: E402
from lockprobe.interfaces.inspect.scoring import VALUES  # noqa: E402
from lockprobe.interfaces.inspect.tasks import flips  # noqa: E402

pytestmark = IN_EVALS
WRITTEN = SPEC.replace("/", "%2F")
KEY = f"flips/{WRITTEN}/truth/rep=1/trial=1"
EXTENT = {"p": [0, 0.4], "trials": 2, "repetitions": 1}


def stumbling(request):
    """Replies in turn, and once in a while, by what was told, with something else first."""
    told = words(request["messages"][-1])
    if told.startswith("You attempted A"):
        return completion("no idea")
    asked_again = told.startswith("That reply")
    if asked_again:
        request = {**request, "messages": request["messages"][:-2]}
    return truthful(request)


def ran(tmp_path, monkeypatch, answer, **settings):
    """The same study by our own runner."""
    with here(answer, Manner(keeps=False), keep=True) as server:
        monkeypatch.setenv("FAKE_BASE_URL", server.url)
        monkeypatch.setenv("FAKE_API_KEY", "sk-private-0123456789")
        run_study(study(StudyOptions(agent=[SPEC], **settings)), tmp_path / "ran")
    return {trial.key: trial for trial in load(tmp_path / "ran")}, server


def conversations(server):
    """What was sent, without the order in which trials took turns."""
    return sorted(json.dumps(request, sort_keys=True) for request in server.requests)


def test_a_trial_in_an_eval_is_the_one_that_the_runner_plays(tmp_path, monkeypatch):
    log, asked_there = evaluated(tmp_path, monkeypatch, flips(**EXTENT), stumbling)
    expected, asked_here = ran(tmp_path, monkeypatch, stumbling, **EXTENT)
    assert log.status == "success"
    assert {trial.key: trial for trial in read_log(log.location).trials} == expected
    assert conversations(asked_there) == conversations(asked_here)
    assert {len(step.decision.replies) for trial in expected.values() for step in trial.steps} == {1, 2}


def test_epochs_are_further_repetitions(tmp_path, monkeypatch):
    log, _ = evaluated(tmp_path, monkeypatch, flips(p=0.4, trials=1, repetitions=2), truthful, epochs=2)
    source = read_log(log.location)
    expected, _ = ran(tmp_path, monkeypatch, truthful, p=[0.4], trials=1, repetitions=4)
    assert source.study.repetitions == 4
    assert {trial.key: trial for trial in source.trials} == expected


def test_what_a_provider_broke_is_the_samples_error_and_the_other_trials_go_on(tmp_path, monkeypatch):
    def answer(request):
        opening = words(request["messages"][0])
        openings.setdefault(opening, len(openings))
        late = len(request["messages"]) > 3
        return failure(401, "no") if openings[opening] == 1 and late else truthful(request)

    openings = {}
    log, _ = evaluated(tmp_path, monkeypatch, flips(p=0, trials=4, repetitions=1), answer, max_samples=1)
    failed = [sample for sample in log.samples if sample.error]
    source = read_log(log.location)
    assert len(failed) == 1
    assert all(not sample.scores for sample in failed)
    assert len(source.trials) == 3
    assert source.unfinished == {f"flips/{WRITTEN}/{sample.id}" for sample in failed}
    (success,) = (score for score in log.results.scores if score.name == "success")
    assert success.scored_samples == 3


def test_a_reply_that_stays_unusable_is_on_record_and_unscored(tmp_path, monkeypatch):
    log, _ = evaluated(
        tmp_path, monkeypatch, flips(p=0, trials=1, repetitions=1, repairs=1), lambda request: completion("?")
    )
    (trial,) = read_log(log.location).trials
    assert (trial.ending, trial.error.boundary, trial.error.replies) == ("error", "reply", ("?", "?"))
    assert log.samples[0].error is None
    assert {(score.name, score.scored_samples, score.unscored_samples) for score in log.results.scores} == {
        (name, 0, 1) for name in VALUES
    }


def test_every_message_is_told_apart_and_the_truth_stands_beside_it(tmp_path, monkeypatch):
    log, server = evaluated(tmp_path, monkeypatch, flips(p=0.6, trials=1, repetitions=1), truthful)
    (sample,), (trial,) = log.samples, read_log(log.location).trials
    assert [message.role for message in sample.messages] == ["user", "assistant"] * len(trial.steps) + ["user"]
    calls = [event for event in sample.events if event.event == "model"]
    in_calls = {message.id for call in calls for message in [*call.input, call.output.message]}
    assert in_calls == {message.id for message in sample.messages[:-1]}
    said = [event.data for event in sample.events if event.event == "info"]
    assert len(said) == len(trial.steps)
    for step, line, message in zip(trial.steps, said, sample.messages[1::2], strict=True):
        assert line.startswith(f"Step {step.step}: ")
        assert ("false report" in line) == (step.moved != step.told_moved)
        assert message.metadata["true"] == ("moved" if step.moved else "did not move")
    assert any(step.moved != step.told_moved for step in trial.steps)
    assert "false report" not in json.dumps(server.requests)
    assert '"true"' not in json.dumps([request["messages"] for request in server.requests])


def test_settings_of_an_eval_are_those_of_the_agent(tmp_path, monkeypatch):
    task = flips(p=0, trials=1, repetitions=1, images=2)
    log, server = evaluated(tmp_path, monkeypatch, task, truthful, temperature=0.5, top_k=3, max_tokens=70)
    (trial,) = read_log(log.location).trials
    assert trial.agent == f"{SPEC}?temperature=0.5&max_tokens=70&images=2"
    assert (trial.facts["temperature"], json.loads(trial.facts["config"])) == (0.5, {"top_k": 3})
    assert {request["temperature"] for request in server.requests} == {0.5}


def test_agent_specs_name_only_what_differs():
    assert playing.agent_spec(MODEL, {"images": None, "repairs": 4}, GenerateConfig(temperature=None)) == SPEC
    assert playing.agent_spec(MODEL, {"repairs": 1}, GenerateConfig(reasoning_effort="low")) == (
        f"{SPEC}?effort=low&repairs=1"
    )
    with pytest.raises(BadValue, match="repairs"):
        playing.agent_spec(MODEL, {"repairs": 99}, GenerateConfig())


def test_a_trial_that_a_limit_cut_off_is_unscored_and_not_finished(tmp_path, monkeypatch):
    log, _ = evaluated(tmp_path, monkeypatch, flips(p=0, trials=1, repetitions=1), truthful, token_limit=20)
    source = read_log(log.location)
    assert (log.status, log.samples[0].limit.type) == ("success", "token")
    assert (source.trials, source.unfinished) == ((), {KEY})
    assert all((score.scored_samples, score.unscored_samples) == (0, 1) for score in log.results.scores)


@pytest.mark.parametrize("fault", [ChannelFault, PlantFault, ModelFault])
def test_what_broke_outside_the_model_is_named_as_what_it_is(tmp_path, monkeypatch, fault):
    async def breaks(*arguments):
        trial, timing = await play_timed(*arguments)
        error = TrialError(boundary=fault.boundary, message="it broke", step=1)
        return replace(trial, ending="error", error=error, steps=()), timing

    monkeypatch.setattr("lockprobe.studies.running.trial_setup.play_timed", breaks)
    log, _ = evaluated(tmp_path, monkeypatch, flips(p=0, trials=1, repetitions=1), truthful)
    (sample,) = log.samples
    assert sample.error.message == f"{fault.__name__}('it broke')"


def broken_in_the_choice(request):
    status, body = completion("")
    broken = {"finish_reason": "error", "error": {"code": 502, "message": "Upstream error"}}
    return status, body | {"choices": [body["choices"][0] | broken]}


def in_parts(request):
    status, body = truthful(request)
    (choice,) = body["choices"]
    text = choice["message"]["content"]
    parts = [{"type": "text", "text": text[:9]}, {"type": "text", "text": f"{text[9:]}<|im_end|>"}]
    return status, body | {"choices": [choice | {"message": choice["message"] | {"content": parts}}]}


def refusing_later(request):
    late = len(request["messages"]) > 3
    return completion(None, refusal="I cannot help with opening locks.") if late else truthful(request)


@pytest.mark.parametrize(
    "answer",
    [in_parts, refusing_later, lambda request: completion('{"jo', stop="length")],
    ids=["parts", "refusal", "cut"],
)
def test_odd_replies_fare_in_an_eval_as_with_our_own_runner(tmp_path, monkeypatch, answer):
    extent = {"p": [0], "trials": 1, "repetitions": 1}
    log, asked_there = evaluated(tmp_path, monkeypatch, flips(**extent), answer)
    expected, asked_here = ran(tmp_path, monkeypatch, answer, **extent)
    assert {trial.key: trial for trial in read_log(log.location).trials} == expected
    assert conversations(asked_there) == conversations(asked_here)
    (trial,) = expected.values()
    if answer is refusing_later:
        assert (trial.error.boundary, len(trial.steps)) == ("refusal", 2)
        assert all((score.scored_samples, score.unscored_samples) == (0, 1) for score in log.results.scores)
        assert log.samples[0].scores["played"].reason == "refusal"


def test_a_fault_inside_the_choice_is_asked_again_in_an_eval_and_then_the_samples_error(tmp_path, monkeypatch):
    course = []

    def passing(request):
        course.append(request)
        return broken_in_the_choice(request) if len(course) in (2, 3) else truthful(request)

    monkeypatch.setattr("lockprobe.agents.llm.retry.pausing", _at_once)
    extent = {"p": 0, "trials": 1, "repetitions": 1}
    log, _ = evaluated(tmp_path / "passes", monkeypatch, flips(**extent), passing, max_retries=2)
    (trial,) = read_log(log.location).trials
    assert trial.solved
    assert len(course) == len(trial.steps) + 2
    log, server = evaluated(tmp_path / "stays", monkeypatch, flips(**extent), broken_in_the_choice, max_retries=2)
    assert len(server.requests) == 3
    assert "the provider answered 502: Upstream error (tried 3 times)" in log.samples[0].error.message
    assert read_log(log.location).unfinished == {KEY}


async def _at_once(seconds):
    """No pause."""
