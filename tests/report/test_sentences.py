"""Sentences say what the numbers bear and no more: nothing that is not shown is said to be nothing."""

from dataclasses import replace

import pytest
from builders import play_study, played_by_people, small_study, write_study

from lockprobe.boxes.families import box
from lockprobe.report.page import parts_of
from lockprobe.report.prose.first_screen import flips_answer
from lockprobe.report.prose.idle import idle_doses_said
from lockprobe.report.prose.several_answers import Question, several_answers
from lockprobe.report.prose.subject import subject_of
from lockprobe.report.prose.success import finding
from lockprobe.report.results import results
from lockprobe.statistics.summary import summarise
from lockprobe.studies.options.studyfile import study
from lockprobe.testing import play_trials


def test_a_flip_rate_without_a_false_report_is_named_and_no_effect_is_denied():
    trials = [trial for p in (0.0, 0.0001) for trial in play_trials("human-inspired", 6, p=p)]
    summary = summarise(trials, box("chain-4"))
    (agent,) = summary.agents
    steps = sum(len(trial.steps) for trial in trials) // 2
    said = f"At a flip rate of 0.0001, no report was false (human-inspired, {steps} steps), so nothing is concluded from it."
    assert idle_doses_said(agent) == said
    assert finding(agent).endswith(said)
    assert "effect" not in finding(agent) + flips_answer(summary)
    (acting,) = summarise([*trials, *play_trials("human-inspired", 6, p=0.4)], box("chain-4")).agents
    assert said in finding(acting)
    assert "0.0001" not in finding(acting).replace(said, "")


@pytest.mark.parametrize("agents", [("viewer", "human-inspired"), ("random",)])
def test_every_folded_heading_says_something_even_where_nothing_was_solved_or_tested(tmp_path, agents):
    planned = study("flips", agent=agents, p=[0], trials=1, repetitions=1, max_steps=3)
    found = results(write_study(tmp_path / "study", planned))
    parts = {part.heading: part.answer for part in parts_of(found) if part.name not in ("overview", "trials")}
    assert {"Hypothesis tests", "Action loops", "Speed"} <= parts.keys()
    assert [heading for heading, answer in parts.items() if not answer] == []


def asking(i, *p_values):
    tested = tuple((f"on agent {n}", p_value) for n, p_value in enumerate(p_values))
    return Question(about=f"cause {i}", answer=lambda many: f"Answer {i}.", tested=tested)


@pytest.mark.parametrize(
    ("p_values", "lost"),
    [
        ([0.001, 0.8], ""),
        ([0.03, 0.8], "0"),  # Holm: 2 x 0.03
        ([0.03, 0.02], ""),  # 2 x 0.02, then 0.03
        ([0.03, 0.04], "01"),
        ([0.6, 0.026], "1"),
        ([None, 0.03], ""),  # one question alone
        ([0.03], ""),
        ([0.02, 0.02, 0.9], "01"),  # 3 x 0.02
        ([0.01, 0.02, 0.9], ""),  # 3 x 0.01, then 2 x 0.02
    ],
)
def test_a_change_is_said_if_it_is_detected_after_all(p_values, lost):
    asked = [asking(i, *([] if value is None else [value])) for i, value in enumerate(p_values)]
    every = "both" if len(asked) == 2 else f"all {len(asked)}"
    expected = [
        f"An effect of cause {i} was detected in its own section (P = {value:.2g}), but not after correction for {every} "
        "questions of this page."
        if str(i) in lost
        else f"Answer {i}."
        for i, value in enumerate(p_values)
    ]
    assert several_answers(asked) == " ".join(expected)


@pytest.mark.parametrize(
    ("first", "second", "lost"),
    [
        ([0.001, 0.03, 0.04], [0.8], "on agent 1 and on agent 2"),  # each twice
        ([0.001, 0.03], [0.0001], ""),  # the other question is clearer, so this one counts once
        ([0.001, 0.02], [0.8], ""),
        ([0.001, 0.06], [0.8], ""),  # it was not detected before
    ],
)
def test_further_agents_of_a_question_are_corrected_alike(first, second, lost):
    said = several_answers([asking(0, *first), asking(1, *second)])
    of_these = f" Of these, the effect {lost} was not detected after correction for both questions of this page."
    assert said == f"Answer 0.{of_these if lost else ''} Answer 1."


@pytest.fixture(scope="module")
def summary():
    study = small_study(("participant", "random"), (0.0, 0.4), 2, 5)
    agents = play_study(small_study(("random", "human-inspired"), study.p, 2, 5))
    return summarise([*agents, *played_by_people(study, 2)], study.box)


def test_no_sentence_calls_people_by_their_spec(summary):
    said = [finding(agent) for agent in summary.agents]
    assert not [sentence for sentence in said if "participant" in sentence]
    assert not [sentence for sentence in said if sentence.startswith("people")]
    assert not [sentence for sentence in said for many in ("eople solves", "eople needs") if many in sentence]
    (people,) = (agent for agent in summary.agents if agent.agent == "participant")
    assert (subject_of(people).name, people.name) == ("people", "participant")
    assert subject_of(replace(people, shown="reports")).name == "people (reports)"
