"""What the text of a language model says: a decision, or why it is none.

Servers leave marks of their template and the model's reasoning in the text. Models put fences and words around an
object, bend JSON a little, or spell a value otherwise. A text is accepted if it has exactly one reading, and the record
names what was tidied (:data:`TIDIED`). A text with two readings is refused: two different objects, an object beside a
broken one, a field with two values.
"""

from __future__ import annotations

import ast
import json
import re
import unicodedata
import warnings
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Literal

from lockprobe.foundation.errors import RefusalFault, ReplyFault
from lockprobe.trial.briefing import Briefing
from lockprobe.trial.record import Decision, Outcome, Situation, Task
from lockprobe.trial.told_outcome import in_words

REFUSED = "content_filter"
"""Why a reply stopped if the model or its provider refused; the text is then the words of the refusal."""

CLAIMS: Mapping[str, Outcome | None] = {in_words("moved"): "moved", in_words("blocked"): "blocked", "none": None}
"""The claims that a reply may make about the last action; ``none`` in the first step only."""

LONGEST_HYPOTHESIS = 4000
"""Characters."""

Tidied = Literal["reasoning", "template", "fence", "prose", "repeated", "syntax", "spelling"]
"""What had to be tidied to read a reply."""

TIDIED: Mapping[Tidied, str] = {
    "reasoning": "reasoning in the text",
    "template": "tokens of the server's template",
    "fence": "a code fence",
    "prose": "text around the object",
    "repeated": "the same object twice",
    "syntax": "bent JSON",
    "spelling": "another spelling of a value",
}
"""The same in words, in the order of a record."""

_REASONING = r"(?:seed:)?(?:think|thinking|thoughts?|reason|reasoning|reasoning_content|analysis|reflection|scratchpad)"
_TAG = re.compile(
    rf"(?P<open><{_REASONING}(?:\s[^<>]*)?>|\[THINK\]|◁think▷|<\|begin_of_thought\|>|<\|START_THINKING\|>"
    rf"|<\|channel>thought|<unused94>)"
    rf"|</{_REASONING}>|\[/THINK\]|◁/think▷|<\|end_of_thought\|>|<\|END_THINKING\|>|<channel\|>|<unused95>",
    re.IGNORECASE,
)
"""Where reasoning begins and ends."""

_CHANNEL = re.compile(r"<\|channel\|>\s*(\w+)[^<]*(?:<\|constrain\|>[^<]*)?<\|message\|>")
_CHANNEL_END = re.compile(r"<\|(?:end|return|call|start|channel)\|>")
"""The channels of the Harmony format; only the one called ``final`` is the reply."""

_TURN = re.compile(
    r"<\|(?:im_end|im_start|eot_id|eom_id|eot|end|return|call|start|start_header_id|end_of_text|endoftext|user|assistant"
    r"|system|END_OF_TURN_TOKEN|START_OF_TURN_TOKEN|END_RESPONSE)\|>|<\uff5c(?:end▁of▁sentence|User|Assistant)\uff5c>"
    r"|</s>|<(?:start|end)_of_turn>|<\|turn>|<turn\|>|<eos>|\[INST\]"
)
"""Tokens between two turns; what follows one is no longer part of the reply."""

_OR_BEFORE = re.compile(r"\bor\s*$", re.IGNORECASE)
_OR_AFTER = re.compile(r"\s*(?:or|alternatively)\b", re.IGNORECASE)
"""Words beside an object that say that it is one of two answers."""

_TOKEN = re.compile(
    r"<\|[^|<>\s]{1,40}\|?>|<[^|<>\s]{1,40}\|>|<\uff5c[^\uff5c<>\s]{1,40}\uff5c>|</?s>|<(?:start|end)_of_turn>|<(?:bos|eos|pad)>|\[/?INST\]"
)
"""Any token of a template."""

_MARKED = re.compile(r"[<\[◁]")
"""What every text with marks holds."""

_FENCE = re.compile(r"(?:`{3,}|~{3,})[ \t]*[\w+-]*")
_NO_WIDTH = re.compile("[\ufeff\u200b\u200c\u200d\u2060]")
_QUOTED = re.compile(r"[\"'\u201c\u2018]\s*([\w -]{1,40}?)\s*[\"'\u201d\u2019]")

_OF_A_CALL = ("name", "type", "id")
"""What stands beside the object in the call of a tool, which some models write although none is offered."""

