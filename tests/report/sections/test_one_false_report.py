"""The effect of one false report: corrected for agents, with a heading, a table and what is not estimated."""

import re

import pytest
from builders import small_study, write_study
from page_parts import part

from lockprobe.report.opened import open_study
from lockprobe.report.pages import page_of, tables_of
from lockprobe.report.prose.subject import Subject
from lockprobe.report.results import results_of
from lockprobe.report.rows import Estimate, Finding
from lockprobe.report.sections.one_false_report import effects_on
from lockprobe.report.study_numbers import study_numbers
from lockprobe.statistics.excursion import decision_points, excursions
from lockprobe.studies.options.studyfile import study
from lockprobe.testing import play_trials

EFFECT = "effect_of_one_false_report"
AGENTS = ("cognitive:insistent", "cognitive:perseverant", "human-inspired")


@pytest.fixture(scope="module")
def trials():
    return {agent: play_trials(agent, 60 if agent != AGENTS[2] else 4, p=0.4) for agent in AGENTS}


def rows_of(trials, *agents):
    found = {one: excursions(decision_points(trials[one])) for one in agents}
    return list(effects_on({(one, "symbolic"): (Subject.of(one), effects) for one, effects in found.items()}))


def effects_of(rows, agent):
    return [row for row in rows if isinstance(row, Estimate) and (row.quantity, row.agent) == (EFFECT, agent)]


def said(rows, kind):
    return [row.text for row in rows if isinstance(row, Finding) and row.kind == kind]


def test_several_agents_are_one_family(trials):
    """P values are multiplied and intervals are wider than of the agent alone; those without an estimate do not count."""
    alone, together = rows_of(trials, AGENTS[0]), rows_of(trials, *AGENTS)
    assert {row.corrected_for for agent in AGENTS for row in effects_of(together, agent)} == {2}
    assert not effects_of(together, AGENTS[2])
    for one, two in zip(effects_of(alone, AGENTS[0]), effects_of(together, AGENTS[0]), strict=True):
        assert two.p_value == pytest.approx(min(1, 2 * one.p_value))
        assert (two.low < one.low, two.high > one.high, two.value) == (True, True, one.value)
    assert "corrected for 2 agents" in said(together, "effect")[0]
    assert "corrected for" not in said(alone, "effect")[0]


def test_the_heading_has_the_change_of_success_of_the_first_agents_with_its_interval(trials):
    (heading,) = said(rows_of(trials, *AGENTS), "answer")
    assert heading.startswith("Success after one more false report, in points: ")
    assert heading.count("[") == 2
    assert f" {AGENTS[0]}; " in heading
    assert heading.endswith(f" {AGENTS[1]}.")
    assert said(rows_of(trials, AGENTS[2]), "answer") == []


def test_every_effect_is_in_the_table_or_among_those_that_are_not_estimated(tmp_path):
    planned = small_study(("cognitive:perseverant",), (0.0, 0.4), 2, 15)
    found = results_of(study_numbers(open_study(write_study(tmp_path / "study", planned))))
    estimated, missing = found.where(EFFECT), [fact for fact in found.facts if "one false report" in fact.about]
    assert len(estimated) + len(missing) == 28
    assert len(tables_of(found)["lies"]) == 1 + len(estimated)
    page, details = (part(page_of(name, found), "one_false_report") for name in ("report", "details"))
    assert found.said("one_false_report", "effect")[0][:60] in page
    assert "Effects that are not estimated for <code>cognitive:<wbr>perseverant</code>" in details
    lines = re.findall(r"<summary>(\d+) effects?: (.*?)</summary>", details)
    assert "fewer than 15 trials hold the outcome, or miss it" in [reason for _, reason in lines]
    assert sum(int(many) for many, _ in lines) == len(missing)


def test_agents_are_called_with_their_modality_and_a_table_without_rows_is_left_out(tmp_path):
    shown = ["symbolic?tell=state", "symbolic?tell=outcome"]
    few = {"agent": ["human-inspired"], "p": [0, 0.4], "modality": shown, "trials": 2, "repetitions": 1}
    found = results_of(study_numbers(open_study(write_study(tmp_path / "few", study("flips", **few)))))
    page = page_of("report", found).partition('id="one_false_report"')[2].partition('<details class="section"')[0]
    assert tables_of(found)["lies"] == []
    assert "All effects of one false report" not in page
    names = re.findall(r"not estimated for <code>(.*?)</code>", page)
    assert names == [one.label for one in found.courses()]
    assert len({*names}) == len(shown)
    many = few | {"trials": 16}
    found = results_of(study_numbers(open_study(write_study(tmp_path / "many", study("flips", **many)))))
    named = {row[0] for row in tables_of(found)["lies"][1:]}
    assert named
    assert named <= {one.label for one in found.courses()}
    examples = [one for one in found.exhibits if one.section == "trials"]
    assert examples
    assert all(found.courses()[0].shown in one.why for one in examples)


def test_there_is_no_such_part_without_flip_rates_between_0_and_1(tmp_path):
    found = results_of(study_numbers(open_study(write_study(tmp_path / "study", small_study(p=(0.0,), trials=1)))))
    assert 'id="one_false_report"' not in page_of("report", found)
    assert tables_of(found)["lies"] == []
