"""Hosted models over HTTP: the same loop, runner and journal; faults are bounded and attributed."""

import asyncio
import json
import os
import time
from dataclasses import dataclass, replace

import pytest
from provider_server import completion, failure, here, truthful, words
from stored import contents, records, sql

from lockprobe.agents.catalogue import resolve
from lockprobe.agents.llm import model as llm
from lockprobe.agents.llm.model_facts import ModelFacts
from lockprobe.agents.llm.settings import ModelSettings, read_settings
from lockprobe.agents.model_access import Access
from lockprobe.agents.prompt import Message, picture_fingerprint
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue, Missing, SettingsChanged, UnknownName
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
from lockprobe.testing.provider import pictures
from lockprobe.trial.loop import play
from lockprobe.trial.model_call import Usage
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.plan import Plan

SPEC = "llm:openai-api/fake/model"


@pytest.fixture(autouse=True)
def no_keys(monkeypatch):
    for name in os.environ:
        if name.endswith(("_API_KEY", "_BASE_URL")):
            monkeypatch.delenv(name)


def played(tmp_path, monkeypatch, answer, spec=SPEC, *, connections=4, retries=2, pause=0.01, **settings):
    """Trials of a small study against a server."""
    request = StudyOptions(agent=[spec], **({"p": [0, 0.4], "trials": 3, "repetitions": 1} | settings))
    with here(answer, keep=True) as server:
        for provider in ("FAKE", "OPENAI"):
            monkeypatch.setenv(f"{provider}_BASE_URL", server.url)
            monkeypatch.setenv(f"{provider}_API_KEY", "sk-private-0123456789")
        planned = study(request)
        with Journal.open(tmp_path, planned) as journal:
            run(planned, journal, limits=Limits(access=Access(connections=connections, retries=retries, pause=pause)))
        return load(tmp_path), server


@pytest.mark.parametrize("spec", [SPEC, "llm:openai/gpt-4o"])
def test_a_study_over_http(tmp_path, monkeypatch, spec):
    trials, server = played(tmp_path, monkeypatch, truthful, spec, modality=["symbolic"])
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
    sent = {line for line in server.headers if line.lower().startswith("authorization")}
    assert sent == {"authorization: Bearer sk-private-0123456789"}
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
    assert len(server.requests) == 2 * 5
    for trial in trials:
        assert (trial.ending, trial.error.boundary) == ("error", "reply")
        assert trial.error.message == "no usable reply in 5 turns: not one JSON object"
        assert trial.error.replies == ("no",) * 5
    played(tmp_path, monkeypatch, truthful, trials=2, p=[0])
    assert len(load(tmp_path)) == 2
    assert all(trial.ending == "error" for trial in load(tmp_path))


def test_a_provider_that_refuses_ends_as_error_and_is_owed_again(tmp_path, monkeypatch):
    def answer(request):
        return failure(401, "Incorrect API key provided: sk-private-0123456789")

    trials, _ = played(tmp_path, monkeypatch, answer, trials=1)
    assert [trial.error.boundary for trial in trials] == ["model", "model"]
    assert "Incorrect API key provided: [secret]" in trials[0].error.message
    assert "private" not in str(contents(tmp_path))
    again, _ = played(tmp_path, monkeypatch, truthful, trials=1)
    assert [trial.ending for trial in again] == ["solved", "solved"]
    assert len(records(tmp_path)) == 4


def test_a_provider_that_answers_rubbish_is_asked_again_and_no_step_is_played_twice(tmp_path, monkeypatch):
    asked = []

    def answer(request):
        asked.append(request)
        return (200, b'{"choices": [') if len(asked) in (3, 30) else truthful(request)

    trials, _ = played(tmp_path, monkeypatch, answer)
    assert [trial.ending for trial in trials] == ["solved"] * 6
    assert len(asked) == sum(len(trial.steps) for trial in trials) + 2
    calls = list(read_calls(tmp_path))
    assert sorted(call.retries for call in calls)[-3:] == [0, 1, 1]
    assert len({(call.key, call.step) for call in calls}) == len(calls)


