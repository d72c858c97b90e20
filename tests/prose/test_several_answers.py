"""The first sentence of a page that answers several questions: a change stands if it is detected after all of them."""

import pytest

from lockprobe.prose.overview import several_answers


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
    asked = [(f"cause {i}", f"Answer {i}.", value) for i, value in enumerate(p_values)]
    every = "both" if len(asked) == 2 else f"all {len(asked)}"
    expected = [
        f"An effect of cause {i} was detected in its own section (P = {value:.2g}), but not after correction for {every} "
        "questions of this page."
        if str(i) in lost
        else f"Answer {i}."
        for i, value in enumerate(p_values)
    ]
    assert several_answers(asked) == " ".join(expected)
