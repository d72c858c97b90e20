"""The catalogue of agents by spec (:data:`KNOWN`). Heavy modules are imported only when an agent needs them.

Options follow a question mark: ``human-inspired:proximity?lapse=0.1``. Those of a viewer and of its strategy stand side
by side: ``viewer:human-inspired:proximity?acuity=40&lapse=0.1``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from inspect import iscoroutinefunction
from typing import Any, Literal

from lockprobe.agents.llm.settings import Access, Model, ModelSettings
from lockprobe.agents.policy import Policy
from lockprobe.agents.strategies import CHARACTERS, STRATEGIES
from lockprobe.agents.viewer import Viewer
from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.foundation.plugins import find_plugin, first_line, plugin_names
from lockprobe.foundation.spec import MCP, PEOPLE, Spec, arguments_from, options_of, spec_kind, spec_name
from lockprobe.foundation.terminal_text import printable
from lockprobe.foundation.validation import check_number
from lockprobe.trial.protocols import Agent

Engine = Literal["inline", "process", "network", "person", "client"]
"""Where its time goes: none to speak of; a processor (one worker process each); waiting for somebody else; and a
person or a client with tools, who are waited for by a server and never by a run."""

_VIEWED, _OBSERVER = "human-inspired:target-first", "ideal-observer"

SAME_IN_ALL_TRIALS = ("client", "wording")
"""Facts of a client that may not change under its name: records that differ in them are different conditions."""

_OUTSIDE = {
    PEOPLE: (r"(:[a-z0-9]{4,32})?", "participant, or participant:ID with 4 to 32 lower-case letters and digits"),
    MCP: (r":[A-Za-z0-9][A-Za-z0-9._-]{0,63}", "mcp:NAME with at most 64 letters, digits, dots, hyphens, underscores"),
}
"""Agents outside of the loop, whom a server waits for: how their specs go on after the kind, and the same in words."""

_SAID = {
    **{name: first_line(type(one)) for name, one in STRATEGIES.items()},
    **CHARACTERS,
    _OBSERVER: "Infers the interlock from all reports (Bayesian) and plans by the posterior.",
    "viewer": "Reads pictures and plays any strategy with its readings.",
    "llm:local": "SmolLM2-135M-Instruct, a very small language model.",
    MCP: "An agent with tools, which connects to lockprobe mcp.",
}
"""Name or kind -> what the agent is, in a sentence."""


def _with_options(name: str) -> str:
    options = ", ".join(options_of(type(STRATEGIES[name])))
    return f"{_SAID[name]} Options: {options}." if options else _SAID[name]


_PRESETS = [name for name in STRATEGIES if name.startswith("human-inspired")]

KNOWN: Mapping[str, str] = {
    **{name: _with_options(name) for name in STRATEGIES if name not in (*_PRESETS, *CHARACTERS)},
    _OBSERVER: f"{_SAID[_OBSERVER]} Options: prior, noise, reading.",
    "human-inspired[:PRESET]": f"{_with_options('human-inspired')} Presets: "
    f"{', '.join(name.partition(':')[2] for name in _PRESETS[1:])}.",
    "cognitive:CHARACTER": "A softmax memory with fixed settings. Characters: "
    f"{', '.join(name.partition(':')[2] for name in CHARACTERS)}.",
    "viewer[:STRATEGY]": f"{_SAID['viewer']} It can misread; its strategy is {_VIEWED} unless you name one. "
    "Options: acuity, and its strategy's.",
    "llm:local": _SAID["llm:local"],
    "llm:gguf:PATH": "Any language model in a GGUF file.",
    "llm:PROVIDER/MODEL": "Any model that is served, hosted or on a machine of your own, such as llm:openai/gpt-4o. "
    f"Options: {', '.join(options_of(ModelSettings))}.",
    "participant": "People, on the page of lockprobe serve.",
    "mcp:NAME": _SAID[MCP],
    "python:module:Name": "Your own class with the Agent protocol.",
}
"""The forms of all specs of Lockprobe's own agents, with descriptions."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentSource:
    """How to get an agent.

    Attributes:
        spec: Its spec.
        engine: What its computing time depends on.
        sees: Whether it reads pictures, and not only reports in words. A user's class counts as able to, and has to
            refuse pictures itself if it cannot: planning a study or reading a record runs no code of a user.
        make: Builds the agent; may load a model, and may raise :class:`lockprobe.foundation.errors.UserMistake`.
        check: Checks cheaply whether ``make`` can work, with the same errors.
    """

    spec: str
    engine: Engine
    make: Callable[[], Agent]
    check: Callable[[], object] = lambda: None
    sees: bool = True