def test_a_provider_that_answers_only_rubbish_breaks_trials_which_then_go_on_where_they_stood(tmp_path, monkeypatch):
    def answer(request):
        return (200, b'{"choices": [') if len(request["messages"]) == 5 else truthful(request)

    broken, _ = played(tmp_path, monkeypatch, answer, trials=2)
    assert [(trial.error.boundary, len(trial.steps)) for trial in broken] == [("model", 2)] * 4
    again, server = played(tmp_path, monkeypatch, truthful, trials=2)
    assert [trial.ending for trial in again] == ["solved"] * 4
    assert len(server.requests) == sum(len(trial.steps) - 2 for trial in again)


def test_a_run_in_which_only_errors_come_stops_and_says_why(tmp_path, monkeypatch):
    with pytest.raises(Missing, match=r"broke 10 trials in a row \(.*out of credit.*nothing finished is lost"):
        played(tmp_path, monkeypatch, lambda request: failure(403, "out of credit"), trials=30)


@dataclass(frozen=True)
class Photographs:
    """Made-up files for pictures: which configuration they are of stands in them, and is told nowhere else."""

    depth: bool = False

    def perceive(self, percept, past, task, rng):
        state = bytes(percept.positions)
        shown = [Picture(kind="rgb", png=b"\x89PNG colours \xff" + state)]
        if self.depth:
            shown.append(Picture(kind="depth", png=b"\x89PNG depth \xff" + state))
        hidden = Picture(kind="depth16", png=b"measured" + state, shown=False)
        text = "The picture shows the box." if percept.joint is None else f"You attempted {percept.joint}."
        return replace(percept, outcome=None, positions=None, text=text, pictures=(*shown, hidden))


def shown(monkeypatch, answer, channel, spec=SPEC):
    """One trial of a model that is shown pictures: the trial and the requests that arrived."""
    plan = Plan(
        study="s",
        agent=spec,
        box=box(),
        condition=flips((0,), modalities=("rgb",))[0],
        repetition=1,
        trial=1,
        seed=1,
    )

    async def played():
        agent = resolve(spec).make()
        try:
            return await play(plan, plant=SymbolicPlant(plan.box), interventions=[channel], agent=agent)
        finally:
            await agent.aclose()

    with here(answer, keep=True) as server:
        monkeypatch.setenv("FAKE_BASE_URL", server.url)
        monkeypatch.setenv("FAKE_API_KEY", "sk-private-0123456789")
        return asyncio.run(played()), server.requests


@pytest.mark.parametrize("depth", [False, True])
def test_every_observation_arrives_with_its_pictures_as_they_are(monkeypatch, depth):
    trial, requests = shown(monkeypatch, truthful, Photographs(depth=depth))
    assert trial.solved
    states = [*(step.state for step in trial.steps)]
    for turn, request in enumerate(requests):
        told = [message for message in request["messages"] if message["role"] == "user"]
        assert len(told) == turn + 1
        for message, state in zip(told, states, strict=False):
            by_label = dict(zip(trial.labels, state, strict=True))
            marks = bytes(int(by_label[label]) for label in trial.listing)
            expected = [(b"\x89PNG colours \xff" + marks, "data:image/png", "high")]
            if depth:
                expected.append((b"\x89PNG depth \xff" + marks, "data:image/png", "high"))
            assert pictures(message) == expected
            assert [part["type"] for part in message["content"]] == ["text"] + ["image_url"] * (1 + depth)
    assert words(requests[0]["messages"][0]).endswith("The picture shows the box.")
    assert words(requests[1]["messages"][-1]) == f"You attempted {trial.listing[0]}."
    assert b"measured" not in json.dumps(requests).encode()


