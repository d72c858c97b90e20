"""A misinterpretation contradicts what was told; rates of misreading are recovered from flips at known rates."""

from collections import Counter
from dataclasses import replace

from builders import make_trial

from lockprobe.interventions.misread_flip import MisreadFlip
from lockprobe.statistics.misinterpretation import Claim, claim_counts, claims, misread_rates
from lockprobe.statistics.proportions import wilson
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.condition import Condition


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


RATES = {"A": (0.5, 0.1), "B": (0.0, 0.3), "C": (0.8, 0.0), "D": (0.2, 0.2)}
FLIP = replace(
    MisreadFlip(like="rgb"),
    by_label=tuple(f"{label}:{hidden}:{invented}" for label, (hidden, invented) in RATES.items()),
)


def test_the_rates_that_made_false_reports_lie_within_the_intervals_of_what_is_found():
    """At 99.9 %, for eight rates, so that a right function fails in fewer than one of a hundred seeds."""
    played = [
        run_trial(
            agent="cognitive:perseverant", trial=number, shuffle="never", condition=Condition(interventions=(FLIP,))
        )
        for number in range(1, 121)
    ]
    said, joints = claim_counts(played), played[0].joints
    found = misread_rates(said, joints)
    for joint, rates in zip(joints, RATES.values(), strict=True):
        for i, outcome in enumerate(("moved", "blocked")):
            n = sum(count for claim, count in said.items() if (claim.joint, claim.truth) == (joint, outcome))
            low, high = wilson(found[joint][i], n, 3.29)  # at 99.9 %
            assert low <= rates[i] <= high
    by = misread_rates(said, joints, "direction")
    assert len({*by.values()}) == 1 < len({*found.values()})


def test_a_joint_without_a_claim_has_the_rate_of_all():
    said = {Claim("a", "moved", "moved", "moved"): 3, Claim("a", "blocked", "moved", "moved"): 1}
    assert misread_rates(said, "ab") == {"a": (0.25, 0.0), "b": (0.25, 0.0)}
    assert misread_rates(said, "ab", "direction") == {"a": (0.25, 0.0), "b": (0.25, 0.0)}
    assert misread_rates(said, "ab", "total") == {"a": (0.25, 0.25), "b": (0.25, 0.25)}
    assert misread_rates({}, ["a"]) == {"a": (0.0, 0.0)}
