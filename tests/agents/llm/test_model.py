"""Hosted models over HTTP: the same loop, runner and journal. Faults of all kinds are in ``tests/studies/test_chaos.py``."""

import asyncio
import json
import time
from dataclasses import dataclass, replace

import pytest
from provider_server import completion, pictures, truthful, words
from stored import sql

from lockprobe.agents.catalogue import resolve
from lockprobe.agents.llm import model as llm
from lockprobe.agents.llm.model_facts import ModelFacts
from lockprobe.agents.llm.settings import Access, Model, ModelSettings
from lockprobe.agents.prompt import Message, picture_fingerprint
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import SettingsChanged
from lockprobe.interventions.conditions import flips
from lockprobe.interventions.words import TextChannel
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.report.verify.verification import verify
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running.runner import Limits, run
from lockprobe.trial.loop import play
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.plan import Plan

SPEC = "llm:openai-api/fake/model"
OTHER = "llm:openai/gpt-4o"


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


def doubted(directory):
    """What ``lockprobe verify`` does not believe."""
    return [check.said for check in verify(directory) if not check.holds]


@pytest.mark.parametrize("spec", [SPEC, OTHER])
def test_a_study_over_http(tmp_path, played, spec):
    trials, server = played(truthful, spec, p=[0, 0.4], trials=3)
    assert len(trials) == 6
    assert all(trial.solved for trial in trials)  # in turn: round-robin always solves chain-4
    assert sum(len(trial.steps) for trial in trials) == len(server.requests)
    for trial in trials:
        assert trial.facts["model"] == spec.removeprefix("llm:")
        assert trial.steps[0].decision.claimed is None
        for before, step in zip(trial.steps, trial.steps[1:], strict=False):
            assert step.decision.claimed == ("moved" if before.told_moved else "blocked")
            assert step.decision.hypothesis == "in turn"
            assert (step.decision.usage.calls, step.decision.usage.input_tokens) == (1, 11)
    for request in server.requests:
        claims = ["none"] if len(request["messages"]) == 1 else ["moved", "did not move"]
        schema = request["response_format"]["json_schema"]["schema"]
        assert schema["properties"]["last_action"]["enum"] == claims
        assert sorted(schema["properties"]["joint"]["enum"]) == list("ABCD")
    sent = {line for line in server.headers if line.lower().startswith("authorization")}
    assert sent == {"authorization: Bearer sk-private-0123456789"}
    assert not any(b"private" in path.read_bytes() for path in tmp_path.iterdir())


def test_a_malformed_reply_is_asked_again_and_recorded(played):
    def answer(request):
        if len(request["messages"]) == 1:
            return completion("I would try joint A first!")
        if "could not be used" in request["messages"][-1]["content"]:
            return truthful({"messages": request["messages"][:-2]})
        return truthful(request)

    trials, server = played(answer, trials=1)
    first = trials[0].steps[0].decision
    assert (first.replies[0], len(first.replies), first.usage.calls) == ("I would try joint A first!", 2, 2)
    assert trials[0].solved
    assert "could not be used (not one JSON object)" in server.requests[1]["messages"][-1]["content"]
    assert "could not be used" not in str(server.requests[2])  # the repair is not part of the history


@dataclass(frozen=True)
class Photographs:
    """Made-up files for pictures: which configuration they are of stands in them, and is told nowhere else."""

    def perceive(self, percept, past, task, rng):
        state = bytes(percept.positions)
        shown = [Picture(kind=kind, png=b"\x89PNG \xff" + kind.encode() + state) for kind in ("rgb", "depth")]
        hidden = Picture(kind="depth16", png=b"measured" + state, shown=False)
        text = "The picture shows the box." if percept.joint is None else f"You attempted {percept.joint}."
        return replace(percept, outcome=None, positions=None, text=text, pictures=(*shown, hidden))