def test_older_pictures_leave_the_conversation_if_asked(monkeypatch):
    trial, requests = shown(monkeypatch, truthful, Photographs(), f"{SPEC}?images=2&detail=low")
    last = [message for message in requests[-1]["messages"] if message["role"] == "user"]
    assert len(last) == len(trial.steps) > 4
    assert [len(pictures(message)) for message in last] == [0] * (len(last) - 2) + [1, 1]
    assert all(words(message).endswith("(picture no longer shown)") for message in last[:-2])
    assert [detail for message in last for _, _, detail in pictures(message)] == ["low", "low"]
    assert (trial.facts["model"], trial.facts["images"], trial.facts["detail"]) == ("openai-api/fake/model", 2, "low")


def test_a_repair_keeps_the_pictures(monkeypatch):
    def answer(request):
        repaired = "could not be used" in words(request["messages"][-1])
        return truthful({"messages": request["messages"][:-2]}) if repaired else completion("a knob")

    trial, requests = shown(monkeypatch, answer, Photographs())
    assert trial.solved
    assert len(trial.steps[0].decision.replies) == 2
    assert [len(pictures(message)) for message in requests[1]["messages"]] == [1, 0, 0]


def test_a_model_that_cannot_see_is_a_fault_of_the_model_as_any_other(monkeypatch):
    def answer(request):
        return failure(400, "Invalid content type. image_url is only supported by certain models.")

    trial, _ = shown(monkeypatch, answer, Photographs())
    assert (trial.ending, trial.error.boundary, trial.steps) == ("error", "model", ())
    assert "image_url is only supported by certain models" in trial.error.message
    assert "base64" not in trial.error.message


def test_a_model_that_is_told_reports_is_asked_and_recorded_without_a_word_of_pictures(monkeypatch):
    """The fingerprint of the prompt and the other facts are compared when a study is resumed."""
    trial, requests = shown(monkeypatch, truthful, TextChannel())
    assert trial.facts["prompt"] == "chat 91048d939031"
    assert trial.facts["picture_prompt"] == f"chat {picture_fingerprint()}"
    sent = ["effort", "host", "max_tokens", "repairs", "schema", "temperature", "top_p"]
    assert sorted(trial.facts) == sorted([*sent, "model", "picture_prompt", "prompt", "runtime"])
    assert all(isinstance(message["content"], str) for request in requests for message in request["messages"])


@pytest.mark.parametrize(
    ("options", "mistake", "message"),
    [
        ("image=4", UnknownName, "no option of llm:openai-api/fake/model is called 'image' (did you mean 'images'?)"),
        (
            "images=-1",
            BadValue,
            "images: got -1, expected the number of observations that keep their pictures, 0 for all",
        ),
        ("images=few", BadValue, "images: got 'few', expected a whole number"),
        ("detail=fine", BadValue, "detail: got 'fine', expected one of auto, low, high"),
    ],
)
def test_an_option_that_cannot_be_is_one_line(options, mistake, message):
    with pytest.raises(mistake) as wrong:
        read_settings(f"openai-api/fake/model?{options}")
    assert str(wrong.value).startswith(message)


def test_where_nobody_asks_what_the_last_action_did_nothing_that_is_sent_speaks_of_it(tmp_path, monkeypatch):
    def answer(request):
        listing = request["messages"][0]["content"].split(" joints: ")[1].split(".")[0].split(", ")
        turn = sum(message["role"] == "assistant" for message in request["messages"])
        return completion(json.dumps({"hypothesis": "in turn", "joint": listing[turn % len(listing)]}))

    trials, server = played(tmp_path, monkeypatch, answer, assessment=False)
    assert not any("last_action" in json.dumps(request) for request in server.requests)
    assert [trial.ending for trial in trials] == ["solved"] * 6
    for trial in trials:
        assert trial.assessment is False
        assert {step.decision.claimed for step in trial.steps} == {None}
        assert all(len(step.decision.replies) == 1 for step in trial.steps)


