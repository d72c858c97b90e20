"""Parts of sentences: who is spoken of, shares, differences, flip rates and P values.

People are many, and have no spec. The letter p is the flip rate's in code and in files: for readers a flip rate is
written out, and the P of a P value is a capital.
"""

from __future__ import annotations

import re

from lockprobe.analysis.proportions import Proportion
from lockprobe.spec import PEOPLE

__all__ = ["begun", "called", "of_people", "of_trials", "p_said", "percent", "points_said", "test_said", "told", "verb"]

_P = re.compile(r"\bp\b")

_MANY = (
    ("the agent is", "people are"),
    ("the agent loops", "people loop"),
    ("the agent solves", "people solve"),
    ("the agent", "people"),
    ("its action habits", "their action habits"),
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


def told(p: float) -> str:
    """Under which condition, in a sentence."""
    return "when told the truth" if p == 0 else f"at a flip rate of {p:g}"


def of_trials(share: Proportion) -> str:
    """A share as a count and in per cent."""
    return f"{share.count} of {share.n} trials ({percent(share.value)})"


def percent(value: float) -> str:
    """A share in whole per cent."""
    return f"{100 * value:.0f} %"


def points_said(value: float) -> str:
    """A difference of shares in points, with its sign."""
    return f"{100 * value:+.0f}".replace("-", "\N{MINUS SIGN}")


def p_said(value: float) -> str:
    """A P value.

    >>> p_said(0.0004), p_said(0.843)
    ('P < 0.001', 'P = 0.84')
    """
    return "P < 0.001" if value < 0.001 else f"P = {value:.2g}"


def test_said(name: str) -> str:
    """The name of a test for readers: names as they are on record, and in the audit, say p for the flip rate.

    >>> test_said("looped by step 10, Mantel-Haenszel by p")
    'looped by step 10, Mantel-Haenszel by flip rate'
    """
    return _P.sub("flip rate", name.replace("values of p", "flip rates"))
