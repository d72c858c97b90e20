"""A condition that changed nothing is no null result: it is in no comparison, and is named."""

import pytest
from reported import found_in

from lockprobe.studies.options.studyfile import study


def found(directory, *conditions, agents=("human-inspired",), p=(0,), **options):
    asked = {"trials": 12, "repetitions": 1, "condition": list(conditions)} | options
    return found_in(directory, study("flips", agent=list(agents), p=list(p), **asked))


def compared(results):
    """The agents and conditions whose success is compared with that of the control."""
    return {(row.agent, row.condition) for row in results.where("success_difference") if row.control}


def never(results):
    return {(row.agent, row.condition) for row in results.where("success", of="") if row.note == "never acted"}


@pytest.mark.parametrize("acts", ["history?last=50", "flip?p=1&at=20", "nudge?after=6", "hypothesis"])
def test_a_condition_that_changed_nothing_is_compared_with_nothing_and_named(tmp_path, acts):
    results = found(tmp_path, acts, "flip?p=0.4")
    (cell,) = (one for one in results.cells if one.condition == acts)
    assert never(results) == {("human-inspired", acts)}
    assert compared(results) == {("human-inspired", "flip?p=0.4")}
    assert cell.value("steps", "changed") == 0
    said = f"{acts} changed nothing (0 of {cell.value('steps'):g} steps), so nothing is concluded from it."
    assert said in " ".join(one.text for one in results.facts)


def test_where_no_condition_changed_anything_that_is_the_answer(tmp_path):
    acts = "history?last=50"
    results = found(tmp_path, acts, agents=("human-inspired", "round-robin"))
    steps = sum(cell.value("steps") for cell in results.cells if cell.condition == acts)
    said = f"{acts} changed nothing for any agent (0 of {steps:g} steps), so nothing is concluded from it."
    assert (results.answer, compared(results)) == (said, set())
