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
from collections.abc import Mapping, Sequence
from contextlib import suppress

from lockprobe.foundation.errors import RefusalFault, ReplyFault
from lockprobe.trial.record import Decision, Outcome, Situation, in_words

REFUSED = "content_filter"
"""Why a reply stopped if the model or its provider refused; the text is then the words of the refusal."""

CLAIMS: Mapping[str, Outcome | None] = {in_words("moved"): "moved", in_words("blocked"): "blocked", "none": None}
"""The claims that a reply may make about the last action; ``none`` in the first step only."""

LONGEST_HYPOTHESIS = 4000
"""Characters."""

TIDIED = ("marks", "text", "syntax", "spelling")
"""What had to be tidied to read a reply: reasoning or marks of a template, words around it, bent JSON, spelling."""

_REASONING = r"(?:seed:)?(?:think|thinking|thoughts?|reason|reasoning|reasoning_content|analysis|reflection|scratchpad)"
_MESSAGE = r"[^<]*(?:<\|constrain\|>[^<]*)?<\|message\|>"
_TAG = re.compile(
    rf"(?P<open><{_REASONING}(?:\s[^<>]*)?>|\[THINK\]|◁think▷|<\|begin_of_thought\|>|<\|START_THINKING\|>"
    rf"|<\|channel>thought|<unused94>|<\|channel\|>\s*(?!final\b)\w+{_MESSAGE})"
    rf"|</{_REASONING}>|\[/THINK\]|◁/think▷|<\|end_of_thought\|>|<\|END_THINKING\|>|<channel\|>|<unused95>"
    rf"|<\|channel\|>\s*final\b{_MESSAGE}",
    re.IGNORECASE,
)
"""Where reasoning begins and ends; in the Harmony format it ends where the channel called ``final`` begins."""

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

_GROUP = re.compile(r"""\{(?:[^{}"'\\]++|"(?:\\.|[^"\\])*+"|'(?:\\.|[^'\\])*+')*+\}""", re.DOTALL)
"""A group in braces with no other inside."""

_ALTERNATIVE = re.compile(r"\bor\s*\0|\0\s*(?:or|alternatively)\b", re.IGNORECASE)
"""Words beside an object, which stands as a zero here, that say that it is one of two answers."""

_KEY = re.compile(r"""[{,]\s*["'\u201c\u2018]?([\w -]{1,40}?)["'\u201d\u2019]?\s*[:"'\u201c]""")
"""The name of a field."""

_SPELLED = {
    "moved": "moved|hasmoved|didmove",
    "did not move": "did(?:not|nt)move|notmoved|has(?:not|nt)moved",
    "none": "|none|null|nothing|na|n/a",
}
"""How models spell a claim behind its subject, in the form of :func:`plain_form`."""

_Pairs = tuple[tuple[str, object], ...]
"""A JSON object as it stands in the text, with repeated names."""

Found = tuple[dict[str, object], set[str]]
"""The fields of an object, under the names asked for, and what was tidied to read it."""


def asked_for(situation: Situation) -> dict[str, tuple[str, ...]]:
    """The fields of a reply, in the order in which they are asked for, with the values that each may have.

    A hypothesis may be any text. Of the last action ``none`` can be said in the first step, and nothing else.
    """
    task, order = situation.task, situation.briefing.hypothesis
    fields = {"joint": task.joints}
    if order != "off":
        fields = {"hypothesis": (), **fields} if order == "before" else {**fields, "hypothesis": ()}
    if not task.assessment:
        return fields
    claims = tuple(words for words, outcome in CLAIMS.items() if (outcome is None) == (situation.percept.joint is None))
    return {"last_action": claims, **fields}


def parse_reply(text: str, situation: Situation, stop: str = "stop") -> Decision:
    """The decision in a raw reply, if that has exactly one reading.

    ``stop`` says why it stopped, as :attr:`lockprobe.trial.model_call.Call.stop` has it.

    Raises:
        RefusalFault: If it stopped because the model or its provider refused, with the words of the refusal.
        ReplyFault: If it is not the object that was asked for, saying why.
    """
    if stop == REFUSED:
        raise RefusalFault(f"refused: {text}")
    asked = asked_for(situation)
    fields, tidied = object_in(text, [*asked])
    read: dict[str, str] = {}
    for name, allowed in asked.items():
        given = fields.get(name, "" if name == "hypothesis" else None)
        if name == "hypothesis":
            said = "" if given is None else str(given)
            read[name] = said.encode("utf-8", "replace").decode("utf-8")  # half of a character outside the basic plane
            if len(read[name]) > LONGEST_HYPOTHESIS:
                raise ReplyFault(f"hypothesis: {len(read[name])} characters, at most {LONGEST_HYPOTHESIS}")
        elif given is None and allowed != ("none",):
            raise ReplyFault(f"{name}: Field required")
        else:
            read[name] = _meant(name, given, allowed, situation.percept.joint or "")
        if given != read[name]:
            tidied.add("spelling")
    return Decision(
        joint=read["joint"],
        claimed=CLAIMS[read.get("last_action", "none")],
        hypothesis=read.get("hypothesis", ""),
        replies=(text,),
        tidied=tuple(what for what in TIDIED if what in tidied),
    )


