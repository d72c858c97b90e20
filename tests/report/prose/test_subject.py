"""Sentences call people people, with verbs that fit, and every other agent by its spec."""

from dataclasses import replace

import pytest
from builders import play_study, played_by_people, small_study

from lockprobe.report.prose.agent_comparison import comparison_said
from lockprobe.report.prose.subject import Subject, subject_of
from lockprobe.report.prose.success import finding
from lockprobe.statistics.summary import summarise


@pytest.fixture(scope="module")
def summary():
    study = small_study(("participant", "random"), (0.0, 0.4), 2, 5)
    agents = play_study(small_study(("random", "human-inspired"), study.p, 2, 5))
    return summarise([*agents, *played_by_people(study, 2)], study.box)


def test_no_sentence_calls_people_by_their_spec(summary):
    said = [finding(agent) for agent in summary.agents]
    said += [sentence for one in summary.comparisons for sentence in comparison_said(one, summary)]
    assert not [sentence for sentence in said if "participant" in sentence]
    assert not [sentence for sentence in said if sentence.startswith("people")]
    assert not [sentence for sentence in said for many in ("eople solves", "eople needs") if many in sentence]
    (people,) = (agent for agent in summary.agents if agent.agent == "participant")
    assert (subject_of(people).name, people.name) == ("people", "participant")
    assert subject_of(replace(people, shown="reports")).name == "people (reports)"


def test_who_needs_more_or_solves_more_is_said_of_people_in_the_plural(summary):
    (one,) = (one for one in summary.comparisons if {one.first[0], one.second[0]} == {"random", "participant"})
    assert one.second[0] == "participant"
    more, fewer = (replace(one.success, value=side, low=side - 0.1, high=side + 0.1) for side in (0.3, -0.3))
    clear = replace(one, success=more, success_adjusted=0.001, steps=fewer, steps_adjusted=0.001, interaction=None)
    solve, need = comparison_said(clear, summary)
    assert solve.startswith("People solve the box more often than random: ")
    assert need.startswith("People need fewer steps than random, ")


def test_specs_stay_as_they_are():
    random, people = Subject.of("random"), Subject.of("participant")
    assert (random.name, random.first, Subject.of("peopled").first) == ("random", "random", "peopled")
    assert (random.form("it", "they"), people.form("it", "they")) == ("it", "they")
