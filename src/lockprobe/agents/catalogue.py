"""The catalogue of agents by spec. Heavy modules are imported only when an agent needs them.

Specs: ``random``, ``random-no-repeat``, ``round-robin``, ``right-to-left``, ``human-inspired[:preset]``,
``ideal-observer``, ``cognitive:MODEL``, ``viewer[:STRATEGY]`` (reads pictures and plays a strategy by them),
``llm:local`` (the embedded model), ``llm:gguf:PATH`` (any GGUF file), ``llm:PROVIDER/MODEL`` (any model that is
served), ``participant`` (people), ``mcp:NAME`` (an agent with tools), ``python:module:Name`` (your class), and what
installed packages add by an entry point in the group ``lockprobe.agents``. Options follow a question mark:
``human-inspired:proximity?lapse=0.1``. Those of a viewer and of its strategy stand side by side:
``viewer:human-inspired:proximity?acuity=40&lapse=0.1``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, is_dataclass
from inspect import iscoroutinefunction, isfunction
from typing import Any, Literal

from lockprobe.agents.cognitive import CHARACTERS, MODELS, SoftmaxMemory
from lockprobe.agents.human_inspired import PRESETS, HumanInspired
from lockprobe.agents.llm.settings import Access, Model, ModelSettings
from lockprobe.agents.outside import OutsideAgent, check_client, check_participant
from lockprobe.agents.strategies import RandomAgent, RandomNoRepeat, RightToLeft, RoundRobin
from lockprobe.agents.viewer import Eyesight, Viewer
from lockprobe.foundation.docstrings import first_line
from lockprobe.foundation.errors import BadValue, UnknownName, UserMistake
from lockprobe.foundation.plugins import Plugin, find_plugin, has_methods, plugin_names
from lockprobe.foundation.spec import MCP, PEOPLE, Spec, spec_kind, with_options
from lockprobe.foundation.terminal_text import printable
from lockprobe.trial.protocols import Agent

Engine = Literal["inline", "process", "network", "person", "client"]
"""Where its time goes: none to speak of; a processor (one worker process each); waiting for somebody else; and a
person or a client with tools, who are waited for by a server and never by a run."""

Senses = Literal["reports", "pictures"]
"""What an agent can read: only reports in words, or pictures too."""

_STRATEGIES: Mapping[str, Callable[[], Agent]] = {
    "random": RandomAgent,
    "random-no-repeat": RandomNoRepeat,
    "round-robin": RoundRobin,
    "right-to-left": RightToLeft,
}
_ACCESS = Access()
_VIEWED = "human-inspired:target-first"


def _options(kind: type[Any]) -> list[str]:
    return [field.name for field in fields(kind)]


def _described(kind: type[Any]) -> str:
    """The first line of a class's docstring, and its fields as options."""
    options = f" Options: {', '.join(_options(kind))}." if _options(kind) else ""
    return f"{first_line(kind)}{options}"


_KNOWN: Mapping[str, str] = {
    **{name: first_line(make) for name, make in _STRATEGIES.items()},
    "human-inspired[:PRESET]": f"{_described(HumanInspired)} Presets: {', '.join(PRESETS)}.",
    "ideal-observer": "Infers the interlock from all reports (Bayesian) and plans by the posterior. "
    "Options: prior, noise, plan, reading.",
    **{f"cognitive:{name}": _described(model) for name, model in MODELS.items()},
    "cognitive:CHARACTER": f"A softmax memory with fixed settings. Characters: {', '.join(CHARACTERS)}.",
    "viewer[:STRATEGY]": "Reads pictures and plays any strategy with its readings. "
    f"It can misread; its strategy is {_VIEWED} unless you name one. "
    f"Options: {', '.join(_options(Eyesight))}, and its strategy's.",
    "llm:local": "SmolLM2-135M-Instruct, a very small language model.",
    "llm:gguf:PATH": "Any language model in a GGUF file.",
    "llm:PROVIDER/MODEL": "Any model that is served, hosted or on a machine of your own, such as llm:openai/gpt-4o. "
    f"Options: {', '.join(_options(ModelSettings))}.",
    "participant": "People, on the page of lockprobe serve.",
    "mcp:NAME": "An agent with tools, which connects to lockprobe mcp.",
    "python:module:Name": "Your own class with the Agent protocol.",
}

