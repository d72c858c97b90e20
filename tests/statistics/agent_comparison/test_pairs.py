"""Two agents on the same boxes: which are compared, counts by hand, families, people, broken trials, levels."""

from dataclasses import replace

import numpy as np
import pytest
from builders import SOLUTION, make_trial

from lockprobe.statistics.agent_comparison.pairs import compared as uncorrected
from lockprobe.statistics.agent_comparison.pairs import comparisons, interaction_of, judged
from lockprobe.statistics.conditions.axis_trials import on_axis
from lockprobe.trial.record import STATES

FAILED = (0,) * 20


def trials(agent, solved, of=12, p=(0.0, 0.3), modality=STATES):
    """So many trials solved at every p, those with the lowest numbers; at once, or not at all."""
    return [
        make_trial(SOLUTION if i < n else FAILED, agent=agent, p=value, trial=i + 1, modality=modality)
        for value, n in zip(p, solved, strict=True)
        for i in range(of)
    ]


def compared(*groups):
    """The only pair, not corrected; its second agent is that of the first group."""
    (found,) = uncorrected(on_axis([trial for group in groups for trial in group]))
    return found


def test_models_are_compared_with_each_other_and_with_the_baselines():
    agents = ("llm:a", "llm:b", "human-inspired?lapse=0.1", "random", "round-robin")
    found = comparisons(on_axis([trial for agent in agents for trial in trials(agent, (5, 5))]))
    assert [(one.second[0], one.first[0], one.among) for one in found] == [
        ("llm:a", "llm:b", "subjects"),
        ("llm:a", "human-inspired?lapse=0.1", "reference"),
        ("llm:a", "random", "reference"),
        ("llm:b", "human-inspired?lapse=0.1", "reference"),
        ("llm:b", "random", "reference"),
    ]
    alone = comparisons(on_axis([*trials("random", (3, 3)), *trials("round-robin", (9, 9))]))
    assert [(one.second[0], one.among) for one in alone] == [("random", "subjects")]


def test_only_agents_that_saw_the_box_alike_are_compared():
    made = [t for a in ("llm:a", "llm:b") for m in ("rgb", STATES) for t in trials(a, (9, 9), modality=m)]
    found = comparisons(on_axis([*made, *trials("random", (9, 9))]))
    between = [one for one in found if one.among == "subjects"]
    assert {(one.first, one.second) for one in between} == {
        (("llm:b", "rgb"), ("llm:a", "rgb")),
        (("llm:b", STATES), ("llm:a", STATES)),
    }
    assert len(found) - len(between) == 4


def test_counts_by_hand():
    found = compared(trials("llm:b", (9, 12)), trials("llm:a", (3, 6)))
    assert found.shares == (9 / 24, 21 / 24)
    assert (found.success.value, found.success.pairs, found.success.blocks) == (0.5, 24, 12)
    assert found.steps.value == -8.0  # 12 of 24 trials solved in 4 steps instead of failing after 20
    at = found.at[0.0].success
    assert (at.value, at.pairs) == (0.5, 12)
    assert at.p_value == pytest.approx(2 / 2**6)
    assert found.success.p_value == pytest.approx(2 / 2**9)  # nine blocks differ, all one way


def test_who_is_called_first_changes_signs_alone():
    one, two = trials("llm:a", (3, 10)), trials("llm:b", (9, 5))
    found, turned = compared(two, one), compared(one, two)
    assert found.success.value == -turned.success.value
    assert found.success.p_value == turned.success.p_value
    assert (found.steps.low, found.steps.high) == pytest.approx((-turned.steps.high, -turned.steps.low))
    assert found.interaction.at[0].change.value == -turned.interaction.at[0].change.value


def test_a_trial_that_broke_for_one_drops_its_pair():
    broken = make_trial([0], agent="llm:b", p=0.3, trial=12, broken="model")
    found = compared([*trials("llm:b", (9, 12))[:-1], broken], trials("llm:a", (3, 6)))
    assert [at.success.pairs for at in found.at.values()] == [12, 11]
    made = [*trials("llm:a", (3,), p=(0.0,)), *trials("llm:b", (3,), p=(0.3,))]
    assert uncorrected(on_axis(made)) == []


