"""Every shape of an answer is a reply, a refusal or a fault of the provider, whichever provider's class reads it."""

import asyncio
import json
import os
from itertools import cycle

import pytest
from provider_server import Manner, completion, here

from lockprobe.agents.llm.settings import ModelSettings
from lockprobe.agents.model_access import Access
from lockprobe.agents.prompt import REFUSED, Message
from lockprobe.foundation.errors import ModelFault

lines = pytest.importorskip("lockprobe.agents.llm.client")
answers = pytest.importorskip("lockprobe.agents.llm.openai_answers")

PROVIDERS = ("openai-api/fake/model", "openai/gpt-4o", "openrouter/a/b")
ERROR = {"code": 502, "message": "Upstream error"}


def read_by_classes(table):
    """Every case with a provider, in turn; what has a status of its own with all: their classes look at those first."""
    turn = cycle(PROVIDERS)
    return [
        pytest.param(*case, model, id=f"{name}-{model}")
        for name, case in table.items()
        for model in (PROVIDERS if case[0][0] != 200 else [next(turn)])
    ]


@pytest.fixture(autouse=True)
def own_environment(monkeypatch):
    for name in os.environ:
        if name.endswith(("_API_KEY", "_BASE_URL")):
            monkeypatch.delenv(name)


def body(content="", finish="stop", message=None, choice=None, **more):
    """An answer with one choice; ``message``, ``choice`` and others add to or replace what it holds."""
    status, usual = completion("", stop=finish)
    (only,) = usual["choices"]
    only = only | {"message": only["message"] | {"content": content} | (message or {})} | (choice or {})
    return status, usual | {"choices": [only]} | more


def asked(monkeypatch, answer, model=PROVIDERS[0], **access):
    """What came of one request, and how often it was made."""
    with here(lambda request: answer, Manner(keeps=False)) as server:
        for provider in ("FAKE", "OPENAI", "OPENROUTER"):
            monkeypatch.setenv(f"{provider}_BASE_URL", server.url)
            monkeypatch.setenv(f"{provider}_API_KEY", "sk-private-0123456789")

        async def ask():
            line = lines.ModelClient(model, ModelSettings(), Access(**({"pause": 0, "retries": 1} | access)))
            try:
                return await line.ask([Message(role="user", text="joints: A, B")], {"type": "object"})
            except ModelFault as fault:
                return fault
            finally:
                await line.aclose()

        return asyncio.run(ask()), server.arrived.total()


FAULTS = {
    "an error in the choice": (body(finish="error", choice={"error": ERROR}), "answered 502: Upstream error"),
    "the same with text": (body('{"jo', finish="error", choice={"error": ERROR}), "answered 502: Upstream error"),
    "an error in words": (body(choice={"error": "overloaded"}), "overloaded"),
    "an error beside the choice": (body(finish="error", error=ERROR), "answered 502: Upstream error"),
    "an error beside a reply": (body("a reply", error={"message": "odd"}), "odd"),
    "an error without a message": (body(choice={"message": None, "error": ERROR}), "answered 502: Upstream error"),
    "an error and no choice": (body(choices=[], error=ERROR), "answered 502: Upstream error"),
    "an error as the reason": (body(finish="error"), "finish_reason error"),
    "a reason of another kind": (body(finish="insufficient_system_resource"), "finish_reason insufficient_system"),
    "the router's reason": (
        body(choice={"native_finish_reason": "network_error"}),
        "native_finish_reason network_error",
    ),
    "no reason for nothing": (body(finish=None), "an empty reply without a reason for its end"),
    "Gemini's other": (body(finish="OTHER"), "finish_reason OTHER"),
    "nothing written": (
        body("", usage={"prompt_tokens": 11, "completion_tokens": 0, "total_tokens": 11}),
        "an empty reply of 0 tokens, stop",
    ),
    "errors in a list": ((200, {"success": False, "errors": [{"code": 7000, "message": "No route"}]}), "No route"),
    "null": (body(None), "a reply without content (null), stop"),
    "no content": (body([]), "a reply without content (null), stop"),
    "no message": (body(choice={"message": None}), "a reply without content (null), stop"),
    "no choice": (body(choices=[]), "no reply in its answer"),
    "null choices": (body(choices=None), "no reply in its answer"),
}


