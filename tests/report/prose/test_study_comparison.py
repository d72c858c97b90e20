"""The sentence about a comparison of studies says what the numbers bear, and no more."""

import re
from dataclasses import replace

from builders import SOLUTION, make_trial

from lockprobe.report.prose.study_comparison import comparison_of_studies_said, leading
from lockprobe.report.prose.subject import Subject
from lockprobe.statistics.agent_comparison.across_studies import Sample, Side, study_differences


def sample(study, solved, *, luck=1, agent="llm:a", condition="truth", broken=0, baseline=False):
    trials = [make_trial(SOLUTION if i < solved else (0,) * 20, agent=agent, trial=i + 1) for i in range(20)]
    trials += [make_trial([0], agent=agent, trial=21 + i, broken="model") for i in range(broken)]
    return Sample(side=Side(study, agent), condition=condition, luck=luck, baseline=baseline, trials=trials)


def said(*samples):
    found = study_differences(samples)
    names = {
        one.side: Subject(name=f"{one.side.agent} in {'abc'[one.side.study]}", plural=one.side.agent == "people")
        for one in samples
    }
    return comparison_of_studies_said(found, names)


def test_a_difference_that_is_shown():
    assert said(sample(0, 2), sample(1, 18)) == (
        "llm:a in b solves the box more often than llm:a in a under truth: 90 % against 10 % (+80 points, 95 % interval "
        "+52 to +93; P < 0.001; 20 pairs of trials with common random numbers)."
    )
    assert said(sample(0, 18), sample(1, 2, luck=2)).endswith("; 20 and 20 trials, independent samples).")
    assert " less often than " in said(sample(0, 18), sample(1, 2, luck=2))


def test_a_difference_that_is_not_shown_is_not_said_to_be_nothing():
    found = said(sample(0, 9), sample(1, 11, luck=2))
    assert found.startswith(
        "No difference between studies was detected, which does not show that there is none; it is "
    )
    assert "solves" not in found
    several = said(sample(0, 9), sample(1, 11, luck=2), sample(2, 10, luck=3))
    assert several.startswith("No difference between studies was detected in 3 comparisons, ")
    assert "P = 1, corrected for 3 differences" in several


def test_of_several_the_clearest_that_is_shown_is_told():
    found = said(sample(0, 10), sample(1, 11, luck=2), sample(2, 20, luck=3))
    assert re.match(
        r"2 of 3 differences between studies were detected, the clearest: llm:a in c solves .* llm:a in a ", found
    )
    one = said(sample(0, 10), sample(1, 16, luck=2), sample(2, 20, luck=3))
    assert re.match(r"1 of 3 differences between studies was detected: llm:a in c solves the box more often ", one)


def test_a_sentence_about_several_families_is_corrected_for_their_number():
    """A P value of 0.03 in its family: the sentence is about two, and the table about each."""
    nudged = [replace(sample(study, n, condition="nudge", luck=study), family="") for study, n in ((0, 4), (1, 11))]
    flips = [replace(sample(study, 10, luck=study), family="flip rate") for study in (0, 1)]
    alone, both = said(*nudged), said(*flips, *nudged)
    assert alone.startswith("llm:a in b solves the box more often than llm:a in a under nudge: ")
    assert both.startswith("No difference between studies was detected in 2 comparisons, ")
    assert ", corrected for 1 difference of its family and for 2 families of conditions; " in both
    assert both.endswith(" 1 more is detected if each family is taken alone.")
    clear = [replace(sample(study, n, condition="nudge"), family="") for study, n in ((0, 1), (1, 19))]
    assert said(*flips, *clear).startswith("1 of 2 differences between studies was detected: llm:a in b solves ")
    assert "taken alone" not in said(*flips, *clear)


def test_people_are_many_and_broken_trials_are_told():
    assert re.match("People in b solve the box more often", said(sample(0, 2), sample(1, 18, agent="people")))
    assert "P < 0.001, the largest over the treatments of broken trials;" in said(sample(0, 2), sample(1, 18, broken=2))


def test_baselines_lead_only_where_there_is_nothing_else():
    samples = [sample(0, 2), sample(1, 18, agent="random", baseline=True)]
    assert "difference between baselines" not in said(*samples, sample(1, 2))
    found = study_differences([*samples, sample(1, 2)])
    assert {one.kind for one in leading(found)} == {"between"}
    assert leading([]) == []


def test_without_a_pair_between_studies_nothing_is_concluded():
    nothing = "No two studies have a trial to compare under a condition that they share."
    assert said(sample(0, 2), sample(0, 18, agent="llm:b")) == nothing
    assert said(sample(0, 2)) == nothing
