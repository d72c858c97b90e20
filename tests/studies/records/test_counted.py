"""Counting records says what loading them says, rows say what their records do, and the hash is of all of them."""

import tempfile
from dataclasses import replace
from pathlib import Path

import pytest
from builders import make_trial, small_study, write_study
from hypothesis import given
from hypothesis import strategies as st
from stored import sql, timings

from lockprobe import run_study, study
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.studies.records.read_records import count_records, load
from lockprobe.studies.records.results_hash import check_hash, results_hash, stored_hash
from lockprobe.studies.records.store import played_in, read, written
from lockprobe.studies.records.trial_rows import INSERT, Timing, contradictions, row_of
from lockprobe.trial.model_call import Usage

STUDY = replace(small_study(["random", "human-inspired", "participant"], p=[0.0, 0.3], trials=3), strategy_trials=3)
CONDITIONS = {one.p: one for one in STUDY.conditions}


def same_as_loaded(directory, planned=STUDY):
    """The counts of a directory are held against the loaded trials; returns how many entries are counted together."""
    trials = load(directory)
    with read(directory) as store:
        found = count_records(store, planned)
        assert stored_hash(store, planned) == results_hash(planned, trials)
        assert played_in(store)[0] == sum(sql(directory, "select steps from trial"))
    assert sum(one.number for one in found) == len(trials)
    assert sum(one.steps for one in found) == sum(len(trial.steps) for trial in trials)
    for say in (
        lambda one: one.solved,
        lambda one: one.owed_again,
        lambda one: one.changed_steps,
        lambda one: one.group == "participant",
        lambda one: sum((step.decision.usage or Usage()).input_tokens for step in one.steps if one.facts),
    ):
        assert sum(one.number * say(one.trial) for one in found) == sum(map(say, trials))
    return len(found)


def paid(trial):
    spent = replace(trial.steps[0].decision, usage=Usage(input_tokens=7, calls=1), replies=("a",))
    return replace(trial, facts={"model": "x"}, steps=(replace(trial.steps[0], decision=spent), *trial.steps[1:]))


MANNERS = {
    "played": lambda trial: trial,
    "said": lambda trial: replace(trial, facts={"said": "one\u2028two"}),
    "paid": paid,
}
RECORDS = st.tuples(
    st.sampled_from(["random", "human-inspired", "participant:aaaa", "participant:bbbb"]),
    st.sampled_from([0.0, 0.3]),
    st.integers(1, 3),
    st.integers(1, 3),
    st.sampled_from(["model", "reply", None, None]),
    st.sampled_from([*MANNERS]),
)


@given(st.lists(RECORDS, max_size=25))
def test_a_study_of_all_kinds_of_records_is_counted_as_it_is_loaded(mixed):
    """Of agents and people, also broken and replaced."""
    with tempfile.TemporaryDirectory() as name:
        directory = write_study(Path(name), replace(STUDY, repetitions=3), [])
        with written(directory) as store, store.transaction() as writing:
            for agent, p, repetition, number, broken, manner in mixed:
                joints = [0] if broken else [number % 4] * 20
                trial = make_trial(joints, agent=agent, p=p, repetition=repetition, trial=number, broken=broken)
                trial = MANNERS[manner](trial)
                identity = STUDY.record_identity(CONDITIONS[p])
                timing = Timing(key=trial.key, seconds=1, steps=1)
                writing.execute("update trial set current = 0 where current and key = ?", (trial.key,))
                writing.execute(INSERT, row_of(trial, timing, identity))
        same_as_loaded(directory, replace(STUDY, repetitions=3))


@pytest.mark.parametrize("layout", ["fixed", "shuffled"])
def test_records_of_strategies_are_counted_together(tmp_path, layout):
    planned = replace(small_study(p=[0.0], trials=60), boxes=(box("random-5-17"),), layout=layout)
    run_study(planned, tmp_path)
    assert same_as_loaded(tmp_path, planned) < planned.size / 2
    with read(tmp_path) as store:
        assert list(contradictions(store)) == []


OTHER = {
    "agent": "'human-inspired'", "player": "'participant:aaaa'", "condition": "'flip?p=0.3'", "repetition": "2",
    "trial": "2", "fork": "'lie'", "ending": "'solved'", "owed": "1", "steps": "19", "alike": "null",
}  # fmt: skip


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


def planned(**more):
    asked = {"agent": ["random", "human-inspired"], "p": [0, 0.4], "trials": 2, "repetitions": 1, "max_steps": 6}
    return study("flips", **(asked | more))


def test_the_same_study_twice_has_the_same_hashes_and_every_record_counts(tmp_path):
    one, other = (run_study(planned(), tmp_path / name) for name in ("one", "other"))
    assert timings(tmp_path / "one") != timings(tmp_path / "other")
    first = results_hash(planned(), one)
    assert len(first) == len(planned().settings_hash) == 32
    assert first == results_hash(planned(), other[::-1])
    changed = [replace(one[0], replays=1), *one[1:]]
    others = {results_hash(planned(), found) for found in (one[1:], changed)} | {results_hash(planned(seed=2), one)}
    assert len(others | {first}) == 4


@pytest.mark.parametrize("given", ["", "abc", "g" * 32, "0" * 31, "0" * 64])
def test_what_is_no_hash_is_refused(given):
    check_hash("settings", None)
    check_hash("settings", f" {'0aF' * 10}00 ")
    with pytest.raises(BadValue, match="expected the 32 hexadecimal digits that lockprobe run prints"):
        check_hash("settings", given)
