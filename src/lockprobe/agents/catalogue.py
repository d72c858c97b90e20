"""From an agent's spec to the agent. Nothing heavy is imported before it is asked for.

Specs: ``random``, ``random-no-repeat``, ``round-robin``, ``human-inspired[:preset]``, ``ideal-observer``,
``cognitive:MODEL``, ``viewer[:STRATEGY]`` (reads pictures and plays a strategy by them), ``llm:local`` (the embedded
model), ``llm:gguf:PATH`` (any GGUF file), ``llm:PROVIDER/MODEL`` (any model name of Inspect AI), ``participant``
(people), ``python:module:Name`` (your own class), and what installed packages add by an entry point in the group
``lockprobe.agents``. Options follow a question mark:
``human-inspired:proximity?lapse=0.1``. Those of a viewer and of its strategy stand side by side:
``viewer:human-inspired:proximity?acuity=40&lapse=0.1``.
"""

from __future__ import annotations

import difflib
import importlib
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from types import ModuleType
from typing import Any, Literal
from urllib.parse import urlencode

from lockprobe.agents.access import Access
from lockprobe.agents.cognitive import CHARACTERS, MODELS, SoftmaxMemory
from lockprobe.agents.human_inspired import PRESETS, HumanInspired
from lockprobe.agents.llm.model_facts import facts_of
from lockprobe.agents.llm.settings import ModelSettings, read_settings
from lockprobe.agents.modalities import Senses
from lockprobe.agents.participant import Participant, check_participant
from lockprobe.agents.strategies import RandomAgent, RandomNoRepeat, RoundRobin
from lockprobe.agents.viewer import Sight, Viewer
from lockprobe.errors import BadValue, UnknownName, printable
from lockprobe.plugins import Plugin, find_plugin, plugin_names
from lockprobe.protocols import Agent
from lockprobe.spec import PEOPLE, read_options, spec_name, with_options

__all__ = ["AgentSource", "Engine", "known_specs", "resolve"]

Engine = Literal["inline", "process", "network", "person"]
"""Where its time goes: none to speak of; a processor (one worker process each); waiting for somebody else; and a
person, who is waited for on a page and never by a run."""

_STRATEGIES: dict[str, Callable[[], Agent]] = {
    "random": RandomAgent,
    "random-no-repeat": RandomNoRepeat,
    "round-robin": RoundRobin,
}
_PARAMETRIC = ("human-inspired", "cognitive", "ideal-observer")
_ACCESS = Access()
_VIEWED = "human-inspired:target-first"


def _described(kind: type[Any]) -> str:
    """What it is, in its own first words, and the options that its fields are."""
    return f"{(kind.__doc__ or '').splitlines()[0]} Options: {', '.join(field.name for field in fields(kind))}."


