"""The report is short, and what it leaves to ``details.html`` stands there, under the links that lead to it."""

import re
from html import unescape

import pytest
from builders import modality_study, played_by_people, small_study, write_study
from page_parts import part
from page_text import page_text

from lockprobe.report.opened import open_study
from lockprobe.report.pages import page_of, parts_of
from lockprobe.report.results import results_of
from lockprobe.report.section import Detail, Figure, Table, nested
from lockprobe.report.study_numbers import study_numbers
from lockprobe.studies.options.studyfile import study

AGENTS = ["cognitive:perseverant", "cognitive:careful", "human-inspired", "llm:local"]
MANY = {
    "p": [0, 0.2, 0.4],
    "condition": ["nudge", "drop?p=0.5", "nudge + flip?p=0.4", *(f"flip?p={p}&others=kept" for p in (0.2, 0.4))],
    "sweep": "tremble?p=0.1,0.3",
}
MOST = 5_000
"""Words of a report when all of it is unfolded."""


def many_agents():
    """A study of flip rates, readings of false reports, another dose and other conditions."""
    return study("flips", agent=AGENTS[:3], trials=6, repetitions=2, **MANY), None


def people():
    planned = small_study(("participant",), (0.0, 0.4), 2, 5)
    return planned, played_by_people(planned, 2)


@pytest.fixture(scope="module", params=["many agents", "people", "modalities"])
def found(request, tmp_path_factory, modal):
    made = {"many agents": many_agents, "people": people, "modalities": lambda: (modality_study(), modal)}
    planned, trials = made[request.param]()
    return results_of(
        study_numbers(open_study(write_study(tmp_path_factory.mktemp("details") / "study", planned, trials)))
    )


def details_of(found):
    """Every detail of the report, with its part."""
    return [(of, one) for of in parts_of(found, "report") for one in nested(of.blocks) if isinstance(one, Detail)]


def test_a_report_has_at_most_5_000_words_when_all_is_unfolded(found):
    words = " ".join(page_text(page_of("report", found))).split()
    assert 300 < len(words) <= MOST


def test_every_detail_has_a_link_and_its_heading_in_the_same_part_of_the_details(found):
    report, details = (page_of(name, found) for name in ("report", "details"))
    own = details_of(found)
    assert len(own) > 5
    for of, one in own:
        links = [unescape(text) for text in re.findall(rf'<a href="details.html#{of.name}">(.*?)</a>', report)]
        assert links.count(one.summary) == 1, one.summary
        headings = re.findall(r"<h3>(.*?)</h3>", part(details, of.name))
        assert one.summary in map(unescape, headings), one.summary
        assert f"<summary>{one.summary}</summary>" not in unescape(report)


def test_every_link_to_the_details_has_its_anchor_there_once(found):
    details = page_of("details", found)
    links = {
        link for name in ("report", "claims") for link in re.findall(r'details\.html#([^"]*)"', page_of(name, found))
    }
    assert links
    assert all(details.count(f'id="{link}"') == 1 for link in links)
    assert "details.html#" not in details


def test_the_first_links_of_the_details_lead_to_each_of_its_parts(found):
    details = page_of("details", found)
    (contents,) = re.findall(r'<ul class="contents">(.*?)</ul>', details)
    assert re.findall(r'href="#(.*?)"', contents) == [one.name for one in parts_of(found, "details")]
    assert re.findall(r'<section id="(.*?)">', details) == [one.name for one in parts_of(found, "details")]


def test_a_table_or_figure_stands_on_one_page_alone(found):
    blocks = [block for of in parts_of(found, "report") for block in of.blocks]
    shown = {(one.block, one.name) for one in blocks if isinstance(one, Table | Figure)}
    details = [block for of in parts_of(found, "details") for block in nested(of.blocks)]
    behind = {(one.block, one.name) for one in details if isinstance(one, Table | Figure)}
    assert shown
    assert behind
    assert shown & behind == set()


def test_a_part_of_the_report_without_details_is_none_of_the_details(found):
    with_details = {of.name for of, _ in details_of(found)}
    own = {one.name for one in parts_of(found, "details")} - {one.name for one in parts_of(found, "report")}
    assert {one.name for one in parts_of(found, "details")} == with_details | own
    assert own == {"agents", "conditions"}
