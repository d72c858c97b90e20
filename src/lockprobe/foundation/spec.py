"""Specs: parsed names of agents, plants, boxes, interventions and modalities, with their options.

A spec is ``KIND[:NAME][?OPTION=VALUE&...]``, for example ``human-inspired:proximity?lapse=0.1``. Options are encoded as
in a URL. :class:`Spec` is the only reader and the only writer of this text; the functions below it turn the options
into the fields of a dataclass or the arguments of a function. The catalogue of each kind makes the object itself:
``agents/catalogue.py``, ``plants/catalogue.py``, ``interventions/conditions.py``, ``boxes/families.py``.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import cache
from inspect import Parameter, Signature, signature
from types import NoneType, UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints
from urllib.parse import parse_qsl, quote

from lockprobe.foundation.errors import BadValue, UnknownName

Made = TypeVar("Made")

PEOPLE = "participant"
"""The spec that stands for all people in a study; one of them is ``participant:ID``."""

MCP = "mcp"
"""The kind of the specs of agents that connect to ``lockprobe mcp``: ``mcp:NAME``."""

_PLAIN = ";/:=?"
"""What stands in the value of an option as it is, beside letters, digits and ``_.-~``; all else is percent-encoded, a
space too, as a ``+`` stands between specs."""


@dataclass(frozen=True, slots=True)
class Spec:
    """A spec, read once.

    >>> spec = Spec.parse("human-inspired:proximity?lapse=0.1")
    >>> spec.kind, spec.name, spec.options
    ('human-inspired', 'proximity', {'lapse': '0.1'})

    ``str(spec)`` is the text that was parsed, byte for byte, so that records keep it as the user wrote it. A spec that
    was not parsed is written with its options encoded.
    """

    kind: str
    name: str = ""
    options: Mapping[str, str] = field(default_factory=dict, hash=False)
    _text: str = field(default="", init=False, repr=False, compare=False)

    @classmethod
    def parse(cls, text: str, what: str = "agent") -> Spec:
        """Read a spec; messages call it ``what``."""
        full_name, mark, query = text.partition("?")
        try:
            pairs = parse_qsl(query, keep_blank_values=True, strict_parsing=bool(query))
        except ValueError:
            pairs = []
        if mark and not pairs:
            raise BadValue(what, text, "options as name?first=1&second=2")
        if len(dict(pairs)) < len(pairs):
            raise BadValue(what, text, "each option at most once")
        kind, _, name = full_name.partition(":")
        spec = cls(kind, name, dict(pairs))
        object.__setattr__(spec, "_text", text)
        return spec

    def __str__(self) -> str:
        if self._text:
            return self._text
        name = f"{self.kind}:{self.name}" if self.name else self.kind
        said = (f"{quote(option, safe='')}={quote(value, safe=_PLAIN)}" for option, value in self.options.items())
        return f"{name}?{'&'.join(said)}" if self.options else name

    @property
    def full_name(self) -> str:
        """Kind and name, without the options: ``human-inspired:proximity``."""
        return spec_name(str(self))

    def without(self, options: Collection[str]) -> Spec:
        """The spec without some options, whether it has them or not."""
        return replace(self, options={name: value for name, value in self.options.items() if name not in options})

    def adding(self, options: Mapping[str, str]) -> Spec:
        """The spec with more options; a value given here replaces an existing one."""
        return replace(self, options={**self.options, **options})


def spec_name(text: str) -> str:
    """Kind and name of a spec. Its options are ignored and need not be well formed."""
    return text.partition("?")[0]


def spec_kind(text: str) -> str:
    """The kind of a spec. Its options are ignored and need not be well formed."""
    return spec_name(text).partition(":")[0]


def named_spec(text: str, what: str, example: str) -> tuple[str, str]:
    """The name and the spec in ``NAME=SPEC``; in a spec alone the name is empty.

    >>> named_spec("lies=flip?p=0.4", "condition", ""), named_spec("flip?p=0.4", "condition", "")
    (('lies', 'flip?p=0.4'), ('', 'flip?p=0.4'))

    A name has none of ``? : / +``, so the first equals sign before any of them ends it. ``what`` is what a message
    calls the text, and ``example`` is well formed.
    """
    name, equals, spec = text.partition("=")
    if not equals or any(mark in name for mark in "?:/+"):
        return "", text
    if not name.strip() or not spec.strip():
        raise BadValue(what, text, f"NAME=SPEC, for example {example}")
    return name.strip(), spec.strip()


def split_specs(text: str) -> list[str]:
    """The specs in a text that joins them with plus signs: ``tremble?p=0.1 + nudge``."""
    return [part.strip() for part in text.split("+")]


def group_of(agent: str) -> str:
    """The agent that a spec counts for: itself, or ``participant`` for a single person, ``participant:3f9a01bc``."""
    return PEOPLE if agent.startswith(f"{PEOPLE}:") else agent


_signature: Callable[[Any], Signature] = cache(signature)


def options_of(make: Callable[..., object]) -> Mapping[str, Parameter]:
    """The options of a class or function: the arguments that can be given by name, and the argument of each.

    An option has no underscore behind a Python keyword (``from_`` is ``from``). Private arguments are none.
    """
    return {
        argument.name.rstrip("_"): argument
        for argument in _signature(make).parameters.values()
        if argument.kind in (argument.KEYWORD_ONLY, argument.POSITIONAL_OR_KEYWORD) and argument.name[0] != "_"
    }


def settings_of(made: Any) -> dict[str, object]:
    """The settings of a dataclass for the record, by option; several values are joined to one word."""
    values = {part.name: getattr(made, part.name) for part in fields(made) if not part.name.startswith("_")}
    return {name.rstrip("_"): in_words(value) if isinstance(value, tuple) else value for name, value in values.items()}


def in_words(value: object) -> str:
    """A value as text in a spec; several values are separated by semicolons.

    >>> in_words(True), in_words(0.4), in_words((4, 8))
    ('yes', '0.4', '4;8')
    """
    if isinstance(value, tuple):
        return ";".join(map(in_words, value))
    if isinstance(value, bool):
        return "yes" if value else "no"
    return short if isinstance(value, float) and float(short := f"{value:g}") == value else str(value)


def with_options(kind: type[Made], name: str, options: Mapping[str, str]) -> Made:
    """A dataclass with its fields from options as text."""
    return kind(**arguments_from(kind, name, options))


def arguments_from(
    make: Callable[..., object], name: str, options: Mapping[str, str], taken: Collection[str] = ()
) -> dict[str, object]:
    """Arguments for a function or class from options as text, converted by annotation, else by default.

    Its options are those of :func:`options_of`, but for the arguments that it gets from elsewhere (``taken``). Users
    know it by its ``name``.
    """
    if not options:
        return {}
    hints = _annotations(make)
    known = {option: argument for option, argument in options_of(make).items() if argument.name not in taken}
    found: dict[str, object] = {}
    for option, text in options.items():
        if option not in known:
            raise UnknownName(f"option of {name}", option, known or ["none"])
        argument = known[option]
        kind = hints.get(argument.name, str if argument.default in (None, argument.empty) else type(argument.default))
        found[argument.name] = _value(option, text, kind)
    return found


@cache
def _annotations(make: Callable[..., object]) -> Mapping[str, Any]:
    """The annotations of arguments; to read these takes longer than all else here."""
    plain = isinstance(make, type) and not is_dataclass(make)
    try:
        return get_type_hints(getattr(make, "__init__") if plain else make)  # noqa: B009
    except (AttributeError, NameError, TypeError):  # they name imports for type checkers only
        written = {kind.__name__: kind for kind in (bool, int, float, str)}
        return {one.name: written[one.annotation] for one in options_of(make).values() if one.annotation in written}


def _value(name: str, text: str, kind: Any) -> object:
    if get_origin(kind) in (Union, UnionType):  # with None, which only leaving the option out can give
        (kind,) = (part for part in get_args(kind) if part is not NoneType)
    if get_origin(kind) is tuple:  # of any length, all of one kind
        return tuple(_value(name, part, get_args(kind)[0]) for part in text.split(";"))
    if get_origin(kind) is Literal:
        if text not in get_args(kind):
            raise BadValue(name, text, f"one of {', '.join(get_args(kind))}")
        return text
    if kind is bool:
        if text not in ("yes", "no"):
            raise BadValue(name, text, "yes or no")
        return text == "yes"
    try:
        return kind(text)
    except ValueError:
        raise BadValue(name, text, "a whole number" if kind is int else "a number") from None
