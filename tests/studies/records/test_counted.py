"""What is counted in the store is what is loaded, rows say what their records do, and the hash is of all of them."""

from collections import Counter
from dataclasses import replace

import pytest
from builders import make_trial, small_study, write_study
from stored import sql, timings

from lockprobe import run_study, study
from lockprobe.foundation.errors import BadFile
from lockprobe.studies.records.read_records import (
    contradictions,
    in_order,
    load,
    results_hash,
    stored_records,
    tally,
)
from lockprobe.studies.records.store import read

STUDY = small_study(["random", "human-inspired", "participant"], p=[0.0, 0.3], trials=3)


def test_what_is_counted_in_the_store_is_what_is_loaded(tmp_path):
    """Of agents and people, also broken and replaced."""
    broken = {1: [None], 2: ["model", None], 3: ["reply"]}
    played = [
        make_trial([number % 4] * 20, agent=agent, p=p, trial=number, broken=why)
        for agent in ("random", "human-inspired", "participant:aaaa")
        for p in (0.0, 0.3)
        for number in broken
        for why in broken[number]
    ]
    played.append(make_trial([0], agent="participant:bbbb", p=0.3, trial=3, broken="plant"))
    write_study(tmp_path, STUDY, played)
    trials, told = load(tmp_path), Counter()
    with read(tmp_path) as store:
        for one in tally(store, STUDY):
            told[one.agent, one.player, one.ending, one.boundary, one.owed_again] += one.number
        assert sum(one.steps for one in tally(store, STUDY)) == sum(len(trial.steps) for trial in trials)
        assert list(in_order(trials)) == list(stored_records(store))
    assert told == Counter(
        (one.spec, one.player, one.ending, one.error.boundary if one.error else "", one.owed_again) for one in trials
    )


OTHER = {
    "agent": "'human-inspired'", "player": "'participant:aaaa'", "condition": "'flip?p=0.3'", "repetition": "2",
    "trial": "2", "fork": "'lie'", "ending": "'solved'", "owed": "1", "steps": "19", "boundary": "'model'",
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
    first = results_hash(planned(), in_order(one))
    assert len(first) == len(planned().settings_hash) == 32
    assert first == results_hash(planned(), in_order(other[::-1]))
    changed = [replace(one[0], changed_steps=9), *one[1:]]
    others = {results_hash(planned(), in_order(found)) for found in (one[1:], changed)}
    assert len(others | {first, results_hash(planned(seed=2), in_order(one))}) == 4
