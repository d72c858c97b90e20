"""The first screen: question, answer and key numbers, as rows and on the page."""

import re

import pytest
from builders import SOLUTION, make_trial, small_study, study_of
from reported import found_in

from lockprobe.boxes.families import box
from lockprobe.foundation.formatting import points
from lockprobe.report.page import Page
from lockprobe.report.primary import primary_lines
from lockprobe.report.questions.first_screen import answer_of


def screen(page):
    """The text above the first part."""
    return re.sub(r"\s+", " ", re.sub("<[^>]*>", "", page.partition("<body>")[2].partition('id="trials"')[0]))


@pytest.fixture(scope="module")
def models(tmp_path_factory):
    """Five models that false reports help."""
    agents = [f"llm:acme/{name}" for name in "abcde"]
    trials = [
        make_trial(SOLUTION if i < solved else (0,) * 20, agent=agent, p=p, trial=i + 1)
        for agent in agents
        for p, solved in ((0.0, 3), (0.4, 9))
        for i in range(10)
    ]
    planned = study_of(name="flips", agents=(*agents,), boxes=(box("chain-4"),), repetitions=1, trials=10)
    return found_in(tmp_path_factory.mktemp("models"), planned, trials)


def test_the_first_screen_is_in_the_results_and_on_the_page(models):
    said = models.facts_about("overview")
    assert [*said] == ["question", "trial"]
    assert models.answer.startswith(
        "No effect of false reports on the success of any of 5 agents was detected; changes of up to"
    )
    top = screen(Page(found=models).text())
    assert all(text in top for text in (models.answer, *said.values()))
    assert "Partial" not in top
    for line in primary_lines(models):  # every agent is in the list
        row = models.one("success_difference", agent=line.agent, axis="flip rate", versus="")
        assert (line.first.value, line.second.value, line.change) == (0.3, 0.9, row)
        assert re.search(
            rf"{line.label} ?30 ?90[ 0-9]*\+60 ?\[{re.escape(points(row.low))}, {re.escape(points(row.high))}\]", top
        )
    assert "changes and P are corrected for 5 comparisons" in top


@pytest.mark.parametrize(("other", "p"), [("llm:b", (0.0, 0.4)), ("random", (0.4,))])
def test_an_agent_that_always_breaks_is_named_and_the_others_are_judged(tmp_path, other, p):
    planned = small_study(["llm:a", other], p, 1, 2)
    trials = [
        make_trial((0,), agent=agent, p=rate, trial=i, broken="reply")
        if agent == "llm:a"
        else make_trial(SOLUTION, agent=agent, p=rate, trial=i)
        for agent in planned.agents
        for rate in p
        for i in (1, 2)
    ]
    found = found_in(tmp_path, planned, trials)
    named, _, rest = found.answer.partition(". ")
    assert named == f"All {2 * len(p)} trials of llm:a ended as an error"
    assert other in rest
    assert [line.agent for line in primary_lines(found)] == [other]
    alone = found_in(tmp_path / "alone", planned, trials[: 2 * len(p)])
    assert alone.answer == f"{named}."


def test_no_answer_stands_where_its_numbers_are_missing(models):
    assert answer_of(models) == models.answer
    assert answer_of(models.with_rows(models.facts)).startswith("The answer could not be computed")