def _meant(name: str, value: object, allowed: Sequence[str], last: str) -> str:
    """The one of the allowed values that is meant, alone or in a list of one, with or without a subject."""
    if isinstance(value, list) and len(value) == 1:
        value = value[0]
    if isinstance(value, str) and value in allowed:
        return value
    if value is None or (isinstance(value, str | int) and not isinstance(value, bool)):
        plain = plain_form("" if value is None else str(value)).rstrip("!")
        who = "(?:the)?(?:joint)?"
        subject = f"(?:it|(?:the)?joint|{who}{re.escape(plain_form(last))})?" if last else ""
        forms = {one: f"{subject}(?:{form})" for one, form in _SPELLED.items()}
        if name == "joint":
            forms = {joint: f"{who}{re.escape(plain_form(joint))}" for joint in allowed}
        meant = [one for one in allowed if re.fullmatch(forms[one], plain)]
        if len(meant) == 1:
            return meant[0]
    raise ReplyFault(f"{name}: {repr(value)[:80]} is none of {', '.join(allowed)}")


def plain_form(text: str) -> str:
    """A name without case, white space, underscores, hyphens of any kind, quotes and full stops.

    >>> plain_form("'Left-Slider'.") == plain_form("left slider")
    True
    """
    return re.sub(
        r"[\s_\-\u2010-\u2015\u2212\"'`\u201c\u201d\u2018\u2019*.]+", "", unicodedata.normalize("NFKC", text).casefold()
    )


def object_in(text: str, names: Sequence[str]) -> Found:
    """The fields of the object in a text that have one of the names, and what was tidied to read it.

    Names are compared as :func:`plain_form` has them; other fields are left out.

    Raises:
        ReplyFault: If there is none, or not one reading; the message says why.
    """
    if (whole := _loaded(text)) is not None:
        fields, tidied = _fields_of(whole, names)
        if fields or not any(isinstance(value, tuple) for _, value in whole):
            return fields, tidied
    said, found, around, end = without_marks(text), list[Found](), "", 0
    if not said.strip():
        raise ReplyFault("reasoning without a reply after it" if text.strip() else "an empty reply")
    for group in _GROUP.finditer(said):
        pairs = _loaded(group[0])
        fields, tidied = _fields_of(_bent(group[0]) if pairs is None else pairs, names)
        if fields:
            found.append((fields, tidied | {"syntax"} if pairs is None else tidied))
            around, end = f"{around}{said[end : group.start()]}\0", group.end()
    around += said[end:]
    if around.count("{") > around.count("}"):
        raise ReplyFault("a JSON object that does not end")
    plain = {plain_form(name) for name in names}
    broken = any(plain_form(key) in plain for key in _KEY.findall(around))
    if not found or (broken and len(found) == 1):
        raise ReplyFault("not one JSON object")
    readings = {json.dumps({name: plain_form(str(of)) for name, of in sorted(one.items())}) for one, _ in found}
    if broken or len(readings) > 1:
        raise ReplyFault("JSON objects that differ")
    if _ALTERNATIVE.search(around):
        raise ReplyFault("a JSON object and an alternative")
    fields, tidied = found[0]
    more = around.replace("\0", "").strip() or len(found) > 1
    return fields, tidied.union(["marks"] if said != text else (), ["text"] if more else ())


def spoken(text: str) -> str:
    """A raw reply as it stands in the conversation: without reasoning and marks of a template."""
    return without_marks(text) or "(empty)"


def without_marks(text: str) -> str:
    """The reply behind the last reasoning that ends, without tokens of a template.

    A whole JSON object is left as it is. Of reasoning that ends nowhere, or after which nothing comes, nothing is left,
    unless one object is all that there is besides the tags.
    """
    if not any(sign in text for sign in "<[◁") or _loaded(text) is not None:  # most replies have none of them
        return text
    tags = list(_TAG.finditer(text))
    end = max((tag.end() for tag in tags if not tag["open"]), default=0)
    said = _without_tokens(text[end : next((tag.start() for tag in tags if tag["open"] and tag.start() >= end), None)])
    if not said.strip() and _loaded(alone := _without_tokens(_TAG.sub("", text))) is not None:
        return alone.strip()
    return text if said == text else said.strip()


def _without_tokens(text: str) -> str:
    """The text of the first turn that has one, without tokens of a template."""
    turns = (_TOKEN.sub("", turn) for turn in _TURN.split(text))
    return next((turn for turn in turns if turn.strip()), "")


def _loaded(text: str) -> _Pairs | None:
    """The JSON object that a text is; None if it is none."""
    try:
        found = json.loads(text, object_pairs_hook=tuple)
    except (ValueError, RecursionError):
        return None
    return found if isinstance(found, tuple) else None


def _bent(group: str) -> _Pairs:
    """A group in braces as models write it who think of Python: other quotes, or a comma before the end."""
    with suppress(ValueError, SyntaxError, MemoryError, RecursionError), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of escapes that Python does not know
        tree = ast.parse(group, mode="eval").body
        if isinstance(tree, ast.Dict):
            said = zip(tree.keys, tree.values, strict=True)
            return tuple((str(ast.literal_eval(key or "")), ast.literal_eval(of)) for key, of in said)
    return ()


def _fields_of(pairs: _Pairs, names: Sequence[str]) -> Found:
    """The fields that have one of the names; refused if one has two values."""
    fields, tidied = dict[str, object](), set[str]()
    for key, value in pairs:
        name = key if key in names else next((one for one in names if plain_form(one) == plain_form(key)), None)
        if name is None:
            continue
        if name in fields and fields[name] != value:
            raise ReplyFault(f"{name}: two values")
        if name in fields:
            tidied.add("syntax")
        if name != key:
            tidied.add("spelling")
        fields[name] = value
    return fields, tidied
