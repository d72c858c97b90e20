"""Hypothesis tests: one of each question to conclude from, and those that others use, with what the audit measured."""

import re
from html import unescape
from typing import get_args

import pytest
from builders import small_study, write_study
from page_parts import part

from lockprobe.report.opened import open_study
from lockprobe.report.pages import page_of
from lockprobe.report.prose.hypothesis_tests import asked, limits_said, unit_of_effect
from lockprobe.report.results import results_of
from lockprobe.report.sections.course_rows import RULE
from lockprobe.report.study_numbers import study_numbers
from lockprobe.simulation.audit.rates import false_positives, measured
from lockprobe.statistics.inference.verdict import Question

AGENTS = ("cognitive:perseverant", "human-inspired", "random")


def numbers_in(directory, planned):
    return study_numbers(open_study(write_study(directory / "study", planned)))


def section(found, page="report"):
    return unescape(part(page_of(page, found), "hypothesis_tests"))


def cells(found):
    """The rows of the table of tests, as text."""
    rows = re.findall(r'<tr class="(best|naive)">(.*?)</tr>', section(found, "details"))
    plain = [(kind, row.replace('<span class="concluded">', "").replace("</span>", "", 1)) for kind, row in rows]
    return [(kind, re.findall(r"<td[^>]*>(.*?)</td>", row)) for kind, row in plain]


@pytest.fixture(scope="module")
def numbers(tmp_path_factory):
    return numbers_in(tmp_path_factory.mktemp("tests"), small_study(AGENTS, (0.0, 0.2, 0.4, 0.6), 2, 8))


@pytest.fixture(scope="module")
def found(numbers):
    return results_of(numbers)


def test_every_test_of_the_battery_is_a_row(numbers, found):
    for agent, course in zip(numbers.flips.agents, found.courses(), strict=True):
        tests = [] if agent.blind else agent.inference.tests
        rows = {row.test: row for row in (*course.where("test"), *course.where("naive_test"))}
        assert set(rows) == {test.name for test in tests}
        for test in tests:
            row = rows[test.name]
            assert (row.quantity == "test") == test.recommended
            assert row.of == (test.question if test.recommended else f"{test.question}: {test.name}")
            assert (row.p_value, row.low, row.high) == (test.p_value, test.low, test.high)
            assert row.value == (test.effect if test.holds is None else test.holds)
            assert row.unit == (unit_of_effect(test.name) if test.holds is None else RULE)
            assert row.note == limits_said(test)
            assert (course.value("test_direction", row.of) or 0) == test.direction
            assert course.value("test_null", row.of) == test.baseline


def test_each_question_has_one_test_to_conclude_from(found):
    course = found.courses()[0]
    assert [row.of for row in course.where("test")] == list(get_args(Question))
    shown = cells(found)
    assert [row[0] for kind, row in shown if kind == "best"] == [asked(question) for question in get_args(Question)]
    assert {row[0] for kind, row in shown if kind == "naive"} == {""}
    assert section(found, "details").count("<h3><code>") == 1  # the baselines are not judged


def test_false_positives_are_those_of_the_audit(found):
    rows = {row[1]: row[4] for _, row in cells(found)}
    for row in (*found.where("test"), *found.where("naive_test")):
        best, worst = false_positives(row.test)
        assert rows[row.test] == f"{100 * best.rate:.1f} to {100 * worst.rate:.1f} %"


@pytest.mark.parametrize(("p_value", "said"), [(0.01, "yes"), (0.9, "not detected"), (None, "\N{EN DASH}")])
def test_a_test_that_is_not_valid_has_no_plain_yes(found, p_value, said):
    changed = [
        row.model_copy(update={"p_value": p_value, "unit": ""} if row.quantity in ("test", "naive_test") else {})
        for row in found.rows
    ]
    invalid = {rate.test for rate in measured() if rate.valid is False and not rate.recommended}
    shown = [(row[1], re.sub("<br>.*", "", row[5])) for _, row in cells(found.changed(rows=tuple(changed)))]
    assert invalid & {test for test, _ in shown}
    for test, conclusion in shown:
        assert conclusion == ("not valid (rejects)" if said == "yes" and test in invalid else said)


def test_a_rule_without_a_p_value_says_yes_or_no(found):
    (rule,) = [row for row in found.where("naive_test", agent=AGENTS[0]) if row.unit == RULE]
    for holds, said in ((0, "not detected"), (1, "not valid (rejects)")):
        rows = [row.model_copy(update={"value": holds} if row is rule else {}) for row in found.rows]
        (shown,) = [row for _, row in cells(found.changed(rows=tuple(rows))) if row[1] == rule.test]
        assert shown[2:4] == ["\N{EN DASH}", ""]
        assert shown[5].startswith(said)


def test_with_one_flip_rate_only_questions_that_need_none_are_shown(tmp_path):
    found = results_of(numbers_in(tmp_path, small_study(AGENTS, (0.0,), 2, 8)))
    assert "With one flip rate, effects of false reports cannot be tested." in section(found)
    shown = [row[0] for kind, row in cells(found) if kind == "best"]
    assert shown == [asked("harm")]
    assert {row.p_value for row in found.where("test", of="success")} == {None}


def test_agents_that_play_alike_have_no_tests(tmp_path):
    found = results_of(numbers_in(tmp_path, small_study(("random", "round-robin"), (0.0, 0.4), 1, 6)))
    assert found.where("test") == []
    assert "No agent has trials that differ between flip rates." in section(found)