_JOINT = ("", "the", "joint", "thejoint")
_SPELLED: Mapping[str, Collection[str]] = {
    "moved": ("moved", "hasmoved", "didmove"),
    "did not move": ("didnotmove", "didntmove", "notmoved", "hasnotmoved", "hasntmoved"),
}
_NOTHING = ("", "none", "null", "nothing", "na", "n/a")


class _Object(dict[str, object]):
    """A JSON object, and its pairs as they stand in the text, with repeated names."""

    def __init__(self, pairs: list[tuple[str, object]]) -> None:
        super().__init__(pairs)
        self.pairs = pairs


Found = tuple[dict[str, object], set[Tidied]]
"""The fields of the object in a text, under the names asked for, and what was tidied to read it."""


def keys(task: Task, briefing: Briefing) -> list[str]:
    """The fields of a reply, in the order in which they are asked for."""
    orders = {"before": ["hypothesis", "joint"], "after": ["joint", "hypothesis"], "off": ["joint"]}
    return ["last_action"] * task.assessment + orders[briefing.hypothesis]


def claims(situation: Situation) -> list[str]:
    """The allowed claims about the last action: ``none`` in the first step only, and no claims if nobody asks."""
    if not situation.task.assessment:
        return []
    return ["none"] if situation.percept.joint is None else [words for words, outcome in CLAIMS.items() if outcome]


def parse_reply(text: str, situation: Situation, stop: str = "stop", asked: Sequence[str] = ()) -> Decision:
    """The decision in a raw reply, if that has exactly one reading.

    Args:
        text: The raw reply.
        situation: The situation that it is about.
        stop: Why it stopped, as :attr:`lockprobe.trial.model_call.Call.stop` has it.
        asked: The fields that are read, if they are not those that the situation asks for.

    Raises:
        RefusalFault: If it stopped because the model or its provider refused, with the words of the refusal.
        ReplyFault: If it is not the object that was asked for, saying why.
    """
    if stop == REFUSED:
        raise RefusalFault(f"refused: {text}")
    asked, claimable = asked or keys(situation.task, situation.briefing), claims(situation)
    fields, tidied = object_in(text, asked)
    read: dict[str, str] = {}
    for name in asked:
        given = fields.get(name)
        if given is None and name != "hypothesis" and not (name == "last_action" and claimable == ["none"]):
            raise ReplyFault(f"{name}: Field required")
        if name == "joint":
            joints = {joint: [f"{what}{plain_form(joint)}" for what in _JOINT] for joint in situation.task.joints}
            read[name] = _one_of(name, given, joints)
        elif name == "last_action":
            read[name] = _one_of(name, given, _spellings(claimable, situation.percept.joint or ""))
        else:
            said = given if isinstance(given, str) else "" if given is None else json.dumps(given, ensure_ascii=False)
            read[name] = said.encode("utf-8", "replace").decode("utf-8")  # half of a character outside the basic plane
            if len(read[name]) > LONGEST_HYPOTHESIS:
                raise ReplyFault(f"hypothesis: {len(read[name])} characters, at most {LONGEST_HYPOTHESIS}")
        if given != read[name] and (name in fields or name != "hypothesis"):
            tidied.add("spelling")
    return Decision(
        joint=read["joint"],
        claimed=CLAIMS[read.get("last_action", "none")],
        hypothesis=read.get("hypothesis", ""),
        replies=(text,),
        tidied=tuple(what for what in TIDIED if what in tidied),
    )


def _spellings(claimable: Sequence[str], last: str) -> dict[str, Collection[str]]:
    """How each claim can be spelled: with the last joint, ``it`` or nothing before it."""
    subjects = ("", "it", "joint", "thejoint", *(f"{what}{plain_form(last)}" for what in _JOINT))
    forms = {claim: {f"{subject}{form}" for subject in subjects for form in of} for claim, of in _SPELLED.items()}
    return {claim: forms.get(claim, _NOTHING) for claim in claimable}


def _one_of(name: str, value: object, spelled: Mapping[str, Collection[str]]) -> str:
    """The one that a value means, alone or in a list of one.

    Raises:
        ReplyFault: If it means none, or several.
    """
    if isinstance(value, list) and len(value) == 1:
        value = value[0]
    if isinstance(value, str) and value in spelled:
        return value
    if value is None or (isinstance(value, str | int) and not isinstance(value, bool)):
        plain = plain_form("" if value is None else str(value)).rstrip("!")
        meant = [one for one, forms in spelled.items() if plain in forms]
        if len(meant) == 1:
            return meant[0]
    raise ReplyFault(f"{name}: {repr(value)[:80]} is none of {', '.join(spelled)}")


