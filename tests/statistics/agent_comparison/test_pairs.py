"""Which pairs are compared, and what holds where trials broke."""

import numpy as np
from builders import SOLUTION, make_trial

from lockprobe.report.prose.agent_comparison import comparison_said
from lockprobe.statistics.summary import summarise


def trials(agent, solved, modality="symbolic", of=20):
    return [
        make_trial(SOLUTION if i < solved else (0,) * 20, agent=agent, trial=i + 1, modality=modality, p=p)
        for p in (0.0, 0.4)
        for i in range(of)
    ]


def test_models_are_compared_with_each_other_and_with_the_baselines():
    agents = ("llm:a", "llm:b", "human-inspired?lapse=0.1", "random", "round-robin")
    found = summarise([trial for agent in agents for trial in trials(agent, 10)]).comparisons
    assert [(one.second[0], one.first[0], one.among) for one in found] == [
        ("llm:a", "llm:b", "subjects"),
        ("llm:a", "human-inspired?lapse=0.1", "reference"),
        ("llm:a", "random", "reference"),
        ("llm:b", "human-inspired?lapse=0.1", "reference"),
        ("llm:b", "random", "reference"),
    ]


def test_strategies_alone_are_what_the_study_is_about():
    found = summarise(trials("random", 3) + trials("round-robin", 18)).comparisons
    assert [(one.second[0], one.among) for one in found] == [("random", "subjects")]


def test_only_agents_that_saw_the_box_alike_are_compared():
    made = [t for a in ("llm:a", "llm:b") for m in ("rgb", "symbolic") for t in trials(a, 9, m)] + trials("random", 9)
    found = summarise(made).comparisons
    between = [one for one in found if one.among == "subjects"]
    assert {(one.first, one.second) for one in between} == {
        (("llm:b", "rgb"), ("llm:a", "rgb")),
        (("llm:b", "symbolic"), ("llm:a", "symbolic")),
    }
    assert len(found) - len(between) == 4


def with_broken(agent, solved, broken=(), n=40, p=0.0):
    """Trials at one p: those of the given numbers solved or broken, all others failed."""
    return [
        make_trial((0, 1, 2), agent=agent, trial=i, p=p, broken="reply")
        if i in broken
        else make_trial(SOLUTION if i in solved else (0,) * 20, agent=agent, trial=i, p=p)
        for i in range(n)
    ]


def compared(*groups):
    summary = summarise([trial for group in groups for trial in group])
    (one,) = summary.comparisons
    return one, summary


def some(n, seed):
    return set(np.random.default_rng(seed).permutation(40)[:n].tolist())


def test_an_agent_whose_failures_break_is_not_called_better():
    """Both solve 20 of 40. Of the second all failures but two break: it solved 20 of 22."""
    second = some(20, 2)
    failures = sorted(set(range(40)) - second)
    plain, _ = compared(with_broken("llm:b", second), with_broken("llm:a", some(20, 1)))
    bounded, summary = compared(with_broken("llm:b", second, failures[2:]), with_broken("llm:a", some(20, 1)))
    assert not plain.bounded
    assert bounded.bounded
    assert bounded.second_share > 0.85
    assert bounded.success.low < 0 < bounded.success.high
    assert (plain.verdict, bounded.verdict) == (0, 0)
    assert "interval and P value hold whatever became of broken trials" in comparison_said(bounded, summary)[0]


def interaction(broken, harm=22):
    """Of an agent that false reports help and one that they harm; of the first, so many trials break at 0.4."""
    helped = [*with_broken("llm:a", some(8, 1)), *with_broken("llm:a", some(30, 3), broken, p=0.4)]
    harmed = [*with_broken("llm:b", some(30, 2)), *with_broken("llm:b", some(30 - harm, 4), p=0.4)]
    return compared(helped, harmed)[0].interaction


def test_an_interaction_has_the_largest_p_value_of_both_ends():
    whole, few = interaction(()), interaction(some(3, 5))
    assert whole.p_value <= few.p_value < 0.05  # it holds however the three ended
    assert few.clearest.dose == whole.clearest.dose == 0.4
    assert interaction((), harm=0).p_value < 0.05
    assert interaction(some(36, 5), harm=0).p_value == 1.0  # if all 36 failed, false reports harm the first more
