"""Speed: its rows say what the trials say, and its figure, table and sentence what the rows say."""

import pytest
from builders import SOLUTION, make_trial, modality_study, play_study, small_study
from drawn import beside, shades, staircases
from reported import found_in

from lockprobe.foundation.formatting import p_cell
from lockprobe.report.questions.speed import SECTIONS, draw
from lockprobe.statistics.outcomes import outcomes

PLANNED = small_study(["cognitive:perseverant", "random"], (0.0, 0.2, 0.4), 2, 8)


@pytest.fixture(scope="module")
def played():
    return play_study(PLANNED)


@pytest.fixture(scope="module")
def found(played, tmp_path_factory):
    return found_in(tmp_path_factory.mktemp("speed"), PLANNED, played)


def test_steps_are_those_of_the_trials(found, played):
    """Without trials that broke the mean over all of them is that of their lengths."""
    for cell in found.cells:
        own = outcomes([one for one in played if (one.group, one.condition) == (cell.agent, cell.condition)])
        assert cell.value("mean_steps_all") == pytest.approx(own.length.mean())
        for part, share in (("half", 0.5), ("80 %", 0.8)):
            solved = sorted(own.length[own.solved].tolist())
            reached = -(-round(share * len(own) * 100) // 100)
            assert cell.value("steps_to_solve", part) == (solved[reached - 1] if len(solved) >= reached else None)
        curve = cell.curve("success_by_step")
        assert curve.value[-1] == own.solved.mean()
    (course, _) = found.courses()
    change = course.get("steps_difference", "higher")
    steps = [cell.value("mean_steps_all") for cell in course.cells]
    assert change.value == pytest.approx((steps[1] + steps[2]) / 2 - steps[0])
    assert change.low < change.value < change.high
    assert found.courses()[1].get("steps_difference", "higher") is None  # it plays alike whatever it is told


def test_the_figure_has_a_line_an_agent_with_a_band_about_those_that_the_study_is_about(found):
    (axes,) = draw(found).axes
    curves = [course.cells[0].curve("success_by_step") for course in found.courses()]
    assert [tuple(line.get_ydata()[:-1]) for line in staircases(axes)] == [curve.value for curve in curves]
    assert beside(axes) == {*found.subjects, "random", "random agents, exact"}
    corners = set().union(*shades(axes))
    assert corners >= set(enumerate(curves[0].low)) | set(enumerate(curves[0].high))
    assert not corners >= set(enumerate(curves[1].high))
    for of in ("uniform", "no-repeat"):
        assert corners >= set(enumerate(found.curve("success_by_step", of=of).value))


# Modalities

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