def plain_form(text: str) -> str:
    """A name without case, white space, underscores, hyphens of any kind, quotes and full stops.

    >>> plain_form("'Left-Slider'.") == plain_form("left slider")
    True
    """
    return re.sub(
        r"[\s_\-\u2010-\u2015\u2212\"'`\u201c\u201d\u2018\u2019*.]+", "", unicodedata.normalize("NFKC", text).casefold()
    )


def object_in(text: str, names: Sequence[str]) -> Found:
    """The object in a text, with those of its fields that have one of the names; other fields are left out.

    Names are compared as :func:`plain_form` has them.

    Raises:
        ReplyFault: If there is none, or not one reading; the message says why.
    """
    try:
        return _object_in(text, names)
    except RecursionError:
        raise ReplyFault("not one JSON object") from None


def _object_in(text: str, names: Sequence[str]) -> Found:
    if isinstance(whole := _loaded(text), _Object):
        return _fields_of(whole, names)
    if isinstance(whole, str) and whole.strip():
        fields, tidied = _object_in(whole, names)
        return fields, tidied | {"syntax"}
    said, marks = without_marks(text)
    if not said.strip():
        raise ReplyFault("reasoning without a reply after it" if text.strip() else "an empty reply")
    found, around, broken = _objects(said, names)
    if not found or (broken and len(found) == 1):
        raise ReplyFault("not one JSON object")
    readings = {json.dumps({name: plain_form(str(of)) for name, of in sorted(one.items())}) for one, _ in found}
    if broken or len(readings) > 1:
        raise ReplyFault("JSON objects that differ")
    if _OR_BEFORE.search(around[0]) or _OR_AFTER.match(around[-1]):
        raise ReplyFault("a JSON object and an alternative")
    fields, tidied = found[0]
    tidied = tidied.union(marks, ["repeated"] if len(found) > 1 else ())
    left = _NO_WIDTH.sub("", "".join(around))
    if _FENCE.search(left):
        tidied.add("fence")
    if _FENCE.sub("", left).strip() or not tidied:
        tidied.add("prose")
    return fields, tidied


def _objects(text: str, names: Sequence[str]) -> tuple[list[Found], list[str], bool]:
    """The groups in braces that have one of the names, the texts around them, and whether such a one is broken."""
    plain = {plain_form(name) for name in names}
    found, around, end, broken = list[Found](), list[str](), 0, False
    for start, stop in _groups(text):
        pairs, bent = _read(text[start:stop])
        if pairs is None:
            broken |= any(plain_form(quoted) in plain for quoted in _QUOTED.findall(text[start:stop]))
            continue
        fields, tidied = _fields_of(pairs, names)
        if fields:
            found.append((fields, tidied | {"syntax"} if bent else tidied))
            around.append(text[end:start])
            end = stop
    return found, [*around, text[end:]], broken


def spoken(text: str) -> str:
    """A raw reply as it stands in the conversation: without reasoning and marks of a template."""
    return without_marks(text)[0] or "(empty)"


def without_marks(text: str) -> tuple[str, tuple[Tidied, ...]]:
    """The reply without reasoning and without tokens of a template, and which of the two were removed.

    A whole JSON object is left as it is. Of reasoning that ends nowhere, or after which nothing comes, nothing is left,
    unless one object is all that there is besides the tags.
    """
    if not _MARKED.search(text) or isinstance(_loaded(text), _Object):
        return text, ()
    channel, others = _final_channel(text)
    said = _after_reasoning(channel)
    if not said.strip() and isinstance(_loaded(bare := _without_tokens(_TAG.sub("", text))), _Object):
        return bare.strip(), ("reasoning",)
    spoken = _without_tokens(said)
    tidied: list[Tidied] = ["reasoning"] if others or said != channel else []
    if spoken != said or (channel != text and not others):
        tidied.append("template")
    return (spoken.strip(), tuple(tidied)) if tidied else (text, ())


def mark_in(text: str) -> str:
    """The first mark in a reply that has some."""
    found = [one for pattern in (_TAG, _CHANNEL, _TOKEN) if (one := pattern.search(text)) is not None]
    return min(found, key=lambda one: one.start())[0]


