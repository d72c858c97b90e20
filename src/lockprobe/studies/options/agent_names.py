"""Names of agents: what keys, tables and pages call an agent in place of its spec."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from lockprobe.agents.catalogue import resolve
from lockprobe.agents.local import portable
from lockprobe.foundation.errors import BadValue, UserMistake
from lockprobe.foundation.spec import PEOPLE, named_spec
from lockprobe.foundation.terminal_text import printable

LONGEST_LABEL = 200
"""Characters of what keys, tables and pages call an agent."""

_SHOWN = 40


def named_agents(written: Iterable[str]) -> tuple[list[str], dict[str, str]]:
    """The specs of agents that are written as ``SPEC`` or ``NAME=SPEC``, and spec -> name of those with a name.

    Specs are those of records, without paths of this machine (:func:`lockprobe.agents.local.portable`).

    >>> named_agents(["careful=human-inspired?lapse=0.1", "random"])
    (['human-inspired?lapse=0.1', 'random'], {'human-inspired?lapse=0.1': 'careful'})

    Raises:
        BadValue: If a name is that of an agent, or one agent has two names.
    """
    specs, names = list[str](), dict[str, str]()
    for text in written:
        name, spec = named_spec(text, "agent", "careful=human-inspired?lapse=0.1")
        spec = portable(spec)
        if spec in specs and (name or names.get(spec)):
            said = f"{printable(short(spec))} once: the same seed gives the same trials under every name"
            raise BadValue("agent", printable(short(text)), said)
        specs.append(spec)
        if name:
            if spec == PEOPLE or (name != spec and _is_agent(name)):
                said = f"{PEOPLE} without a name" if spec == PEOPLE else f"another name: {name} is an agent"
                raise BadValue("agent", printable(short(text)), said)
            names[spec] = name
    return specs, names


def _is_agent(name: str) -> bool:
    try:
        return bool(resolve(name))
    except UserMistake:
        return False


def check_names(agents: Iterable[str], names: Mapping[str, str]) -> None:
    """Refuse a name that cannot stand in a key, and a spec that is too long to stand there without a name."""
    for spec in agents:
        name = names.get(spec, "")
        if not name and len(spec) > LONGEST_LABEL:
            expected = f"at most {LONGEST_LABEL} characters, not {len(spec)}, or a name: --agent 'NAME=SPEC'"
            raise BadValue("agent", printable(short(spec)), expected)
        if not name.isprintable() or name != name.strip() or len(name) > LONGEST_LABEL or name == PEOPLE:
            expected = f"a name of at most {LONGEST_LABEL} visible characters without blanks around it"
            raise BadValue("name of an agent", printable(short(name)), expected)


def joined_agents(there: Sequence[str], asked: Sequence[str]) -> tuple[str, ...]:
    """The agents of a study after agents are added: new ones follow those that are there, and people stand last.

    >>> joined_agents(["random"], ["round-robin"]), joined_agents(["participant"], ["random"])
    (('random', 'round-robin'), ('random', 'participant'))
    """
    if {*asked} <= {*there}:
        return tuple(there)
    return tuple(sorted(dict.fromkeys((*there, *asked)), key=lambda agent: agent == PEOPLE))


def short(text: str) -> str:
    """The beginning of a long text, for a message."""
    return text if len(text) <= LONGEST_LABEL else f"{text[:_SHOWN]}…"
