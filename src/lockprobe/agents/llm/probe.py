"""One real request to a model, and what it shows of its server before a study is paid for."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from lockprobe.agents.llm.answer import IN_REASONING
from lockprobe.agents.llm.client import ModelClient
from lockprobe.agents.llm.settings import Access, Model
from lockprobe.agents.prompt import Message
from lockprobe.agents.reply import REFUSED, object_in
from lockprobe.foundation.errors import ModelFault, ReplyFault
from lockprobe.trial.model_call import Call
from lockprobe.trial.pictures.frame import to_png
from lockprobe.trial.pictures.picture import Picture

_ACCESS = Access(connections=1, timeout=60.0, retries=0, connect=4.0)
_CALL = Call(key="", step=1, turn=1, request="", reply=None)
_COLOURS = ("green", "red", "blue")
_FIELDS = ("joint", "colour")
_FORM: dict[str, object] = {
    "type": "object",
    "properties": {
        "joint": {"type": "string", "enum": ["A", "B"]},
        "colour": {"type": "string", "enum": ["none", *_COLOURS]},
    },
    "required": list(_FIELDS),
    "additionalProperties": False,
}
_ASKED = (
    "Reply with one JSON object and nothing else:\n"
    f'{{"joint": "A", "colour": the colour of the picture, one of {", ".join(_COLOURS)}, or "none" without a picture}}'
)
_RED = Picture(kind="rgb", png=to_png(np.full((64, 64, 3), (220, 20, 20), dtype=np.uint8)))


class Shown(NamedTuple):
    """What a request showed of one thing: whether a study can be played with it, and how it is."""

    what: str
    ok: bool
    detail: str


async def probe(spec: str) -> list[Shown]:
    """Ask a model once, with a picture unless it is known to be blind; without it, if it refuses the picture.

    Raises:
        UserMistake: If nothing can be asked: of a wrong spec, a missing key, a wrong address.
    """
    line = ModelClient(Model.parse(spec), _ACCESS)
    asked, refused = Message(role="user", text=_ASKED), ""
    try:
        if line.model.facts.images is not False:
            try:
                answer = await line.ask(_CALL, [replace(asked, pictures=(_RED,))], _FORM)
                return _shown(line, answer, pictures="")
            except ModelFault as fault:
                if not re.match(r"the provider answered 4(?!01|03|29)", str(fault)):
                    raise
                refused = f"refused: {fault}"
        answer = await line.ask(_CALL, [asked], _FORM)
        return _shown(line, answer, pictures=refused or "not sent: it reads none")
    except ModelFault as fault:
        said, reached = str(fault), not str(fault).startswith("no ")
        found = [Shown("server", reached, line.server.url if reached else f"{line.server.url}: {said}")]
        if reached:
            found.append(Shown("key" if re.search("answered 40[13]", said) else "request", ok=False, detail=said))
        return found
    finally:
        await line.aclose()


def _shown(line: ModelClient, answer: Call, *, pictures: str) -> list[Shown]:
    """What an answer shows. ``pictures`` says what became of the picture, if it was not sent."""
    usage, form, text = answer.usage, line.model.form, answer.reply or ""
    counted = f"{usage.input_tokens} in, {usage.output_tokens} out"
    uncounted = "not counted: a budget takes the most for every call"
    found = [
        Shown("server", ok=True, detail=f"{line.server.url}, {answer.seconds:.1f} s, {answer.served or 'unnamed'}"),
        Shown("key", ok=True, detail="accepted" if line.server.key else "none is needed"),
        Shown("tokens", bool(usage.input_tokens), counted if usage.input_tokens else uncounted),
    ]
    fields: dict[str, object] = {}
    why = f"refused: {text[:200]}" if answer.stop == REFUSED else ""
    try:
        fields = {} if why else object_in(text, _FIELDS)[0]
    except ReplyFault as fault:
        why = str(fault) if answer.stop != IN_REASONING else "the object stands in the reasoning and not in the reply"
    advice = f"{why}{'' if form == 'none' else '; schema=none asks for it in words'}"
    kept = text.lstrip().startswith("{") and set(fields) == set(_FIELDS)
    read = "kept" if kept else "not kept, but it can be read"
    found.append(Shown("form of the reply", not why, advice if why else f"{form}, {read}"))
    colour = fields.get("colour")
    seen = pictures or ("read" if colour == "red" else f"sent; of a red one it said {colour!r}")
    found.append(Shown("pictures", seen == "read" or seen.startswith("not sent"), seen))
    hidden = f"{usage.reasoning_tokens} tokens" if usage.reasoning_tokens else ""
    thought = ", ".join(filter(None, ("shown" if answer.reasoned else "", hidden)))
    if line.model.reasons and not thought:
        off = "" if form == "none" else "; schema=none, if the schema turns it off"
        return [*found, Shown("reasoning", ok=False, detail=f"none, although it reasons{off}")]
    return [*found, Shown("reasoning", ok=True, detail=thought or "none")]
