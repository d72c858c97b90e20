"""The sentence on a suite."""

from dataclasses import replace

from lockprobe.report.prose.suite import suite_said
from lockprobe.statistics.proportions import proportion
from lockprobe.statistics.suite.scores import LevelScore, Score, SuiteScore

LESS = "\N{MINUS SIGN}"
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
WORSE = replace(BEST, competence=Score(value=0.3, low=0.2, high=0.4), together=3)
SIZE = "50 % [40, 60], where 0 % is chance and 100 % solves every box"
LOWER = f"False reports lower its competence ({LESS}20 [{LESS}30, {LESS}10] points)."


def test_of_one_agent_it_says_the_competence_and_a_change_only_where_it_is_shown():
    assert suite_said([("a", BEST)]) == f"a has a competence of {SIZE}. {LOWER}"
    open_ = replace(BEST, robustness=Score(value=0.02, low=-0.1, high=0.14))
    assert suite_said([("a", open_)]).endswith(
        f"No effect of false reports on its competence was detected (+2 [{LESS}10, +14] points)."
    )
    raised = replace(BEST, robustness=Score(value=0.2, low=0.1, high=0.3))
    assert "False reports raise its competence (+20" in suite_said([("a", raised)])
    assert suite_said([("a", replace(BEST, robustness=None))]).endswith("solves every box.")
    assert suite_said([("a", replace(BEST, competence=None))]) == suite_said([])


def test_of_studies_that_stop_nothing_is_concluded_from_intervals_of_a_fixed_number():
    said = "Whether false reports change success, the reports of its studies say, which hold at every look."
    assert suite_said([("a", BEST)], stops=True) == f"a has a competence of {SIZE}. {said}"
    shown = [("a", replace(BEST, ranks=(1, 1), together=2)), ("b", replace(WORSE, ranks=(2, 2), together=2))]
    assert suite_said(shown, stops=True) == f"The highest measured competence is a's: {SIZE}. {said}"


def test_the_best_of_several_is_named_as_the_best_only_if_the_comparisons_show_it():
    first, second, third = (replace(one, together=3) for one in (BEST, WORSE, WORSE))
    shown = [
        ("a", replace(first, ranks=(1, 1))),
        ("b", replace(second, ranks=(2, 3))),
        ("c", replace(third, ranks=(2, 3))),
    ]
    assert suite_said(shown) == f"a has the highest competence of 3 agents: {SIZE}. {LOWER}"
    open_ = [
        ("a", replace(first, ranks=(1, 2))),
        ("b", replace(second, ranks=(1, 3))),
        ("c", replace(third, ranks=(2, 3))),
    ]
    assert suite_said(open_) == (
        f"a has the highest competence of 3 agents: {SIZE}; the tests do not decide which of 2 of them is the best. "
        f"{LOWER}"
    )


def test_a_tie_has_no_single_best():
    tie = [("a", replace(BEST, together=2, ranks=(1, 2))), ("b", replace(BEST, together=2, ranks=(1, 2)))]
    assert suite_said(tie) == (
        f"a, b have the highest competence of 2 agents: {SIZE}; the tests do not decide which of 2 of them is the best."
    )


def test_an_agent_that_opened_nothing_is_said_to():
    none = LevelScore(box="fork", chance=0.5, told=proportion(0, 36), misled=proportion(0, 36))
    assert suite_said([("a", replace(BEST, robustness=None, levels=(none,)))]).endswith(
        "It opened no box, so false reports could not lower its competence."
    )
