"""What a server answers, and what becomes of it: how the step ends, how often it is asked, and what is charged.

One row for each shape of an answer that a server was seen to give. Every row plays one step of a trial, with one repair
and one retry, so that a fault of the server is asked for twice, an unusable reply of the model too, and a refusal once.
"""

import asyncio
import gzip
import json
from types import SimpleNamespace

import numpy as np
import pytest
from provider_server import ASKED, Manner, completion, failure, here

from lockprobe.agents.catalogue import resolve
from lockprobe.agents.llm import client
from lockprobe.agents.llm.settings import Access
from lockprobe.agents.prompt import example
from lockprobe.foundation.errors import TrialFault

GOOD = '{"last_action": "moved", "hypothesis": "", "joint": "A"}'
SPEC = "llm:openai-api/fake/model?repairs=1"
UPSTREAM = {"code": 502, "message": "Upstream error"}
FLAGGED = {"code": 403, "message": "Flagged.", "metadata": {"reasons": ["x"]}}
UNCOUNTED = {"prompt_tokens": 0, "completion_tokens": 0, "total_tokens": 0}


class Book:
    """The calls of one trial as a study keeps them."""

    def __init__(self):
        self.asked, self.calls = [], []

    def recall(self, step, turn, request):
        return None

    async def reserve(self, call):
        self.asked.append(call)

    async def write(self, call):
        self.calls.append(call)


@pytest.fixture(scope="module")
def server():
    """One server for all rows; its answer is what each row sets."""
    with here(manner=Manner(keeps=False)) as running:
        yield running


@pytest.fixture
def step(server, monkeypatch):
    """Plays one step against a server that gives these answers, the last one again and again: how it ended and why.

    It ended as ``played``, or at the boundary of its fault; ``tokens`` and attempts that are ``lost`` are charged.
    """
    for provider in ASKED:
        monkeypatch.setenv(f"{provider}_BASE_URL", server.url)

    def play(*answers, spec=SPEC, **access):
        course = list(answers)
        server.answers = lambda request: course.pop(0) if len(course) > 1 else course[0]
        server.arrived.clear()

        async def decide():
            agent = resolve(spec, Access(**({"pause": 0, "retries": 1} | access))).make()
            try:
                return await agent.with_calls("key", book).decide(example(), np.random.default_rng(1))
            finally:
                await agent.aclose()

        book = Book()
        try:
            decision, ended, said = asyncio.run(decide()), "played", ""
        except TrialFault as fault:
            decision, ended, said = None, fault.boundary, str(fault)
        assert len({call.turn for call in book.calls}) == len(book.calls)
        for asked in book.asked:
            (call,) = (call for call in book.calls if call.turn == asked.turn)
            assert (call.retries, call.unanswered) >= (asked.retries, asked.unanswered)
        assert "private" not in repr((said, book.calls))
        tokens, lost = sum(call.usage.output_tokens for call in book.calls), sum(call.unanswered for call in book.calls)
        came = {"ended": ended, "said": said, "times": server.arrived.total(), "tokens": tokens, "lost": lost}
        return SimpleNamespace(**came, decision=decision, calls=book.calls)

    return play


def body(content=GOOD, finish="stop", message=None, choice=None, **more):
    """An answer with one choice; ``message``, ``choice`` and others add to or replace what it holds."""
    status, usual = completion("", stop=finish)
    (only,) = usual["choices"]
    only = only | {"message": only["message"] | {"content": content} | (message or {})} | (choice or {})
    return status, usual | {"choices": [only]} | more


def counted(written, reasoned=None):
    usage = {"prompt_tokens": 11, "completion_tokens": written, "total_tokens": 11 + written}
    return usage if reasoned is None else usage | {"completion_tokens_details": {"reasoning_tokens": reasoned}}


def status(code, error):
    return code, {"error": error}


