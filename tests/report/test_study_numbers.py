"""A study as its questions read it: each agent under each condition, each change from the control, and no pooling."""

from dataclasses import replace

import pytest
from builders import play_study, write_study
from reported import found_in

from lockprobe.report.opened import open_study
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.studies.options.studyfile import study

PLAYED = study(
    "flips",
    agent=["cognitive:perseverant", "random"],
    p=[0, 0.3],
    sweep="tremble?p=0.1,0.2",
    condition=["nudge"],
    trials=6,
    repetitions=2,
    strategy_trials=6,
)


@pytest.fixture(scope="module")
def trials():
    return play_study(PLAYED)


@pytest.fixture(scope="module")
def numbers(trials, tmp_path_factory):
    return StudyNumbers(opened=open_study(write_study(tmp_path_factory.mktemp("numbers") / "study", PLAYED, trials)))


@pytest.fixture(scope="module")
def found(trials, tmp_path_factory):
    return found_in(tmp_path_factory.mktemp("rows"), PLAYED, trials)


def solved(trials, agent, label):
    return [trial.solved for trial in trials if (trial.agent, trial.condition) == (agent, label)]


def test_every_agent_has_a_cell_and_a_share_under_every_condition(numbers, found, trials):
    labels = [one.label for one in PLAYED.conditions]
    assert [(cell.agent, cell.condition) for cell in numbers.cells] == [(a, c) for a in PLAYED.agents for c in labels]
    for cell in found.cells:
        own, share = solved(trials, cell.agent, cell.condition), cell.get("success")
        assert (share.n, share.count) == (len(own), sum(own)) == (12, sum(own))


def test_every_condition_is_compared_with_the_control_in_its_own_family(found, trials):
    rows = found.where("success_difference", of="", versus="")
    families = {}
    for row in rows:
        families.setdefault((row.agent, row.axis), []).append(row.condition)
        change = sum(solved(trials, row.agent, row.condition)) - sum(solved(trials, row.agent, "truth"))
        assert (row.control, row.value) == ("truth", pytest.approx(change / 12))
    assert families == {  # a random agent hears no report
        ("cognitive:perseverant", "flip rate"): ["flip?p=0.3"],
        ("cognitive:perseverant", "tremble p"): ["tremble?p=0.1", "tremble?p=0.2"],
        ("random", "tremble p"): ["tremble?p=0.1", "tremble?p=0.2"],
        ("cognitive:perseverant", ""): ["nudge"],
        ("random", ""): ["nudge"],
    }


def test_an_axis_takes_its_zero_from_the_control_and_pools_no_other_condition(numbers):
    (axis,) = numbers.axes
    assert axis.series.doses == {"truth": 0.0, "tremble?p=0.1": 0.1, "tremble?p=0.2": 0.2}
    assert {len(trials) for course in axis.courses for trials in course.by_dose.values()} == {12}


def test_an_agent_without_trials_has_no_numbers(trials, tmp_path):
    own = [trial for trial in trials if trial.agent == "random"]
    found = found_in(tmp_path, PLAYED, own)
    assert (
        {cell.agent for cell in found.cells} == {row.agent for row in found.where("success_difference")} == {"random"}
    )


def test_agents_under_study_are_one_family_and_baselines_another(tmp_path):
    agents = ("cognitive:careful", "cognitive:insistent", "human-inspired")
    asked = study("flips", agent=list(agents), condition=["flip?p=0.5", "tremble?p=0.3"], trials=4, repetitions=1)
    found = found_in(tmp_path, replace(asked, agents=agents))
    for axis in ("flip rate", ""):
        many = {row.agent: row.corrected_for for row in found.where("success_difference", axis=axis, of="", versus="")}
        assert many == dict(zip(agents, (2, 2, 1), strict=True))
