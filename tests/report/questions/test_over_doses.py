"""Success, loops and speed over doses, and by modality: rows say what the trials say, and sentences what rows say."""

from dataclasses import replace

import pytest
from builders import SOLUTION, make_trial, modality_study, small_study
from reported import found_in

from lockprobe.report.page import Page, parts_of
from lockprobe.report.questions.speed import SECTIONS
from lockprobe.report.section import Table
from lockprobe.statistics.loops.chance import chance_level
from lockprobe.studies.options.studyfile import study

READER = "cognitive:perseverant"
SMALL = {"trials": 6, "repetitions": 1}


def test_other_doses_have_the_same_rows_and_a_part_of_their_own(tmp_path):
    asked = {"agent": [READER, "random"], "p": [0, 0.3, 0.6], "sweep": "tremble?p=0.1,0.2,0.4"}
    found = found_in(tmp_path, study("flips", **asked, **SMALL))
    flips, axis = found.design.axes
    assert (axis.axis.key, axis.axis.doses) == (
        "tremble p",
        {"truth": 0} | {f"tremble?p={p}": p for p in (0.1, 0.2, 0.4)},
    )
    for course in found.courses(axis):
        assert [cell.dose for cell in course.cells] == [0, 0.1, 0.2, 0.4]
        lowest, *others = [cell.value("success") for cell in course.cells]
        assert [row.value for _, row in course.changes()] == pytest.approx([share - lowest for share in others])
    (part,) = [part for part in parts_of(found) if part.name == "doses"]
    assert part.heading == "Tremble p"
    assert "higher doses of tremble" in part.answer
    assert "false report" not in part.answer
    assert not [block for block in part.blocks if isinstance(block, Table)]  # all conditions are one table
    assert flips.axis.of_flips


def test_numbers_of_known_trials(tmp_path):
    """Chance is that of exactly these lengths; simulated where it cannot be counted, and then with an interval."""
    played = [[0, 1, 0, 0, 0, 1, 0] + [1] * 13, SOLUTION]
    trials = [make_trial(one, agent="llm:x", trial=i) for i, one in enumerate(played, 1)]
    trials += [make_trial([0] * 3, agent="llm:x", trial=3, broken="model")]
    (cell,) = found_in(tmp_path / "exact", small_study(("llm:x",), (0.0,), 1, 3), trials).cells
    assert (cell.value("loop_rate"), cell.get("loop_rate").n) == (1 / 2, 2)
    assert cell.value("loop_rate", "uniform") == pytest.approx(chance_level(20).probability / 2)
    assert cell.value("loop_rate", "no-repeat") == pytest.approx(chance_level(20, null="no-repeat").probability / 2)
    assert cell.get("loop_rate", "uniform").low is None
    long = [make_trial([0, 1, 2] * 9, agent="llm:x", budget=27)]
    (cell,) = found_in(tmp_path / "long", replace(small_study(("llm:x",), (0.0,), 1, 1), max_steps=27), long).cells
    level = cell.get("loop_rate", "uniform")
    assert level.note == "simulation"
    assert 0 < level.low < level.value < level.high <= 1


@pytest.mark.parametrize(
    ("loops", "said"), [(12, "more than chance"), (0, "less than chance"), (9, "no difference detected")]
)
def test_the_interval_has_to_lie_outside_both_levels_of_chance(tmp_path, loops, said):
    """Of 12 trials of 12 steps, in which random actions loop in 31 to 48 %."""
    played = [[0, 1, 2] * 4 if i < loops else [0] * 5 + [1] * 5 + [0] * 2 for i in range(12)]
    trials = [make_trial(one, agent="llm:x", trial=i, budget=12) for i, one in enumerate(played, 1)]
    found = found_in(tmp_path, replace(small_study(("llm:x",), (0.0,), 1, 12), max_steps=12), trials)
    assert f", by chance 31 to 48&nbsp;% ({said})" in Page(found=found).text()


# Modalities

SHOWN = ("rgb", "rgbd", "symbolic")
SOON, LATE = [i % 4 for i in range(10)], [8 + i % 4 for i in range(10)]


def shown_parts(directory, *waits, trials=10):
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
            "The higher the fidelity of what is shown, the later or more rarely the box is solved by",
        ),
        ((LATE, SOON, LATE), 10, "The modality changes how soon the box is solved by llm:a/x, in no order"),
        ((SOON, LATE, LATE), 3, "Too few trials ended to test whether the modality changes how soon the box is solved"),
    ],
)
def test_the_answer_is_the_trend_or_else_that_modalities_differ(tmp_path, waits, trials, said):
    _, (part,), _ = shown_parts(tmp_path, *waits, trials=trials)
    assert part.answer.startswith(said)
