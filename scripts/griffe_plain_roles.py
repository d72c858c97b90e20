"""Prepares docstrings for the site, which reads them as Markdown: roles, literal marks and doctests."""

from __future__ import annotations

import re
from typing import Any

import griffe


def plain(text: str) -> str:
    """A docstring in Markdown: roles become names, doctests become blocks of code."""
    text = re.sub(r":(?:mod|class|func|meth|attr|data|exc):`~?([^`]*)`", r"`\1`", text)
    text = re.sub(r"^::$\n?", "", re.sub(r"(?<=\S)::$", ":", text, flags=re.MULTILINE), flags=re.MULTILINE)
    return re.sub(r"^>>> .*(?:\n.*\S.*)*", r"```pycon\n\g<0>\n```", text, flags=re.MULTILINE)


class PlainRoles(griffe.Extension):
    """Rewrites every docstring that is loaded."""

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        """Called once for each object."""
        if obj.docstring:
            obj.docstring.value = plain(obj.docstring.value)