FAULTS = {
    # status 200, and an error in place of the reply, beside it or inside the choice
    "an error in the choice": (body("", "error", choice={"error": UPSTREAM}), "answered 502: Upstream error", 2, 10, 0),
    "the same with text": (body('{"jo', "error", choice={"error": UPSTREAM}), "answered 502: Upstream error", 2, 10, 0),
    "an error in words": (body(choice={"error": "overloaded"}), "overloaded", 2, 10, 0),
    "an error beside the choice": (body("", "error", error=UPSTREAM), "answered 502: Upstream error", 2, 10, 0),
    "an error beside a refusal": (body(None, message={"refusal": "I cannot help."}, error=UPSTREAM), "answered 502: Upstream error", 2, 10, 0),
    "an error beside a reply": (body(error={"message": "odd"}), "odd", 2, 10, 0),
    "an error without a message": (body(choice={"message": None, "error": UPSTREAM}), "answered 502: Upstream", 2, 10, 0),
    "an error and no choice": (body(choices=[], error=UPSTREAM), "answered 502: Upstream error", 2, 10, 0),
    "an error as the reason": (body("", "error"), "an error: finish_reason error", 2, 10, 0),
    "the same uncounted": (body("", "error", usage=None), "finish_reason error", 2, 0, 0),
    "the same counted as nothing": (body("", "error", usage=UNCOUNTED), "finish_reason error", 2, 0, 0),
    "half a reply, uncounted": (body('{"jo', "error", usage=None), "finish_reason error", 2, 0, 2),
    "a reason of another kind": (body("", "insufficient_system_resource"), "finish_reason insufficient_system", 2, 10, 0),
    "the router's reason": (body("", choice={"native_finish_reason": "network_error"}), "native_finish_reason network_", 2, 10, 0),
    "no reason for nothing": (body("", None), "an empty reply that no model gives, without a reason for its end", 2, 10, 0),
    "Gemini's other": (body("", "OTHER"), "finish_reason OTHER", 2, 10, 0),
    "nothing written": (body("", usage=counted(0)), "an empty reply that no model gives, stop", 2, 0, 0),
    "errors in a list": ((200, {"success": False, "errors": [{"code": 7000, "message": "No route"}]}), "an error: No route", 2, 0, 0),
    "null": (body(None), "an empty reply that no model gives, stop", 2, 10, 0),
    "no content": (body([]), "an empty reply that no model gives, stop", 2, 10, 0),
    "no message": (body(choice={"message": None}), "an empty reply that no model gives, stop", 2, 10, 0),
    "no choice": (body(choices=[]), "no reply in its answer", 2, 10, 0),
    "null choices": (body(choices=None), "no reply in its answer", 2, 10, 0),
    "nothing at all": ((200, {"object": "chat.completion"}), "an error: no reply in its answer", 2, 0, 2),
    "no credit": ((200, {"error": {"message": "no credit left", "code": 402}}), "answered 402: no credit left", 1, 0, 0),
    "a code in words": ((200, {"error": {"message": "busy", "code": "503"}, "choices": None}), "answered 503: busy", 2, 0, 0),
    "an error as text": ((200, {"error": "still loading"}), "an error: still loading", 2, 0, 0),
    "a code of its own": ((200, {"error": {"message": "odd", "code": "model_gone"}}), "an error: odd", 2, 0, 0),
    "an object that is an error": ((200, {"object": "error", "message": "boom", "code": 500}), "answered 500: boom", 2, 0, 0),
    "a detail": ((200, {"detail": "not for you"}), "an error: not for you", 2, 0, 0),
    "no key": (body("", "error", choice={"error": {"code": 401, "message": "no key"}}), "answered 401: no key", 1, 5, 0),
    "no model": (body("", "error", choice={"error": {"code": "404", "message": "no model"}}), "answered 404: no model", 1, 5, 0),
    # what cannot be read
    "a torn body": ((200, b'{"choices": ['), "a reply that cannot be read", 2, 0, 2),
    "a body of words": ((200, b"service unavailable"), "a reply that cannot be read", 2, 0, 2),
    # statuses
    **{
        f"status {code}": (failure(code, "no\n luck"), f"the provider answered {code}: no luck", times, 0, 0)
        for code, times in {400: 1, 401: 1, 402: 1, 404: 1, 408: 2, 409: 2, 422: 1, 425: 2, 429: 2, 500: 2, 501: 2, 503: 2, 529: 2}.items()
    },
    "a status in words": ((400, b"no luck"), "the provider answered 400: no luck", 1, 0, 0),
    "a status without an error": ((500, {}), "answered 500: no error is named", 2, 0, 0),
    "a status and an empty error": ((500, {"error": {"message": ""}}), "answered 500: ", 2, 0, 0),
    "a status that refuses nothing": ((400, {"error": {}, "detail": None}), "answered 400: ", 1, 0, 0),
    "a gateway's patience": (failure(504, "gateway timeout"), "answered 504: gateway timeout", 2, 0, 2),
    "another gateway's": (failure(524, "a timeout occurred"), "answered 524: a timeout occurred", 2, 0, 2),
    # a status about the account or the request is no refusal of the conversation
    "a key that is flagged": (status(401, {"code": "invalid_api_key", "message": "Flagged."}), "answered 401: Flagged.", 1, 0, 0),
    "a country": (status(403, {"code": "unsupported_country", "message": "Your account was flagged."}), "answered 403: Your account", 1, 0, 0),
    "a form": (status(400, {"code": "invalid_request_error", "message": "response_format is not supported"}), "answered 400: response_format is not supp", 1, 0, 0),
    "a policy of data": (status(404, {"code": 404, "message": "No endpoint matches your content policy"}), "answered 404: No endpoint matches", 1, 0, 0),
    "no eyes": (status(400, {"message": "image_url is only supported by certain models."}), "answered 400: image_url is only", 1, 0, 0),
    "too long": (
        status(400, {"message": "This model's maximum context length is 10 tokens."}),
        "400: This model's maximum context length is 10 tokens.; to mend it, give it a larger context, or the trials fewer steps", 1, 0, 0,
    ),
    "too long by its code": (status(500, {"message": "No.", "code": "context_length_exceeded"}), "500: No. (context_length_exceeded); to mend it, give it a larger context", 1, 0, 0),
    # errors as text, where no trial of a model would end
    "an empty text that nobody counts": (body("", usage=None), "an empty reply that no model gives, stop", 2, 0, 2),
    "a gateway's page": (body("<html><head><title>502 Bad Gateway</title></head></html>"), "an error: <html><head>", 2, 10, 0),
    "a gateway's words": (body("upstream connect error or disconnect/reset before headers", usage=None), "an error: upstream connect", 2, 0, 2),
    "a server's words": (body("Internal Server Error"), "an error: Internal Server Error", 2, 10, 0),
    "a number and words": (body("503 Service Unavailable"), "an error: 503 Service", 2, 10, 0),
    "an error page's heading": (body("HTTP 502: Bad Gateway"), "an error: HTTP 502: Bad", 2, 10, 0),
    "a busy model": (body("The model is overloaded. Please try again later."), "an error: The model is overloaded", 2, 10, 0),
    "an error object as text": (body(json.dumps({"error": {"message": "Overloaded", "code": 529}})), "answered 529: Overloaded", 2, 10, 0),
    "an error's words as text": (body(json.dumps({"error": "overloaded"})), "an error: overloaded", 2, 10, 0),
    # what no later attempt mends is said with its remedy, and asked for once
    "no form": (status(400, {"message": "'response_format' of type json_schema is unavailable"}), "to mend it, ask for the form of the reply in words, with the option schema=none", 1, 0, 0),
    "no form, with success": (body(choices=[], error={"message": "json_schema is not supported"}), "schema=none", 1, 5, 0),
    "no grammar": (failure(500, "failed to parse grammar"), "schema=none", 1, 0, 0),
    "no such option": (status(400, {"message": "Unsupported parameter: 'temperature'"}), "to mend it, leave that option out of the spec", 1, 0, 0),
    "no such option behind a router": (failure(404, "No endpoints found that support the requested parameters"), "leave that option out", 1, 0, 0),
    "no quota": (status(429, {"message": "You are out.", "code": "insufficient_quota"}), "raise the quota or top up the account", 1, 0, 0),
    "no quota in words": (failure(429, "You exceeded your current quota, please check your plan and billing details."), "top up the account", 1, 0, 0),
    "no quota, with success": (body(choices=[], error={"message": "You are out.", "code": "insufficient_quota"}), "You are out. (insufficient_quota); to mend it, raise the quota", 1, 5, 0),
    "too much for a minute": (failure(429, "input is too long for the tokens of this minute"), "answered 429: input is too long", 2, 0, 0),
    "the quota of a minute": (failure(429, "You exceeded your current quota. Please retry in 0.4s."), "retry in 0.4s", 2, 0, 0),
    "no more today": (failure(429, "Rate limit reached for requests per day (RPD): Limit 50"), "wait until its daily limit is renewed", 1, 0, 0),
    "a key in the error": (failure(401, "Incorrect API key provided: sk-private-0123456789"), "Incorrect API key provided: [secret]", 1, 0, 0),
}  # fmt: skip
"""Faults of the server: what it answers, what is said, how often it is asked, tokens and attempts that are charged."""


