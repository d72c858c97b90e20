"""Pages from templates: text from agents, models and box files is escaped."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import cache, lru_cache, partial
from typing import Any

from markupsafe import Markup, escape

from lockprobe.foundation.formatting import p_cell
from lockprobe.foundation.terminal_text import printable
from lockprobe.report.format import Entry, alone, entry_text
from lockprobe.report.rows import Estimate

_SHORT = 12
"""Words of so many characters stay on one line in a table."""


def rendered(name: str, **values: Any) -> str:
    """A page from its template, with these values; text in them is escaped.

    Args:
        name: Of the template, without its ending.
        values: What the template names; a name without a value is an error.
    """
    return str(_templates().get_template(f"{name}.html.jinja").render(**values))


def own_markup(text: str) -> Markup:
    """Our own markup, or JSON without ``<``."""
    return Markup(text)  # noqa: S704  a template's own output


def _reach(rows: Sequence[Sequence[Entry]], column: str) -> float:
    """The end of an axis around 0 that holds the differences of a column with their intervals; 0 without any."""
    at = [*rows[0]].index(column) if column in rows[0] else None
    drawn = [row[at] for row in rows[1:]] if at is not None else []
    found = [one for one in drawn if isinstance(one, Estimate)]
    ends = [abs(end) for one in found for end in (one.value, one.low, one.high) if end is not None]
    return 1.05 * max([0.1, *ends]) if found else 0.0


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
    # a spec that a line may end in, after the marks between its parts
    breakable = partial(re.sub, r"(:|(?<!<)/|\?|&amp;)(?=\w)", r"\1<wbr>")
    environment.filters |= {"breakable": lambda name: own_markup(breakable(str(_shown(name)))), "entry": entry_text}
    environment.filters |= {"alone": alone, "p": _small, "reach": _reach}
    environment.tests["wordy"] = lambda cell: len(cell) > _SHORT and re.search("[a-z]{4}", cell) is not None
    return environment


def _shown(value: Any) -> Any:
    """A value as a page prints it: text on one line and printable, the P of P values in italics; markup is our own."""
    return value if not isinstance(value, str) or hasattr(value, "__html__") else _escaped(str(value))


@lru_cache(maxsize=10_000)
def _escaped(value: str) -> Markup:
    """A text as a page prints it; cells of tables are often alike."""
    text = str(escape(printable(re.sub(r"\s", " ", value))))
    return own_markup(re.sub(r"\bP(?= (?:=|&lt;) )", "<i>P</i>", text).replace(" %", "&nbsp;%"))


def _small(value: float | None) -> str:
    """A P value as a page prints it."""
    return "< 0.001" if value is not None and value < 0.001 else p_cell(value)
