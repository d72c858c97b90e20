"""The sentence on a suite."""

from dataclasses import replace

from lockprobe.analysis.suite_scores import Score, SuiteScore
from lockprobe.prose.suite import suite_said

BEST = SuiteScore(
    trials=288,
    broken=0,
    competence=Score(value=0.5, low=0.4, high=0.6),
    robustness=Score(value=-0.2, low=-0.3, high=-0.1),
    misreading=None,
    loops=None,
    rationality=None,
    levels=(),
)


def test_it_names_the_first_agent_and_says_a_change_only_where_it_is_shown():
    size = "50 % [40, 60], where 0 % is chance and 100 % solves every box"
    assert suite_said([("a", BEST)]) == (
        f"a has a competence of {size}. False reports lower it (\N{MINUS SIGN}20 [\N{MINUS SIGN}30, \N{MINUS SIGN}10] points)."
    )
    open_ = replace(BEST, robustness=Score(value=0.02, low=-0.1, high=0.14))
    assert suite_said([("a", open_), ("b", BEST)]) == (
        f"a has the highest competence of 2 agents: {size}. No effect of false reports on it was detected (+2 [\N{MINUS SIGN}10, +14] points)."
    )
    raised = replace(BEST, robustness=Score(value=0.2, low=0.1, high=0.3))
    assert "False reports raise it (+20" in suite_said([("a", raised)])
    assert suite_said([("a", replace(BEST, robustness=None))]).endswith("solves every box.")
    assert suite_said([("a", replace(BEST, competence=None))]) == suite_said([])