@pytest.mark.parametrize("row", FAULTS)
def test_a_fault_of_the_server_breaks_the_trial_which_is_owed_again(step, row):
    answer, said, times, tokens, lost = FAULTS[row]
    came = step(answer)
    assert (came.ended, came.times, came.tokens, came.lost) == ("model", times, tokens, lost)
    assert said in came.said
    assert came.said.endswith(" (tried 2 times)") == (times == 2)
    (call,) = came.calls
    assert (call.reply, call.error, call.retries) == (None, came.said, times - 1)


BLANKS = b" " * 200_000
WIRE = {
    "a redirect": ((300, {}), "location: /v1/chat/completions", "300: it sends the conversation to /v1/chat/completions; to mend it, name that server", 0),
    "a redirect that keeps the method": ((308, {}), "location: /v1/chat/completions", "308: it sends the conversation to ", 0),
    "without end": ((200, BLANKS), "x-a: b", "with an answer of more than 100000 bytes", 1),
    "without end when it is unpacked": ((200, gzip.compress(BLANKS)), "content-encoding: gzip", "with an answer of more than 100000 bytes", 1),
    "packed as nobody asked": ((200, b"x"), "content-encoding: br", "with an answer compressed with br, which was not requested", 1),
}  # fmt: skip


@pytest.mark.parametrize("row", WIRE)
def test_a_conversation_is_sent_nowhere_else_and_no_answer_without_bounds_is_taken(step, server, monkeypatch, row):
    answer, header, said, lost = WIRE[row]
    monkeypatch.setattr(client, "LARGEST_ANSWER", 100_000)
    monkeypatch.setattr(server, "manner", Manner(keeps=False, more=(header,)))
    came = step(answer)
    assert (came.ended, came.times, came.lost) == ("model", 1, lost)
    assert came.said.startswith(f"the provider answered {said}")


