"""When a model is asked again for a decision: its reply was malformed.

A refusal ends the trial. So does a reply that the limit cut off for the second time, or before it had begun: the same
limit would cut off the next one too. So does one whose object stands in the reasoning, or that is white space up to the
limit: only another form would help. Other replies that cannot be used are asked for again, after a pause like that
after a fault: some servers write their errors as if the model had said them.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import asdict, replace

from lockprobe.agents.llm.answer import CUT_OFF, IN_REASONING
from lockprobe.agents.llm.settings import Model
from lockprobe.agents.prompt import Message, conversation, repair, reply_schema
from lockprobe.agents.reply import asked_for, parse_reply, spoken, without_marks
from lockprobe.foundation.errors import RefusalFault, ReplyFault
from lockprobe.foundation.formatting import count
from lockprobe.trial.model_call import Call, Usage
from lockprobe.trial.record import Decision, Situation

Ask = Callable[[Call, Sequence[Message], dict[str, object]], Awaitable[Call]]
"""From a call without its reply, the conversation and the form of the reply to the call with its reply."""


def verdict_on(call: Call, situation: Situation) -> Decision | ReplyFault:
    """The decision in the reply of a call, or why there is none."""
    try:
        return parse_reply(call.reply or "", situation, call.stop)
    except ReplyFault as fault:
        return fault


async def decided(situation: Situation, model: Model, ask: Ask) -> Decision:
    """Ask until a reply is well formed.

    Raises:
        RefusalFault: If the model or its provider refused.
        ReplyFault: If too many replies were malformed, or the limit left no room for one.
    """
    messages, schema = conversation(situation, images=model.settings.images), reply_schema(asked_for(situation))
    replies, usage, cut_off = list[str](), Usage(), 0
    while True:
        step, turn, request = len(situation.past) + 1, len(replies) + 1, request_fingerprint(model, messages, schema)
        asked = Call(key="", step=step, turn=turn, request=request, reply=None)
        answer = await ask(asked, messages, schema)
        verdict = verdict_on(answer, situation)
        text = answer.reply or ""
        usage = usage + answer.usage if replies else answer.usage
        replies.append(text)
        if isinstance(verdict, Decision):
            return replace(verdict, replies=tuple(replies), usage=usage, served=answer.served)
        if isinstance(verdict, RefusalFault):
            raise RefusalFault(str(verdict), tuple(replies), asdict(usage))
        cause, final = _cause(answer, model)
        cut_off += answer.stop == CUT_OFF
        if final or len(replies) > model.settings.repairs or cut_off == 2:  # one that had begun can be shorter
            why = f"no usable reply in {count(len(replies), 'turn')}: {verdict}{cause}"
            raise ReplyFault(why, tuple(replies), asdict(usage))
        messages = [
            *messages,
            Message(role="assistant", text=spoken(text)),
            Message(role="user", text=repair(verdict, situation)),
        ]


def request_fingerprint(model: Model, messages: Sequence[Message], schema: dict[str, object]) -> str:
    """A fingerprint of a request: sixteen hexadecimal digits."""
    said = [[message.role, message.text, *(picture.name for picture in message.pictures)] for message in messages]
    form = [said, schema, [model.parameters(), model.settings.schema, model.settings.detail]]
    return hashlib.sha256(json.dumps(form, sort_keys=True).encode()).hexdigest()[:16]


def _cause(answer: Call, model: Model) -> tuple[str, bool]:
    """The cause of an unusable reply: the form, tokens with those of reasoning, the limit; and whether it stays."""
    text, written, reasoned = answer.reply or "", answer.usage.output_tokens, answer.usage.reasoning_tokens
    empty = not without_marks(text).strip()
    if answer.stop == IN_REASONING:
        return " (the object stands in the reasoning and not in the reply: schema=none asks for it in words)", True
    hidden = f", {reasoned or 'some'} of them of reasoning" if reasoned or answer.reasoned else ""
    after = f" after {written} tokens{hidden}" if written else " after reasoning" if answer.reasoned else ""
    if answer.stop == CUT_OFF:
        blanks = len(text) - len(text.rstrip())
        if model.settings.schema != "none" and (blanks >= 100 or 0 < blanks == len(text)):
            allowed = "white space up to the limit, which the schema allows"
            return f" ({allowed}: schema=none asks for the form in words)", True
        limit = "" if model.settings.max_tokens is None else f" than {model.settings.max_tokens}"
        return f" (the reply was cut off{after}: a larger max_tokens{limit} leaves it more room)", empty
    if answer.stop == "tool_calls":
        return " (it called a tool, and there is none)", False
    return f" ({after.strip()})" if empty and after else "", False
