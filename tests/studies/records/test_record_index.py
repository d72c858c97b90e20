"""Counting records says what loading them says, and rows say what their records do."""

import tempfile
from dataclasses import replace
from pathlib import Path

import pytest
from builders import make_trial, small_study, write_study
from hypothesis import given
from hypothesis import strategies as st
from stored import sql

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadFile
from lockprobe.studies.records.read_records import read_records
from lockprobe.studies.records.record_index import RecordIndex
from lockprobe.studies.records.results_hash import StudyHashes, records_digest, results_hash
from lockprobe.studies.records.store import read, written
from lockprobe.studies.records.trial_rows import INSERT, Timing, contradictions, row_of
from lockprobe.studies.running.runner import run_study
from lockprobe.trial.model_call import Usage
from lockprobe.trial.trial_name import ForkName

STUDY = replace(small_study(["random", "human-inspired", "participant"], p=[0.0, 0.3], trials=3), strategy_trials=2)
CONDITIONS = {one.p: one for one in STUDY.conditions}


def same_as_loaded(directory, study=STUDY):
    """The index of a directory is held against the loaded trials; returns how many entries it counts together."""
    trials, left = read_records(directory)
    own = study.own_trials(trials)
    with read(directory) as store:
        index = RecordIndex(store, study)
        assert index.left_out == left
        for counted, loaded in ((index.counted(), own), (index.counted(own=False), trials)):
            assert sum(one.number for one in counted) == len(loaded)
            assert sum(one.steps for one in counted) == sum(len(trial.steps) for trial in loaded)
            for say in (
                lambda one: one.solved,
                lambda one: one.owed_again,
                lambda one: one.changed_steps,
                lambda one: one.group == "participant",
                lambda one: sum((step.decision.usage or Usage()).input_tokens for step in one.steps if one.facts),
            ):
                assert sum(one.number * say(one.trial) for one in counted) == sum(map(say, loaded))
        assert index.digest() == records_digest(own)
        assert all(index.owes(trial.key) == trial.owed_again for trial in trials)
        assert index.owes("no such trial")
    hashes = StudyHashes.of(directory)
    assert (hashes.results, hashes.finished) == (results_hash(study, own), sum(not one.owed_again for one in own))
    return len(index.counted())


def paid(trial):
    spent = replace(trial.steps[0].decision, usage=Usage(input_tokens=7, calls=1), replies=("a",))
    return replace(trial, facts={"model": "x"}, steps=(replace(trial.steps[0], decision=spent), *trial.steps[1:]))


def forked(trial):
    name = ForkName(parent=trial.key, at=1, arm="lie", time=1)
    return replace(trial, fork=name, key=str(name))


MANNERS = {
    "played": lambda trial: trial,
    "said": lambda trial: replace(trial, facts={"said": "one\u2028two"}),
    "paid": paid,
    "forked": forked,
    "of another seed": lambda trial: replace(trial, seed=2),
}
RECORDS = st.tuples(
    st.sampled_from(["random", "human-inspired", "participant:aaaa", "participant:bbbb", "round-robin"]),
    st.sampled_from([0.0, 0.3]),
    st.integers(1, 3),
    st.integers(1, 4),
    st.sampled_from(["model", "reply", None, None]),
    st.sampled_from([*MANNERS]),
    st.booleans(),
)


@given(st.lists(RECORDS, max_size=25))
def test_a_study_of_all_kinds_of_records_is_counted_as_it_is_loaded(mixed):
    """Of agents and people, also broken, replaced, forked, foreign and beyond the size."""
    with tempfile.TemporaryDirectory() as name:
        directory = write_study(Path(name), STUDY, [])
        with written(directory) as store, store.transaction() as writing:
            for agent, p, repetition, number, broken, manner, foreign in mixed:
                joints = [0] if broken else [number % 4] * 20
                trial = make_trial(joints, agent=agent, p=p, repetition=repetition, trial=number, broken=broken)
                trial = MANNERS[manner](trial)
                of = STUDY if not foreign and trial.seed == STUDY.seed else replace(STUDY, seed=2)
                identity = of.record_identity(CONDITIONS[p])
                writing.execute("update trial set current = 0 where current and key = ?", (trial.key,))
                writing.execute(INSERT, row_of(trial, Timing(key=trial.key, seconds=1, steps=1), identity))
        same_as_loaded(directory)


@pytest.mark.parametrize("layout", ["fixed", "shuffled"])
def test_records_of_strategies_are_counted_together(tmp_path, layout):
    planned = replace(small_study(p=[0.0], trials=60), boxes=(box("random-5-17"),), layout=layout)
    run_study(planned, tmp_path)
    assert same_as_loaded(tmp_path, planned) < planned.size / 2
    with read(tmp_path) as store:
        assert list(contradictions(store)) == []


OTHER = {
    "agent": "'human-inspired'",
    "player": "'participant:aaaa'",
    "condition": "'flip?p=0.3'",
    "repetition": "2",
    "trial": "2",
    "fork": "'lie'",
    "ending": "'solved'",
    "owed": "1",
    "steps": "19",
    "alike": "null",
}


@pytest.mark.parametrize("column", OTHER)
def test_a_row_that_says_something_else_than_its_record_is_found(tmp_path, column):
    write_study(tmp_path, STUDY, [make_trial([0] * 20), make_trial([0] * 20, trial=2)])
    sql(tmp_path, f"update trial set {column} = {OTHER[column]} where id = 1")
    with read(tmp_path) as store:
        assert list(contradictions(store)) == [
            f"flips/random/truth/rep=1/trial=1: its {column} are not those of its record"
        ]


def test_records_that_stand_for_other_trials_or_in_place_of_others_are_found(tmp_path):
    write_study(tmp_path, STUDY, [make_trial([0], broken="model"), make_trial([0] * 20), make_trial([1] * 20)])
    with read(tmp_path) as store:
        assert list(contradictions(store)) == ["flips/random/truth/rep=1/trial=1: a second record of a finished trial"]
    sql(tmp_path, "delete from trial where id = 3")
    with read(tmp_path) as store:
        assert list(contradictions(store)) == ["flips/random/truth/rep=1/trial=1: its last record does not count"]
    sql(tmp_path, "update trial set key = 'another' where id = 2")
    with read(tmp_path) as store, pytest.raises(BadFile, match="another: its record is damaged"):
        list(contradictions(store))