def test_pairs_of_one_kind_are_corrected_together():
    strong = compared(trials("llm:b", (12, 12)), trials("llm:a", (0, 1)))
    weak = compared(trials("llm:b", (9, 9)), trials("llm:a", (3, 4)))
    beside = replace(compared(trials("llm:b", (9, 9)), trials("random", (3, 3))), among="reference")
    first, second, third = judged([strong, weak, beside])
    assert first.success.p_value == pytest.approx(2 * strong.success.p_value)
    assert second.success.p_value == pytest.approx(weak.success.p_value)
    assert third.success.p_value == beside.success.p_value
    assert second.at[0.0].success.p_value == pytest.approx(min(1.0, 2 * weak.at[0.0].success.p_value))
    assert third.interaction is None
    assert second.interaction.p_adjusted >= weak.interaction.p_value


def test_two_that_each_play_alike_at_every_p_are_looked_at_once():
    alike = compared(trials("llm:b", (9, 9)), trials("llm:a", (3, 3)))
    apart = compared(trials("llm:b", (9, 8)), trials("llm:a", (3, 3)))
    assert (alike.copies, apart.copies) == (True, False)
    assert [at.success.p_value for at in judged([alike])[0].at.values()] == [alike.at[0.0].success.p_value] * 2
    assert judged([apart])[0].at[0.0].success.p_value == pytest.approx(2 * apart.at[0.0].success.p_value)


def test_two_agents_that_act_the_same_in_every_trial_play_alike_and_have_no_p_value():
    """A trial in which one does something else is enough to be tested, and so is one that broke."""
    one, two = trials("llm:a", (3, 6)), trials("llm:b", (3, 6))
    found = judged([compared(one, two)])[0]
    assert found.plays_alike
    tests = [found.success, found.steps, *(part for at in found.at.values() for part in at)]
    assert {part.p_value for part in tests} == {None}
    assert {part.value for part in tests} == {0.0}
    assert (found.interaction, found.verdict) == (None, 0)
    other = make_trial((1,) * 20, agent="llm:b", p=0.3, trial=12)  # fails too, by another joint
    some = judged([compared(one, [*two[:-1], other])])[0]
    assert (some.plays_alike, some.success.p_value) == (False, 1.0)
    assert [at.success.p_value for at in some.at.values()] == [None, 1.0]
    broken = make_trial((0,), agent="llm:b", p=0.3, trial=12, broken="model")
    assert not judged([compared(one, [*two[:-1], broken])])[0].plays_alike


def test_equally_good_agents_that_play_differently_are_not_told_apart_by_the_test_alone():
    """The first fails at the lowest p alone, in six blocks of ten, the second not here: the test is below 0.05."""
    p = tuple(i / 10 for i in range(7))
    found = judged([compared(trials("llm:b", (10,) * 7, 10, p), trials("llm:a", (4, *[10] * 6), 10, p))])[0]
    assert found.success.p_value < 0.05
    assert found.success.low < 0 < found.success.high
    assert found.verdict == 0


def test_the_verdict_is_of_the_corrected_test():
    found = compared(trials("llm:b", (9, 9)), trials("llm:a", (3, 3)))
    assert found.success.p_value == pytest.approx(2 / 2**6)
    assert [judged([found] * n)[0].verdict for n in (1, 3)] == [1, 0]


def test_agents_beside_people_are_compared_with_both_kept_together():
    own = trials("llm:a", (12, 12), p=(0.0, 0.4))
    people = [
        make_trial(SOLUTION if p else FAILED, agent=f"participant:{(block - i) % 12:0>4}", p=p, trial=block + 1)
        for block in range(12)
        for i, p in enumerate((0.0, 0.4))
    ]
    found = compared(people, own)
    assert found.people
    assert found.success.value == -0.5
    assert [at.success.value for at in found.at.values()] == [-1.0, 0.0]
    assert found.at[0.0].success.p_value == 2 * 0.5**12
    assert found.interaction.clearest.change.value == 1.0
    assert found.interaction.p_value < 0.01
    assert found.interaction.mean.low is None