_OTHERS = {
    "human-inspired[:PRESET]": f"{_described(HumanInspired)} Presets: {', '.join(PRESETS)}.",
    "ideal-observer": "Concludes all that can be from what it was told, and plans by it. "
    "Options: prior, noise, plan, persistence.",
    **{f"cognitive:{name}": _described(model) for name, model in MODELS.items()},
    "cognitive:CHARACTER": f"A softmax memory with settings of its own. Characters: {', '.join(CHARACTERS)}.",
    "viewer[:STRATEGY]": "Reads pictures, misreads included, and plays any strategy above by what it read; "
    f"{_VIEWED} by itself. Options: {', '.join(field.name for field in fields(Sight))}, and its strategy's.",
    "llm:local": "The embedded language model.",
    "llm:gguf:PATH": "Any language model in a GGUF file.",
    "llm:PROVIDER/MODEL": "Any model that Inspect AI reaches, for example llm:openai/gpt-4o. "
    f"Options: {', '.join(field.name for field in fields(ModelSettings))}.",
    "participant": "People, on the page of lockprobe serve.",
    "python:module:Name": "Your own class with the Agent protocol.",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentSource:
    """How to get an agent.

    Attributes:
        spec: Its spec.
        engine: Where its time goes.
        senses: What it can take in. One's own class is taken to look, and has to refuse pictures itself if it cannot:
            no code of a user runs because a study is planned or a record is read.
        make: Builds it; may load a model, and may raise :class:`lockprobe.errors.UserMistake`.
        check: Finds out cheaply whether ``make`` can work, with the same errors.
    """

    spec: str
    engine: Engine
    make: Callable[[], Agent]
    check: Callable[[], None] = lambda: None
    senses: Senses = "reports"


def known_specs() -> dict[str, str]:
    """Every form of spec that Lockprobe has itself, and what it is."""
    return {name: (make.__doc__ or "").strip().split("\n")[0] for name, make in _STRATEGIES.items()} | _OTHERS


def resolve(spec: str, access: Access = _ACCESS) -> AgentSource:
    """Find the agent that a spec names.

    Args:
        spec: Its spec.
        access: How it is reached, if it is a hosted model.

    Raises:
        UnknownName: If there is none; the message lists what exists.
        BadValue: If it holds characters that are not seen themselves, or an option that cannot be.
    """
    if not spec.isprintable():
        raise BadValue("agent", printable(spec), "a name without control characters")
    if spec in _STRATEGIES:
        return AgentSource(spec=spec, engine="inline", make=_STRATEGIES[spec])
    head, _, rest = spec.partition(":")
    if spec.partition("?")[0].partition(":")[0] in _PARAMETRIC:
        agent = _parametric(spec)
        return AgentSource(spec=spec, engine="inline", make=lambda: agent)
    if spec.partition("?")[0].partition(":")[0] == "viewer":
        viewer = _viewer(spec)
        return AgentSource(spec=spec, engine="inline", senses="pictures", make=lambda: viewer)
    if head == PEOPLE:
        check_participant(spec)
        return AgentSource(spec=spec, engine="person", senses="pictures", make=Participant)
    if head == "llm":
        return _language_model(spec, rest, access)
    if (plugin := find_plugin("agent", spec_name(spec))) is not None:
        return _of_another_package(spec, plugin)
    raise UnknownName("agent", spec, [*known_specs(), *plugin_names("agent")], near=_meant(spec))


def _meant(spec: str) -> str | None:
    """The spec that somebody probably meant who left out what stands in front of it, or mistyped it."""
    name, mark, options = spec.partition("?")
    if "/" in name:
        return f"llm:{spec}"
    full = {one: one for one in (*_STRATEGIES, "human-inspired", "ideal-observer", "viewer", PEOPLE)}
    full |= {one: f"cognitive:{one}" for one in (*MODELS, *CHARACTERS)}
    full |= {one: f"human-inspired:{one}" for one in PRESETS} | {"local": "llm:local", "gguf": "llm:gguf:PATH"}
    near = difflib.get_close_matches(name, full, n=1)
    return f"{full[near[0]]}{mark}{options}" if near else None


def _parametric(spec: str) -> Agent:
    """An agent whose parameters stand in its spec."""
    full, options = read_options(spec)
    head, _, name = full.partition(":")
    agent: Agent
    if head == "human-inspired":
        if (preset := PRESETS.get(name or "target-first")) is None:
            raise UnknownName("preset of human-inspired", name, PRESETS)
        agent = with_options(HumanInspired, head, options, preset)
    elif head == "cognitive":
        if name not in MODELS and name not in CHARACTERS:
            raise UnknownName("cognitive model", name, [*MODELS, *CHARACTERS])
        agent = with_options(MODELS.get(name, SoftmaxMemory), full, options, CHARACTERS.get(name))
    elif name:
        raise UnknownName("agent", spec, known_specs())
    else:
        from lockprobe.agents.ideal_observer import IdealObserver

        agent = IdealObserver.from_options(options)
    return agent


def _viewer(spec: str) -> Viewer:
    """A strategy with eyes. Of the options those that are a viewer's are the viewer's, all others its strategy's."""
    full, options = read_options(spec)
    name = full.partition(":")[2] or _VIEWED
    if name not in _STRATEGIES and name.partition(":")[0] not in _PARAMETRIC:
        raise UnknownName("strategy of viewer", name, [*_STRATEGIES, *_PARAMETRIC])
    seeing = {field.name for field in fields(Sight)}
    plain = resolve(name).make()
    deciding: list[str] = [field.name for field in fields(plain)] if is_dataclass(plain) else []
    for option in options:
        if option not in {*seeing, *deciding}:
            raise UnknownName(f"option of {full}", option, [*sorted(seeing), *deciding])
    sight = with_options(Sight, "viewer", {key: text for key, text in options.items() if key in seeing})
    rest = urlencode({key: text for key, text in options.items() if key not in seeing})
    strategy = f"{name}?{rest}" if rest else name
    return Viewer(strategy=resolve(strategy).make(), name=strategy, sight=sight)


def _hosted() -> ModuleType:
    """Imported when a model is asked: it takes seconds."""
    return importlib.import_module("lockprobe.agents.llm.model")


def _language_model(spec: str, name: str, access: Access) -> AgentSource:
    if name.partition("?")[0] == "local" or name.startswith("gguf:"):
        from lockprobe.agents import local

        local.read_options(spec)
        return AgentSource(
            spec=spec,
            engine="process",
            make=lambda: local.LocalModel.from_spec(spec),
            check=lambda: local.check(spec),
        )
    if "/" in name.strip("/"):
        blind = facts_of(read_settings(name)[0]).images is False  # of one that is not known its provider has to say so
        return AgentSource(
            spec=spec,
            engine="network",
            senses="reports" if blind else "pictures",
            make=lambda: _hosted().HostedModel(name, access),
            check=lambda: _hosted().check(name, access),
        )
    raise UnknownName("language model", spec, [name for name in _OTHERS if name.startswith("llm:")])


def _of_another_package(spec: str, plugin: Plugin) -> AgentSource:
    """An agent that Lockprobe does not have itself. Nothing of it is imported before it is made or checked."""
    options = read_options(spec)[1]

    def make() -> Agent:
        found = plugin.make(options)
        with plugin.guarded():
            is_one = isinstance(found, Agent)
        if not is_one:
            raise BadValue("agent", spec, "a class with `facts` and `async decide(situation, rng)`")
        agent: Agent = found
        return agent

    def check() -> None:
        make()

    return AgentSource(spec=spec, engine="inline", senses="pictures", make=make, check=check)
