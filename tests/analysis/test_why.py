"""Why false reports change success: parts that add up, verdicts that hold in worlds of known mechanism."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import ttest_1samp

import lockprobe
from lockprobe.analysis.agent_comparison.paired import block_mean
from lockprobe.analysis.series import SeriesArm
from lockprobe.analysis.why import MARGIN, arms_of, verdict, verdict_of, why
from lockprobe.analysis.why_arms import ARMS, ON_REQUEST
from lockprobe.interventions.condition import read_condition
from lockprobe.spec import Spec

BLOCKS = 60


def conditions(p=0.4, arms=ARMS):
    return [read_condition(ARMS[arm].format(p=p), arm) for arm in arms]


def as_arms(found):
    return [
        SeriesArm(label=one.label, specs=tuple(map(Spec.parse, one.specs)), doses=one.dose_names, modality=one.modality)
        for one in found
    ]


def played(agent, arms=("truth", "lie", "retracted", "remark", "lie + remark"), blocks=BLOCKS, seed=1):
    return {
        one.label: [lockprobe.run_trial(agent=agent, condition=one, trial=i, seed=seed) for i in range(1, blocks + 1)]
        for one in conditions(arms=arms)
    }


@pytest.fixture(scope="module")
def loop_breaker():
    return played("world:loop-breaker")


@pytest.mark.parametrize("p", [0.4, 1.0, 0.05])
def test_arms_are_known_by_what_acts_whatever_they_are_called(p):
    renamed = [replace(one, label=f"condition {i}") for i, one in enumerate(as_arms(conditions(p)))]
    assert arms_of(renamed) == (p, {arm: f"condition {i}" for i, arm in enumerate(ARMS)})


@pytest.mark.parametrize("missing", ["truth", "lie", "retracted"])
def test_without_the_three_arms_there_is_no_answer(missing):
    assert arms_of(as_arms(conditions(arms=[arm for arm in ARMS if arm != missing]))) is None


def test_arms_of_another_rate_are_no_arms():
    mixed = [*as_arms(conditions(0.4, ["truth", "lie"])), *as_arms(conditions(0.2, ["retracted"]))]
    assert arms_of(mixed) is None


def test_the_parts_add_up_and_are_means_over_blocks(loop_breaker):
    found = why(loop_breaker, as_arms(conditions()))
    assert found.change.value == pytest.approx(found.says.value + found.disturbs.value)
    solved = {arm: np.array([trial.solved for trial in trials], float) for arm, trials in loop_breaker.items()}
    truth, lie, remark, both = (solved[arm] for arm in ("truth", "lie", "remark", "lie + remark"))
    assert found.change.value == pytest.approx((lie - truth).mean())
    assert found.says.value == pytest.approx((lie - solved["retracted"]).mean())
    assert found.falsity.value == pytest.approx(((lie - truth) + (both - remark)).mean() / 2)
    assert found.disturbance.value == pytest.approx(((remark - truth) + (both - lie)).mean() / 2)
    assert found.interaction.value == pytest.approx(((both - remark) - (lie - truth)).mean())
    assert [one.success.count for one in found.arms] == [solved[one.arm].sum() for one in found.arms]
    assert found.change.blocks == BLOCKS


def test_the_order_of_trials_and_of_arms_changes_nothing(loop_breaker):
    shuffled = {arm: trials[::-1] for arm, trials in reversed(loop_breaker.items())}
    assert why(shuffled, as_arms(conditions())) == why(loop_breaker, as_arms(conditions()))


def test_errors_leave_their_blocks_out(loop_breaker):
    broken = {arm: list(trials) for arm, trials in loop_breaker.items()}
    broken["lie"][3] = replace(broken["lie"][3], ending="error")
    found = why(broken, as_arms(conditions()))
    assert (found.change.blocks, found.says.blocks, found.disturbs.blocks) == (BLOCKS - 1, BLOCKS - 1, BLOCKS)


@pytest.mark.parametrize(
    ("world", "blocks", "expected"),
    [
        ("world:loop-breaker", 150, "disturbs"),
        ("world:perseverant", 200, "says"),
        ("world:information-hurts", 150, "says"),
        ("world:irrelevant", 40, "no change"),
        ("world:lost-half", 40, "no change"),
    ],
)
def test_worlds_of_known_mechanism_are_told(world, blocks, expected):
    found = why(played(world, ("truth", "lie", "retracted"), blocks, seed=3), as_arms(conditions()))
    assert found.verdict == expected
    assert (found.falsity, found.interaction) == (None, None)


@pytest.mark.parametrize(
    ("change", "says", "disturbs", "equivalence", "expected"),
    [
        (0.5, 0.5, 0.0, 1.0, "says"),
        (0.5, 0.0, 0.5, 1.0, "disturbs"),
        (0.5, 0.25, 0.25, 1.0, "both"),
        (0.0, 0.5, -0.5, 1e-9, "no change"),
        (0.0, 0.0, 0.0, 0.5, "not detectable"),
    ],
)
def test_a_verdict_follows_from_the_three_tests(change, says, disturbs, equivalence, expected):
    def mean(share):
        return block_mean(np.sign(share) * (np.arange(100) < 100 * abs(share)).astype(float)[:, None], unit=1.0)

    assert verdict(mean(change), mean(says), mean(disturbs), equivalence) == expected


def test_the_verdict_errs_rarely_where_nothing_differs():
    """Of 200 studies of 100 blocks without any effect: at most 5 % and three standard errors claim one."""
    rng = np.random.default_rng(1)
    claimed = 0
    for _ in range(200):
        truth, lie, retracted = rng.random((3, 100)) < 0.5
        means = [block_mean((a.astype(float) - b)[:, None], unit=1.0) for a, b in ((lie, truth), (lie, retracted))]
        third = block_mean((retracted.astype(float) - truth)[:, None], unit=1.0)
        claimed += verdict(*means, third, 1.0) != "not detectable"
    assert claimed <= 200 * (0.05 + 3 * math.sqrt(0.05 * 0.95 / 200))


def test_equivalence_is_two_one_sided_tests():
    trials = played("world:careful-believer", ("truth", "lie", "retracted"), 80)
    found = why(trials, as_arms(conditions()))
    differences = np.array([float(b.solved) - a.solved for a, b in zip(trials["truth"], trials["lie"], strict=True)])
    one = ttest_1samp(differences, -MARGIN, alternative="greater").pvalue
    two = ttest_1samp(differences, MARGIN, alternative="less").pvalue
    assert found.equivalence == pytest.approx(max(one, two), abs=0.04)  # Student's is not exact
    assert found.needed == pytest.approx(differences.var(ddof=1) * (2.8016 / MARGIN) ** 2, rel=0.05)


def test_lies_in_loops_are_compared_with_as_many_lies_elsewhere(loop_breaker):
    """Two arms on request; here their trials are those of other arms, so that the difference is known."""
    asked = [read_condition(ON_REQUEST[arm].format(p=0.4), f"my {arm}") for arm in ON_REQUEST]
    trials = loop_breaker | {"my lie in loops": loop_breaker["lie"], "my self-yoked": loop_breaker["remark"]}
    found = why(trials, as_arms([*conditions(), *asked]))
    solved = {arm: np.array([trial.solved for trial in loop_breaker[arm]], float) for arm in ("lie", "remark")}
    assert found.contingent.value == pytest.approx((solved["lie"] - solved["remark"]).mean())
    assert {"lie in loops", "self-yoked"} <= {one.arm for one in found.arms}
    assert why(loop_breaker, as_arms(conditions())).contingent is None
    alone = why(trials, as_arms([*conditions(), asked[0]]))
    assert alone.contingent is None


def test_of_one_agent_nothing_is_corrected_and_of_several_everything(loop_breaker):
    """P values are multiplied, intervals are those of the divided level: a part is detected by both or by neither."""
    alone, many = (why(loop_breaker, as_arms(conditions()), agents=agents) for agents in (1, 10))
    assert alone == why(loop_breaker, as_arms(conditions()))
    assert (alone.agents, many.agents) == (1, 10)
    pairs = [(getattr(alone, part), getattr(many, part)) for part in ("change", "says", "disturbs", "falsity")]
    pairs += [(one.change, two.change) for one, two in zip(alone.arms, many.arms, strict=True) if one.change]
    for one, two in pairs:
        assert two.value == one.value
        assert two.p_value == pytest.approx(min(1.0, 10 * one.p_value))
        assert two.low < one.low or two.low == -1
        assert two.high > one.high or two.high == 1
    assert many.equivalence == pytest.approx(min(1.0, 10 * alone.equivalence))
    assert many.needed > alone.needed


@pytest.mark.parametrize(
    ("shares", "shared", "false"),
    [
        ((0.45, 0.45, 0.45), False, {"says", "disturbs", "both", "unexplained"}),
        ((0.45, 0.55, 0.45), True, {"no change"}),
        ((0.25, 0.65, 0.65), False, {"says", "both"}),
    ],
    ids=["no change", "a change of the margin", "only the disturbance"],
)
def test_of_ten_agents_some_verdict_is_false_in_at_most_5_percent_of_studies(shares, shared, false):
    """In 200 studies of 60 blocks, with three standard errors; each agent by itself errs in up to a third of them."""
    rng = np.random.default_rng(1)
    wrong = 0
    for _ in range(200):
        drawn = rng.random((10, 1 if shared else 3, 60)) < np.array(shares)[None, :, None]
        wrong += any(verdict_of(*arms.astype(float), agents=10) in false for arms in drawn)
    assert wrong <= 200 * (0.05 + 3 * math.sqrt(0.05 * 0.95 / 200))