REFUSALS = {
    "the field": (body(None, message={"refusal": "I cannot help."}), "I cannot help."),
    "the field beside nothing": (body("", message={"refusal": "I cannot help."}), "I cannot help."),
    "a part": (body([{"type": "refusal", "refusal": "I cannot help."}]), "I cannot help."),
    "a filter": (body("", "content_filter"), "finish_reason content_filter"),
    "a filter and null": (body(None, "content_filter"), "finish_reason content_filter"),
    "a filter in mid-sentence": (body('{"jo', "content_filter"), "finish_reason content_filter, after '{\"jo'"),
    "Claude's": (body("", choice={"native_finish_reason": "refusal"}), "native_finish_reason refusal"),
    "an error that refuses": (body(choices=[], error={"code": "content_filter", "message": "Filtered."}), "Filtered."),
    "the same as text": (body(json.dumps({"error": {"code": "content_filter", "message": "Filtered."}})), "Filtered."),
    "a moderation": (body(choices=[], error=FLAGGED), "Flagged."),
    "a router's moderation": (status(403, FLAGGED), "Flagged."),
    "an inspection": (status(400, {"code": "data_inspection_failed", "message": "Not this."}), "Not this."),
    "a risk in words": (status(400, {"code": "invalid_request_error", "message": "Content Exists Risk"}), "Content Exists Risk"),
    "a prompt that is flagged": (body(choices=[], error={"code": "invalid_prompt", "message": "Flagged."}), "Flagged."),
    "a status that refuses": (status(400, {"code": "content_filter", "message": "Filtered."}), "Filtered."),
    "Gemini's through OpenAI's interface": (body(None, "content_filter: SAFETY"), "finish_reason content_filter: SAFETY"),
    **{
        reason: (body(None, reason), f"finish_reason {reason}")
        for reason in ("refusal", "SAFETY", "RECITATION", "PROHIBITED_CONTENT", "BLOCKLIST", "SPII", "sensitive", "guardrail_intervened")
    },
}  # fmt: skip


@pytest.mark.parametrize("row", REFUSALS)
def test_a_refusal_is_one_reply_in_the_words_of_the_provider_and_ends_the_trial(step, row):
    answer, said = REFUSALS[row]
    came = step(answer)
    assert (came.ended, came.said, came.times, came.lost) == ("refusal", f"refused: {said}", 1, 0)
    (call,) = came.calls
    assert (call.reply, call.stop, call.error) == (said, "content_filter", "")


