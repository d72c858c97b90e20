"""Two agents on the same boxes: counts by hand, agents exchanged within luck, corrections by kind of pair."""

import numpy as np
import pytest
from builders import SOLUTION, make_trial

from lockprobe.statistics.agent_comparison.pair import compare, corrected
from lockprobe.statistics.agent_comparison.paired import Sheet, sheets
from lockprobe.statistics.outcomes import outcomes

A, B = ("llm:a", "symbolic"), ("llm:b", "symbolic")


def trials(agent, solved, of=12, p=(0.0, 0.3)):
    """So many trials solved at every p, those with the lowest numbers; at once, or not at all."""
    return [
        make_trial(SOLUTION if i < n else (0,) * 20, agent=agent, p=value, trial=i + 1)
        for value, n in zip(p, solved, strict=True)
        for i in range(of)
    ]


def compared(first, second, among="subjects", names=(A, B)):
    values, laid = sheets([outcomes(first), outcomes(second)])
    return compare(names, values, tuple(laid), among, np.random.default_rng(1), budget=20)


def test_counts_by_hand():
    found = compared(trials("llm:a", (3, 6)), trials("llm:b", (9, 12)))
    assert (found.first_share, found.second_share) == (9 / 24, 21 / 24)
    assert (found.success.value, found.success.pairs, found.success.blocks) == (0.5, 24, 12)
    assert found.steps.value == -8.0  # 12 of 24 trials solved in 4 steps instead of failing after 20
    at = found.at[0].success
    assert (found.at[0].dose, at.only_first, at.only_second, at.n) == (0.0, 0, 6, 12)
    assert at.p_value == pytest.approx(2 / 2**6)
    assert found.success.p_value == pytest.approx(2 / 2**9)  # nine blocks differ, all one way
    assert found.alone == 0


def test_who_is_called_first_changes_signs_alone():
    one, two = trials("llm:a", (3, 10)), trials("llm:b", (9, 5))
    found, turned = compared(one, two), compared(two, one)
    assert found.success.value == -turned.success.value
    assert found.success.p_value == turned.success.p_value
    assert (found.steps.low, found.steps.high) == pytest.approx((-turned.steps.high, -turned.steps.low))
    assert found.interaction.at[0].change.value == -turned.interaction.at[0].change.value


def test_a_trial_that_broke_for_one_drops_its_pair_and_is_counted():
    second = trials("llm:b", (9, 12))
    broken = make_trial([0], agent="llm:b", p=0.3, trial=12, broken="model")
    found = compared(trials("llm:a", (3, 6)), [*second[:-1], broken])
    assert (found.success.pairs, found.alone) == (23, 1)
    assert [at.success.n for at in found.at] == [12, 11]
    assert compared(trials("llm:a", (3,), p=(0.0,)), trials("llm:b", (3,), p=(0.3,))) is None


def test_exchange_of_agents_rarely_tells_equal_agents_apart_that_share_their_luck_over_p():
    """An agent's trials go alike at every p. So few rejections come of a level of 5 % in 999 of 1000 cases."""
    rejected = 0
    for seed in range(200):
        rng = np.random.default_rng(seed)
        one, two = (np.repeat(rng.random((30, 1)) < 0.5, 7, axis=1) * 1.0 for _ in range(2))
        sheet = [Sheet(solved=solved, steps=20 - solved) for solved in (one, two)]
        found = compare((A, B), tuple(i / 10 for i in range(7)), tuple(sheet), "reference", rng, budget=20)
        rejected += found.success.p_value < 0.05
    assert rejected <= 20


def test_pairs_of_one_kind_are_corrected_together():
    strong = compared(trials("llm:a", (0, 1)), trials("llm:b", (12, 12)))
    weak = compared(trials("llm:a", (3, 4)), trials("llm:b", (9, 9)))
    beside = compared(trials("llm:a", (3, 3)), trials("llm:b", (9, 9)), "reference")
    first, second, third = corrected([strong, weak, beside])
    assert first.success_adjusted == pytest.approx(2 * strong.success.p_value)
    assert second.success_adjusted == pytest.approx(weak.success.p_value)
    assert third.success_adjusted == beside.success.p_value
    assert second.at[0].p_adjusted == pytest.approx(min(1.0, 2 * weak.at[0].success.p_value))
    assert third.interaction is None
    assert second.interaction.p_adjusted >= weak.interaction.p_value


def test_two_that_play_alike_at_every_p_are_looked_at_once():
    alike = compared(trials("llm:a", (3, 3)), trials("llm:b", (9, 9)))
    apart = compared(trials("llm:a", (3, 3)), trials("llm:b", (9, 8)))
    assert (alike.copies, apart.copies) == (True, False)
    assert [at.p_adjusted for at in corrected([alike])[0].at] == [alike.at[0].success.p_value] * 2
    assert corrected([apart])[0].at[0].p_adjusted == pytest.approx(2 * apart.at[0].success.p_value)
    assert not compared(trials("llm:a", (3,), p=(0.0,)), trials("llm:b", (9,), p=(0.0,))).copies


def test_equally_good_agents_that_play_differently_are_not_told_apart_by_the_test_alone():
    """The first fails at the lowest p alone, in six blocks of ten, the second not here: the test is below 0.05."""
    p = tuple(i / 10 for i in range(7))
    found, *_ = corrected([compared(trials("llm:a", (4, *[10] * 6), 10, p), trials("llm:b", (10,) * 7, 10, p))])
    assert found.success_adjusted < 0.05
    assert found.steps_adjusted < 0.05
    assert found.success.low < 0 < found.success.high
    assert (found.verdict, found.steps_verdict) == (0, 0)


def test_the_verdict_is_of_the_corrected_test():
    found = compared(trials("llm:a", (3, 3)), trials("llm:b", (9, 9)))
    alone, *_ = corrected([found])
    one, *_ = corrected([found] * 3)
    assert (found.success.p_value, found.verdict, alone.verdict, one.verdict) == (pytest.approx(2 / 2**6), 0, 1, 0)


@pytest.mark.parametrize(
    ("budget", "blocks", "slow"), [(20, 10, 0.05), (20, 18, 0.05), (20, 30, 0.05), (100, 60, 0.037), (100, 100, 0.022)]
)
def test_an_agent_with_rare_long_trials_is_not_called_faster(budget, blocks, slow):
    """Equal means; every trial is solved, so the budget shows in no failure. Without it, 0.2 to 0.6 of studies err."""
    wrong = 0
    usual = (6 - slow * budget) / (1 - slow)
    for seed in range(200):
        rng = np.random.default_rng([seed, blocks])
        first = rng.integers(5, 8, size=(blocks, 7)) * 1.0
        stuck = rng.random((blocks, 1)) < slow
        second = np.where(stuck, budget, np.floor(usual + rng.random((blocks, 7))) + rng.integers(-1, 2, (blocks, 7)))
        solved = np.ones((blocks, 7))
        laid = Sheet(solved=solved, steps=first), Sheet(solved=solved, steps=second)
        found = compare((A, B), tuple(i / 10 for i in range(7)), laid, "reference", rng, budget=budget)
        wrong += corrected([found])[0].steps_verdict != 0
    assert wrong / 200 <= 0.05 + 2 * np.sqrt(0.05 * 0.95 / 200)
