"""Modalities: what the page says of an agent that is shown the box in several ways."""

import pytest
from builders import SOLUTION, make_trial, modality_study
from reported import found_in

from lockprobe.foundation.formatting import p_cell
from lockprobe.report.questions.speed import SECTIONS

SHOWN = ("rgb", "rgbd", "symbolic")
SOON, LATE = [i % 4 for i in range(10)], [8 + i % 4 for i in range(10)]


def parts_of(directory, *waits, trials=10):
    """The results, the parts of the page and the table of an agent that waits so long before it solves the box."""
    made = [
        make_trial([0] * wait + list(SOLUTION), agent="llm:a/x", modality=modality, study="modalities", trial=i)
        for modality, own in zip(SHOWN, waits, strict=True)
        for i, wait in enumerate(own[:trials], 1)
    ]
    found = found_in(directory, modality_study(["llm:a/x"], SHOWN, trials=trials), made)
    return found, list(SECTIONS[1].show(found)), SECTIONS[1].tables[0].cells(found)


@pytest.mark.parametrize(
    ("waits", "trials", "said"),
    [
        (
            (SOON, LATE, LATE),
            10,
            "The higher the fidelity of what is shown, the later or more rarely the box is solved by {who} (",
        ),
        ((LATE, SOON, LATE), 10, "The modality changes how soon the box is solved by {who}, in no order"),
        (
            (SOON, SOON, SOON),
            10,
            "No effect of the modality on how soon the box is solved by {who} was detected (P = 1).",
        ),
        ((SOON, LATE, LATE), 3, "Too few trials ended to test whether the modality changes how soon the box is solved"),
    ],
)
def test_the_answer_is_the_trend_or_else_that_modalities_differ(tmp_path, waits, trials, said):
    _, (part,), _ = parts_of(tmp_path, *waits, trials=trials)
    assert part.answer.startswith(said.format(who="llm:a/x"))


def test_every_two_modalities_have_a_line_with_the_numbers_of_their_rows(tmp_path):
    found, _, (head, *table) = parts_of(tmp_path, SOON, SOON, LATE)
    rows = found.where("hazard_ratio", of="modalities")
    assert [row.corrected_for for row in rows] == [3] * 3
    assert [(line[2], line[3]) for line in table] == [(row, p_cell(row.p_value)) for row in rows]
    assert [line[:2] for line in table[1:]] == [
        ["llm:a/x (positions and outcomes in words)", "RGB"],
        ["llm:a/x (positions and outcomes in words)", "RGB-D"],
    ]
    assert {row.family for row in found.where("success_difference", agent="llm:a/x")} >= {"every two modalities"}
    assert len(head) == len(table[0])
