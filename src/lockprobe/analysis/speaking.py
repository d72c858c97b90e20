"""People in sentences about agents: they are many, and have no spec."""

from __future__ import annotations

from lockprobe.options import PEOPLE

__all__ = ["begun", "called", "of_people", "verb"]

_MANY = (
    ("the agent is", "people are"),
    ("the agent loops", "people loop"),
    ("the agent solves", "people solve"),
    ("the agent", "people"),
)


def called(agent: str, shown: str = "") -> str:
    """What a sentence calls an agent: its spec, and people by that word.

    >>> called("participant"), called("llm:local", "RGB")
    ('people', 'llm:local (RGB)')

    Args:
        agent: Agent spec.
        shown: How the box was shown, where that has to be said.
    """
    name = "people" if agent == PEOPLE else agent
    return f"{name} ({shown})" if shown else name


def verb(agent: str, one: str, many: str) -> str:
    """The form of a verb, or the pronoun, that goes with an agent."""
    return many if agent == PEOPLE else one


def begun(sentence: str) -> str:
    """A sentence as it stands at the beginning; a spec stays as it is.

    >>> begun("people need more"), begun("random needs more")
    ('People need more', 'random needs more')
    """
    return f"P{sentence[1:]}" if sentence.startswith("people ") else sentence


def of_people(sentence: str) -> str:
    """A sentence about an agent as one about people.

    >>> of_people("After a loop the agent is less likely to solve the box")
    'After a loop people are less likely to solve the box'
    """
    for one, many in _MANY:
        sentence = sentence.replace(one, many)
    return sentence
