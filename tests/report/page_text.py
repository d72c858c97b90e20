"""The text of a page, as a reader sees it."""

import re
from html.parser import HTMLParser


class _Text(HTMLParser):
    """The text of a page, a block a line, without scripts, styles and drawings."""

    SILENT = frozenset({"script", "style", "svg", "head"})
    INLINE = frozenset({"a", "b", "i", "em", "strong", "code", "span", "wbr", "sup", "sub", "small", "abbr"})

    def __init__(self) -> None:
        super().__init__()
        self.lines: list[str] = [""]
        self.silent = 0

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.silent += tag in self.SILENT
        self._breaks(tag)

    def handle_endtag(self, tag: str) -> None:
        self.silent -= tag in self.SILENT
        self._breaks(tag)

    def _breaks(self, tag: str) -> None:
        if tag in {"td", "th"}:
            self.lines[-1] += " | "
        elif tag not in self.INLINE:
            self.lines.append("")

    def handle_data(self, data: str) -> None:
        if not self.silent:
            self.lines[-1] += data


def page_text(page: str) -> list[str]:
    """What a reader sees of a page, a block a line."""
    parser = _Text()
    parser.feed(page)
    lines = (re.sub(r"(\| )+", "| ", re.sub(r"\s+", " ", line)).strip(" |") for line in parser.lines)
    return [line for line in lines if line]
