"""Trials that a page shows step by step, and the data of its explorer."""

from builders import SOLUTION, make_trial, play_study, small_study, write_study

from lockprobe.report.opened import open_study
from lockprobe.report.pages import page_of
from lockprobe.report.results import results_of
from lockprobe.report.study_numbers import study_numbers
from lockprobe.studies.options.studyfile import study

CIRCLING = ([0, 1, 2] * 7)[:20]


def found_in(path, planned, trials=None):
    return results_of(study_numbers(open_study(write_study(path / "study", planned, trials))))


def test_a_solved_a_looping_and_a_misread_trial_are_shown_each_once(tmp_path):
    trials = [
        make_trial(CIRCLING, agent="llm:a", trial=1),
        make_trial(SOLUTION, agent="llm:a", trial=2),
        make_trial((0, 0, 0, *SOLUTION), agent="llm:a", trial=3, claims=[None, "moved", "moved", "blocked"]),
        make_trial([0], agent="llm:a", trial=4, broken="model"),
    ]
    found = found_in(tmp_path, small_study(["llm:a"], (0.0,), 1, 4), trials)
    assert [(one.section, one.agent, one.why[:6], one.key[-1]) for one in found.exhibits] == [
        ("trials", "llm:a", "Solved", "2"), ("trials", "llm:a", "Loopin", "1"), ("trials", "llm:a", "Most m", "3"),
    ]  # fmt: skip
    solved, looping, misread = (one.steps for one in found.exhibits)
    assert [step.joint for step in solved] == [trials[1].joints[joint] for joint in SOLUTION]
    assert solved[-1].moved
    assert looping[0].loop == "a"
    assert all(step.loop for step in looping)
    assert [step.again for step in looping[:5]] == [False, False, False, True, True]
    assert [(step.claimed, step.misinterpreted) for step in misread[:4]] == [
        ("moved", True), ("moved", True), ("blocked", False), (None, False),
    ]  # fmt: skip
    page = page_of("details", found)
    assert "moved (misread)" in page
    assert "Equal letters in the column “loop”" in page


def test_one_trial_is_shown_of_each_of_the_first_other_conditions(tmp_path):
    planned = study("flips", agent=["human-inspired"], sweep="tremble?p=0,0.1,0.2,0.3,0.4,0.5,0.6,0.7", trials=2)
    trials = play_study(planned)
    found = found_in(
        tmp_path, planned, [trial for trial in trials if (trial.condition, trial.trial) != ("tremble?p=0.1", 1)]
    )
    shown = [(one.why, one.key) for one in found.exhibits if one.why.startswith("tremble")]
    assert [why for why, _ in shown] == [f"tremble?p=0.{i}" for i in range(1, 7)]
    assert [key[-1] for _, key in shown] == [*"211111"]


def test_without_any_such_trial_the_page_says_so(tmp_path):
    page = page_of("details", found_in(tmp_path, small_study(["random"], (0.0,), 1, 2), []))
    assert "No trial of the first agent was solved, looped or misread." in page


def test_what_an_agent_said_is_text_and_shortened(tmp_path):
    trial = make_trial(SOLUTION, agent="llm:a", hypothesis="<b>bold</b> " + "and " * 100)
    page = page_of("details", found_in(tmp_path, small_study(["llm:a"], (0.0,), 1, 1), [trial]))
    assert "&lt;b&gt;bold&lt;/b&gt; and" in page
    assert "and " * 60 not in page


def test_the_explorer_stands_on_the_page_as_data(tmp_path):
    found = found_in(tmp_path, small_study(["random"], (0.0,), 1, 1))
    page = page_of("report", found, trials='{"trials":[]}')
    assert '<script type="application/json" id="trials-data">{"trials":[]}</script>' in page
