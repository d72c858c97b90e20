"""A misinterpretation contradicts what was told."""

from collections import Counter

from builders import make_trial

from lockprobe.statistics.misinterpretation import claim_counts, claims


def test_claims_are_about_the_step_before_and_each_error_is_told_apart():
    # Steps: 3 moves, 2 moves, 0 is blocked. The report of step 2 is inverted, and so is that of step 3.
    trial = make_trial([3, 2, 0, 0], false_at=[2, 3], claims=[None, "blocked", "blocked", "blocked"])
    said = claims(trial)
    assert [claim[1:] for claim in said] == [
        ("blocked", "moved", "moved"),
        ("blocked", "blocked", "moved"),
        ("blocked", "moved", "blocked"),
    ]
    assert [claim.joint for claim in said] == [step.joint for step in trial.steps[:3]]
    assert [claim.misread for claim in said] == [True, False, True]
    assert [claim.falsely_told for claim in said] == [False, True, True]
    assert [claim.false_belief for claim in said] == [True, True, False]


def test_broken_trials_and_silent_agents_are_not_counted():
    silent = make_trial([3, 0, 0], trial=2, claims=[None, "moved", None])
    broken = make_trial([3, 0, 0], trial=3, claims=[None, "blocked", "moved"], broken="reply")
    assert claim_counts([silent, broken, make_trial([3, 0, 0], trial=4)]) == Counter(claims(silent))
    assert claim_counts([silent]).total() == 1