@pytest.mark.parametrize(("answer", "said", "model"), read_by_classes(FAULTS))
def test_a_fault_of_the_provider_is_asked_again_and_said_in_its_words(monkeypatch, answer, said, model):
    fault, times = asked(monkeypatch, answer, model)
    assert isinstance(fault, ModelFault), fault
    assert said in str(fault)
    assert times == 2


@pytest.mark.parametrize("error", [{"code": 401, "message": "no key"}, {"code": "404", "message": "no model"}])
def test_an_error_that_does_not_pass_is_not_asked_again(monkeypatch, error):
    fault, times = asked(monkeypatch, body(finish="error", choice={"error": error}))
    assert str(fault) == f"the provider answered {error['code']}: {error['message']}"
    assert times == 1


@pytest.mark.parametrize("model", PROVIDERS)
@pytest.mark.parametrize(
    ("status", "error"),
    [
        (401, {"code": "invalid_api_key", "message": "Flagged."}),
        (403, {"code": "unsupported_country", "message": "Your account was flagged."}),
        (400, {"code": "invalid_request_error", "message": "response_format is not supported"}),
        (404, {"code": 404, "message": "No endpoint matches your content policy"}),
    ],
)
def test_a_status_about_the_account_or_the_request_is_no_refusal(monkeypatch, status, error, model):
    fault, times = asked(monkeypatch, (status, {"error": error}), model)
    assert str(fault) == f"the provider answered {status}: {error['message']}"
    assert times == 1


REFUSALS = {
    "the field": (body(None, message={"refusal": "I cannot help."}), "I cannot help."),
    "the field beside nothing": (body("", message={"refusal": "I cannot help."}), "I cannot help."),
    "a part": (body([{"type": "refusal", "refusal": "I cannot help."}]), "I cannot help."),
    "a filter": (body(finish="content_filter"), "finish_reason content_filter"),
    "a filter and null": (body(None, finish="content_filter"), "finish_reason content_filter"),
    "a filter in mid-sentence": (body('{"jo', finish="content_filter"), "finish_reason content_filter, after '{\"jo'"),
    "Claude's": (body(choice={"native_finish_reason": "refusal"}), "native_finish_reason refusal"),
    "an error that refuses": (body(choices=[], error={"code": "content_filter", "message": "Filtered."}), "Filtered."),
    "a moderation": (body(choices=[], error={"code": 403, "message": "Flagged.", "metadata": {"reasons": ["x"]}}), "Flagged."),
    "a router's moderation": ((403, {"error": {"code": 403, "message": "Flagged.", "metadata": {"reasons": ["x"]}}}), "Flagged."),
    "an inspection": ((400, {"error": {"code": "data_inspection_failed", "message": "Not this."}}), "Not this."),
    "a risk in words": ((400, {"error": {"code": "invalid_request_error", "message": "Content Exists Risk"}}), "Content Exists Risk"),
    "a prompt that is flagged": (body(choices=[], error={"code": "invalid_prompt", "message": "Flagged."}), "Flagged."),
    "a status that refuses": ((400, {"error": {"code": "content_filter", "message": "Filtered."}}), "Filtered."),
    **{
        reason: (body(None, finish=reason), f"finish_reason {reason}")
        for reason in ("refusal", "SAFETY", "RECITATION", "PROHIBITED_CONTENT", "BLOCKLIST", "SPII", "sensitive")
    },
    "Gemini's through OpenAI's interface": (body(None, finish="content_filter: SAFETY"), "finish_reason content_filter: SAFETY"),
}  # fmt: skip


@pytest.mark.parametrize(("answer", "said", "model"), read_by_classes(REFUSALS))
def test_a_refusal_is_one_reply_with_the_words_of_the_refusal(monkeypatch, answer, said, model):
    reply, times = asked(monkeypatch, answer, model)
    assert (reply.text, reply.stop, times) == (said, REFUSED, 1)


