"""Finds the one JSON object in a raw reply of a language model.

Servers leave marks of their template and the model's reasoning in the text. Models put fences and words around an
object, or bend JSON a little. A reply is accepted if it has exactly one reading, and the record names what was tidied
(:data:`TIDIED`). A reply with two readings is refused: two different objects, an object beside
a broken one, a field with two values.
"""

from __future__ import annotations

import json
import re
import unicodedata
from collections.abc import Iterator, Mapping, Sequence
from typing import Literal, NamedTuple

from lockprobe.foundation.errors import ReplyFault

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
"""The same in words."""

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

_BARE_CHANNEL = re.compile(r"\s*(?:analysis|commentary)")
_BARE_FINAL = "assistantfinal"
"""The same format from a server that removed its tokens and kept its words."""

_TURN = re.compile(
    r"<\|(?:im_end|im_start|eot_id|eom_id|eot|end|return|call|start|start_header_id|end_of_text|endoftext|user|assistant"
    r"|system|END_OF_TURN_TOKEN|START_OF_TURN_TOKEN|END_RESPONSE)\|>|<\uff5c(?:end▁of▁sentence|User|Assistant)\uff5c>"
    r"|</s>|<(?:start|end)_of_turn>|<\|turn>|<turn\|>|<eos>|\[INST\]"
)
"""Tokens between two turns; what follows one is no longer part of the reply."""

_TOKEN = re.compile(
    r"<\|[^|<>\s]{1,40}\|?>|<[^|<>\s]{1,40}\|>|<\uff5c[^\uff5c<>\s]{1,40}\uff5c>|</?s>|<(?:start|end)_of_turn>|<(?:bos|eos|pad)>|\[/?INST\]"
)
"""Any token of a template."""

_MARKED = re.compile(r"[<\[◁]|assistantfinal")
"""What every text with marks holds."""

_ALTERNATIVE_BEFORE = re.compile(r"\bor\s*$", re.IGNORECASE)
_ALTERNATIVE_AFTER = re.compile(r"\s*(?:or|alternatively)\b", re.IGNORECASE)
_FENCE = re.compile(r"(?:`{3,}|~{3,})[ \t]*[\w+-]*")
_NO_WIDTH = re.compile("[\ufeff\u200b\u200c\u200d\u2060]")
_CLOSING = {'"': '"', "'": "'", "\u201c": "\u201d", "\u2018": "\u2019"}
_LENIENT = re.compile(
    r"""(?P<double>"(?:[^"\\]|\\.)*")|(?P<single>'(?:[^'\\]|\\.)*'|\u201c[^\u201d]*\u201d|\u2018[^\u2019]*\u2019)|(?P<comment>//[^\n]*|/\*.*?\*/)
    |(?P<word>[^\W\d][\w-]*)|(?P<number>[-+.\d][\w.+-]*)|(?P<sign>[{}\[\]:,])|(?P<space>\s+)""",
    re.VERBOSE | re.DOTALL,
)
"""A piece of JSON as models bend it: other quotes, no quotes, comments, a comma before the end."""

_OF_A_CALL = ("name", "type", "id")
"""What stands beside the object in the call of a tool, which some models write although none is offered."""

_CONSTANTS = {"True": "true", "False": "false", "None": "null", "true": "true", "false": "false", "null": "null"}
_QUOTED = re.compile(r"[\"'\u201c\u2018]\s*([\w -]{1,40}?)\s*[\"'\u201d\u2019]")


class FoundObject(NamedTuple):
    """The fields of the object in a reply, under the names asked for, and what was tidied to read it."""

    fields: dict[str, object]
    tidied: tuple[Tidied, ...] = ()


class _Pairs(tuple[tuple[str, object], ...]):
    """A JSON object as it stands in a text, with repeated names."""

    __slots__ = ()


