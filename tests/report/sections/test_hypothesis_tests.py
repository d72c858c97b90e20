"""Hypothesis tests: one of each question to conclude from."""

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
from lockprobe.report.study_numbers import study_numbers
from lockprobe.statistics.inference.verdict import Question

AGENTS = ("cognitive:perseverant", "human-inspired", "random")


def numbers_in(directory, planned):
    return study_numbers(open_study(write_study(directory / "study", planned)))


def section(found, page="report"):
    return unescape(part(page_of(page, found), "hypothesis_tests"))


def cells(found):
    """The rows of the table of tests, as text."""
    rows = re.findall(r'<tr>(<td class="asks">.*?)</tr>', section(found, "details"))
    plain = [row.replace('<span class="concluded">', "").replace("</span>", "", 1) for row in rows]
    return [re.findall(r"<td[^>]*>(.*?)</td>", row) for row in plain]


@pytest.fixture(scope="module")
def numbers(tmp_path_factory):
    return numbers_in(tmp_path_factory.mktemp("tests"), small_study(AGENTS, (0.0, 0.2, 0.4, 0.6), 2, 8))


@pytest.fixture(scope="module")
def found(numbers):
    return results_of(numbers)


def test_every_test_is_a_row(numbers, found):
    for agent, course in zip(numbers.flips.agents, found.courses(), strict=True):
        tests = [] if agent.blind else agent.inference.tests
        rows = {row.of: row for row in course.where("test")}
        assert set(rows) == {test.question for test in tests}
        for test in tests:
            row = rows[test.question]
            assert (row.test, row.value, row.p_value, row.low, row.high) == (
                test.name,
                test.effect,
                test.p_value,
                test.low,
                test.high,
            )
            assert (row.unit, row.note) == (unit_of_effect(test.name), limits_said(test))
            assert (course.value("test_direction", row.of) or 0) == test.direction


def test_each_question_has_one_test_to_conclude_from(found):
    course = found.courses()[0]
    assert [row.of for row in course.where("test")] == list(get_args(Question))
    assert [row[0] for row in cells(found)] == [asked(question) for question in get_args(Question)]
    assert section(found, "details").count("<h3><code>") == 1  # the baselines are not judged


@pytest.mark.parametrize(("p_value", "said"), [(0.01, "yes"), (0.9, "not detected"), (None, "\N{EN DASH}")])
def test_a_conclusion_follows_from_the_p_value(found, p_value, said):
    changed = [row.model_copy(update={"p_value": p_value} if row.quantity == "test" else {}) for row in found.rows]
    shown = cells(found.changed(rows=tuple(changed)))
    assert {re.sub("<br>.*", "", row[4]) for row in shown} == {said}


def test_with_one_flip_rate_nothing_is_tested(tmp_path):
    found = results_of(numbers_in(tmp_path, small_study(AGENTS, (0.0,), 2, 8)))
    assert "With one flip rate, effects of false reports cannot be tested." in section(found)
    assert {row.p_value for row in found.where("test")} == {None}


def test_agents_that_play_alike_have_no_tests(tmp_path):
    found = results_of(numbers_in(tmp_path, small_study(("random", "round-robin"), (0.0, 0.4), 1, 6)))
    assert found.where("test") == []
    assert "No agent has trials that differ between flip rates." in section(found)