def description(spec: str) -> str:
    """What a shipped agent is, in a sentence; empty for people, served models and agents of other packages.

    >>> description("llm:local")
    'SmolLM2-135M-Instruct, a very small language model.'
    """
    return _SAID.get(spec_name(spec)) or _SAID.get(spec_kind(spec), "")


def is_strategy(spec: str) -> bool:
    """Whether an agent is a strategy that ships here: it computes its choices at no cost, and chooses them again.

    >>> is_strategy("human-inspired"), is_strategy("llm:local")
    (True, False)
    """
    return spec_kind(spec) in {"viewer", _OBSERVER, *map(spec_kind, STRATEGIES)}


def is_local(spec: Spec) -> bool:
    """Whether a spec of the kind llm names a model in a file."""
    return spec.name == "local" or spec.name.startswith("gguf:")


def check_outside(spec: str, kind: str) -> str:
    """A spec that has to name a person (of the kind ``participant``) or a client with tools (``mcp``)."""
    form, expected = _OUTSIDE[kind]
    if not re.fullmatch(f"{kind}{form}", spec):
        raise BadValue("agent", spec, expected)
    return spec


def resolve(text: str, access: Access | None = None) -> AgentSource:
    """Find the agent that a spec names. ``access`` is how a hosted model is reached.

    Raises:
        UnknownName: If there is no such agent; the message lists those that exist.
        BadValue: If the spec holds invisible characters, or an invalid option.
    """
    if not text.isprintable():
        raise BadValue("agent", printable(text), "a name without control characters")
    spec = Spec.parse(text)
    if is_strategy(text):
        agent = _viewer(spec) if spec.kind == "viewer" else _strategy(spec)
        return AgentSource(spec=text, engine="inline", sees=spec.kind == "viewer", make=lambda: agent)
    if spec.kind in _OUTSIDE:
        check_outside(text, spec.kind)

        def nobody() -> Agent:
            raise BadValue("agent", text, "one that is called: people join lockprobe serve, and clients lockprobe mcp")

        return AgentSource(spec=text, engine="person" if spec.kind == PEOPLE else "client", make=nobody)
    if spec.kind == "llm":
        return _language_model(spec, access)
    if (plugin := find_plugin("agent", text)) is None:
        near = f"llm:{spec}" if "/" in spec.full_name else None
        raise UnknownName("agent", text, [*KNOWN, *plugin_names("agent")], near=near)
    expected = "a class with `facts` and `async def decide(situation, rng)`"

    def make() -> Agent:  # nothing of another package is imported before
        found = plugin.make(is_one=lambda found: hasattr(found, "decide"), expected=expected)
        with plugin.guarded():
            if not (isinstance(found, Agent) and iscoroutinefunction(found.decide)):
                raise BadValue("agent", text, expected)
        return found

    return AgentSource(spec=text, engine="inline", make=make, check=make)


def _strategy(spec: Spec) -> Policy[Any]:
    found = STRATEGIES.get(spec.full_name)
    if spec.full_name == _OBSERVER:
        from lockprobe.agents.ideal_observer import IdealObserver

        found = IdealObserver()
    if found is None:
        raise UnknownName("strategy", spec.full_name, [*STRATEGIES, _OBSERVER])
    given: Any = arguments_from(type(found), spec.full_name, spec.options)
    return replace(found, **given)  # type: ignore[type-var]  # all are dataclasses


def _viewer(spec: Spec) -> Viewer:
    """A viewer with its strategy; all options but its acuity belong to the strategy."""
    strategy = Spec.parse(spec.name or _VIEWED)
    known = ["acuity", *options_of(type(_strategy(strategy)))]
    for option in spec.options:
        if option not in known:
            raise UnknownName(f"option of {spec.full_name}", option, known)
    strategy = strategy.adding(spec.without(["acuity"]).options)
    sight = arguments_from(Viewer, spec.kind, spec.without(strategy.options).options)
    return Viewer(_strategy(strategy), str(strategy), **sight)  # type: ignore[arg-type]


def _language_model(spec: Spec, access: Access | None) -> AgentSource:
    text = str(spec)
    if is_local(spec):
        from lockprobe.agents import local

        given: Any = arguments_from(local.LocalModel, "a local model", spec.options, taken=("engine",))
        check_number("temperature", given.get("temperature", 1.0), 0.001, 1000)
        return AgentSource(
            spec=text,
            engine="process",
            sees=False,
            make=lambda: local.LocalModel(local.Engine(local.locate(spec.full_name)), **given),
            check=lambda: (local.runtime(), local.locate(spec.full_name)),
        )
    model = Model.parse(text)

    def make() -> Agent:
        from lockprobe.agents.llm.model import HostedModel

        return HostedModel(model, access or Access())

    # of a model that is not known its provider has to say whether it sees
    return AgentSource(spec=text, engine="network", sees=model.facts.images is not False, make=make, check=make)