def object_in(text: str, names: Sequence[str]) -> FoundObject:
    """The object in a reply, with those of its fields that have one of the names; other fields are left out.

    Names are compared as :func:`plain_form` has them.

    Raises:
        ReplyFault: If there is none, or not one reading; the message says why.
    """
    try:
        return _object_in(text, names)
    except RecursionError:
        raise ReplyFault("not one JSON object") from None


def _object_in(text: str, names: Sequence[str]) -> FoundObject:
    if isinstance(whole := _loaded(text), _Pairs):
        return _fields_of(whole, names)
    if isinstance(whole, str) and whole.strip():
        return _also(_object_in(whole, names), "syntax")
    said, tidied = without_marks(text)
    if not said.strip():
        raise ReplyFault("reasoning without a reply after it" if text.strip() else "an empty reply")
    found, around = _only_object(said, names)
    if _FENCE.search(around):
        tidied, around = (*tidied, "fence"), _FENCE.sub("", around)
    if around.strip() or not (tidied or found.tidied):
        tidied = (*tidied, "prose")
    return _also(found, *tidied)


def _also(found: FoundObject, *tidied: Tidied) -> FoundObject:
    return found._replace(tidied=tuple(dict.fromkeys((*tidied, *found.tidied))))


def without_marks(text: str) -> tuple[str, tuple[Tidied, ...]]:
    """The reply without reasoning and without tokens of a template, and which of the two were removed.

    A whole JSON object is left as it is. Of reasoning that ends nowhere, or after which nothing comes, nothing is left,
    unless one object is all that there is besides the tags.
    """
    if not _MARKED.search(text) or isinstance(_loaded(text), _Pairs):
        return text, ()
    channel, others = _final_channel(text)
    said = _after_reasoning(channel)
    if not said.strip() and isinstance(_loaded(bare := _without_tokens(_TAG.sub("", text))), _Pairs):
        return bare.strip(), ("reasoning",)
    spoken = _without_tokens(said)
    tidied: list[Tidied] = ["reasoning"] if others or said != channel else []
    if spoken != said or (channel != text and not others):
        tidied.append("template")
    return (spoken.strip(), tuple(tidied)) if tidied else (text, ())


def mark_in(text: str) -> str:
    """The first mark in a reply that has some."""
    found = [one for pattern in (_TAG, _CHANNEL, _TOKEN) if (one := pattern.search(text)) is not None]
    return min(found, key=lambda one: one.start())[0] if found else _BARE_FINAL


def _final_channel(text: str) -> tuple[str, bool]:
    """The reply in a text of channels, and whether there are other channels."""
    if _BARE_CHANNEL.match(text) and _BARE_FINAL in text:
        return text.rpartition(_BARE_FINAL)[2], True
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


def plain_form(text: str) -> str:
    """A name without case, white space, underscores, hyphens of any kind, quotes and full stops.

    >>> plain_form("'Left-Slider'.") == plain_form("left slider")
    True
    """
    return re.sub(
        r"[\s_\-\u2010-\u2015\u2212\"'`\u201c\u201d\u2018\u2019*.]+", "", unicodedata.normalize("NFKC", text).casefold()
    )


def _loaded(text: str) -> object:
    """The JSON value that a text is, an object as :class:`_Pairs`; None if it is none."""
    try:
        return json.loads(text, object_pairs_hook=_Pairs)
    except (ValueError, RecursionError):
        return None