@pytest.fixture
def shown(served):
    """Plays one trial of a model that is told by a channel: the trial and the requests that arrived."""
    condition = flips((0,), modalities=("rgb",))[0]

    def play_with(answer, channel, spec=SPEC):
        plan = Plan(study="s", agent=spec, box=box(), condition=condition, repetition=1, trial=1, seed=1)

        async def trial():
            agent = resolve(spec).make()
            try:
                return await play(plan, plant=SymbolicPlant(plan.box), interventions=[channel], agent=agent)
            finally:
                await agent.aclose()

        with served(answer) as server:
            return asyncio.run(trial()), server.requests

    return play_with


def test_the_newest_observations_arrive_with_their_pictures_as_they_are_also_when_a_reply_is_asked_for_again(shown):
    def answer(request):
        repaired = "could not be used" in words(request["messages"][-1])
        return truthful({"messages": request["messages"][:-2]}) if repaired else completion("a knob")

    trial, requests = shown(answer, Photographs(), f"{SPEC}?images=2&detail=low")
    assert trial.solved
    for step, request in zip([step for step in trial.steps for _ in range(2)], requests, strict=True):
        told = [message for message in request["messages"] if message["role"] == "user"][: step.step]
        before = [one.state for one in trial.steps[: step.step]]
        for number, (message, state) in enumerate(zip(told, before, strict=True)):
            by_label = dict(zip(trial.labels, state, strict=True))
            marks = bytes(int(by_label[label]) for label in trial.listing)
            whole = [(b"\x89PNG \xff" + kind + marks, "data:image/png", "low") for kind in (b"rgb", b"depth")]
            newest = number >= step.step - 2
            assert pictures(message) == (whole if newest else [])
            assert words(message).endswith("(pictures no longer shown)") != newest
    assert b"measured" not in json.dumps(requests).encode()
    assert (trial.facts["model"], trial.facts["images"], trial.facts["detail"]) == ("openai-api/fake/model", 2, "low")


def test_a_model_that_is_told_reports_is_asked_and_recorded_without_a_word_of_pictures(shown):
    """The fingerprint of the prompt and the other facts are compared when a study is resumed."""
    trial, requests = shown(truthful, TextChannel())
    assert trial.facts["prompt"] == "chat 91048d939031"
    assert trial.facts["picture_prompt"] == f"chat {picture_fingerprint()}"
    sent = ["effort", "host", "max_tokens", "repairs", "schema", "temperature", "top_p"]
    assert sorted(trial.facts) == sorted([*sent, "model", "picture_prompt", "prompt", "runtime"])
    assert all(isinstance(message["content"], str) for request in requests for message in request["messages"])


def test_where_nobody_asks_what_the_last_action_did_nothing_that_is_sent_speaks_of_it(played):
    def answer(request):
        status, body = truthful(request)
        message = body["choices"][0]["message"]
        message["content"] = json.dumps({**json.loads(message["content"]), "last_action": "perhaps"})
        return status, body

    trials, server = played(answer, assessment=False)
    assert not any("last_action" in json.dumps(request["messages"][0]) for request in server.requests)
    assert not any("last_action" in json.dumps(request["response_format"]) for request in server.requests)
    for trial in trials:
        assert (trial.solved, trial.assessment) == (True, False)
        assert {(step.decision.claimed, len(step.decision.replies)) for step in trial.steps} == {(None, 1)}


def test_what_is_sent_is_what_a_reply_is_looked_up_by():
    said, known = Message(role="user", text="What now?"), ModelFacts(reasons=False, most_output=500)

    def request(said=said, schema=None, known=known, **settings):
        model = Model(name="a/b", settings=ModelSettings(**settings), facts=known)
        return llm.fingerprint(model, [said], schema or {})

    others = [
        request(said=replace(said, text="And now?")),
        request(said=replace(said, pictures=(Picture(kind="rgb", png=b"a"),))),
        request(schema={"type": "object"}),
        request(temperature=0.5),
        request(detail="low"),
        request(known=replace(known, most_output=400)),  # the same options, and another bound is sent
        request(known=replace(known, schema="loose")),
        request(known=replace(known, reasons=True, most_output=20_000)),
    ]
    assert len({request(), *others}) == 1 + len(others)
    assert request(repairs=9, known=replace(known, images=False, picture_tokens=9)) == request()


