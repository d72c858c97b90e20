"""What Inspect AI makes of an answer is told apart too, for providers that are asked through other clients."""

import pytest

from lockprobe.agents.prompt import REFUSED

answer = pytest.importorskip("lockprobe.agents.llm.answer")

from inspect_ai.model import (  # noqa: E402
    ChatCompletionChoice,
    ChatMessageAssistant,
    ContentReasoning,
    ContentText,
    ModelOutput,
    ModelUsage,
    StopCategory,
    StopDetails,
)

HARM = StopDetails(type="SAFETY", categories=[StopCategory(category="DANGEROUS_CONTENT", level="HIGH")])
CYBER = StopDetails(
    type="refusal", explanation="It looks like a break-in.", categories=[StopCategory(category="cyber")]
)
BLOCKED = StopDetails(type="PROHIBITED_CONTENT", explanation="Blocked: PROHIBITED_CONTENT")


def output(content="", stop="stop", details=None, usage=(11, 5), error=None):
    """An output of one choice."""
    message = ChatMessageAssistant(content=content)
    choice = ChatCompletionChoice(message=message, stop_reason=stop, stop_details=details)
    counted = usage and ModelUsage(input_tokens=usage[0], output_tokens=usage[1], total_tokens=sum(usage))
    return ModelOutput(model="m", choices=[choice], usage=counted, error=error)


def test_chunks_of_a_text_are_joined_without_a_break_and_reasoning_is_left_out():
    parts = [ContentReasoning(reasoning="Hm"), ContentText(text='{"jo'), ContentText(text='int": "A"}')]
    assert answer.said_in(output(parts)) == ('{"joint": "A"}', "stop")


@pytest.mark.parametrize(
    ("came", "body", "words"),
    [
        (output(stop=REFUSED), {"stop_reason": "refusal"}, "stop_reason refusal"),
        (output(stop=REFUSED), {"candidates": [{"finishReason": "SPII"}]}, "finishReason SPII"),
        (output(stop=REFUSED), {"candidates": [{"finish_reason": "FinishReason.SPII"}]}, "finish_reason SPII"),
        (
            output(stop=REFUSED),
            {"candidates": [{"finishReason": "SPII", "finishMessage": "No."}]},
            "finishReason SPII, No.",
        ),
        (output("Sorry.", stop="unknown"), {"stopReason": "guardrail_intervened"}, "stopReason guardrail_intervened"),
        (output(stop=REFUSED), None, REFUSED),
        (output(stop=REFUSED, details=HARM), None, "SAFETY, DANGEROUS_CONTENT HIGH"),
        (output(stop=REFUSED, details=CYBER), None, "cyber: It looks like a break-in."),
        (output("BLOCKED: x", stop=REFUSED, details=BLOCKED), None, "PROHIBITED_CONTENT: Blocked: PROHIBITED_CONTENT"),
        (output("Sorry.", stop=REFUSED, error="blocked by content filtering"), None, "blocked by content filtering"),
        (output([ContentText(text="I cannot help.", refusal=True)]), None, "I cannot help."),
    ],
)
def test_a_refusal_is_in_the_words_of_the_provider(came, body, words):
    assert answer.said_in(came, body) == (words, REFUSED)


@pytest.mark.parametrize(
    ("came", "body"),
    [
        (output(stop="unknown"), {"candidates": [{"finishReason": "OTHER"}]}),
        (output([], stop="unknown"), None),
        (output("(no content)"), None),
        (output("\nI seem to have had trouble calling a function and replied with x.", stop="unknown"), None),
        (output(), {"candidates": [{"finishReason": "STOP", "content": None}]}),
        (output('{"jo', stop="unknown"), {"candidates": [{"finishReason": "MALFORMED_RESPONSE", "content": {}}]}),
        (ModelOutput(model="m", usage=output().usage), None),
    ],
)
def test_an_answer_without_a_reply_is_a_fault_that_is_asked_again_and_keeps_its_cost(came, body):
    with pytest.raises(answer.Declined) as fault:
        answer.said_in(came, body)
    assert fault.value.retry
    assert (fault.value.charged, fault.value.usage.calls, fault.value.usage.output_tokens) == (True, 0, 5)
    if isinstance(body, dict):
        assert body["candidates"][0]["finishReason"] in str(fault.value)


@pytest.mark.parametrize(
    ("came", "said"),
    [
        (output("a reply", stop="unknown"), ("a reply", "unknown")),
        (output([], stop="stop"), ("", "stop")),
        (output("", stop="max_tokens"), ("", "max_tokens")),
        (output("", stop="tool_calls"), ("", "tool_calls")),
    ],
)
def test_everything_else_is_a_reply(came, said):
    assert answer.said_in(came) == said


def test_reasons_of_all_kinds_are_known():
    refusals = ["content_filter", "SAFETY", "guardrail_intervened", "sensitive", "ERROR_TOXIC", "content_filtered"]
    faults = ["error", "network_error", "abort", "cancelled", "timeout", "MALFORMED_RESPONSE", "engine_overloaded"]
    replies = ["stop", "end_turn", "eos_token", "COMPLETE", "length", "MAX_TOKENS", "tool_calls", "stop_sequence"]
    for kind, reasons in (("refusal", refusals), ("fault", faults), ("reply", replies)):
        assert {answer.kind_of_stop(reason, empty=empty) for reason in reasons for empty in (False, True)} == {kind}