def _only_object(text: str, names: Sequence[str]) -> tuple[FoundObject, str]:
    """The object among the groups in braces that has one of the names, and the text around it.

    Raises:
        ReplyFault: If there is none, or not one reading.
    """
    found: list[FoundObject] = []
    around, end, broken = [], 0, False
    for start, stop in _groups(text):
        pairs, bent = _read(text[start:stop])
        if pairs is None and (inner := text[start + 1 : stop - 1].strip()).startswith("{") and inner.endswith("}"):
            pairs, bent = _read(inner)[0], True  # braces doubled, as in a template, or those of \boxed
        one = FoundObject({}) if pairs is None else _fields_of(pairs, names)
        if one.fields:
            found.append(_also(one, "syntax") if bent else one)
            around.append(text[end:start])
            end = stop
        broken |= pairs is None and _speaks_of(text[start:stop], names)
    if not found or (broken and len(found) == 1):
        raise ReplyFault("not one JSON object")
    if broken or len({_reading(one.fields) for one in found}) > 1:
        raise ReplyFault("JSON objects that differ")
    if _ALTERNATIVE_BEFORE.search(around[0]) or _ALTERNATIVE_AFTER.match(text[end:]):
        raise ReplyFault("a JSON object and an alternative")
    first = found[0] if len(found) == 1 else _also(found[0], "repeated")
    return first, _NO_WIDTH.sub("", "".join([*around, text[end:]]))


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
        elif depth and sign in _CLOSING and (sign == '"' or before in "{[,:"):
            quote, escaped = _CLOSING[sign], False
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


def _read(group: str) -> tuple[_Pairs | None, bool]:
    """A group in braces as an object, and whether its JSON was bent; None if it has no reading."""
    if isinstance(exact := _loaded(group), _Pairs):
        return exact, False
    straight = _straightened(_NO_WIDTH.sub("", group))
    try:
        value = None if straight is None else json.loads(straight, strict=False, object_pairs_hook=_Pairs)
    except ValueError:
        value = None
    return value if isinstance(value, _Pairs) else None, True


def _straightened(group: str) -> str | None:
    """Bent JSON as JSON; None if there is something in it that cannot be told."""
    pieces: list[str] = []
    place = 0
    while place < len(group):
        if (piece := _LENIENT.match(group, place)) is None:
            return None
        place, said = piece.end(), piece[0]
        if piece.lastgroup in ("comment", "space"):
            continue
        if piece.lastgroup == "single":
            inside = re.sub(r'\\.|"', lambda one: {"\\'": "'", '"': '\\"'}.get(one[0], one[0]), said[1:-1])
            said = f'"{inside}"'
        elif piece.lastgroup == "word":
            said = _CONSTANTS.get(said, json.dumps(said))
        elif said in "}]" and pieces and pieces[-1] == ",":
            pieces.pop()
        pieces.append(said)
    return "".join(pieces)


def _speaks_of(group: str, names: Sequence[str]) -> bool:
    """Whether a group names one of the fields in quotes."""
    plain = {plain_form(name) for name in names}
    return any(plain_form(quoted) in plain for quoted in _QUOTED.findall(group))


def _fields_of(pairs: _Pairs, names: Sequence[str]) -> FoundObject:
    """The fields that have one of the names; an object that only wraps such an object stands for it.

    Raises:
        ReplyFault: If one has two values.
    """
    known = {plain_form(name): name for name in names}
    fields: dict[str, object] = {}
    tidied: list[Tidied] = []
    for key, value in pairs:
        if (name := known.get(plain_form(key))) is None:
            continue
        if name in fields and fields[name] != _plain(value):
            raise ReplyFault(f"{name}: two values")
        if name in fields:
            tidied.append("repeated")
        if name != key:
            tidied.append("spelling")
        fields[name] = _plain(value)
    inner = [value for _, value in pairs if isinstance(value, _Pairs)]
    if not fields and len(inner) == 1 and len(pairs) - 1 == sum(key in _OF_A_CALL for key, _ in pairs):
        return _also(_fields_of(inner[0], names), "syntax")
    return FoundObject(fields, tuple(dict.fromkeys(tidied)))


def _plain(value: object) -> object:
    """A value with ordinary objects in it."""
    if isinstance(value, _Pairs):
        return {key: _plain(inner) for key, inner in value}
    return [_plain(inner) for inner in value] if isinstance(value, list) else value


def _reading(fields: dict[str, object]) -> str:
    """What an object says, however it spells it."""
    return json.dumps({name: plain_form(str(value)) for name, value in fields.items()}, sort_keys=True)