def test_a_conversation_that_is_too_long_is_no_reply_and_its_trial_is_owed_again(tmp_path, played):
    def answer(request):
        said = {"message": "This model's maximum context length is 9 tokens.", "code": "context_length_exceeded"}
        return (400, {"error": said}) if len(request["messages"]) > 3 else truthful(request)

    trials, _ = played(answer, trials=1)
    assert (trials[0].error.boundary, len(trials[0].steps), trials[0].owed_again) == ("model", 2, True)
    assert trials[0].error.message.startswith("the conversation is longer than the model can read: This model's max")
    last = list(read_calls(tmp_path))[-1]
    assert (last.reply, last.error, last.most) == (None, trials[0].error.message, None)


def test_a_call_keeps_what_it_took_whether_it_failed_or_not(tmp_path, played):
    def answer(request):
        asked.append(request)
        return (200, b'{"choices": [') if len(asked) in (1, 2, 4, 5, 6) else truthful(request)

    asked = []
    played(answer, trials=1, max_steps=2)
    good, failed = list(read_calls(tmp_path))
    assert (good.retries, good.unanswered, good.usage.input_tokens) == (2, 2, 11)
    assert (failed.reply, failed.retries, failed.unanswered) == (None, 2, 3)
    assert failed.seconds > 0
    assert good.most.input_tokens > 11
    assert good.most.output_tokens == failed.most.output_tokens > 0


def test_another_model_under_the_same_name_is_refused_before_it_is_asked(tmp_path, played, monkeypatch):
    played(truthful)
    sql(tmp_path, "delete from trial where id > 1")  # one is owed again
    sql(tmp_path, "delete from call")
    monkeypatch.setattr(llm, "chat_fingerprint", lambda: "another prompt")
    with pytest.raises(SettingsChanged, match="'chat another prompt' asked"):
        played(truthful)
    assert sql(tmp_path, "select * from call") == []


def test_marks_and_reasoning_are_kept_in_the_record_and_sent_to_nobody(tmp_path, played):
    def marked(request):
        said = truthful(request)[1]["choices"][0]["message"]["content"]
        return completion(f"A secret thought</think>{said}<|im_end|>")

    (trial,), server = played(marked, trials=1)
    assert {step.decision.tidied for step in trial.steps} == {("reasoning", "template")}
    assert [step.decision.replies for step in trial.steps] == [(call.reply,) for call in read_calls(tmp_path)]
    assert all("A secret thought</think>" in step.decision.replies[0] for step in trial.steps)
    sent = json.dumps(server.requests)
    assert "secret" not in sent
    assert "im_end" not in sent
    replies = [json.loads(message["content"]) for message in server.requests[-1]["messages"][1::2]]
    assert [reply["joint"] for reply in replies] == [step.decision.joint for step in trial.steps][:-1]


def test_a_refusal_in_the_middle_of_a_trial_keeps_its_steps_and_the_replies_before_it(played):
    def answer(request):
        late = len(request["messages"]) >= 5
        if late and "could not be used" not in words(request["messages"][-1]):
            return completion("no")
        return completion(None, refusal="I cannot go on.") if late else truthful(request)

    (trial,), server = played(answer, trials=1)
    assert (trial.error.boundary, trial.error.step, len(trial.steps)) == ("refusal", 3, 2)
    assert (trial.error.replies, trial.error.usage.calls) == (("no", "I cannot go on."), 2)
    assert len(server.requests) == 4


@pytest.mark.parametrize(
    ("message", "tokens", "why"),
    [
        ({"content": "<think>Hm.</think>"}, 900, "after 900 tokens, some of them of reasoning"),
        ({"content": "", "reasoning": "Hm."}, None, "after reasoning"),
    ],
)
def test_an_empty_reply_after_reasoning_names_it_also_when_it_is_read_again(tmp_path, played, message, tokens, why):
    def answer(request):
        status, body = completion("", stop="stop")
        body["choices"][0]["message"] |= message
        usage = {"prompt_tokens": 11, "completion_tokens": tokens, "total_tokens": 911} if tokens else None
        return status, body | {"usage": usage}

    (trial,), _ = played(answer, f"{SPEC}?repairs=0", trials=1)
    assert trial.error.message.endswith(f" ({why})")
    (call,) = read_calls(tmp_path)
    assert call.reasoned
    assert doubted(tmp_path) == []


