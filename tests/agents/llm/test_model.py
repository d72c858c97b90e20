"""Hosted models over HTTP: the same loop, runner and journal. Faults of all kinds are in ``tests/studies/test_chaos.py``."""

import json
import time
from dataclasses import replace

import pytest
from provider_server import completion, truthful, words

from lockprobe.agents.llm.asking_again import request_fingerprint
from lockprobe.agents.llm.model_facts import ModelFacts
from lockprobe.agents.llm.settings import Access, Model, ModelSettings
from lockprobe.agents.prompt import Message
from lockprobe.report.verify import verify
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running.runner import Limits, run
from lockprobe.trial.pictures.picture import Picture

SPEC = "llm:openai-api/fake/model"


@pytest.fixture
def played(tmp_path, served):
    """Plays, or goes on with, a small study against a server with these answers."""

    def run_with(answer, spec=SPEC, *, connections=4, retries=2, pause=0.01, **settings):
        asked = {"p": [0], "trials": 2, "repetitions": 1, "modality": ["symbolic"]} | settings
        planned = study(StudyOptions(agent=[spec], **asked))
        access = Access(connections=connections, retries=retries, pause=pause)
        with served(answer) as server, Journal.open(tmp_path, planned) as journal:
            run(planned, journal, limits=Limits(access=access))
        return load(tmp_path), server

    return run_with


def test_a_study_over_http(tmp_path, played):
    trials, server = played(truthful, p=[0, 0.4], trials=1)
    assert all(trial.solved for trial in trials)  # in turn: round-robin always solves chain-4
    assert sum(len(trial.steps) for trial in trials) == len(server.requests)
    for trial in trials:
        assert (trial.facts["model"], trial.facts["prompt"]) == (SPEC.removeprefix("llm:"), "chat 43b10f00272b")
        for before, step in zip(trial.steps, trial.steps[1:], strict=False):
            said = ("moved" if before.told_moved else "blocked", "in turn")
            assert (step.decision.claimed, step.decision.hypothesis) == said
            assert (step.decision.usage.calls, step.decision.usage.input_tokens) == (1, 11)
    sent = {line for line in server.headers if line.lower().startswith("authorization")}
    assert sent == {"authorization: Bearer sk-private-0123456789"}
    assert not any(b"private" in path.read_bytes() for path in tmp_path.iterdir())


@pytest.mark.slow
def test_a_study_with_pictures_sends_the_newest_of_them_and_is_believed(tmp_path, played):
    twin = "fast-twin?width=96&height=96"
    (trial,), server = played(truthful, f"{SPEC}?images=2", plant=twin, modality=["rgb"], trials=1, max_steps=3)
    sent = [json.dumps(request["messages"]).count("data:image/png;base64,") for request in server.requests]
    assert (len(trial.steps), sent) == (3, [1, 2, 2])
    assert [check.said for check in verify(tmp_path) if not check.holds] == []


def test_what_is_sent_is_what_a_reply_is_looked_up_by():
    said, known = Message(role="user", text="What now?"), ModelFacts(reasons=False, most_output=500)

    def request(said=said, schema=None, known=known, **settings):
        model = Model(name="a/b", settings=ModelSettings(**settings), facts=known)
        return request_fingerprint(model, [said], schema or {})

    others = [
        request(said=replace(said, text="And now?")),
        request(said=replace(said, pictures=(Picture(kind="rgb", png=b"a"),))),
        request(schema={"type": "object"}),
        request(temperature=0.5),
        request(known=replace(known, most_output=400)),  # the same options, and another bound is sent
        request(known=replace(known, schema="loose")),
    ]
    assert len({request(), *others}) == 1 + len(others)
    assert request(repairs=9, known=replace(known, images=False, picture_tokens=9)) == request()


