"""The captions of a page as a reader meets them, before anything behind a summary is opened."""

import re
from html.parser import HTMLParser

SENTENCES = 2
"""A caption has at most so many on what is shown, and as many on how it was computed."""

WORDS = 45
"""A sentence has at most so many: two are not made of four by semicolons."""

_ABBREVIATED = re.compile(r"\b(Fig|Sec)\.")
_QUOTED = re.compile("\N{LEFT DOUBLE QUOTATION MARK}.*?\N{RIGHT DOUBLE QUOTATION MARK}")


def sentences(text):
    """The sentences of a text; what it quotes is left out."""
    text = _ABBREVIATED.sub(r"\1", _QUOTED.sub("", text))
    return [one for one in re.split(r"(?<=[.!?])[)\"']*\s+", text.strip()) if one]


class _Captions(HTMLParser):
    """Captions of figures, and all paragraphs outside tables: pairs of what is shown and how it was computed.

    A paragraph that begins with an agent and a colon says what was found of it, and is no caption.
    """

    def __init__(self, page):
        super().__init__()
        self.found, self._open = [], []
        self.feed(re.sub(r"<p><code>[^<]*(?:<wbr>[^<]*)*</code>: .*?</p>", "", page))

    def handle_starttag(self, tag, attrs):
        if tag in ("br", "img", "meta", "wbr"):
            return
        names = {tag, *(dict(attrs).get("class") or "").split()}
        if names & {"p", "figcaption", "note", "lead"} and not self._within("figcaption", "note", "lead"):
            self.found.append(["", ""])
        self._open.append(names)

    def handle_endtag(self, tag):
        while self._open and tag not in self._open.pop():
            pass

    def handle_data(self, data):
        if self._within("p", "figcaption", "note", "lead") and not self._within("table", "how"):
            self.found[-1][self._within("computed")] += data

    def _within(self, *names):
        return any(names_of & set(names) for names_of in self._open)


def captions(page, results=None):
    """What each caption of a page shows, and how that was computed, in sentences.

    Args:
        page: The page.
        results: The content of ``results.json``: paragraphs that it holds are findings and no captions.
    """
    said = " ".join(_words(results).split())
    pairs = [[" ".join(part.split()) for part in pair] for pair in _Captions(page).found]
    return [
        [sentences(part) for part in pair] for pair in pairs if any(pair) and (any(pair[1:]) or pair[0] not in said)
    ]


def too_long(page, results=None):
    """The captions of a page that have too many sentences, or sentences of too many words."""
    return [
        pair
        for pair in captions(page, results)
        if any(len(part) > SENTENCES or any(len(one.split()) > WORDS for one in part) for part in pair)
    ]


def _words(value):
    if isinstance(value, dict):
        return " ".join(map(_words, value.values()))
    return " ".join(map(_words, value)) if isinstance(value, list) else value if isinstance(value, str) else ""