def test_an_impossible_count_of_a_fault_is_charged_as_the_most_that_can_be(tmp_path, played):
    def answer(request):
        status, body = completion("")
        counts = {"prompt_tokens": 10**9, "completion_tokens": 10**9, "total_tokens": 2 * 10**9}
        return status, body | {"choices": [body["choices"][0] | {"finish_reason": "error"}], "usage": counts}

    played(answer, trials=1)
    (call,) = read_calls(tmp_path)
    assert call.claimed.output_tokens == 3 * 10**9
    assert call.usage.output_tokens == 32_768


def counting(read):
    """A server that says that it read so many tokens of the messages."""

    def answer(request):
        tokens = read([len(words(message)) // 4 for message in request["messages"]])
        usage = {"prompt_tokens": tokens, "completion_tokens": 20, "total_tokens": tokens + 20}
        return 200, truthful(request)[1] | {"usage": usage}

    return answer


def test_a_conversation_that_is_cut_in_silence_breaks_the_trial_with_the_remedy(tmp_path, played):
    broken, _ = played(counting(lambda sizes: min(sum(sizes), 250)))
    for trial in broken:
        assert (trial.error.boundary, trial.owed_again) == ("model", True)
        assert trial.error.message.startswith("the server read 250 tokens of a conversation of which it had read ")
        assert "to mend it, give it a larger context (Ollama: OLLAMA_CONTEXT_LENGTH" in trial.error.message
        assert len(trial.steps) > 1
    failed = [call for call in read_calls(tmp_path) if call.error]
    assert {(call.reply, call.usage.input_tokens, call.usage.output_tokens) for call in failed} == {(None, 250, 20)}
    again, _ = played(counting(sum))
    assert [trial.ending for trial in again] == ["solved"] * 2
    assert doubted(tmp_path) == []


def test_a_server_that_counts_what_is_new_alone_cuts_nothing(played):
    trials, _ = played(counting(lambda sizes: sum(sizes[-2:])))
    assert [trial.ending for trial in trials] == ["solved"] * 2


def upstream():
    status, body = completion("")
    error = {"code": 502, "message": "Upstream error"}
    return status, body | {"choices": [body["choices"][0] | {"finish_reason": "error", "error": error}]}


OUTAGES = {
    "an error behind a router": upstream,
    "empty, and nobody counts": lambda: (200, completion("")[1] | {"usage": None}),
    "an error as text": lambda: completion("upstream connect error"),
    "an error object as text": lambda: completion('{"error": {"message": "overloaded", "type": "server_error"}}'),
    "words of its own": lambda: completion("Something went wrong here."),
}


@pytest.mark.parametrize("shape", OUTAGES)
def test_a_short_outage_in_any_words_loses_no_trial(tmp_path, played, shape):
    since = []

    def answer(request):
        if len(request["messages"]) > 3 and len(since) == 0:
            since.append(time.monotonic())
        return OUTAGES[shape]() if since and time.monotonic() - since[0] < 0.5 else truthful(request)

    trials, _ = played(answer, p=[0, 0.4], trials=4, pause=0.1, retries=6)
    assert [trial.ending for trial in trials] == ["solved"] * 8
    assert doubted(tmp_path) == []


def test_where_all_trials_get_the_same_words_that_had_replies_before_it_is_the_server_that_says_so(tmp_path, played):
    def answer(request):
        return completion("Something went wrong here.") if len(request["messages"]) > 3 else truthful(request)

    broken, _ = played(answer, trials=4)
    said = "all trials get the same words in the place of replies: 'Something went wrong here.'"
    assert {(trial.error.boundary, trial.owed_again, trial.error.message) for trial in broken} == {
        ("model", True, said)
    }
    again, _ = played(truthful, trials=4)
    assert [trial.ending for trial in again] == ["solved"] * 4
    assert doubted(tmp_path) == []


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
    assert doubted(tmp_path) == []
