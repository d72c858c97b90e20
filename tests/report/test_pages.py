"""The page says one thing first, and is written alike: p is no letter of two meanings, captions are short."""

import re
from html import unescape
from html.parser import HTMLParser
from pathlib import Path

import pytest
from builders import make_trial, modality_study, play_study, played_by_people, small_study, write_study
from page_text import page_text

from lockprobe.report.page import figures_of, parts_of
from lockprobe.report.rows import Results
from lockprobe.report.section import Figure, Table
from lockprobe.report.write import write_report
from lockprobe.studies.options.studyfile import study

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


AGENTS = ["cognitive:perseverant", "cognitive:careful", "human-inspired"]
MANY = {
    "p": [0, 0.2, 0.4],
    "condition": ["nudge", "drop?p=0.5", "nudge + flip?p=0.4", *(f"flip?p={p}&others=kept" for p in (0.2, 0.4))],
    "sweep": "tremble?p=0.1,0.3",
}


def many_agents(modal):
    """A study of flip rates, readings of false reports, another dose and other conditions."""
    return study("flips", agent=AGENTS, trials=6, repetitions=2, **MANY), None


def a_subject(modal):
    """An agent whose success rises, beside one that is blind, with a trial that broke."""
    rises = {0.0: 2, 0.3: 7, 0.6: 9}
    trials = [
        make_trial([3, 2, 1, 0] if i <= solved else [0] * 20, agent="llm:x", p=p, trial=i, claims=[None, "moved"])
        for p, solved in rises.items()
        for i in range(1, 11)
    ]
    trials[-1] = make_trial([0], agent="llm:x", p=0.6, trial=10, broken="reply")
    return small_study(("llm:x", "random"), tuple(rises), 1, 10), [
        *trials,
        *play_study(small_study(("random",), tuple(rises), 1, 10)),
    ]


def people(modal):
    planned = small_study(("participant", "round-robin"), (0.0, 0.4), 1, 6)
    return planned, [*played_by_people(planned, 2), *play_study(small_study(("round-robin",), planned.p, 1, 6))]


def modalities(modal):
    return modality_study(), modal


@pytest.fixture(scope="module", params=[many_agents, a_subject, people, modalities])
def written(request, tmp_path_factory, modal):
    """The results of a study and its page."""
    directory = write_study(tmp_path_factory.mktemp("pages") / "study", *request.param(modal))
    write_report(directory)
    found = Results.model_validate_json((directory / "results.json").read_bytes())
    return found, (directory / "report.html").read_text("utf-8")


def test_at_most_700_words_stand_before_something_is_unfolded(written):
    _, page = written
    assert 100 < len(" ".join(page_text(folded(page))).split()) <= 700


def folded(page):
    """The page without what is folded away: of every part its heading and its answer."""
    while (
        inner := re.sub(
            r"(?s)<details[^>]*>\s*<summary>((?:(?!<details).)*?)</summary>(?:(?!<details).)*?</details>", r"\1", page
        )
    ) != page:
        page = inner
    return page


def test_a_table_or_figure_stands_on_the_page_once(written):
    found, page = written
    shown = [
        (one.block, one.name)
        for of in parts_of(found)
        for one in of.blocks
        if isinstance(one, Table | Figure) and one.name
    ]
    assert len(shown) > 5
    assert len(shown) == len({*shown})
    assert page.count("<img") >= len([one for one in figures_of(parts_of(found)) if one.applies(found)]) > 0


def test_no_interval_of_people_is_called_a_plain_wilson_interval(written):
    found, page = written
    if found.where("people"):
        said = [one for one in page_text(page) if "Wilson" in one]
        assert said
        assert not [one for one in said if "clustered by person" not in one and "Fisher" not in one]


no_conditions = pytest.mark.parametrize("written", [a_subject, people, modalities], indirect=True)
"""Names of conditions and of other doses hold a p."""


def words(page):
    """The text of a page without what is quoted or a name: the paper's words, specs and keys."""
    page = re.sub(r"(?s)<(style|script|code|blockquote)\b.*?</\1>", " ", page)
    return unescape(re.sub(r"<(?!/?[iI]>)[^>]*>", "\n", page))


@no_conditions
def test_a_flip_rate_is_written_out_and_the_p_of_a_p_value_is_a_capital(written):
    _, whole = written
    page = words(whole).replace("lip rate <i>p</i>", "lip rate").replace("p-value", "")
    assert not re.findall(r".{0,40}(?<!-)\bp\b(?!-).{0,40}", page)
    assert not re.findall(r"[^>]\bP\b [=<] ", page)  # in italics wherever it has a value
    assert re.search(r"<i>P</i> (=|&lt;) [01]", whole)


@no_conditions
def test_captions_say_in_two_sentences_what_is_shown_and_in_two_how_it_was_computed(written):
    found, page = written
    plain = found.plain()
    assert too_long(page, plain) == []
    shown = captions(page, plain)
    assert len(shown) > 12
    assert any(computed for _, computed in shown)


def test_the_documentation_writes_flip_rates_out():
    root = Path(__file__).parents[2]
    for path in [
        root / "README.md",
        *sorted({*(root / "docs").glob("*.md"), *(root / "robot" / "docs").glob("*.md")}),
    ]:
        prose = re.sub(r"(?s)```.*?```|`[^`\n]*`|\n    [^\n]*", "", path.read_text("utf-8"))
        assert not re.findall(r".*(?<![-\w])p\b(?![-=]).*", prose), path.name
