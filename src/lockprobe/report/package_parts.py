"""Parts of a page that packages add: what they may hold, and the page without them.

``verify`` runs no code of packages, so it cannot make their parts again. It takes them out of the page and compares the
rest. So a part must not reach beyond itself: it is one element, of plain text, tables and pictures, without styles, and
it says whose it is.
"""

from __future__ import annotations

import re
from html.parser import HTMLParser

__all__ = ["stays_within", "without_packages"]

_ELEMENTS = frozenset(
    {
        "a", "b", "br", "caption", "code", "col", "colgroup", "dd", "details", "div", "dl", "dt", "em", "figcaption",
        "figure", "h2", "h3", "h4", "hr", "i", "img", "li", "ol", "p", "pre", "small", "span", "strong", "sub",
        "summary", "sup", "table", "tbody", "td", "tfoot", "th", "thead", "tr", "ul", "wbr",
    }
)  # fmt: skip
"""What a part is made of."""

_EMPTY = frozenset({"br", "col", "hr", "img", "wbr"})
"""Elements without an end tag."""

_PART = re.compile(
    r"<!-- a section of another package -->\n"
    r'(?P<part><details class="section" id="[a-z0-9_-]+\.[a-z0-9._-]+">\n<summary>(?P<head>.*?)</summary>\n'
    r'<p class="by">From the package (?P<source>[^<>]+), not from Lockprobe\.</p>\n(?P<body>.*?)</details>\n)'
    r'<!-- its end -->\n(?=<!-- a section of another package -->\n|\n<details class="section" id="|\n</body>)',
    re.DOTALL,
)


class _Reader(HTMLParser):
    """Whether markup ends all that it begins, and holds nothing but plain elements."""

    def __init__(self) -> None:
        super().__init__(convert_charrefs=False)
        self.within: list[str] = []
        self.plain = True

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        named = (name == "style" or name.startswith("on") for name, _ in attrs)
        self.plain &= tag in _ELEMENTS and not any(named)
        if tag not in _EMPTY:
            self.within.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.plain = False  # a browser does not end it here

    def handle_endtag(self, tag: str) -> None:
        self.plain &= bool(self.within) and self.within.pop() == tag

    def handle_data(self, data: str) -> None:
        self.plain &= "<" not in data  # of a tag without an end


def stays_within(markup: str) -> bool:
    """Whether markup ends what it begins and cannot change the page around it.

    >>> stays_within("<p>24 <b>dozens</b></p>"), stays_within("</details><p>"), stays_within("<style>p {}</style>")
    (True, False, False)
    """
    reader = _Reader()
    reader.feed(markup)
    reader.close()
    return reader.plain and not reader.within and not re.search(r"<[!?]", markup) and not reader.rawdata


def without_packages(page: bytes) -> tuple[bytes, list[str]]:
    """A page without the parts that packages add, and the package of each."""
    sources: list[str] = []

    def removed(found: re.Match[str]) -> str:
        if not stays_within(found["head"]) or not stays_within(found["body"]):
            return found[0]
        sources.append(found["source"])
        return ""

    text = page.decode("utf-8", "surrogateescape")
    return _PART.sub(removed, text).encode("utf-8", "surrogateescape"), sources
