"""The page of the audit shows the rates that ship with the package."""

import re
from html import unescape

import pytest
from builders import small_study, write_study

from lockprobe.report.opened import open_study
from lockprobe.report.pages import page_of, parts_of
from lockprobe.report.prose.hypothesis_tests import QUESTIONS
from lockprobe.report.results import results_of
from lockprobe.report.study_numbers import study_numbers
from lockprobe.simulation.audit.rates import measured, shipped


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    planned = small_study(["random"], (0.0,), 1, 1)
    directory = write_study(tmp_path_factory.mktemp("audit") / "study", planned, [])
    return results_of(study_numbers(open_study(directory)))


def test_every_rate_has_a_cell_that_says_what_it_is(found):
    page = unescape(page_of("audit", found))
    cells = re.findall(r"<td[^>]*>(?:<b>)?(\[?[\d.]+ ± [\d.]+[]!\s]*)(</b>)?</td>", page)
    known = [rate for rate in measured() if rate.question in QUESTIONS]
    many = shipped()["many_agents"]["rates"]
    looks = shipped()["every_look"]["rates"]
    assert len(cells) == len(known) + len(many) + len(looks)
    assert sum(bool(bold) for _, bold in cells) == sum(rate.recommended for rate in known)
    assert sum(said[0] == "[" for said, _ in cells) == sum(rate.truth for rate in known) + sum(
        rate["truth"] for rate in many
    )
    assert sum(said[-1] == "!" for said, _ in cells) == sum(rate.valid is False for rate in known) + sum(
        rate["valid"] is False for rate in (*many, *looks)
    )


def test_headings_ask_and_say_how_often_the_recommended_test_errs_at_most(found):
    parts = parts_of(found, "audit")
    assert [part.heading for part in parts if part.name.startswith("question-")] == list(QUESTIONS.values())
    worst = max(r.rate for r in measured() if r.question == "success" and r.recommended and not r.truth)
    first = next(part for part in parts if part.name == "question-1")
    assert (
        first.answer
        == f"Where the truth is no, the recommended test rejects in at most {100 * worst:.1f} % of studies."
    )


def test_the_page_says_how_often_studies_that_are_looked_at_ever_err(found):
    shown = shipped()["every_look"]
    part = next(part for part in parts_of(found, "audit") if part.name == "every-look")
    table, note = part.blocks
    assert table.rows[0] == ["said falsely at least once", "agents", "worlds", "the worst of them", "of studies, %"]
    assert [row[:4] for row in table.rows[1:]] == [
        [one["says"], str(one["agents"]), str(one["worlds"]), one["world"]] for one in shown["rates"]
    ]
    assert table.rows[1][4].startswith(f"{100 * shown['rates'][0]['rate']:.1f} ± ")
    assert f"{shown['rates'][0]['studies']} studies of {shown['blocks']} blocks" in str(note)


def test_the_page_says_what_is_simulated(found):
    page = unescape(page_of("audit", found))
    assert f"seed {shipped()['seed']}" in page
    assert f"Rejections in per cent of {measured()[0].studies} studies in each world." in page
    for worlds in (shipped()["worlds"], shipped()["many_agents"]["worlds"]):
        assert all(f"<dt>{name}</dt><dd>{says}</dd>" in page for name, says in worlds.items())


def test_the_audit_has_no_rows(found):
    assert not [row for row in found.findings if row.section == "audit"]
