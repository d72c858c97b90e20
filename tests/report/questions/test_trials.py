"""The trial that a report names as the one to watch first."""

from builders import SOLUTION, make_trial, small_study
from reported import found_in


def test_the_trial_to_watch_first_is_a_solved_one_if_there_is_one(tmp_path):
    trials = [
        make_trial(([0, 1, 2] * 7)[:20], agent="llm:a", trial=1),
        make_trial(SOLUTION, agent="llm:a", trial=2),
        make_trial([0], agent="llm:a", trial=3, broken="model"),
    ]
    planned = small_study(["llm:a"], (0.0,), 1, 3)
    for name, own, first in (("both", trials, 1), ("unsolved", trials[:1], 0), ("broken", trials[2:], None)):
        said = found_in(tmp_path / name, planned, own).fact("trials", "first")
        assert said == ("" if first is None else trials[first].key)