# Broken trials


def with_broken(agent, solved, broken=(), n=40, p=0.0):
    """Trials at one p: those of the given numbers solved or broken, all others failed."""
    return [
        make_trial((0, 1, 2), agent=agent, trial=i, p=p, broken="reply")
        if i in broken
        else make_trial(SOLUTION if i in solved else FAILED, agent=agent, trial=i, p=p)
        for i in range(n)
    ]


def some(n, seed):
    return set(np.random.default_rng(seed).permutation(40)[:n].tolist())


def test_an_agent_whose_failures_break_is_not_called_better():
    """Both solve 20 of 40. Of the second all failures but two break: it solved 20 of 22."""
    second = some(20, 2)
    failures = sorted(set(range(40)) - second)
    plain = compared(with_broken("llm:b", second), with_broken("llm:a", some(20, 1)))
    found = compared(with_broken("llm:b", second, failures[2:]), with_broken("llm:a", some(20, 1)))
    assert (plain.bounded, found.bounded) == (False, True)
    assert found.shares[1] > 0.85
    assert found.success.low < 0 < found.success.high
    assert (judged([plain])[0].verdict, judged([found])[0].verdict) == (0, 0)


def test_an_interaction_has_the_largest_p_value_of_both_ends():
    """Of an agent that false reports help and one that they harm; of the first, some trials break at 0.4."""

    def moved(broken, harm=22):
        helped = [*with_broken("llm:a", some(8, 1)), *with_broken("llm:a", some(30, 3), broken, p=0.4)]
        harmed = [*with_broken("llm:b", some(30, 2)), *with_broken("llm:b", some(30 - harm, 4), p=0.4)]
        return compared(helped, harmed).interaction

    whole, few = moved(()), moved(some(3, 5))
    assert whole.p_value <= few.p_value < 0.05  # it holds however the three ended
    assert few.clearest.dose == whole.clearest.dose == 0.4
    assert moved((), harm=0).p_value < 0.05
    assert moved(some(36, 5), harm=0).p_value == 1.0  # if all 36 failed, false reports harm the first more


# Does noise help one more: found where it does, not where only base rates differ.

P = (0.0, 0.2, 0.4)


def moved_by(first, second, blocks=30, seed=0, **more):
    """Agents that solve the box with these chances at every p."""
    one, two = (
        (np.random.default_rng([seed, i]).random((blocks, 3)) < np.array(chances)) * 1.0
        for i, chances in enumerate((first, second), start=1)
    )
    return interaction_of(P, two - one, None, np.random.default_rng([seed, 3]), **more)


def test_noise_that_helps_one_agent_only_is_found_and_where():
    helped = moved_by((0.5, 0.5, 0.5), (0.1, 0.2, 0.9), blocks=60)
    assert helped.p_value < 0.01
    assert [at.dose for at in helped.at] == [0.2, 0.4]
    assert helped.at[1].change.p_value == helped.p_value
    assert helped.at[1].change.low < 0.8 < helped.at[1].change.high
    assert moved_by((0.1, 0.2, 0.9), (0.5, 0.5, 0.5), blocks=60).at[1].change.value < 0


@pytest.mark.parametrize(("first", "second"), [((0.2,) * 3, (0.9,) * 3), ((0.1, 0.3, 0.5), (0.4, 0.6, 0.8))])
def test_equal_effects_of_noise_on_unequal_agents_are_rarely_taken_for_different_ones(first, second):
    """So few rejections, or fewer, come of a level of 5 % in 999 of 1000 cases."""
    rejected = sum(moved_by(first, second, seed=seed, flips=400).p_value < 0.05 for seed in range(200))
    assert rejected <= 20


def test_a_block_without_the_lowest_p_is_dropped():
    apart = np.random.default_rng(1).integers(-1, 2, (12, 3)) * 1.0
    apart[:4, 0] = apart[5, 1] = np.nan
    some_left = interaction_of(P, apart, None, np.random.default_rng(1))
    assert [at.change.pairs for at in some_left.at] == [7, 8]
    apart[:, 0] = np.nan
    assert interaction_of(P, apart, None, np.random.default_rng(1)) is None