def test_what_is_sent_is_what_a_reply_is_looked_up_by():
    asked = [Message(role="user", text="What now?")]
    known = ModelFacts(reasons=False, most_output=500)
    ways = [
        (asked, {}, ModelSettings(), known),
        ([replace(asked[0], text="And now?")], {}, ModelSettings(), known),
        ([replace(asked[0], pictures=(Picture(kind="rgb", png=b"a"),))], {}, ModelSettings(), known),
        (asked, {"type": "object"}, ModelSettings(), known),
        (asked, {}, ModelSettings(temperature=0.5), known),
        (asked, {}, ModelSettings(detail="low"), known),
        (asked, {}, ModelSettings(), replace(known, most_output=400)),  # the same options, and another bound is sent
        (asked, {}, ModelSettings(), replace(known, schema="loose")),
        (asked, {}, ModelSettings(), replace(known, reasons=True, most_output=20_000)),
    ]
    assert len({llm._fingerprint(*way) for way in ways}) == len(ways)
    same = (asked, {}, ModelSettings(repairs=9), replace(known, images=False, context=9))
    assert llm._fingerprint(*same) == llm._fingerprint(*ways[0])


def test_a_conversation_that_is_too_long_is_no_reply_and_its_trial_is_owed_again(tmp_path, monkeypatch):
    def answer(request):
        long = len(request["messages"]) > 3
        said = {"message": "This model's maximum context length is 9 tokens.", "code": "context_length_exceeded"}
        return (400, {"error": said}) if long else truthful(request)

    trials, _ = played(tmp_path, monkeypatch, answer, trials=1, p=[0])
    assert (trials[0].error.boundary, len(trials[0].steps), trials[0].owed_again) == ("model", 2, True)
    assert trials[0].error.message.startswith("the conversation is longer than the model can read: This model's max")
    last = list(read_calls(tmp_path))[-1]
    assert (last.reply, last.error, last.most) == (None, trials[0].error.message, None)


def test_a_call_keeps_what_it_took_whether_it_failed_or_not(tmp_path, monkeypatch):
    def answer(request):
        asked.append(request)
        return (200, b'{"choices": [') if len(asked) in (1, 2, 4, 5, 6) else truthful(request)

    asked = []
    played(tmp_path, monkeypatch, answer, trials=1, p=[0], max_steps=2)
    good, failed = list(read_calls(tmp_path))
    assert (good.retries, good.unanswered, good.usage.input_tokens) == (2, 2, 11)
    assert (failed.reply, failed.retries, failed.unanswered) == (None, 2, 3)
    assert failed.seconds > 0
    assert good.most.input_tokens > 11
    assert good.most.output_tokens == failed.most.output_tokens > 0


def test_facts_say_the_host(monkeypatch):
    monkeypatch.setenv("OPENAI_BASE_URL", "https://gateway.example/v1")
    monkeypatch.setenv("OPENAI_API_KEY", "sk-private-0123456789")
    assert resolve("llm:openai/gpt-4o").make().facts["host"] == "gateway.example"


def test_another_model_under_the_same_name_is_refused_before_it_is_asked(tmp_path, monkeypatch):
    played(tmp_path, monkeypatch, truthful, trials=1)
    sql(tmp_path, "delete from trial where id > 1")  # one is owed again
    sql(tmp_path, "delete from call")
    monkeypatch.setattr(llm, "chat_fingerprint", lambda: "another prompt")
    with pytest.raises(SettingsChanged, match="'chat another prompt' asked"):
        played(tmp_path, monkeypatch, truthful, trials=1)
    assert sql(tmp_path, "select * from call") == []


def bent(**changes):
    """A server whose answers are not quite what they should be."""

    def answer(request):
        status, body = truthful(request)
        return status, body | changes

    return answer


def test_counts_that_cannot_be_are_not_believed(tmp_path, monkeypatch):
    usage = {"prompt_tokens": 5, "completion_tokens": 5, "total_tokens": 10}
    impossible = usage | {"prompt_tokens_details": {"cached_tokens": 1_000_000}}
    trials, _ = played(tmp_path, monkeypatch, bent(usage=impossible), trials=1, p=[0])
    assert {step.decision.usage for step in trials[0].steps} == {Usage(calls=1)}
    assert all(call.most is not None for call in read_calls(tmp_path))  # nobody knows what they cost


