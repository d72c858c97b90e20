"""The hash of settings changes with every setting, that of results with every record; neither with the clock."""

from dataclasses import replace

import pytest
from stored import timings

from lockprobe import run_study, study
from lockprobe.foundation.errors import BadValue
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import load
from lockprobe.studies.records.results_hash import StudyHashes, check_hash, results_hash

FREE = ["random", "cognitive:careful", "human-inspired"]


def planned(**more):
    return study("flips", **({"agent": FREE, "p": [0, 0.4], "trials": 2, "repetitions": 1, "max_steps": 6} | more))


def test_the_same_study_twice_has_the_same_hashes(tmp_path):
    for name in ("one", "other"):
        run_study(planned(), tmp_path / name)
    first, second = (StudyHashes.of(tmp_path / name) for name in ("one", "other"))
    assert first == second
    assert (len(first.settings), len(first.results)) == (32, 32)
    assert (first.finished, first.planned) == (12, 12)
    took = [timings(tmp_path / name) for name in ("one", "other")]
    assert took[0] != took[1]


def test_the_order_of_records_does_not_matter_and_every_record_does(tmp_path):
    run_study(planned(), tmp_path)
    trials = load(tmp_path)
    whole = results_hash(planned(), trials)
    assert results_hash(planned(), trials[::-1]) == whole
    changed = [replace(trials[0], replays=1), *trials[1:]]
    others = {results_hash(planned(), one) for one in (trials[1:], changed)} | {results_hash(planned(seed=2), trials)}
    assert len(others | {whole}) == 4


@pytest.mark.parametrize(
    "more",
    [
        {},
        {"p": [0.0, 1]},
        {"condition": ["flip?p=0.4", "nudge?after=2"], "p": None},
        {"box": "fork", "layout": "shuffled", "strategy_trials": 3, "assessment": False},
        {"agent": ["viewer"], "modality": ["rgb"], "plant": "fast-twin"},
    ],
)
def test_the_hash_of_settings_is_the_same_before_and_after_they_are_on_disk(tmp_path, more):
    given = {name: value for name, value in ({"p": [0, 0.4]} | more).items() if value is not None}
    one = study("flips", **({"agent": ["random"], "trials": 1, "repetitions": 1} | given))
    from lockprobe.studies.records.directory import write_settings

    write_settings(tmp_path, one)
    assert read_study(tmp_path).settings_hash == one.settings_hash
    assert one.settings_hash.startswith(one.identity)


@pytest.mark.parametrize("given", ["", "abc", "g" * 32, "0" * 31, "0" * 64])
def test_what_is_no_hash_is_refused(given):
    check_hash("settings", None)
    check_hash("settings", f" {'0aF' * 10}00 ")
    with pytest.raises(BadValue, match="expected the 32 hexadecimal digits that lockprobe run and status print"):
        check_hash("settings", given)