def _final_channel(text: str) -> tuple[str, bool]:
    """The reply in a text of channels, and whether there are other channels."""
    channels = [*_CHANNEL.finditer(text)]
    if not channels:
        return text, False
    finals = []
    for channel in channels:
        if channel[1] == "final":
            end = _CHANNEL_END.search(text, channel.end())
            finals.append(text[channel.end() : end.start() if end else len(text)])
    return "\n".join(finals), len(finals) < len(channels)


def _after_reasoning(text: str) -> str:
    """The text outside reasoning. Before an end without a beginning, everything is reasoning."""
    said: list[str] = []
    start: int | None = 0
    for tag in _TAG.finditer(text):
        if tag["open"]:
            if start is not None:
                said.append(text[start : tag.start()])
            start = None
        else:
            if start is not None:
                said.clear()
            start = tag.end()
    return "".join([*said, "" if start is None else text[start:]])


def _without_tokens(text: str) -> str:
    """The text up to the end of its turn, without tokens of a template."""
    begins = 0
    for turn in _TURN.finditer(text):
        if _TOKEN.sub("", text[begins : turn.start()]).strip():
            text = text[: turn.start()]
            break
        begins = turn.end()
    return _TOKEN.sub("", text)


def _loaded(text: str) -> object:
    """The JSON value that a text is, an object as :class:`_Object`; None if it is none."""
    try:
        return json.loads(text, object_pairs_hook=_Object)
    except (ValueError, RecursionError):
        return None


def _groups(text: str) -> Iterator[tuple[int, int]]:
    """Where the outermost groups in braces begin and end.

    Raises:
        ReplyFault: If one does not end.
    """
    depth, start, quote, before, escaped = 0, 0, "", "", False
    for place, sign in enumerate(text):
        if quote:
            quote = "" if sign == quote and not escaped else quote
            escaped = sign == "\\" and not escaped
        elif depth and (sign == '"' or (sign == "'" and before in "{[,:")):
            quote, escaped = sign, False
        elif sign == "{":
            start = start if depth else place
            depth += 1
        elif sign == "}" and depth:
            depth -= 1
            if not depth:
                yield start, place + 1
        before = before if sign.isspace() else sign
    if depth:
        raise ReplyFault("a JSON object that does not end")


def _read(group: str) -> tuple[_Object | None, bool]:
    """A group in braces as an object, and whether its JSON was bent; None if it has no reading."""
    inner = group[1:-1].strip()
    doubled = [inner] if inner.startswith("{") and inner.endswith("}") else []  # as in a template, or those of \boxed
    for one in (group, *doubled):
        if isinstance(exact := _loaded(one), _Object):
            return exact, one is not group
        with suppress(ValueError, SyntaxError, MemoryError), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of escapes that Python does not know
            if isinstance(value := _literal(ast.parse(_NO_WIDTH.sub("", one), mode="eval").body), _Object):
                return value, True
    return None, True


def _literal(node: ast.AST | None) -> object:
    """A value as models write it who think of Python: other quotes, none, or a comma before the end.

    Raises:
        ValueError: If it is more than a value.
    """
    match node:
        case ast.Dict(keys=keys, values=values):
            return _Object([(str(_literal(key)), _literal(of)) for key, of in zip(keys, values, strict=True)])
        case ast.List(elts=parts):
            return [_literal(part) for part in parts]
        case ast.Constant(value=str() | int() | float() | None as value):
            return value
        case ast.Name(id=word):
            return {"true": True, "false": False, "null": None}.get(word, word)
    raise ValueError("no value")


def _fields_of(found: _Object, names: Sequence[str]) -> Found:
    """The fields that have one of the names; an object that only wraps such an object stands for it.

    Raises:
        ReplyFault: If one has two values.
    """
    known = {plain_form(name): name for name in names}
    fields, tidied = dict[str, object](), set[Tidied]()
    for key, value in found.pairs:
        if (name := known.get(plain_form(key))) is None:
            continue
        if name in fields and fields[name] != value:
            raise ReplyFault(f"{name}: two values")
        if name in fields:
            tidied.add("repeated")
        if name != key:
            tidied.add("spelling")
        fields[name] = value
    inner = [value for _, value in found.pairs if isinstance(value, _Object)]
    if not fields and len(inner) == 1 and len(found.pairs) - 1 == sum(key in _OF_A_CALL for key, _ in found.pairs):
        fields, tidied = _fields_of(inner[0], names)
        tidied.add("syntax")
    return fields, tidied
