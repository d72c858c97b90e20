"""Pages are short, lead to their details, and are written alike: p is no letter of two meanings, captions are short."""

import re
from html import unescape
from pathlib import Path

import pytest
from builders import make_trial, modality_study, play_study, played_by_people, small_study, write_study
from captions import captions, too_long
from page_parts import part
from page_text import page_text

from lockprobe.report.pages import parts_of
from lockprobe.report.rows import Results
from lockprobe.report.section import Detail, Figure, Table, nested
from lockprobe.report.write import write_report
from lockprobe.studies.options.studyfile import study

AGENTS = ["cognitive:perseverant", "cognitive:careful", "human-inspired"]
MANY = {
    "p": [0, 0.2, 0.4],
    "condition": ["nudge", "drop?p=0.5", "nudge + flip?p=0.4", *(f"flip?p={p}&others=kept" for p in (0.2, 0.4))],
    "sweep": "tremble?p=0.1,0.3",
}
PAGES = ("report", "details", "claims")


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
    """The results of a study and its pages."""
    directory = write_study(tmp_path_factory.mktemp("pages") / "study", *request.param(modal))
    write_report(directory)
    found = Results.model_validate_json((directory / "results.json").read_bytes())
    return found, {name: (directory / f"{name}.html").read_text("utf-8") for name in PAGES}


def details_of(found):
    """Every detail of the report, with its part."""
    return [(of, one) for of in parts_of(found, "report") for one in nested(of.blocks) if isinstance(one, Detail)]


def test_a_report_has_at_most_5_000_words_when_all_is_unfolded(written):
    _, pages = written
    assert 300 < len(" ".join(page_text(pages["report"])).split()) <= 5_000


def test_every_detail_has_a_link_and_its_heading_in_the_same_part_of_the_details(written):
    found, pages = written
    own = details_of(found)
    assert len(own) > 5
    for of, one in own:
        links = [unescape(text) for text in re.findall(rf'<a href="details.html#{of.name}">(.*?)</a>', pages["report"])]
        assert links.count(one.summary) == 1, one.summary
        headings = re.findall(r"<h3>(.*?)</h3>", part(pages["details"], of.name))
        assert one.summary in map(unescape, headings), one.summary
        assert f"<summary>{one.summary}</summary>" not in unescape(pages["report"])


def test_every_link_to_the_details_has_its_anchor_there_once(written):
    _, pages = written
    links = {link for name in ("report", "claims") for link in re.findall(r'details\.html#([^"]*)"', pages[name])}
    assert links
    assert all(pages["details"].count(f'id="{link}"') == 1 for link in links)
    assert "details.html#" not in pages["details"]


def test_a_table_or_figure_stands_on_one_page_alone(written):
    found, _ = written
    blocks = [block for of in parts_of(found, "report") for block in of.blocks]
    shown = {(one.block, one.name) for one in blocks if isinstance(one, Table | Figure)}
    details = [block for of in parts_of(found, "details") for block in nested(of.blocks)]
    behind = {(one.block, one.name) for one in details if isinstance(one, Table | Figure)}
    assert shown
    assert behind
    assert shown & behind == set()


no_conditions = pytest.mark.parametrize("written", [a_subject, people, modalities], indirect=True)
"""Names of conditions and of other doses hold a p."""


def words(page):
    """The text of a page without what is quoted or a name: the paper's words, specs and keys."""
    page = re.sub(r"(?s)<(style|script|code|blockquote)\b.*?</\1>", " ", page)
    return unescape(re.sub(r"<(?!/?[iI]>)[^>]*>", "\n", page))


@no_conditions
@pytest.mark.parametrize("name", PAGES)
def test_a_flip_rate_is_written_out_and_the_p_of_a_p_value_is_a_capital(written, name):
    _, pages = written
    page = words(pages[name]).replace("lip rate <i>p</i>", "lip rate").replace("p-value", "")
    assert not re.findall(r".{0,40}(?<!-)\bp\b(?!-).{0,40}", page)
    assert not re.findall(r"[^>]\bP\b [=<] ", page)  # in italics wherever it has a value
    assert re.search(r"<i>P</i> (=|&lt;) [01]", pages["report"] + pages["claims"])


@no_conditions
def test_a_test_that_does_not_reject_says_not_detected_and_no_number_has_a_star(written):
    _, pages = written
    page, details = pages["report"], pages["details"]
    cells = re.findall(r"<td[^>]*>(.*?)</td>", part(details, "hypothesis_tests"))
    says = [re.sub("<[^>]*>", "", cell.partition("<br>")[0]) for cell in cells[4::5]]
    assert set(says) <= {"yes", "not valid (rejects)", "not detected", "\N{EN DASH}"}
    assert ("not detected" in says) == bool(says)
    overview = re.findall(r"<td(?! class=\"who\")[^>]*>(.*?)</td>", part(page, "hypothesis_tests"))
    concluded = [re.sub(r" \([^()]*\)", "", cell) for cell in overview]
    assert set(concluded) <= {"detected", "not detected", "\N{EN DASH}"}
    assert ("not detected" in concluded) == ("not detected" in says)
    assert not re.search(r"\d ?\*", words(page) + words(details))


@no_conditions
@pytest.mark.parametrize("name", PAGES)
def test_captions_say_in_two_sentences_what_is_shown_and_in_two_how_it_was_computed(written, name):
    found, pages = written
    page, plain = pages[name], found.plain()
    assert too_long(page, plain) == []
    shown = captions(page, plain)
    assert len(shown) > {"report": 20, "details": 8, "claims": 2}[name]
    assert any(computed for _, computed in shown)
    assert name in {"details", "claims"} or "How is this computed?" in page


def test_the_documentation_writes_flip_rates_out():
    root = Path(__file__).parents[2]
    for path in [
        root / "README.md",
        *sorted({*(root / "docs").glob("*.md"), *(root / "robot" / "docs").glob("*.md")}),
    ]:
        prose = re.sub(r"(?s)```.*?```|`[^`\n]*`|\n    [^\n]*", "", path.read_text("utf-8"))
        assert not re.findall(r".*(?<![-\w])p\b(?![-=]).*", prose), path.name