def test_a_name_from_outside_is_kept_short_and_harmless(tmp_path, monkeypatch):
    trials, _ = played(tmp_path, monkeypatch, bent(model="\x1b[31m\u202e" + "m" * 9999), trials=1, p=[0])
    served = trials[0].steps[0].decision.served
    assert served.startswith("?[31m?mmm")
    assert len(served) == 200


def said(request):
    """The well-formed reply to a request."""
    return truthful(request)[1]["choices"][0]["message"]["content"]


def answering(change, **more):
    """A server whose replies are well-formed ones, changed."""
    return lambda request: completion(change(said(request)), **more)


OTHER = "llm:openai/gpt-4o"
"""The class of another provider: what both share is shown with either, in turn."""


@pytest.mark.parametrize(
    ("spec", "change", "tidied"),
    [
        (SPEC, lambda text: f"Hm\n</think>\n{text}", ("reasoning",)),
        (OTHER, lambda text: f"<|channel|>final<|message|>{text}<|return|>", ("template",)),
        (SPEC, lambda text: f"{text}<|im_end|>", ("template",)),
        (OTHER, lambda text: f"Here it is:\n```JSON\n{text}\n```", ("fence", "prose")),
        (SPEC, lambda text: text.replace('"in turn"', "null"), ("spelling",)),
        (OTHER, lambda text: text.replace("did not move", "Did not move.").replace("in turn", "here"), None),
    ],
)
def test_a_habit_of_model_or_server_costs_no_trial_and_is_on_record(tmp_path, monkeypatch, spec, change, tidied):
    trials, server = played(tmp_path, monkeypatch, answering(change), spec, modality=["symbolic"], trials=1)
    assert [trial.solved for trial in trials] == [True, True]
    assert len(server.requests) == sum(len(trial.steps) for trial in trials)
    decisions = [step.decision for trial in load(tmp_path) for step in trial.steps]
    if tidied is None:
        assert {decision.tidied for decision in decisions} == {(), ("spelling",)}
    else:
        assert {decision.tidied for decision in decisions} == {tidied}
    assert [decision.replies for decision in decisions] == [(call.reply,) for call in sorted_calls(tmp_path, trials)]


def sorted_calls(directory, trials):
    """The calls in the order of the trials' steps."""
    place = {trial.key: i for i, trial in enumerate(trials)}
    return sorted(read_calls(directory), key=lambda call: (place[call.key], call.step))


def test_marks_and_reasoning_are_kept_in_the_record_and_sent_to_nobody(tmp_path, monkeypatch):
    marked = answering(lambda text: f"A secret thought</think>{text}<|im_end|>")
    trials, server = played(tmp_path, monkeypatch, marked, trials=1, p=[0])
    assert all("A secret thought</think>" in step.decision.replies[0] for step in trials[0].steps)
    sent = json.dumps(server.requests)
    assert "secret" not in sent
    assert "im_end" not in sent
    replies = [json.loads(message["content"]) for message in server.requests[-1]["messages"][1::2]]
    assert [reply["joint"] for reply in replies] == [step.decision.joint for step in trials[0].steps][:-1]


@pytest.mark.parametrize(
    ("spec", "answer"),
    [
        (SPEC, lambda request: completion(None, refusal="I cannot help with opening locks.")),
        (OTHER, lambda request: completion("", stop="content_filter")),
        *(
            (each, lambda request: (400, {"error": {"code": "content_filter", "message": "The prompt was filtered."}}))
            for each in (SPEC, OTHER)
        ),
    ],
)
def test_a_refusal_is_an_ending_of_its_own_which_is_paid_for_once(tmp_path, monkeypatch, spec, answer):
    for _ in range(2):
        trials, server = played(tmp_path, monkeypatch, answer, spec, modality=["symbolic"], trials=2, p=[0])
        for trial in trials:
            assert (trial.ending, trial.error.boundary, trial.owed_again) == ("error", "refusal", False)
            assert trial.error.message.startswith("refused: ")
            assert trial.error.message == f"refused: {trial.error.replies[0]}"
        assert {call.stop for call in read_calls(tmp_path)} == {"content_filter"}
    assert server.requests == []
    assert len(list(read_calls(tmp_path))) == 2