CUT = " (the reply was cut off after {}: a larger max_tokens than 900 leaves it more room)"
UNUSABLE = {
    "no object": (body("no"), 2, "not one JSON object", 10),
    "another form": (body('{"move": "A"}'), 2, "last_action: Field required", 10),
    "no joint": (body('{"last_action": "moved", "hypothesis": ""}'), 2, "joint: Field required", 10),
    "empty": (body(""), 2, "an empty reply (after 5 tokens)", 10),
    "empty after thoughts": (body(None, message={"reasoning_content": "Hm"}), 2, "an empty reply (after 5 tokens, some of them of reasoning)", 10),
    "the same by another name": (body(None, message={"reasoning": "Hm"}), 2, "an empty reply (after 5 tokens, some of them of reasoning)", 10),
    "thoughts in the text alone": (body("<think>Hm.</think>"), 2, "(after 5 tokens, some of them of reasoning)", 10),
    "thoughts that are counted": (body("", usage=counted(900, 900)), 2, "an empty reply (after 900 tokens, 900 of them of reasoning)", 1800),
    "thoughts and null": (body(None, usage=counted(9, 9)), 2, "an empty reply (after 9 tokens, 9 of them of reasoning)", 18),
    "a tool": (body(None, "tool_calls", message={"tool_calls": [{"id": "c", "type": "function", "function": {"name": "reply", "arguments": "{}"}}]}), 2, "an empty reply (it called a tool, and there is none)", 10),
    "cut off": (body('{"jo', "length"), 2, "a JSON object that does not end" + CUT.format("5 tokens"), 10),
    "cut off by another name": (body('{"jo', "MAX_TOKENS"), 2, "a JSON object that does not end" + CUT.format("5 tokens"), 10),
    "cut off before it began": (body("", "length", usage=counted(900, 900)), 1, "an empty reply" + CUT.format("900 tokens, 900 of them of reasoning"), 900),
    "the object in the thoughts": (body("", message={"reasoning_content": f"So {GOOD}"}), 1, "an empty reply (the object stands in the reasoning and not in the reply: schema=none asks for it in words)", 5),
    "an object in the thoughts beside other words": (body("no", message={"reasoning_content": f"So {GOOD}"}), 2, "not one JSON object", 10),
    "its fields in the thoughts": (body("", "length", message={"reasoning": 'I need "last_action", "hypothesis" and "joint", as in {"joint"'}), 1, "an empty reply" + CUT.format("5 tokens, some of them of reasoning"), 5),
    "the same, cut off": (body(None, "length", message={"reasoning": GOOD}), 1, "(the object stands in the reasoning and not in the reply: schema=none asks for it in words)", 5),
    "white space to the end": (body("\n \t", "length"), 1, "an empty reply (white space up to the limit, which the schema allows: schema=none asks for the form in words)", 5),
    "white space after its beginning": (body('{"joint": "A",' + "\n" * 100, "length"), 1, "(white space up to the limit, which the schema allows: schema=none asks for the form in words)", 5),
    "cut off in mid-thought": (body("<think>Hm", "length", usage=counted(900)), 1, "reasoning without a reply after it" + CUT.format("900 tokens"), 900),
    "cut off and null": (body(None, "length"), 1, "an empty reply" + CUT.format("5 tokens"), 5),
    "cut off and empty": (body("", "max_tokens"), 1, "an empty reply" + CUT.format("5 tokens"), 5),
}  # fmt: skip
"""Replies that cannot be used: what is answered, after how many turns the trial ends, and why."""


@pytest.mark.parametrize("row", UNUSABLE)
def test_an_unusable_reply_is_asked_for_again_while_that_can_help_and_ends_the_trial_for_good(step, row):
    answer, turns, why, tokens = UNUSABLE[row]
    came = step(answer, spec=f"{SPEC}&max_tokens=900")
    assert (came.ended, came.times, came.tokens, came.lost) == ("reply", turns, tokens, 0)
    assert came.said.startswith(f"no usable reply in {turns} turn{'s' * (turns > 1)}: ")
    assert came.said.endswith(why)
    assert all(call.reply is not None for call in came.calls)
    assert [call.turn for call in came.calls] == [*range(1, turns + 1)]


