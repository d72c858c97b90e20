"""Success over doses: rows are what the tests give, over flip rates and over every other dose alike."""

from dataclasses import replace

import pytest
from builders import play_study, small_study, write_study
from reported import found_in

from lockprobe.foundation.seeds import generator
from lockprobe.report.opened import open_study
from lockprobe.report.page import parts_of
from lockprobe.report.results import results_of
from lockprobe.report.rows import BOUNDS
from lockprobe.report.section import Table
from lockprobe.statistics.differences import any_difference
from lockprobe.studies.options.studyfile import study
from lockprobe.trial.record import TrialError

AGENTS = ("cognitive:perseverant", "human-inspired", "random")
READER = "cognitive:perseverant"
SMALL = {"trials": 6, "repetitions": 1}


def broke(trial):
    error = TrialError(boundary="reply", message="not one JSON object", step=4)
    return replace(trial, steps=trial.steps[:3], ending="error", error=error, changed={}, changed_steps=0)


@pytest.fixture(scope="module", params=[False, True], ids=["whole", "broken"])
def numbers(request, tmp_path_factory):
    """A study of flip rates, or one of which every seventh trial broke."""
    planned = small_study(AGENTS, (0.0, 0.2, 0.4, 0.6), 2, 8)
    trials = [broke(trial) if request.param and i % 7 == 3 else trial for i, trial in enumerate(play_study(planned))]
    return open_study(write_study(tmp_path_factory.mktemp("success") / "study", planned, trials))


def test_every_change_is_a_row_with_its_shares_and_its_bounds(numbers):
    found = results_of(numbers)
    for course, shown in zip(numbers.courses, found.courses(), strict=True):
        rng = generator(course.trials[0].seed, "analysis", course.spec, course.modality, "permutation")
        tested = any_difference(course.tested, rng, agents=course.family)
        changes = {cell.dose: row for cell, row in shown.changes()}
        assert {dose: (row.value, row.low, row.high, row.p_value) for dose, row in changes.items()} == {
            one.dose: (one.value, one.low, one.high, one.p_value) for one in tested
        }
        assert course.blind == (not changes) == (shown.clearest is None)
        for (cell, row), (_, first), (_, second) in zip(
            shown.changes(), shown.changes("the control", "success_in_pairs"), shown.changes("", "success_in_pairs"),
            strict=True,
        ):  # fmt: skip
            assert row.value == pytest.approx(second.value - first.value)
            assert first.n == second.n == row.n <= cell.trials
        for end, at in zip(BOUNDS, (0, 1), strict=True):
            bounds = {cell.dose: row.value for cell, row in shown.changes(end)}
            assert bounds == {one.dose: one.bounds[at] for one in tested if one.bounds}
        if shown.clearest:
            assert shown.clearest[1].p_value == min(row.p_value for row in changes.values())


def test_other_doses_have_the_same_rows_and_a_part_of_their_own(tmp_path):
    asked = {"agent": [READER, "random"], "p": [0, 0.3, 0.6], "sweep": "tremble?p=0.1,0.2,0.4"}
    found = found_in(tmp_path, study("flips", **asked, trials=8, repetitions=2))
    flips, axis = found.design.axes
    assert (axis.key, axis.doses) == ("tremble p", {"truth": 0} | {f"tremble?p={p}": p for p in (0.1, 0.2, 0.4)})
    for course in found.courses(axis):
        assert [cell.dose for cell in course.cells] == [0, 0.1, 0.2, 0.4]
        lowest, *others = [cell.value("success") for cell in course.cells]
        assert [row.value for _, row in course.changes()] == pytest.approx([share - lowest for share in others])
    (part,) = [part for part in parts_of(found) if part.name == "doses"]
    assert part.heading == "Tremble p"
    assert "higher doses of tremble" in part.answer
    assert "false report" not in part.answer
    assert not [block for block in part.blocks if isinstance(block, Table)]  # all conditions are one table
    assert flips.of_flips


@pytest.mark.parametrize("p", [[0], [0, 0.4]])
def test_options_of_an_agent_are_a_dose_without_another_condition(tmp_path, p):
    agents = [f"human-inspired?lapse={lapse}" for lapse in (0, 0.1, 0.3)]
    found = found_in(tmp_path, study("flips", agent=agents, p=p, **SMALL))
    axis = found.design.axes[-1]
    (course,) = found.courses(axis)
    assert (axis.name, [cell.agent for cell in course.cells]) == ("lapse", agents)
    assert len(course.changes()) == 2
    (part,) = [part for part in parts_of(found) if part.name == "doses"]
    assert part.answer
    assert not found.beside_flips
