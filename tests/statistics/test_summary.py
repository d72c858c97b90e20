"""A study in numbers: counts by hand, every condition once, and sentences that say no more than the numbers."""

from dataclasses import replace

import numpy as np
import pytest
from builders import SOLUTION, make_trial, play_study, small_study

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue
from lockprobe.report.prose.success import finding
from lockprobe.statistics.summary import summarise

FAILED = (0,) * 20
AGENT = "llm:local"


def condition(p, solved, n, *, agent=AGENT, repetitions=1):
    """Trials of one condition, of which so many are solved, others at every p; failures differ between conditions."""
    lucky = set(np.random.default_rng(int(100 * p)).permutation(n)[:solved].tolist())
    return [
        make_trial(
            SOLUTION if i in lucky else (int(10 * p) % 4, *FAILED[1:]),
            agent=agent, p=p, repetition=1 + i % repetitions, trial=1 + i // repetitions,
        )
        for i in range(n)
    ]  # fmt: skip


def only(trials):
    (agent,) = summarise(trials).agents
    return agent


def test_counts_by_hand():
    broken = make_trial([0], agent=AGENT, p=0.4, trial=99, broken="model")
    summary = summarise([*condition(0.0, 7, 30), *condition(0.4, 20, 30), broken])
    first, second = summary.conditions
    assert (first.key, first.dose, first.success.count, first.success.n) == ("flips/llm:local/truth", 0.0, 7, 30)
    assert (second.success.count, second.success.n, second.errors) == (20, 30, {"model": 1})
    assert first.errors == {}


def test_every_trial_is_in_one_condition_and_one_point():
    trials = play_study(small_study())
    summary = summarise(trials)
    assert sum(c.success.n for c in summary.conditions) == len(trials)
    assert len({c.key for c in summary.conditions}) == len(summary.conditions) == 6
    for found in summary.conditions:
        assert [point.repetition for point in found.points] == [1, 2]
        pooled = sum(point.success * point.n for point in found.points) / found.success.n
        assert pooled == pytest.approx(found.success.value)


def test_variants_of_a_reference_are_references():
    agents = ("human-inspired:proximity", "human-inspired?lapse=0.1", "ideal-observer?noise=aware", "cognitive:careful")
    summary = summarise([trial for agent in agents for trial in condition(0.0, 2, 4, agent=agent)])
    assert [agent.agent for agent in summary.subjects] == ["cognitive:careful"]


def test_an_agent_that_ignores_reports_is_called_blind():
    agents = {agent.agent: agent for agent in summarise(play_study(small_study())).agents}
    assert agents["random"].blind
    assert agents["random"].contrast is None
    assert "played alike whatever it was told" in finding(agents["random"])
    assert not agents["human-inspired"].blind


def test_the_interval_of_a_chosen_difference_is_wider():
    rows = [*condition(0.0, 10, 30), *condition(0.4, 18, 30)]
    one, several = only(rows), only([*rows, *condition(0.2, 10, 30), *condition(0.6, 11, 30)])
    assert several.contrast.other.dose == 0.4
    assert several.contrast.choices == 3
    assert several.contrast.difference.low < one.contrast.difference.low
    assert several.contrast.difference.high > one.contrast.difference.high


def test_a_clear_rise_is_called_one():
    agent = only([*condition(0.0, 7, 30), *condition(0.4, 20, 30)])
    assert (agent.contrast.detectable, agent.contrast.choices) == (True, 1)
    said = finding(agent)
    assert "more often at a flip rate of 0.4 than when told the truth" in said
    assert "20 of 30 trials (67 %) against 7 of 30 trials (23 %)" in said


def test_chance_is_not_called_an_effect():
    agent = only([*condition(0.0, 10, 30), *condition(0.2, 12, 30), *condition(0.4, 14, 30)])
    assert not agent.contrast.detectable
    assert agent.contrast.difference.p_value == agent.inference.difference.p_value
    assert finding(agent).startswith("No effect of false reports on the success of llm:local was detected")
    assert "This does not show that there is no effect." in finding(agent)


def test_choosing_the_best_is_paid_for():
    one = only([*condition(0.0, 8, 30), *condition(0.6, 17, 30)])
    many = only(
        [trial for p, k in ((0.0, 8), (0.1, 9), (0.2, 9), (0.3, 9), (0.6, 17)) for trial in condition(p, k, 30)]
    )
    assert one.contrast.detectable
    assert not many.contrast.detectable


def test_copies_of_the_same_trial_are_counted_and_said():
    """An agent that acts the same whenever it is told the same gives no new trial for more of them."""
    solving, failing = [3, 2, 1, 0], [1] * 20
    for n in (30, 60):
        trials = [
            make_trial(solving if (i + bool(p)) % 2 else failing, agent="a", p=p, trial=i + 1)
            for p in (0.0, 0.4)
            for i in range(n)
        ]
        (agent,) = summarise(trials).agents
        assert [one.distinct_sequences for one in agent.conditions] == [2, 2]
        said = "When told the truth, its 60 trials contain only 2 different sequences of actions."
        assert finding(agent).endswith(said) == (n == 60)


def test_nothing_solved_and_one_condition_and_nothing_ended():
    assert "it solved 0 of 30 trials (0 %) when" in finding(only([*condition(0.0, 0, 30), *condition(0.3, 0, 30)]))
    assert "no difference to test" in finding(only(condition(0.0, 3, 10)))
    broken = only([make_trial([0], agent=AGENT, broken="model")])
    assert "No trial" in finding(broken)
    assert broken.conditions[0].success.n == 0
    assert summarise([]).agents == ()


def test_trials_of_two_boxes_are_not_analysed_together():
    other = replace(make_trial(SOLUTION), box="chain-5", key="elsewhere")
    with pytest.raises(BadValue, match="boxes chain-4, chain-5"):
        summarise([make_trial(SOLUTION), other])
    with pytest.raises(BadValue, match="boxes chain-4, chain-6"):
        summarise([make_trial(SOLUTION)], box("chain-6"))


def test_partial_studies_are_compared_on_what_both_conditions_have():
    """Thirty trials told the truth, five at 0.4: the counts, the points and the interval are of those five."""
    trials = [*condition(0.0, 9, 30), *(t for t in condition(0.4, 24, 30) if t.trial <= 5)]
    agent = only(trials)
    found = agent.contrast.difference
    assert (found.first.n, found.second.n, agent.contrast.whole) == (5, 5, False)
    assert found.value == found.second.value - found.first.value
    assert found.low <= found.value <= found.high
    assert "of the trials that it finished under both conditions" in finding(agent)


def test_the_contrast_is_the_permutation_test_of_the_inference():
    agent = only([*condition(0.0, 7, 30), *condition(0.4, 20, 30)])
    (test,) = (t for t in agent.inference.tests if t.question == "success")
    assert test.p_value == agent.contrast.difference.p_value < 0.05
    assert test.effect == pytest.approx(13 / 30)
    assert agent.contrast.difference.pairs.n == 30
