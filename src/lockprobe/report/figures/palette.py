"""What an agent looks like: one colour and one mark, the same in every report.

Agents that ship have theirs in a table; those of any other come out of its spec. Thick lines and filled markers are
agents that the study is about, thin ones with hollow markers those to compare with. An agent that is shown the box in
several ways keeps its mark, in a shade and a dash for each way.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from hashlib import sha256
from itertools import product
from typing import Any

import matplotlib as mpl

from lockprobe.foundation.spec import spec_name
from lockprobe.report.rows import Course

Dash = str | tuple[int, tuple[float, ...]]
Marker = str | tuple[int, int, int]

SUBJECTS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")
"""Colours by Okabe and Ito, whom people with any common colour vision can tell apart."""

TARGET = SUBJECTS[0]
"""The target joint of a box, in figures as on pages."""

ACCENT = SUBJECTS[1]
"""The colour of loops, where one agent is shown by itself."""

_DASHES: tuple[Dash, ...] = ("-", (0, (5, 1.5)), (0, (4, 1.2, 1, 1.2)))

_DOUBLE: Dash = (0, (5, 1.2, 1, 1.2, 1, 1.2))
"""Of the cognitive models alone, so that none of them has the marker and dash of an agent that does not ship."""

_COLOURS = ("#332288", "#882255", "#999933", "#661100", "#AA4499", "#005F73")
"""Colours of agents that do not ship, none of them a colour of one that does."""

_MARKERS: tuple[Marker, ...] = (">", "p", "h", "d", (4, 1, 0), (6, 1, 0))
"""Of agents that do not ship; the last are stars of so many points."""

_SHIPPED: dict[str, tuple[str, Marker, Dash]] = {
    "participant": (SUBJECTS[0], "o", "-"),
    "llm:local": (SUBJECTS[1], "s", "-"),
    "human-inspired": (SUBJECTS[2], "D", _DASHES[2]),
    "ideal-observer": (SUBJECTS[3], "^", "-"),
    "round-robin": (SUBJECTS[4], "v", _DASHES[1]),
    "right-to-left": ("#8c8c00", "v", _DOUBLE),
    "viewer": (SUBJECTS[5], "P", "-"),
    "random": ("#7a7a7a", "X", "-"),
    "random-no-repeat": ("#3d3d3d", "<", "-"),
    "cognitive:careful": ("#5A6900", "p", _DOUBLE),
    "cognitive:perseverant": ("#6929C4", ">", _DOUBLE),
    "cognitive:insistent": ("#C218F0", "h", _DOUBLE),
    "cognitive:random-map": ("#2138E8", "d", _DOUBLE),
    "cognitive:softmax-memory": ("#69C387", (4, 1, 0), _DOUBLE),
}
"""Colour, marker and dash of the agents that ship; of an agent with options of its own they come out of its spec."""

_LEGIBLE = 4.5
"""Contrast of text to white."""

_SHADES = {"symbolic": 0.0, "rgb": 0.45, "rgbd": -0.35}
"""How much white (above 0) or black is mixed into the colour of an agent that is shown the box in several ways."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Style:
    """How one agent looks; ``lead`` if the study is about it. An empty marker draws none."""

    colour: str
    marker: Marker = "o"
    dash: Dash = "-"
    lead: bool = True

    @property
    def face(self) -> str:
        """The inside of its markers."""
        return self.colour if self.lead else "white"

    @property
    def line(self) -> dict[str, Any]:
        """Its line with its markers, as settings of Matplotlib."""
        return {
            "color": self.colour,
            "linestyle": self.dash,
            "linewidth": 1.4 if self.lead else 0.9,
            "marker": self.marker,
            "markersize": 4.8 if self.lead else 3.6,
            "markerfacecolor": self.face,
            "markeredgewidth": 0.7,
            "zorder": 4 if self.lead else 3,
        }


