"""Pages from templates: text from agents, models and box files is escaped, and figures are part of the page."""

from __future__ import annotations

import base64
import re
from functools import cache
from typing import Any

from lockprobe.foundation.terminal_text import printable

__all__ = ["compact_svg", "image", "rendered"]

_COLUMN = 270.0
"""A figure is one column of print wide up to here, in points."""

_SHORT = 12
"""Words of so many characters stay on one line in a table."""


def rendered(name: str, **values: Any) -> str:
    """A page from its template, with these values; text in them is escaped.

    Args:
        name: Of the template, without its ending.
        values: What the template names; a name without a value is an error.
    """
    return str(_templates().get_template(f"{name}.html.jinja").render(**values))


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
    environment.filters |= {"breakable": _breakable, "specs": _specs}
    environment.tests["wordy"] = lambda cell: len(cell) > _SHORT and re.search("[a-z]{4}", cell) is not None
    return environment


def image(svg: bytes) -> dict[str, Any]:
    """A figure for the page, and whether it is more than one column of print wide."""
    wide = re.search(rb'width="([\d.]+)pt"', svg)
    source = "data:image/svg+xml;base64," + base64.b64encode(compact_svg(svg)).decode()
    return {"source": source, "broad": wide is not None and float(wide[1]) > _COLUMN}


def compact_svg(svg: bytes) -> bytes:
    """A figure of matplotlib in about half as many bytes: coordinates to a hundredth of a point."""
    svg = re.sub(rb"<metadata>.*?</metadata>|<!--.*?-->|<\?xml.*?\?>|<!DOCTYPE.*?>", b"", svg, flags=re.DOTALL)
    svg = re.sub(rb"> <", b"><", re.sub(rb"\s+", b" ", re.sub(rb'<g id="[^"]*"', b"<g", svg)))
    svg = re.sub(rb"(?<!scale\()(\b\d+\.\d\d)\d+", rb"\1", svg)
    svg = re.sub(
        rb'(<use [^>]*?)transform="translate\(([\d.]+) 0\)"', rb'\1x="\2"', svg.replace(b"xlink:href", b"href")
    )
    names = {name: b"%x" % i for i, name in enumerate(dict.fromkeys(re.findall(rb' id="([^"]*)"', svg)))}
    return re.sub(rb'(?<= id=")[^"]*|(?<=#)[A-Za-z][\w-]*(?=[")])', lambda name: names.get(name[0], name[0]), svg)


def _shown(value: Any) -> Any:
    """A value as a page prints it: text on one line and printable, the P of P values in italics; markup is our own."""
    if not isinstance(value, str) or hasattr(value, "__html__"):
        return value
    from markupsafe import Markup, escape

    text = str(escape(printable(re.sub(r"\s", " ", value))))
    return Markup(re.sub(r"\bP(?= (?:=|&lt;) )", "<i>P</i>", text))  # noqa: S704  escaped just above


def _breakable(name: str) -> Any:
    """A spec that a line may end in, after the marks between its parts."""
    from markupsafe import Markup

    return Markup(re.sub(r"(:|(?<!<)/|\?|&amp;)(?=\w)", r"\1<wbr>", str(_shown(name))))  # noqa: S704  escaped by _shown


def _specs(text: str) -> Any:
    """A sentence with its specs in the letters of code."""
    from markupsafe import Markup

    return Markup(re.sub(r"\S+:[^\s,;]*[\w)]", lambda spec: f"<code>{spec[0]}</code>", str(_shown(text))))  # noqa: S704
