"""One real request to a model, and what it shows of its server before a study is paid for."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from lockprobe.agents.llm.answer import CUT_OFF, IN_REASONING, MENDING
from lockprobe.agents.llm.client import ModelClient
from lockprobe.agents.llm.settings import Access, Model
from lockprobe.agents.prompt import Message, reply_schema
from lockprobe.agents.reply import REFUSED, object_in
from lockprobe.foundation.errors import ReplyFault
from lockprobe.trial.model_call import Call
from lockprobe.trial.pictures.frame import to_png
from lockprobe.trial.pictures.picture import Picture

_ACCESS = Access(connections=1, timeout=60.0, retries=0, connect=4.0)
_CALL = Call(key="", step=1, turn=1, request="", reply=None)
_COLOURS = ("green", "red", "blue")
_NAMES = ("joint", "colour")
_FORM = reply_schema(dict(zip(_NAMES, (("A", "B"), ("none", *_COLOURS)), strict=True)))
_ASKED = (
    "Reply with one JSON object and nothing else:\n"
    f'{{"joint": "A", "colour": the colour of the picture, one of {", ".join(_COLOURS)}, or "none" without a picture}}'
)
_RED = Picture(kind="rgb", png=to_png(np.full((64, 64, 3), (220, 20, 20), dtype=np.uint8)))


Shown = tuple[str, bool, str]
"""What a request showed of one thing: its name, whether a study can be played with it, and how it is."""


async def probe(spec: str) -> list[Shown]:
    """Ask a model once, with a picture unless it is known to be blind; without it, if it refuses the picture."""
    line = ModelClient(Model.parse(spec), _ACCESS)
    asked, seen = Message(role="user", text=_ASKED, pictures=(_RED,)), ""
    if line.model.facts.images is False:
        asked, seen = replace(asked, pictures=()), "not sent: it reads none"
    try:
        answer = await line.ask(_CALL, [asked], _FORM)
        if not seen and re.match(r"the provider answered 4(?!01|03|29)", answer.error):
            seen = f"refused: {answer.error}"
            answer = await line.ask(_CALL, [replace(asked, pictures=())], _FORM)
    finally:
        await line.aclose()
    said, url = answer.error, line.server.url
    if said.startswith("no "):
        return [("server", False, f"{url}: {said}")]
    if re.search("answered (429|503)", said) and MENDING not in said:
        return [("server", False, f"{url}: busy, try again ({said})")]
    if said:
        return [("server", True, url), ("key" if re.search("answered 40[13]", said) else "request", False, said)]
    return _shown(line, answer, seen)


def _shown(line: ModelClient, answer: Call, seen: str) -> list[Shown]:
    """What an answer shows. ``seen`` says what became of the picture, if it was not sent."""
    usage, schema, text = answer.usage, line.model.settings.schema, answer.reply or ""
    fields: dict[str, object] = {}
    why = f"refused: {text[:200]}" if answer.stop == REFUSED else ""
    try:
        fields = {} if why else object_in(text, _NAMES)[0]
        why = why or ("" if "joint" in fields else "joint: Field required")
    except ReplyFault as fault:
        why = str(fault) if answer.stop != IN_REASONING else "the object stands in the reasoning and not in the reply"
    kept = "kept" if text.lstrip().startswith("{") and set(fields) == set(_NAMES) else "not kept, but it can be read"
    colour, in_words = fields.get("colour"), "" if schema == "none" else "; schema=none asks for it in words"
    if why and answer.stop == CUT_OFF:
        why, in_words = f"the reply was cut at {usage.output_tokens} tokens: raise max_tokens", ""
    seen = seen or ("read" if colour == "red" else f"sent; of a red one it said {colour!r}")
    counted = f"{usage.input_tokens} in, {usage.output_tokens} out"
    uncounted = "not counted: a budget takes the most for every call"
    thoughts = ["shown"] * answer.reasoned + [f"{usage.reasoning_tokens} tokens"] * bool(usage.reasoning_tokens)
    missed = line.model.reasons and not thoughts
    off = "none, although it reasons" + ("" if schema == "none" else "; schema=none, if the schema turns it off")
    return [
        ("server", True, f"{line.server.url}, {answer.seconds:.1f} s, {answer.served or 'unnamed'}"),
        ("key", True, "accepted" if line.server.key else "none is needed"),
        ("tokens", bool(usage.input_tokens), counted if usage.input_tokens else uncounted),
        ("form of the reply", not why, f"{why}{in_words}" if why else f"{schema}, {kept}"),
        ("pictures", seen == "read" or seen.startswith("not sent"), seen),
        ("reasoning", not missed, off if missed else ", ".join(thoughts) or "none"),
    ]