HALVES = [GOOD[:9], GOOD[9:]]
PLAYED = {
    "a text": body(),
    "a part": body([{"type": "text", "text": GOOD}]),
    "parts without a break": body([{"type": "text", "text": HALVES[0]}, {"type": "output_text", "text": HALVES[1]}]),
    "parts that are texts": body(HALVES),
    "a part without a kind": body([{"text": GOOD}]),
    "one part alone": body({"type": "text", "text": GOOD}),
    "after thoughts": body([{"type": "thinking", "thinking": [{"type": "text", "text": "Hm"}]}, {"type": "text", "text": GOOD}]),
    "parts of other kinds": body([{"type": "image", "url": "x"}, {"type": "text", "text": GOOD}]),
    "the object itself": body(json.loads(GOOD)),
    "no error": body(error=None),
    "an empty error": body(error={}),
    "an error of nothing": body(error={"code": None, "message": ""}),
    "no error in the choice": body(choice={"error": None}),
    "a router's stop": body(choice={"native_finish_reason": "STOP"}),
    "no reason": body(finish=None),
    "another reason": body(finish="eos_token"),
    "Gemini's other, and a reply": body(finish="OTHER"),
    **{f"refusal {refusal!r}": body(message={"refusal": refusal}) for refusal in (None, "", False)},
    "no usage": body(usage=None),
    "usage in words": body(usage={"prompt_tokens": "private", "completion_tokens": 1, "total_tokens": 1}),
    "usage below nothing": body(usage={"prompt_tokens": -5, "completion_tokens": -1, "total_tokens": -6}),
    "usage beyond all": body(usage={"prompt_tokens": 10**30, "completion_tokens": 10**400, "total_tokens": 1}),
    "an impossible cache": body(usage=counted(5) | {"prompt_tokens_details": {"cached_tokens": 10**6}}),
    "half of a character": body(GOOD.replace('"hypothesis": ""', '"hypothesis": "it\\ud83d opens"')),
    "a model that speaks of an error": body(GOOD.replace('"hypothesis": ""', '"hypothesis": "an \\"error\\": 503"')),
    "thoughts before it": body(f"Hm\n</think>\n{GOOD}"),
    "a channel": body(f"<|channel|>final<|message|>{GOOD}<|return|>"),
}  # fmt: skip


@pytest.mark.parametrize("row", PLAYED)
def test_content_of_any_form_is_played_and_what_is_no_error_leaves_it_alone(step, row, capfd):
    came = step(PLAYED[row])
    assert (came.ended, came.times, came.lost) == ("played", 1, 0), came.said
    assert (came.decision.joint, came.decision.claimed, came.decision.usage.calls) == ("A", "moved", 1)
    assert came.tokens == (0 if "usage" in row or "cache" in row else 5)
    assert came.calls[0].reasoned == (row == "after thoughts")  # apart from the text
    assert "private" not in "".join(capfd.readouterr())


@pytest.mark.parametrize(
    ("course", "tokens", "lost", "retries"),
    [
        ([body("", "error"), body(None), body()], 15, 0, 2),
        ([failure(500, "no"), (200, b"{"), failure(504, "no"), body()], 5, 2, 3),
        ([body('{"jo', "error", usage=None), body("", "error"), body(usage=None)], 5, 2, 2),
        ([failure(429, "no"), body("no"), body()], 10, 0, 1),
    ],
)
def test_what_failed_attempts_cost_is_in_the_account_of_the_call(step, course, tokens, lost, retries):
    came = step(*course, retries=5)
    assert (came.ended, came.tokens, came.lost) == ("played", tokens, lost)
    assert (came.times, sum(call.retries for call in came.calls)) == (len(course), retries)


@pytest.mark.parametrize(
    ("more", "served"),
    [
        ({}, "fake"),
        ({"system_fingerprint": "fp_1"}, "fake, fp_1"),
        ({"provider": "DeepInfra", "system_fingerprint": "fp_1"}, "fake by DeepInfra, fp_1"),
        ({"model": None, "provider": 7, "system_fingerprint": "\x1b[31m"}, "?[31m"),
    ],
)
def test_who_served_a_reply_is_kept_with_its_call(step, more, served):
    came = step(body(**more))
    assert (came.decision.served, came.calls[0].served) == (served, served)


def said(content, stop="end_turn", usage=(7, 3, 1, 5), **more):
    """An answer of Anthropic's: tokens read anew, read from the cache, put there, and written."""
    names = ("input_tokens", "cache_read_input_tokens", "cache_creation_input_tokens", "output_tokens")
    counts = dict(zip(names, usage, strict=True)) if usage else None
    parts = [{"type": "text", "text": content}] if isinstance(content, str) else content
    usual = {"type": "message", "role": "assistant", "model": "claude", "stop_reason": stop}
    return 200, usual | {"content": parts, "usage": counts} | more


