"""Pages from templates: text from agents, models and box files is escaped."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import cache, lru_cache
from typing import Any, TypeVar

from lockprobe.foundation.formatting import p_cell, points
from lockprobe.foundation.terminal_text import printable

_Drawn = TypeVar("_Drawn", bound=Any)

_SHORT = 12
"""Words of so many characters stay on one line in a table."""


def rendered(name: str, **values: Any) -> str:
    """A page from its template, with these values; text in them is escaped.

    Args:
        name: Of the template, without its ending.
        values: What the template names; a name without a value is an error.
    """
    return str(_templates().get_template(f"{name}.html.jinja").render(**values))


def with_axis(rows: Sequence[_Drawn]) -> list[tuple[_Drawn, float]]:
    """Differences, or None, each with the end of an axis around 0 that holds them all with their intervals."""
    ends = [abs(end) for row in rows if row for end in (row.value, row.low, row.high) if end is not None]
    return [(row, 1.05 * max([0.1, *ends])) for row in rows]


@cache
def _templates() -> Any:
    """The templates of the pages, compiled once. What is put in is escaped."""
    import jinja2

    environment = jinja2.Environment(
        autoescape=True,
        finalize=_shown,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        loader=jinja2.PackageLoader("lockprobe.report"),
    )
    environment.filters |= {"breakable": _breakable, "specs": _specs, "points": points, "p": _small}
    environment.tests["wordy"] = lambda cell: len(cell) > _SHORT and re.search("[a-z]{4}", cell) is not None
    return environment


def _shown(value: Any) -> Any:
    """A value as a page prints it: text on one line and printable, the P of P values in italics; markup is our own."""
    return value if not isinstance(value, str) or hasattr(value, "__html__") else _escaped(str(value))


@lru_cache(maxsize=10_000)
def _escaped(value: str) -> Any:
    """A text as a page prints it; cells of tables are often alike."""
    from markupsafe import Markup, escape

    text = str(escape(printable(re.sub(r"\s", " ", value))))
    return Markup(re.sub(r"\bP(?= (?:=|&lt;) )", "<i>P</i>", text))  # noqa: S704  escaped just above


def _breakable(name: str) -> Any:
    """A spec that a line may end in, after the marks between its parts."""
    from markupsafe import Markup

    return Markup(re.sub(r"(:|(?<!<)/|\?|&amp;)(?=\w)", r"\1<wbr>", str(_shown(name))))  # noqa: S704  escaped by _shown


def _small(value: float | None) -> str:
    """A P value as a page prints it."""
    return "< 0.001" if value is not None and float(f"{value:.2g}") < 0.001 else p_cell(value)


def _specs(text: str) -> Any:
    """A sentence with its specs in the letters of code."""
    from markupsafe import Markup

    return Markup(re.sub(r"\S+:[^\s,;]*[\w)]", lambda spec: f"<code>{spec[0]}</code>", str(_shown(text))))  # noqa: S704