def test_marks_and_reasoning_are_kept_in_the_record_and_sent_to_nobody(tmp_path, played):
    def marked(request):
        said = truthful(request)[1]["choices"][0]["message"]["content"]
        return completion(f"A secret thought</think>{said}<|im_end|>")

    (trial,), server = played(marked, trials=1)
    assert {step.decision.tidied for step in trial.steps} == {("marks",)}
    assert [step.decision.replies for step in trial.steps] == [(call.reply,) for call in read_calls(tmp_path)]
    assert all("A secret thought</think>" in step.decision.replies[0] for step in trial.steps)
    sent = json.dumps(server.requests)
    assert "secret" not in sent
    assert "im_end" not in sent
    replies = [json.loads(message["content"]) for message in server.requests[-1]["messages"][1::2]]
    assert [reply["joint"] for reply in replies] == [step.decision.joint for step in trial.steps][:-1]


def counting(read):
    """A server that says that it read so many tokens of the messages."""

    def answer(request):
        tokens = read([len(words(message)) // 4 for message in request["messages"]])
        usage = {"prompt_tokens": tokens, "completion_tokens": 20, "total_tokens": tokens + 20}
        return 200, truthful(request)[1] | {"usage": usage}

    return answer


def test_a_conversation_that_is_cut_in_silence_breaks_the_trial_with_the_remedy(tmp_path, played):
    first, _ = played(counting(lambda sizes: min(sum(sizes), 250)))
    broken, server = played(counting(lambda sizes: min(sum(sizes), 250)))  # asks once, and knows what was read before
    assert {trial.key: trial.steps for trial in broken} == {trial.key: trial.steps for trial in first}
    assert len(server.requests) == 2
    for trial in broken:
        assert (trial.error.boundary, trial.owed_again) == ("model", True)
        assert trial.error.message.startswith("the server read 250 tokens of a conversation of which it had read ")
        assert "to mend it, give it a larger context (Ollama: OLLAMA_CONTEXT_LENGTH" in trial.error.message
        assert len(trial.steps) > 1
    failed = [call for call in read_calls(tmp_path) if call.error]
    assert {(call.reply, call.usage.input_tokens, call.usage.output_tokens) for call in failed} == {(None, 250, 20)}
    again, _ = played(counting(lambda sizes: sum(sizes[-2:])))  # what is new alone, of which nothing is cut
    assert [trial.ending for trial in again] == ["solved"] * 2


@pytest.mark.parametrize("shape", [(200, completion("")[1] | {"usage": None}), completion("Something went wrong.")])
def test_a_short_outage_in_any_words_loses_no_trial(played, shape):
    """As a fault of the server, and in words of its own, which are asked for again as a model's."""
    since = []

    def answer(request):
        if len(request["messages"]) > 3 and len(since) == 0:
            since.append(time.monotonic())
        return shape if since and time.monotonic() - since[0] < 0.3 else truthful(request)

    trials, _ = played(answer, trials=4, pause=0.1, retries=6)
    assert [trial.ending for trial in trials] == ["solved"] * 4


def test_where_all_trials_get_the_same_words_that_had_replies_before_it_is_the_server_that_says_so(played):
    def answer(request):
        return completion("Something went wrong here.") if len(request["messages"]) > 3 else truthful(request)

    broken, _ = played(answer, trials=4)
    said = "all trials get the same words in the place of replies: 'Something went wrong here.'"
    assert {(trial.error.boundary, trial.owed_again, trial.error.message) for trial in broken} == {
        ("model", True, said)
    }
    again, _ = played(truthful, trials=4)
    assert [trial.ending for trial in again] == ["solved"] * 4


def test_an_honest_study_with_counted_failures_is_believed(tmp_path, played):
    def answer(request):
        asked.append(request)
        status, body = counting(sum)(request)
        if len(asked) % 4 == 1:
            return status, body | {"choices": [], "error": {"message": "busy", "code": 503}}
        if len(asked) % 4 == 2:
            counts = {"completion_tokens": 0, "total_tokens": body["usage"]["prompt_tokens"]}
            empty = [{"message": {"content": ""}, "finish_reason": "stop"}]
            return status, body | {"choices": empty, "usage": body["usage"] | counts}
        return status, body

    asked = []
    trials, _ = played(answer, connections=1)
    assert [trial.ending for trial in trials] == ["solved"] * 2
    assert {(call.retries, call.unanswered) for call in read_calls(tmp_path)} == {(2, 0), (0, 0)}
    assert [check.said for check in verify(tmp_path) if not check.holds] == []
