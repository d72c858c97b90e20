"""Behind each step of a person's trial stands one act of theirs, or the records are refused."""

import pytest
from builders import small_study
from stored import acts as entries
from stored import rewrite_acts
from taking_part import take_part

from lockprobe.foundation.errors import BadFile
from lockprobe.people.diary import read_diaries
from lockprobe.people.step_times import acts_of_steps, key_of
from lockprobe.studies.records.read_records import load

STUDY = small_study(["participant"], p=[0.0, 0.4], trials=2)
ANN, BOB = "aaaa01", "bbbb02"


@pytest.fixture
def directory(tmp_path):
    take_part(tmp_path, STUDY, ANN, [(0.4, 1, 1), (0.0, 1, 2)])
    take_part(tmp_path, STUDY, BOB, [(0.0, 1, 1), (0.4, 2, 1)], left_after=1)
    return tmp_path


def acts(directory):
    trials = {trial.key: trial for trial in load(directory)}
    return acts_of_steps(STUDY, trials, read_diaries(directory), directory)


def test_every_step_of_the_record_has_its_act_and_no_other_has(directory):
    found = acts(directory)
    assert set(found) == {(trial.key, step.step) for trial in load(directory) for step in trial.steps}
    for trial in load(directory):
        for step in trial.steps:
            act = found[trial.key, step.step]
            assert (act.act.joint, act.act.claimed, act.told) == (step.decision.joint, step.decision.claimed, step.told)


def test_boxes_are_trials_of_the_study_and_the_practice_is_none(directory):
    ann = read_diaries(directory)[0]
    assert key_of(STUDY, ann, 1) == "flips/participant/flip?p=0.4/rep=1/trial=1"
    assert [key_of(STUDY, ann, box) for box in (0, None, 3)] == ["", "", ""]


def test_a_trial_that_somebody_else_played_has_no_acts_of_this_person(directory, tmp_path):
    trials = {trial.key: trial for trial in load(directory)}
    only_bob = [kept for kept in read_diaries(directory) if kept.joined.identity == BOB]
    found = acts_of_steps(STUDY, trials, only_bob, directory)
    assert {key for key, _ in found} == {"flips/participant/truth/rep=1/trial=1"}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            lambda line: {**line, "act": {**line["act"], "joint": "C" if line["act"]["joint"] != "C" else "D"}},
            " on record",
        ),
        (lambda line: {**line, "act": {**line["act"], "claimed": "moved"}}, " on record"),
        (lambda line: {**line, "step": 40}, "is not in the diary"),
    ],
)
def test_a_diary_that_says_something_else_than_the_record_is_refused(directory, change, said):
    lines = entries(directory, ANN)
    first = next(i for i, line in enumerate(lines) if line.get("box") == 1)
    lines[first] = change(lines[first])
    rewrite_acts(directory, ANN, lines)
    with pytest.raises(BadFile, match=f"study.db: participant {ANN}: step .*{said}"):
        acts(directory)


@pytest.mark.parametrize("slot", [{"repetition": -1}, {"trial": 3}, {"condition": "flip?p=0.5"}])
def test_a_diary_of_another_study_is_refused(directory, slot):
    lines = entries(directory, BOB)
    lines[0]["slots"][1] |= slot
    rewrite_acts(directory, BOB, lines)
    with pytest.raises(BadFile, match="trials of another study"):
        acts(directory)