REPLIES = {
    "text": "a reply",
    "a part": [{"type": "text", "text": "a reply"}],
    "parts without a break": [{"type": "text", "text": "a r"}, {"type": "output_text", "text": "eply"}],
    "parts that are texts": ["a r", "eply"],
    "a part without a kind": [{"text": "a reply"}],
    "one part alone": {"type": "text", "text": "a reply"},
    "after thoughts": [{"type": "thinking", "thinking": [{"type": "text", "text": "Hm"}]}, {"type": "text", "text": "a reply"}],
    "parts of other kinds": [{"type": "image", "url": "x"}, {"type": "text", "text": "a reply"}],
}  # fmt: skip


@pytest.mark.parametrize(("answer", "model"), read_by_classes({name: (body(said),) for name, said in REPLIES.items()}))
def test_content_of_any_form_is_one_text(monkeypatch, answer, model):
    reply, times = asked(monkeypatch, answer, model)
    assert (reply.text, reply.stop, reply.unanswered, times) == ("a reply", "stop", 0, 1)


def test_content_that_is_the_object_itself_is_its_text(monkeypatch):
    reply, _ = asked(monkeypatch, body({"last_action": "moved", "joint": "A"}))
    assert json.loads(reply.text) == {"last_action": "moved", "joint": "A"}


HARMLESS = [
    {"error": None},
    {"error": {}},
    {"error": {"code": None, "message": ""}},
    {"choice": {"error": None}},
    {"choice": {"native_finish_reason": "STOP"}},
    {"finish": None},
    {"finish": "eos_token"},
    *({"message": {"refusal": refusal}} for refusal in (None, "", False)),
    {"usage": None},
]


@pytest.mark.parametrize(
    ("answer", "model"), read_by_classes({str(more): (body("a reply", **more),) for more in HARMLESS})
)
def test_what_is_no_error_and_no_refusal_leaves_a_reply_alone(monkeypatch, answer, model):
    reply, times = asked(monkeypatch, answer, model)
    assert (reply.text, times) == ("a reply", 1)
    assert reply.stop in ("stop", "unknown")


@pytest.mark.parametrize(("content", "finish"), [(None, "length"), ("", "max_tokens"), ('{"jo', "MAX_TOKENS")])
def test_a_reply_that_reached_its_limit_is_one_also_if_it_is_empty(monkeypatch, content, finish):
    reply, times = asked(monkeypatch, body(content, finish=finish))
    assert (reply.text, reply.stop, times) == (content or "", "max_tokens", 1)


@pytest.mark.parametrize("more", [{"message": {"reasoning_content": "Hm"}}, {"message": {"reasoning": "Hm"}}, {"usage": {
    "prompt_tokens": 1, "completion_tokens": 9, "total_tokens": 10, "completion_tokens_details": {"reasoning_tokens": 9}
}}])  # fmt: skip
def test_nothing_after_reasoning_is_an_empty_reply(monkeypatch, more):
    reply, times = asked(monkeypatch, body(None, **more))
    assert (reply.text, reply.stop, times) == ("", "stop", 1)


COUNTED = {"prompt_tokens": 11, "completion_tokens": 5, "total_tokens": 16}
NOT_COUNTED = {"prompt_tokens": 0, "completion_tokens": 0, "total_tokens": 0}


@pytest.mark.parametrize(
    ("content", "usage", "tokens", "unanswered"),
    [("", COUNTED, 10, 0), ("", None, 0, 0), ("", NOT_COUNTED, 0, 0), ('{"jo', COUNTED, 10, 0), ('{"jo', None, 0, 2)],
)
def test_what_a_provider_counts_for_a_fault_is_kept_and_what_it_may_have_charged_too(
    monkeypatch, content, usage, tokens, unanswered
):
    fault, _ = asked(monkeypatch, body(content, finish="error", usage=usage))
    assert (fault.usage.get("output_tokens", 0), fault.unanswered) == (tokens, unanswered)