def test_a_refusal_in_the_middle_of_a_trial_keeps_its_steps_and_the_replies_before_it(tmp_path, monkeypatch):
    def answer(request):
        late = len(request["messages"]) >= 5
        if late and "could not be used" not in words(request["messages"][-1]):
            return completion("no")
        return completion(None, refusal="I cannot go on.") if late else truthful(request)

    (trial,), server = played(tmp_path, monkeypatch, answer, trials=1, p=[0])
    assert (trial.error.boundary, trial.error.step, len(trial.steps)) == ("refusal", 3, 2)
    assert trial.error.replies == ("no", "I cannot go on.")
    assert trial.error.usage.calls == 2
    assert len(server.requests) == 4


@pytest.mark.parametrize(
    ("message", "tokens", "why"),
    [
        ({"content": "", "reasoning_content": "Hm."}, 900, "after 900 tokens, some of them of reasoning"),
        ({"content": "<think>Hm.</think>"}, 900, "after 900 tokens, some of them of reasoning"),
        ({"content": "", "reasoning": "Hm."}, None, "after reasoning"),
        ({"content": ""}, 900, "after 900 tokens"),
    ],
)
def test_an_empty_reply_after_reasoning_that_nobody_counts_names_it_also_when_it_is_read_again(
    tmp_path, monkeypatch, message, tokens, why
):
    def answer(request):
        status, body = completion("", stop="stop")
        body["choices"][0]["message"] |= message
        if tokens is None:
            return status, {name: of for name, of in body.items() if name != "usage"}
        return status, body | {"usage": {"prompt_tokens": 11, "completion_tokens": tokens, "total_tokens": 11 + tokens}}

    (trial,), _ = played(tmp_path, monkeypatch, answer, f"{SPEC}?repairs=0", trials=1, p=[0])
    assert trial.error.message.endswith(f" ({why})")
    (call,) = read_calls(tmp_path)
    assert call.reasoned == ("reasoning" in why)
    assert [check.said for check in verify(tmp_path) if not check.holds] == []


def test_an_outage_behind_a_router_loses_no_trial(tmp_path, monkeypatch):
    def outage(request):
        asked.append(request)
        if 5 <= len(asked) < 20:
            broken = {"finish_reason": "error", "error": {"code": 502, "message": "Upstream error"}}
            status, body = completion("")
            return status, body | {"choices": [body["choices"][0] | broken]}
        return truthful(request)

    asked = []
    trials, _ = played(tmp_path, monkeypatch, outage)
    assert {trial.error.boundary for trial in trials if trial.error} == {"model"}
    again, _ = played(tmp_path, monkeypatch, truthful)
    assert [trial.ending for trial in again] == ["solved"] * 6
    assert all("could not be used" not in json.dumps(request) for request in asked)


def test_an_impossible_count_of_a_fault_is_charged_as_the_most_that_can_be(tmp_path, monkeypatch):
    def answer(request):
        status, body = completion("")
        counts = {"prompt_tokens": 10**9, "completion_tokens": 10**9, "total_tokens": 2 * 10**9}
        return status, body | {"choices": [body["choices"][0] | {"finish_reason": "error"}], "usage": counts}

    played(tmp_path, monkeypatch, answer, trials=1, p=[0])
    (call,) = read_calls(tmp_path)
    assert call.claimed.output_tokens == 3 * 10**9
    assert call.usage.output_tokens == 32_768


def cutting(limit):
    """A server that counts what it reads, and reads no more than so many tokens."""

    def answer(request):
        read = sum(len(words(message)) for message in request["messages"]) // 4
        usage = {"prompt_tokens": min(read, limit), "completion_tokens": 20, "total_tokens": min(read, limit) + 20}
        return 200, truthful(request)[1] | {"usage": usage}

    return answer