_CHARACTERS = {
    "cognitive:careful": "Turns to what has neither moved nor failed, the target first.",
    "cognitive:perseverant": "Does again what has just moved, and so undoes it.",
    "cognitive:insistent": "Does again what has just failed.",
}
"""What a softmax memory does with these settings."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentSource:
    """How to get an agent.

    Attributes:
        spec: Its spec.
        engine: What its computing time depends on.
        senses: What it can perceive. A user's class counts as able to see, and has to refuse pictures itself if it
            cannot: planning a study or reading a record runs no code of a user.
        make: Builds the agent; may load a model, and may raise :class:`lockprobe.foundation.errors.UserMistake`.
        check: Checks cheaply whether ``make`` can work, with the same errors.
    """

    spec: str
    engine: Engine
    make: Callable[[], Agent]
    check: Callable[[], object] = lambda: None
    senses: Senses = "reports"


def known_specs() -> dict[str, str]:
    """The forms of all specs of Lockprobe's own agents, with descriptions."""
    return dict(_KNOWN)


def description(spec: str) -> str:
    """The description of a shipped agent in one sentence; empty for hosted models, people and other agents.

    >>> description("llm:local")
    'SmolLM2-135M-Instruct, a very small language model.'
    """
    form = Spec.parse(spec)
    if not form.options and form.full_name in _CHARACTERS:
        return _CHARACTERS[form.full_name]
    if form.kind in (PEOPLE, "python"):
        return ""
    kinds = {name.partition("[")[0].removesuffix(":NAME").removesuffix(":CHARACTER"): of for name, of in _KNOWN.items()}
    found = kinds.get(form.full_name) or kinds.get(form.kind, "")
    return f"{found.partition('. ')[0].removesuffix('.')}." if found else ""


def resolve(spec: str | Spec, access: Access = _ACCESS) -> AgentSource:
    """Find the agent that a spec names.

    Args:
        spec: The spec, or its text.
        access: Connection settings, if it is a hosted model.

    Raises:
        UnknownName: If there is no such agent; the message lists those that exist.
        BadValue: If the spec holds invisible characters, or an invalid option.
    """
    text = str(spec)
    if not text.isprintable():
        raise BadValue("agent", printable(text), "a name without control characters")
    if text in _STRATEGIES:
        return AgentSource(spec=text, engine="inline", make=_STRATEGIES[text])
    spec = spec if isinstance(spec, Spec) else Spec.parse(spec)
    if spec.kind in _PARAMETRIC:
        agent = _PARAMETRIC[spec.kind](spec)
        return AgentSource(spec=text, engine="inline", make=lambda: agent)
    if spec.kind == "viewer":
        return _viewer(spec)
    if spec.kind in (PEOPLE, MCP):
        (check_participant if spec.kind == PEOPLE else check_client)(text)
        engine: Engine = "person" if spec.kind == PEOPLE else "client"
        return AgentSource(spec=text, engine=engine, senses="pictures", make=OutsideAgent)
    if spec.kind == "llm":
        return _language_model(spec, access)
    if (plugin := find_plugin("agent", text)) is not None:
        return _of_another_package(spec, plugin)
    near = f"llm:{spec}" if "/" in spec.full_name else None
    raise UnknownName("agent", text, [*_KNOWN, *plugin_names("agent")], near=near)


def is_strategy(spec: str) -> bool:
    """Whether an agent is a strategy that ships here: it computes its choices at no cost, and chooses them again.

    >>> is_strategy("human-inspired"), is_strategy("llm:local")
    (True, False)
    """
    return spec in _STRATEGIES or Spec.parse(spec).kind in (*_PARAMETRIC, "viewer")


def _human_inspired(spec: Spec) -> Agent:
    if (preset := PRESETS.get(spec.name or "target-first")) is None:
        raise UnknownName("preset of human-inspired", spec.name, PRESETS)
    return with_options(HumanInspired, spec.kind, spec.options, preset)


