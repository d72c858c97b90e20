"""Two agents, one of which breaks in its long trials: nothing is concluded that hangs on what became of those."""

import numpy as np
from builders import SOLUTION, make_trial

from lockprobe.analysis.summary import summarise
from lockprobe.prose.agent_comparison import comparison_said


def trials(agent, solved, broken=(), n=40):
    """Trials at one p: those of the given numbers solved or broken, all others failed."""
    return [
        make_trial((0, 1, 2), agent=agent, trial=i, broken="reply")
        if i in broken
        else make_trial(SOLUTION if i in solved else (0,) * 20, agent=agent, trial=i)
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
    plain, _ = compared(trials("llm:b", second), trials("llm:a", some(20, 1)))
    bounded, summary = compared(trials("llm:b", second, failures[2:]), trials("llm:a", some(20, 1)))
    assert not plain.bounded
    assert bounded.bounded
    assert bounded.second_share > 0.85
    assert bounded.success.low > 0
    assert (plain.verdict, bounded.verdict) == (0, 0)
    assert "the largest p-value over what became of broken trials" in comparison_said(bounded, summary)[0]


def test_a_difference_that_holds_at_both_ends_is_told():
    found, _ = compared(trials("llm:b", set(range(2, 40)), {0, 1}), trials("llm:a", some(4, 1)))
    assert (found.bounded, found.verdict) == (True, 1)


def test_without_broken_trials_nothing_is_bounded():
    found, summary = compared(trials("llm:b", some(36, 2)), trials("llm:a", some(4, 1)))
    assert (found.bounded, found.verdict) == (False, 1)
    assert "broken" not in comparison_said(found, summary)[0]