def styles(courses: Sequence[Course]) -> list[tuple[Course, Style]]:
    """Every agent with its looks: those that the study is about first, then the references.

    No two share a colour, as far as there are enough, nor marker and dash, and so they look unlike in grey as well;
    those of one colour share neither. The one whose spec comes later in the alphabet takes the next look.
    """
    shown = [*(one for one in courses if one.subject), *(one for one in courses if not one.subject)]
    found: dict[tuple[str, str], Style] = {}
    own = _own_colours([agent.agent for agent in shown])
    for agent in sorted(shown, key=lambda agent: (agent.agent not in _SHIPPED, agent.agent, agent.modality)):
        colour, marker, dash = _free(list(_looks(agent, own[agent.agent])), found.values())
        found[agent.agent, agent.modality] = Style(colour=colour, marker=marker, dash=dash, lead=agent.subject)
    return [(agent, found[agent.agent, agent.modality]) for agent in shown]


def of_agent(course: Course, style: Style, white: float = 0.0) -> Style:
    """A style in the colour that the agent has in every figure, or in a lighter shade of it.

    An agent whose option is the dose of an axis has courses of its own there, and no other in the study.

    Args:
        course: The agent.
        style: Marks and dashes.
        white: How much white is mixed into the colour, from 0 to 1.
    """
    known = {one.agent for one in course.found.courses()}
    own = _own_colours(known if course.agent in known else [course.agent])
    colour, *_ = next(_looks(course, own[course.agent]))
    return replace(style, colour=_mixed(colour, white) if white else colour)


def _free(looks: Sequence[tuple[str, Marker, Dash]], taken: Collection[Style]) -> tuple[str, Marker, Dash]:
    """The first look that is not taken; better one that has nothing of an agent of the same colour."""
    pairs = {(style.marker, style.dash) for style in taken}
    alike = [style for style in taken if style.colour == looks[0][0]]
    markers, dashes = {style.marker for style in alike}, {style.dash for style in alike}
    free = [look for look in looks if look[1:] not in pairs]
    apart = [look for look in free if look[1] not in markers and look[2] not in dashes]
    return [*apart, *free, *looks][0]


def _number(agent: str) -> int:
    return int.from_bytes(sha256(agent.encode()).digest()[:8])


def _own_colours(agents: Collection[str]) -> dict[str, str]:
    """The colour of each agent: of those that do not ship, the first that fewest others have, from its own on."""
    used = Counter(dict.fromkeys(_COLOURS, 0))
    found = {}
    for agent in sorted(set(agents)):
        if agent in _SHIPPED:
            found[agent] = _SHIPPED[agent][0]
            continue
        start = _number(agent) % len(_COLOURS)
        found[agent] = min(_COLOURS[start:] + _COLOURS[:start], key=lambda colour: used[colour])
        used[found[agent]] += 1
    return found


def _looks(agent: Course, colour: str) -> Iterator[tuple[str, Marker, Dash]]:
    """What it may look like, its own look first, in a colour."""
    first = _number(agent.agent) // len(_COLOURS)
    pairs = list(product(_MARKERS, _DASHES))
    _, marker, dash = _SHIPPED.get(agent.agent, (colour, *pairs[first % len(pairs)]))
    if agent.shown and (kind := spec_name(agent.modality)) in _SHADES:
        colour = _mixed(colour, _SHADES[kind])
        dash = _DASHES[list(_SHADES).index(kind)]
    yield colour, marker, dash
    start = first % len(pairs)
    yield from ((colour, *pair) for pair in pairs[start:] + pairs[:start])


def _mixed(colour: str, white: float) -> str:
    end = 1.0 if white > 0 else 0.0
    red, green, blue = (part + abs(white) * (end - part) for part in mpl.colors.to_rgb(colour))
    return mpl.colors.to_hex((red, green, blue))


@cache
def of_text(colour: str) -> str:
    """The colour, as dark as text on white has to be (contrast of 4.5, WCAG 2.2).

    >>> of_text("#69C387"), of_text("#222222")
    ('#447f58', '#222222')
    """
    darker = (_mixed(colour, -part / 20) if part else colour for part in range(20))
    return next((one for one in darker if _contrast(one) >= _LEGIBLE), colour)


def _contrast(colour: str) -> float:
    """Contrast to white."""
    linear = [part / 12.92 if part <= 0.04 else ((part + 0.055) / 1.055) ** 2.4 for part in mpl.colors.to_rgb(colour)]
    return 1.05 / (0.05 + 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2])
