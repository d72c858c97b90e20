"""What a robot took to have happened, counted against the truth."""

from builders import make_trial

from lockprobe.report.prose.robot import verdicts_said
from lockprobe.statistics.robot import verdicts


def test_wrong_verdicts_are_counted_by_kind_and_failures_apart():
    """Joint 3 moves, joint 0 does not."""
    one = make_trial([3, 0, 0], budget=3, trial=1, verdicts=["moved", "moved", "failed"])
    two = make_trial([3, 0], budget=2, trial=2, verdicts=["blocked", "blocked"])
    found = verdicts([one, two])
    assert (found.attempts, found.failed) == (5, 1)
    assert (found.wrong.count, found.wrong.n, found.wrong.clusters) == (2, 4, 2)
    assert (found.moved_for_blocked, found.blocked_for_moved) == (1, 1)
    said = verdicts_said(found)
    assert "was wrong at 2 of 4 attempts (50.0 %, 95 % interval " in said
    assert "; it could not decide at 1 more" in said
    assert said.endswith("Agents are not told this verdict.")  # a hand that fails to move a joint is in every number


def test_trials_that_share_their_luck_are_one_cluster():
    both = [make_trial([3], budget=1, agent=agent, verdicts=["moved"]) for agent in ("random", "viewer")]
    assert verdicts(both).wrong.clusters == 1


def test_a_robot_that_is_always_right_has_an_interval_too():
    right = verdicts([make_trial([3], budget=1, trial=i, verdicts=["moved"]) for i in range(1, 11)])
    assert (right.wrong.count, right.wrong.low) == (0, 0)
    assert 0 < right.wrong.high < 0.4
    assert " took " not in verdicts_said(right)


def test_no_robot_no_verdicts():
    assert verdicts([make_trial([3, 0])]) is None
    helpless = verdicts([make_trial([0], budget=1, verdicts=["failed"])])
    assert verdicts_said(helpless) == "The robot could not determine the outcome of any of 1 attempts."
