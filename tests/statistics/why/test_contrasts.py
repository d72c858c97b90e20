"""Why false reports change success: success in the arms of recorded trials, and verdicts in worlds of known mechanism."""

from dataclasses import replace

import numpy as np
import pytest
from why_answers import as_arms

import lockprobe
from lockprobe.interventions.conditions import read_condition
from lockprobe.statistics.why.arms import ARMS, ON_REQUEST, PLANNED
from lockprobe.statistics.why.contrasts import why
from lockprobe.statistics.why.mechanism import MARGIN, decide

BLOCKS = 60


def conditions(arms=ARMS):
    return [read_condition({**ARMS, **ON_REQUEST}[arm].format(p=0.4, reading=""), arm) for arm in arms]


def played(agent, arms=ARMS, blocks=BLOCKS, seed=1):
    return {
        one.label: [lockprobe.run_trial(agent=agent, condition=one, trial=i, seed=seed) for i in range(1, blocks + 1)]
        for one in conditions(arms)
    }


@pytest.fixture(scope="module")
def perseverant():
    return played("cognitive:perseverant")


def test_the_decision_is_that_of_the_outcomes_and_counts_are_those_of_the_records(perseverant):
    found = why(perseverant, as_arms())
    solved = {arm: np.array([trial.solved for trial in trials], float) for arm, trials in perseverant.items()}
    assert found.decision == decide(solved)
    assert [(one.arm, one.success.count) for one in found.arms] == [(arm, solved[arm].sum()) for arm in ARMS]
    assert found.success("lie").count == solved["lie"].sum()
    assert (found.p, found.agent, found.decision.total.blocks) == (0.4, "cognitive:perseverant", BLOCKS)
    changes = {one.arm: one.change for one in found.arms}
    assert changes.pop("truth") is None
    for arm, change in changes.items():
        assert change.value == pytest.approx((solved[arm] - solved["truth"]).mean())


def test_the_order_of_trials_and_of_arms_changes_nothing(perseverant):
    shuffled = {arm: trials[::-1] for arm, trials in reversed(perseverant.items())}
    assert why(shuffled, as_arms()) == why(perseverant, as_arms())


def test_errors_leave_their_blocks_out(perseverant):
    broken = {arm: list(trials) for arm, trials in perseverant.items()}
    broken["lie"][3] = replace(broken["lie"][3], ending="error")
    found = why(broken, as_arms())
    contrasts = found.decision.contrasts
    assert (found.decision.total.blocks, contrasts["false last after true"].blocks) == (BLOCKS - 1, BLOCKS)


def test_intervals_hold_whatever_became_of_broken_trials(perseverant):
    """Of false reports every fourth trial broke: the ends are those of all of these unsolved, and all solved."""
    solved = {arm: np.array([trial.solved for trial in trials], float) for arm, trials in perseverant.items()}
    broke = np.arange(BLOCKS) % 4 == 1
    broken = dict(perseverant) | {
        "lie": [
            replace(trial, ending="error") if one else trial
            for trial, one in zip(perseverant["lie"], broke, strict=True)
        ]
    }
    found = why(broken, as_arms()).decision
    failed, opened = (decide(solved | {"lie": np.where(broke, end, solved["lie"])}) for end in (0.0, 1.0))
    assert found.total.low == min(failed.total.low, opened.total.low)
    assert found.total.high == max(failed.total.high, opened.total.high)
    assert found.equivalence == max(failed.equivalence, opened.equivalence)
    assert found.total.value == (solved["lie"] - solved["truth"])[~broke].mean()


@pytest.mark.parametrize("missing", PLANNED)
def test_where_a_planned_arm_has_no_trial_there_is_no_answer(perseverant, missing):
    assert why(perseverant | {missing: []}, as_arms()) is None


def test_where_no_effect_is_detected_no_arm_is_compared(perseverant):
    same = dict.fromkeys(ARMS, perseverant["truth"])
    found = why(same, as_arms())
    assert not found.detected
    assert [one.change for one in found.arms] == [None] * len(ARMS)
    assert len(found.arms) == len(ARMS)


def test_worlds_of_known_mechanism_are_told(perseverant):
    breaker = why(played("cognitive:loop-breaker", blocks=90, seed=3), as_arms())
    assert (breaker.decision.verdict, breaker.decision.claims) == ("form", ("form",))
    assert why(perseverant, as_arms()).decision.claims == ("last",)


def test_needed_blocks_follow_from_the_variance(perseverant):
    found = why(perseverant, as_arms())
    differences = np.array(
        [float(b.solved) - a.solved for a, b in zip(perseverant["truth"], perseverant["lie"], strict=True)]
    )
    assert found.needed == pytest.approx(differences.var(ddof=1) * (2.8016 / MARGIN) ** 2, rel=0.05)
