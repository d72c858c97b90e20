"""Trials that a page shows step by step, and the data of its explorer."""

from builders import SOLUTION, make_trial, small_study
from reported import found_in

from lockprobe.report.pages import page_of

CIRCLING = ([0, 1, 2] * 7)[:20]


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


def test_what_an_agent_said_is_text_and_shortened(tmp_path):
    trial = make_trial(SOLUTION, agent="llm:a", hypothesis="<b>bold</b> " + "and " * 100)
    page = page_of("details", found_in(tmp_path, small_study(["llm:a"], (0.0,), 1, 1), [trial]))
    assert "&lt;b&gt;bold&lt;/b&gt; and" in page
    assert "and " * 60 not in page