def test_a_conversation_that_is_cut_in_silence_breaks_the_trial_with_the_remedy(tmp_path, monkeypatch):
    broken, _ = played(tmp_path, monkeypatch, cutting(250), trials=2, p=[0])
    for trial in broken:
        assert (trial.error.boundary, trial.owed_again) == ("model", True)
        assert trial.error.message.startswith("the server read 250 tokens of a conversation of which it had read ")
        assert "to mend it, give it a larger context (Ollama: OLLAMA_CONTEXT_LENGTH" in trial.error.message
        assert len(trial.steps) > 1
    failed = [call for call in read_calls(tmp_path) if call.error]
    assert {(call.reply, call.usage.input_tokens, call.usage.output_tokens) for call in failed} == {(None, 250, 20)}
    again, _ = played(tmp_path, monkeypatch, cutting(10**6), trials=2, p=[0])
    assert [trial.ending for trial in again] == ["solved"] * 2
    assert [check.said for check in verify(tmp_path) if not check.holds] == []


def test_a_server_that_counts_what_is_new_alone_cuts_nothing(tmp_path, monkeypatch):
    def answer(request):
        new = len("".join(words(message) for message in request["messages"][-2:])) // 4
        usage = {"prompt_tokens": new, "completion_tokens": 20, "total_tokens": new + 20}
        return 200, truthful(request)[1] | {"usage": usage}

    trials, _ = played(tmp_path, monkeypatch, answer, trials=2, p=[0])
    assert [trial.ending for trial in trials] == ["solved"] * 2


OUTAGES = {
    "empty, and nobody counts": lambda: (200, completion("")[1] | {"usage": None}),
    "an error as text": lambda: completion("upstream connect error"),
    "an error object as text": lambda: completion('{"error": {"message": "overloaded", "type": "server_error"}}'),
    "words of its own": lambda: completion("Something went wrong here."),
}


@pytest.mark.parametrize("shape", OUTAGES)
def test_a_short_outage_in_any_words_loses_no_trial(tmp_path, monkeypatch, shape):
    since = []

    def answer(request):
        if len(request["messages"]) > 3 and len(since) == 0:
            since.append(time.monotonic())
        return OUTAGES[shape]() if since and time.monotonic() - since[0] < 0.5 else truthful(request)

    trials, _ = played(tmp_path, monkeypatch, answer, trials=4, pause=0.1, retries=6)
    assert [trial.ending for trial in trials] == ["solved"] * 8
    assert [check.said for check in verify(tmp_path) if not check.holds] == []


def test_where_all_trials_get_the_same_words_that_had_replies_before_it_is_the_server_that_says_so(
    tmp_path, monkeypatch
):
    def answer(request):
        return completion("Something went wrong here.") if len(request["messages"]) > 3 else truthful(request)

    broken, _ = played(tmp_path, monkeypatch, answer, trials=2)
    assert {(trial.error.boundary, trial.owed_again) for trial in broken} == {("model", True)}
    said = "all trials get the same words in the place of replies: 'Something went wrong here.'"
    assert {trial.error.message for trial in broken} == {said}
    again, _ = played(tmp_path, monkeypatch, truthful, trials=2)
    assert [trial.ending for trial in again] == ["solved"] * 4
    assert [check.said for check in verify(tmp_path) if not check.holds] == []


def test_an_honest_study_with_counted_failures_is_believed(tmp_path, monkeypatch):
    def answer(request):
        asked.append(request)
        status, body = truthful(request)
        spoilt = {
            1: {"choices": [], "error": {"message": "busy", "code": 503}},
            2: {"choices": [{"message": {"content": ""}, "finish_reason": "stop"}]},
        }
        counts = cutting(10**6)(request)[1]["usage"]
        if len(asked) % 4 == 2:
            counts |= {"completion_tokens": 0, "total_tokens": counts["prompt_tokens"]}
        return status, body | {"usage": counts} | spoilt.get(len(asked) % 4, {})

    asked = []
    trials, _ = played(tmp_path, monkeypatch, answer, trials=2, p=[0], connections=1)
    assert [trial.ending for trial in trials] == ["solved"] * 2
    assert {(call.retries, call.unanswered) for call in read_calls(tmp_path)} == {(2, 0), (0, 0)}
    assert [check.said for check in verify(tmp_path) if not check.holds] == []
