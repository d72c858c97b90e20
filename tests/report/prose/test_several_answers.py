"""The first sentence of a page that answers several questions: a change stands if it is detected after all of them."""

import pytest

from lockprobe.report.prose.several_answers import Question, several_answers


def asking(i, *p_values):
    tested = tuple((f"on agent {n}", p_value) for n, p_value in enumerate(p_values))
    return Question(about=f"cause {i}", answer=lambda many: f"Answer {i}.", tested=tested)


@pytest.mark.parametrize(
    ("p_values", "lost"),
    [
        ([0.001, 0.8], ""),
        ([0.03, 0.8], "0"),  # Holm: 2 x 0.03
        ([0.03, 0.02], ""),  # 2 x 0.02, then 0.03
        ([0.03, 0.04], "01"),
        ([0.6, 0.026], "1"),
        ([None, 0.03], ""),  # one question alone
        ([0.03], ""),
        ([0.02, 0.02, 0.9], "01"),  # 3 x 0.02
        ([0.01, 0.02, 0.9], ""),  # 3 x 0.01, then 2 x 0.02
    ],
)
def test_a_change_is_said_if_it_is_detected_after_all(p_values, lost):
    asked = [asking(i, *([] if value is None else [value])) for i, value in enumerate(p_values)]
    every = "both" if len(asked) == 2 else f"all {len(asked)}"
    expected = [
        f"An effect of cause {i} was detected in its own section (P = {value:.2g}), but not after correction for {every} "
        "questions of this page."
        if str(i) in lost
        else f"Answer {i}."
        for i, value in enumerate(p_values)
    ]
    assert several_answers(asked) == " ".join(expected)


@pytest.mark.parametrize(
    ("first", "second", "lost"),
    [
        ([0.001, 0.03, 0.04], [0.8], "on agent 1 and on agent 2"),  # each twice
        ([0.001, 0.03], [0.0001], ""),  # the other question is clearer, so this one counts once
        ([0.001, 0.02], [0.8], ""),
        ([0.001, 0.06], [0.8], ""),  # it was not detected before
    ],
)
def test_further_agents_of_a_question_are_corrected_alike(first, second, lost):
    said = several_answers([asking(0, *first), asking(1, *second)])
    of_these = f" Of these, the effect {lost} was not detected after correction for both questions of this page."
    assert said == f"Answer 0.{of_these if lost else ''} Answer 1."


def test_conditions_are_named_only_if_they_are_detected_after_all():
    tested = (("of nudge", 0.001), ("of warn", 0.03))
    told = Question(about="other conditions", answer=lambda many: f"After {many}.", tested=tested, corrected=True)
    after = "after correction for both questions of this page."
    lost = f"The effect of warn was detected in its own section, but not {after}"
    assert several_answers([told, asking(1, 0.8)]) == f"After 2. {lost} Answer 1."
    assert several_answers([told]) == "After 1."
