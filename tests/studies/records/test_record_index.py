"""Counting records says what loading them says."""

import zlib
from dataclasses import replace

import pytest
from builders import make_trial, small_study, write_study

from lockprobe.boxes.families import box
from lockprobe.foundation.storage.jsonl import checked_length, whole_lines
from lockprobe.studies.records.read_records import load, read_records
from lockprobe.studies.records.record_index import RecordIndex
from lockprobe.studies.records.results_hash import records_digest
from lockprobe.studies.running.runner import run_study
from lockprobe.trial.model_call import Usage
from lockprobe.trial.trial_json import trial_to_line

STUDY = small_study()


def appended(directory, *trials, study=STUDY):
    conditions = {one.label: one for one in study.conditions}
    with (directory / "trials.jsonl").open("ab") as file:
        for trial in trials:
            file.write(trial_to_line(trial, study.record_identity(conditions[trial.condition])) + b"\n")


def same_as_loaded(directory, study=STUDY):
    """The index of a directory, which is held against the loaded trials."""
    index, (trials, left) = RecordIndex(directory, study), read_records(directory)
    own = study.own_trials(trials)
    assert index.left_out == left
    assert len(index) == len(trials)
    for counted, loaded in ((index.counted(), own), (index.counted(own=False), trials)):
        of = {"steps": lambda one: 1, "solved": lambda one: one.solved, "owed": lambda one: one.owed_again}
        assert sum(one.number for one in counted) == len(loaded)
        assert sum(one.steps for one in counted) == sum(len(trial.steps) for trial in loaded)
        for say in of.values():
            assert sum(one.number * say(one.trial) for one in counted) == sum(map(say, loaded))
        assert sum(one.number * one.trial.changed_steps for one in counted) == sum(one.changed_steps for one in loaded)
    assert index.digest() == records_digest(own)
    assert all(index.owes(trial.key) == trial.owed_again for trial in trials)
    assert index.owes("no such trial")
    return index


def test_records_of_strategies_are_counted_together(tmp_path):
    run_study(planned := small_study(p=[0.0], trials=60), tmp_path)
    index = same_as_loaded(tmp_path, planned)
    assert len(index.counted()) < len(index) / 2


def test_shuffled_panels_and_records_of_another_study(tmp_path):
    planned = replace(STUDY, box=box("random-5-17"), layout="shuffled")
    run_study(planned, tmp_path)
    same_as_loaded(tmp_path, planned)
    run_study(other := replace(planned, seed=2), tmp_path / "other")
    with (tmp_path / "trials.jsonl").open("ab") as file:
        file.write((tmp_path / "other" / "trials.jsonl").read_bytes())
    assert same_as_loaded(tmp_path, planned).left_out.foreign == other.size


def test_trials_that_broke_were_played_again_or_stand_twice(tmp_path):
    write_study(
        tmp_path, STUDY, [make_trial([0], trial=1, broken="model"), make_trial([0, 1], trial=2, broken="reply")]
    )
    same_as_loaded(tmp_path)
    appended(tmp_path, make_trial([0, 1] * 10, trial=1))
    assert same_as_loaded(tmp_path).left_out.replaced == 1
    appended(tmp_path, *[make_trial([1] * 20, trial=number) for number in (3, 4, 3)])
    assert same_as_loaded(tmp_path).left_out.contradicted == 0
    appended(tmp_path, make_trial([2] * 20, trial=3))
    assert (same_as_loaded(tmp_path).left_out.repeated, same_as_loaded(tmp_path).left_out.contradicted) == (2, 1)


def test_usage_and_records_beyond_the_plan(tmp_path):
    asked = make_trial([0] * 20, trial=1)
    spent = replace(asked.steps[0].decision, usage=Usage(input_tokens=7, calls=1), replies=("a",))
    paid = replace(asked, steps=(replace(asked.steps[0], decision=spent), *asked.steps[1:]))
    write_study(tmp_path, STUDY, [paid, make_trial([0] * 20, trial=2), make_trial([0] * 20, trial=3)])
    appended(tmp_path, *[make_trial([1] * 20, trial=number) for number in (4, 5, 6)])
    appended(tmp_path, make_trial([1] * 20, agent="round-robin"))
    index = same_as_loaded(tmp_path)
    assert sum(one.number for one in index.counted()) == 4
    used = [step.decision.usage for one in index.counted() for step in one.trial.steps]
    assert Usage(input_tokens=7, calls=1) in used
    assert len(load(tmp_path)) == 7


@pytest.mark.parametrize("older", [False, True])
def test_texts_with_other_ends_of_lines_have_the_digest_of_what_they_say(tmp_path, older):
    """They are escaped in lines that are written now, and stand as they are in older ones."""
    trials = [make_trial([1] * 20, hypothesis="one\u2028two", trial=number) for number in (1, 2, 3)]
    write_study(tmp_path, study := small_study(p=[0.0], trials=3), trials)
    path = tmp_path / "trials.jsonl"
    assert b"one\\u2028two" in path.read_bytes()
    if older:
        raw = [line[: checked_length(line)].replace(b"\\u2028", "\u2028".encode()) for _, line in whole_lines(path)]
        path.write_bytes(b"".join(b'%s,"crc":"%08x"}\n' % (line, zlib.crc32(line)) for line in raw))
    assert load(tmp_path) == trials
    same_as_loaded(tmp_path, study)
