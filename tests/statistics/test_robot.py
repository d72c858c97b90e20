"""What arm and camera took attempts for, counted against the truth and against each other."""

from builders import make_trial

from lockprobe.statistics.robot import robot_senses


def test_wrong_verdicts_are_counted_by_kind_and_failures_apart():
    """Joint 3 moves, joint 0 does not."""
    one = make_trial([3, 0, 0], budget=3, trial=1, verdicts=["moved", "moved", "failed"])
    two = make_trial([3, 0], budget=2, trial=2, verdicts=["blocked", "blocked"])
    found = robot_senses([one, two])
    verdict = found.all.verdict
    assert (found.all.attempts, found.all.moved, verdict.undecided, found.all.camera) == (5, 2, 1, None)
    assert (verdict.wrong.count, verdict.wrong.n, verdict.wrong.clusters) == (2, 4, 2)
    assert (verdict.moved_for_blocked, verdict.blocked_for_moved) == (1, 1)


def test_verdict_and_camera_are_compared_joint_by_joint_where_both_decide():
    said = ["moved", "moved", "failed", "blocked"]
    one = make_trial([3, 0, 3, 0], budget=4, verdicts=said, readings=["0000", "0001", "0000", "0000", "?000"])
    found = robot_senses([one])
    target, free = found.joints[one.joints[0]], found.joints[one.joints[3]]
    assert [(of.attempts, of.moved) for of in (target, free, found.all)] == [(2, 0), (2, 2), (4, 2)]
    assert (target.verdict.right.count, target.verdict.right.n) == (1, 2)
    assert (target.camera.right.count, target.camera.right.n, target.camera.undecided) == (1, 1, 1)
    assert (target.agree.count, target.agree.n) == (0, 1)
    assert (free.camera.right.count, free.camera.right.n) == (1, 2)  # its reading went back before it moved
    assert (free.agree.count, free.agree.n) == (1, 1)


def test_a_robot_that_is_always_right_has_an_interval_too():
    right = robot_senses([make_trial([3], budget=1, trial=i, verdicts=["moved"]) for i in range(1, 11)])
    wrong = right.all.verdict.wrong
    assert (wrong.count, wrong.low) == (0, 0)
    assert 0 < wrong.high < 0.4


def test_no_robot_no_verdicts():
    assert robot_senses([make_trial([3, 0])]) is None
    helpless = robot_senses([make_trial([0], budget=1, verdicts=["failed"])])
    assert (helpless.all.attempts, helpless.all.verdict.undecided) == (1, 1)