def _cognitive(spec: Spec) -> Agent:
    if spec.name not in MODELS and spec.name not in CHARACTERS:
        raise UnknownName("cognitive model", spec.name, [*MODELS, *CHARACTERS])
    model = MODELS.get(spec.name, SoftmaxMemory)
    agent: Agent = with_options(model, spec.full_name, spec.options, CHARACTERS.get(spec.name))
    return agent


def _ideal_observer(spec: Spec) -> Agent:
    if spec.name:
        raise UnknownName("agent", str(spec), _KNOWN)
    from lockprobe.agents.ideal_observer import IdealObserver

    return with_options(IdealObserver, spec.kind, spec.options)


_PARAMETRIC: Mapping[str, Callable[[Spec], Agent]] = {
    "human-inspired": _human_inspired,
    "cognitive": _cognitive,
    "ideal-observer": _ideal_observer,
}
"""The kinds of strategies with parameters in their spec."""


def _viewer(spec: Spec) -> AgentSource:
    """A viewer with its strategy. Options of its eyesight are its own; all others belong to the strategy."""
    strategy = Spec.parse(spec.name or _VIEWED)
    if spec.name not in ("", *_STRATEGIES) and strategy.kind not in _PARAMETRIC:
        raise UnknownName("strategy of viewer", spec.name, [*_STRATEGIES, *_PARAMETRIC])
    seeing, plain = sorted(_options(Eyesight)), resolve(strategy).make()
    known = [*seeing, *(_options(type(plain)) if is_dataclass(plain) else [])]
    for option in spec.options:
        if option not in known:
            raise UnknownName(f"option of {spec.full_name}", option, known)
    sight = with_options(Eyesight, spec.kind, {name: text for name, text in spec.options.items() if name in seeing})
    strategy = strategy.adding(spec.without(seeing).options)
    viewer = Viewer(strategy=resolve(strategy).make(), name=str(strategy), sight=sight)
    return AgentSource(spec=str(spec), engine="inline", senses="pictures", make=lambda: viewer)


def _language_model(spec: Spec, access: Access) -> AgentSource:
    text = str(spec)
    if spec.name == "local" or spec.name.startswith("gguf:"):
        from lockprobe.agents import local

        local.LocalSettings.parse(spec)
        return AgentSource(
            spec=text,
            engine="process",
            make=lambda: local.LocalModel.from_spec(spec),
            check=lambda: local.check(spec),
        )
    if "/" not in spec.name.strip("/"):
        raise UnknownName("language model", text, [name for name in _KNOWN if spec_kind(name) == spec.kind])
    blind = Model.parse(text).facts.images is False  # of one that is not known its provider has to say so

    def make() -> Agent:
        from lockprobe.agents.llm.model import HostedModel

        return HostedModel(text, access)

    senses: Senses = "reports" if blind else "pictures"
    return AgentSource(spec=text, engine="network", senses=senses, make=make, check=make)


def _is_agent(found: object) -> bool:
    """Whether it is a class of agents, or an agent."""
    return has_methods(found, "decide") or (not isinstance(found, type) and isinstance(found, Agent))


def _of_another_package(spec: Spec, plugin: Plugin) -> AgentSource:
    """An agent of another package. Nothing of it is imported before it is made or checked."""
    expected = "a class with `facts` and `async decide(situation, rng)`"

    def make() -> Agent:
        found = plugin.make(spec.options, is_one=_is_agent, expected=expected)
        with plugin.guarded():
            is_one = isinstance(found, Agent)
            plain = is_one and isfunction(getattr(found.decide, "__func__", found.decide))
            waits = not plain or iscoroutinefunction(found.decide)
        if not is_one:
            raise BadValue("agent", str(spec), expected)
        if not waits:
            raise UserMistake(f"agent {str(spec)!r}: decide must be `async def`")
        agent: Agent = found
        return agent

    return AgentSource(spec=str(spec), engine="inline", senses="pictures", make=make, check=make)