def test_what_failed_attempts_cost_is_in_the_cost_of_the_reply_that_came_in_the_end(monkeypatch):
    course = [body(finish="error"), body(None), body("a reply")]
    with here(lambda request: course.pop(0), Manner(keeps=False)) as server:
        monkeypatch.setenv("FAKE_BASE_URL", server.url)
        monkeypatch.setenv("FAKE_API_KEY", "k")

        async def ask():
            line = lines.ModelClient(PROVIDERS[0], ModelSettings(), Access(pause=0))
            try:
                return await line.ask([Message(role="user", text="joints: A, B")], {"type": "object"})
            finally:
                await line.aclose()

        reply = asyncio.run(ask())
    assert (reply.usage.calls, reply.usage.input_tokens, reply.usage.output_tokens) == (1, 33, 15)
    assert (reply.retries, reply.unanswered) == (2, 0)


def said_in_responses(monkeypatch, output, status="completed", **more):
    usual = {"id": "x", "object": "response", "created_at": 1, "model": "fake", "parallel_tool_calls": True}
    usage = {
        "input_tokens": 11,
        "output_tokens": 5,
        "total_tokens": 16,
        "output_tokens_details": {"reasoning_tokens": 5},
    }
    answer = usual | {"tools": [], "tool_choice": "auto", "status": status, "output": output, "usage": usage} | more
    return asked(monkeypatch, (200, answer), "openai/o3")


def message(*texts, kind="output_text"):
    key = "refusal" if kind == "refusal" else "text"
    parts = [{"type": kind, key: text, "annotations": []} for text in texts]
    return {"type": "message", "id": "y", "role": "assistant", "status": "completed", "content": parts}


REASONING = {"type": "reasoning", "id": "r", "summary": []}


@pytest.mark.parametrize(
    ("output", "more", "text", "stop"),
    [
        ([REASONING, message("a r", "eply")], {}, "a reply", "stop"),
        ([message("I cannot help.", kind="refusal")], {}, "I cannot help.", REFUSED),
        ([], {"status": "incomplete", "incomplete_details": {"reason": "content_filter"}}, REFUSED, REFUSED),
        (
            [REASONING],
            {"status": "incomplete", "incomplete_details": {"reason": "max_output_tokens"}},
            "",
            "max_tokens",
        ),
        ([REASONING], {}, "", "stop"),
    ],
)
def test_the_newer_interface_says_the_same(monkeypatch, output, more, text, stop):
    reply, times = said_in_responses(monkeypatch, output, **more)
    assert (reply.text, reply.stop, times) == (text, stop, 1)


@pytest.mark.parametrize(
    ("output", "more"),
    [
        ([], {}),
        ([message()], {}),
        ([message("")], {"usage": {"input_tokens": 11, "output_tokens": 0, "total_tokens": 11}}),
        ([], {"status": "queued"}),
        ([message("a r")], {"status": "in_progress"}),
        ([message("a r")], {"status": "incomplete"}),
        ([], {"status": "failed"}),
        ([message("a r")], {"status": "cancelled"}),
        ([message("a r")], {"status": "failed", "error": {"code": "server_error", "message": "Upstream error"}}),
    ],
)
def test_the_newer_interface_has_the_same_faults(monkeypatch, output, more):
    fault, times = said_in_responses(monkeypatch, output, **more)
    assert (type(fault), times) == (ModelFault, 2)


def test_a_client_is_changed_once_and_what_is_streamed_is_left_alone():
    openai = pytest.importorskip("openai")

    async def changed():
        client = openai.AsyncOpenAI(api_key="k", base_url="http://here/v1")

        async def usual(**request):
            return openai.types.chat.ChatCompletion.model_construct(choices=[], usage=None)

        client.chat.completions.create = usual
        answers.check_answers(client)
        create = client.chat.completions.create
        answers.check_answers(client)
        assert client.chat.completions.create is create
        with pytest.raises(answers.Declined):
            await create()
        assert (await create(stream=True)).choices == []
        await client.close()

    asyncio.run(changed())


@pytest.mark.parametrize("client", [None, object()])
def test_other_clients_are_left_alone(client):
    answers.check_answers(client)
