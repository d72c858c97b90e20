"""The text of a page, as a reader sees it."""

import html
import re

SILENT = "script|style|svg|head"
INLINE = "a|b|i|em|strong|code|span|wbr|sup|sub|small|abbr"


def page_text(page: str) -> list[str]:
    """What a reader sees of a page, a block a line, cells apart, without scripts, styles and drawings."""
    page = re.sub(rf"<({SILENT})\b.*?</\1>", "\n", re.sub(r"\s+", " ", page))
    page = re.sub(r"</?t[dh]\b[^>]*>", " | ", page)
    page = re.sub(rf"<(?!/?(?:{INLINE})\b)[^>]*>", "\n", page)
    text = re.sub(r"[^\S\n]+", " ", html.unescape(re.sub(r"<[^>]*>", "", page)))
    lines = (re.sub(r"(\| )+", "| ", line).strip(" |") for line in text.split("\n"))
    return [line for line in lines if line]
