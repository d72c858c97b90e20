"""The confusion matrix against claims that are counted one by one, and its recovery from flips at known rates."""

from dataclasses import replace

import pytest

from lockprobe.interventions.misread_flip import MisreadFlip
from lockprobe.statistics.confusion import Confusion, confusion
from lockprobe.statistics.misinterpretation import claims
from lockprobe.statistics.proportions import proportion
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.condition import Condition

RATES = {"A": (0.5, 0.1), "B": (0.0, 0.3), "C": (0.8, 0.0), "D": (0.2, 0.2)}
FLIP = replace(
    MisreadFlip(like="rgb"),
    by_label=tuple(f"{label}:{hidden}:{invented}" for label, (hidden, invented) in RATES.items()),
)


def trials(count):
    """Trials of an agent that believes what it is told, which is false at known rates, on an unlabelled panel."""
    return [
        run_trial(
            agent="cognitive:perseverant", trial=number, shuffle="never", condition=Condition(interventions=(FLIP,))
        )
        for number in range(1, count + 1)
    ]


PLAYED = trials(120)
FOUND = confusion(PLAYED)


def test_every_claim_is_counted_once():
    said = [(trial.steps[claim.step - 1].joint, claim) for trial in PLAYED for claim in claims(trial)]
    assert FOUND.claims == len(said)
    assert FOUND.misread == sum(claim.claimed != claim.truth for _, claim in said)
    for joint in FOUND.joints:
        own = [claim for name, claim in said if name == joint and claim.truth == "moved"]
        assert FOUND.count("moved", joint) == (sum(claim.claimed == "blocked" for claim in own), len(own))


def test_the_rates_that_made_it_lie_within_its_intervals():
    """At 99.9 %, for eight rates, so that a right matrix fails in fewer than one of a hundred seeds."""
    for joint, (hidden, invented) in zip(PLAYED[0].joints, RATES.values(), strict=True):
        for outcome, rate in (("moved", hidden), ("blocked", invented)):
            wrong, made = FOUND.count(outcome, joint)
            within = proportion(wrong, made, level=0.999)
            assert made == 0 or within.low <= rate <= within.high


def test_a_joint_without_a_claim_has_the_rate_of_all():
    found = Confusion(joints=("a", "b"), made={("a", "moved"): 4}, wrong={("a", "moved"): 1})
    assert found.rates() == {"a": (0.25, 0.0), "b": (0.25, 0.0)}
    assert found.rates("total") == {"a": (0.25, 0.25), "b": (0.25, 0.25)}
    assert FOUND.rates("direction")[FOUND.joints[0]] == pytest.approx(
        tuple(wrong / made for wrong, made in (FOUND.count("moved"), FOUND.count("blocked")))
    )