def anthropic(code, kind, words):
    return code, {"type": "error", "error": {"type": kind, "message": words}}


THOUGHT = {"type": "thinking", "thinking": "Hm", "signature": "x"}
CYBER = {"type": "refusal", "category": "cyber", "explanation": "It looks like a break-in."}
MESSAGES = {
    "a text": (said(GOOD), "played", "", 1, 5, 0),
    "after thoughts": (said([THOUGHT, {"type": "text", "text": GOOD}]), "played", "", 1, 5, 0),
    "in chunks": (said([{"type": "text", "text": half} for half in HALVES]), "played", "", 1, 5, 0),
    "uncounted": (said(GOOD, usage=None), "played", "", 1, 0, 0),
    "counted in words": (said(GOOD, usage=(7, "3", 1, 5)), "played", "", 1, 0, 0),
    "thoughts alone": (said([THOUGHT]), "reply", "an empty reply (after 5 tokens, some of them of reasoning)", 2, 10, 0),
    "cut off": (said('{"jo', "max_tokens"), "reply", "a JSON object that does not end (the reply was cut off after 5", 2, 10, 0),
    "a refusal": (said([], "refusal", stop_details=CYBER), "refusal", "refused: cyber: It looks like a break-in.", 1, 5, 0),
    "a refusal in silence": (said([], "refusal"), "refusal", "refused: finish_reason refusal", 1, 5, 0),
    "no content": (said([]), "model", "an empty reply that no model gives, end_turn", 2, 10, 0),
    "a pause": (said("Hm", "pause_turn"), "model", "finish_reason interrupted", 2, 10, 0),
    "no room": (said('{"jo', "model_context_window_exceeded"), "model", "finish_reason model_context_window_exceeded; to mend it, give it a larger context", 1, 5, 0),
    "too long": (anthropic(400, "invalid_request_error", "prompt is too long: 9 tokens > 8 maximum"), "model", "prompt is too long: 9 tokens > 8 maximum; to mend it, give it a larger context", 1, 0, 0),
    "overloaded": (anthropic(529, "overloaded_error", "Overloaded"), "model", "the provider answered 529: Overloaded", 2, 0, 0),
    "too many": (anthropic(429, "rate_limit_error", "Slower"), "model", "the provider answered 429: Slower", 2, 0, 0),
    "broken": (anthropic(500, "api_error", "Internal server error"), "model", "answered 500: Internal server error", 2, 0, 0),
    "a wrong key": (anthropic(401, "authentication_error", "invalid x-api-key"), "model", "answered 401: invalid x-api-key", 1, 0, 0),
    "no credit": (anthropic(400, "invalid_request_error", "Your credit balance is too low"), "model", "top up the account", 1, 0, 0),
    "an error with success": (anthropic(200, "overloaded_error", "Overloaded"), "model", "answered with an error: Overloaded", 2, 0, 0),
}  # fmt: skip
"""What Anthropic's interface answers, where the step ends, what is said, how often it is asked, tokens, attempts."""


@pytest.mark.parametrize("row", MESSAGES)
def test_the_same_is_understood_of_anthropic(step, row):
    answer, ended, words, times, tokens, lost = MESSAGES[row]
    came = step(answer, spec="llm:anthropic/claude-opus-5?repairs=1&max_tokens=900")
    assert (came.ended, came.times, came.tokens, came.lost) == (ended, times, tokens, lost), came.said
    assert words in came.said
    if row == "a text":
        usage = came.decision.usage
        assert (usage.input_tokens, usage.cached_tokens, usage.stored_tokens) == (11, 3, 1)


@pytest.mark.parametrize("spec", ["llm:openai/gpt-4o?repairs=1", "llm:openrouter/a/b?repairs=1"])
def test_whoever_is_asked_the_same_shapes_mean_the_same(step, spec):
    kinds = {"model": FAULTS, "refusal": REFUSALS, "reply": UNUSABLE}
    for ended, table in kinds.items():
        for row in list(table)[:: len(table) // 5]:
            assert step(table[row][0], spec=spec).ended == ended, row
    assert step(PLAYED["after thoughts"], spec=spec).decision.joint == "A"
