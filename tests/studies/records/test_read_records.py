"""Records say of which study they are, and whether they are what was written."""

import random
import re
from dataclasses import replace

import pytest
from builders import make_trial, small_study, write_study

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.foundation.storage.jsonl import with_checksum
from lockprobe.interventions.conditions import flips, read_condition
from lockprobe.studies.records.read_records import left_out, load, read_records
from lockprobe.studies.running.runner import run_study
from lockprobe.trial.trial_json import trial_from_json, trial_from_line, trial_to_json, trial_to_line

STUDY = small_study(["random"], p=[0.0, 0.4], repetitions=1, trials=2)


def appended(directory, other):
    """The records of another study, at the end of those of the first, as ``cat`` does it."""
    with (directory / "trials.jsonl").open("ab") as file:
        file.write((other / "trials.jsonl").read_bytes())


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"seed": 2}, "seed is 2, not 1"),
        ({"box": box("chain-3")}, "box is 'chain-3', not 'chain-4'"),
        ({"max_steps": 5}, "budget is 5, not 20"),
    ],
)
def test_records_of_another_study_hide_none_and_are_counted_and_named(tmp_path, change, why):
    ours = run_study(STUDY, tmp_path / "a")
    theirs = run_study(replace(STUDY, **change), tmp_path / "b")
    appended(tmp_path / "a", tmp_path / "b")
    trials, left = read_records(tmp_path / "a")
    assert trials == ours
    assert (left.foreign, left.repeated, left.replaced) == (len(theirs), 0, 0)
    assert left.first_foreign == f"line 5, {theirs[0].key}: {why}"
    assert run_study(STUDY, tmp_path / "a") == ours


def test_what_no_value_of_a_record_says_its_identity_says(tmp_path):
    run_study(STUDY, tmp_path / "a")
    run_study(other := replace(STUDY, shuffle="never"), tmp_path / "b")
    appended(tmp_path / "a", tmp_path / "b")
    truth = STUDY.conditions[0]
    assert left_out(tmp_path / "a").first_foreign.endswith(
        f"truth did something else there: it is {other.record_identity(truth)}, not {STUDY.record_identity(truth)}"
    )


def named(label, spec, **settings):
    return replace(STUDY, conditions=(read_condition("truth"), read_condition(spec, label)), **settings)


def test_conditions_of_one_name_that_do_other_things_are_never_pooled(tmp_path):
    """Two studies call two flip rates ``x``: a record of the one is none of the other."""
    ours = run_study(named("x", "flip?p=0.1"), tmp_path / "a")
    theirs = run_study(named("x", "flip?p=0.9"), tmp_path / "b")
    assert {trial.key for trial in ours} == {trial.key for trial in theirs}
    appended(tmp_path / "a", tmp_path / "b")
    trials, left = read_records(tmp_path / "a")
    assert sorted(trials, key=lambda one: one.key) == sorted(ours, key=lambda one: one.key)
    assert (left.foreign, left.repeated) == (2, 2)  # the truth is the same trial in both
    assert "flips/random/x/rep=1/trial=1: x did something else there" in left.first_foreign


def test_a_condition_under_another_name_is_said_to_be_one(tmp_path):
    run_study(named("x", "flip?p=0.1"), tmp_path / "a")
    run_study(named("y", "flip?p=0.1"), tmp_path / "b")
    appended(tmp_path / "a", tmp_path / "b")
    assert left_out(tmp_path / "a").first_foreign.endswith("its condition y is called x here")


def test_a_condition_that_a_study_does_not_have_is_none_of_it(tmp_path):
    run_study(STUDY, tmp_path / "a")
    run_study(named("z", "flip?p=0.7"), tmp_path / "b")
    appended(tmp_path / "a", tmp_path / "b")
    assert left_out(tmp_path / "a").first_foreign.endswith("its condition is z, which this study does not have")


def test_records_of_a_study_that_was_added_to_are_of_it():
    more = replace(STUDY, agents=("random", "round-robin"), conditions=flips((0.0, 0.1)), trials=9, repetitions=3)
    (truth, flip), (_, other) = STUDY.conditions, more.conditions
    assert more.record_identity(truth) == STUDY.record_identity(truth)
    assert more.record_identity(other) != STUDY.record_identity(flip)
    assert replace(STUDY, seed=2).record_identity(truth) != STUDY.record_identity(truth)


def test_a_line_without_a_checksum_is_refused_and_named(tmp_path):
    run_study(STUDY, tmp_path)
    path = tmp_path / "trials.jsonl"
    path.write_bytes(re.sub(rb',"crc":"[0-9a-f]{8}"', b"", path.read_bytes(), count=1))
    with pytest.raises(BadFile, match="line 1: checksum: got 'none'"):
        load(tmp_path)


def test_a_line_reads_back_with_its_study():
    trial = make_trial([0, 1], budget=2)
    line = trial_to_line(trial, "0123456789ab")
    assert trial_from_line(line + b"\n") == (trial, "0123456789ab")
    assert trial_from_json(trial_to_json(trial)) == trial_from_json(trial_to_json(trial).decode()) == trial
    with pytest.raises(BadValue, match="identity"):
        trial_from_line(with_checksum(trial_to_json(trial)))
    assert trial_to_json(trial)[:-1] == line[: line.index(b',"identity"')]


def test_a_line_that_was_changed_is_refused_and_named(tmp_path):
    write_study(tmp_path, STUDY, [make_trial([0, 1, 2]), make_trial([2, 1, 0], trial=2)])
    path = tmp_path / "trials.jsonl"
    path.write_bytes(path.read_bytes().replace(b'"moved":false', b'"moved":true', 1))
    with pytest.raises(BadFile, match=r"trials.jsonl: line 1: checksum: .* the line was changed; without"):
        load(tmp_path)


def test_no_single_bit_flips_unseen():
    trial = make_trial([0, 1, 2, 3, 0, 1], claims=[None, "moved"])
    line = trial_to_line(trial, STUDY.record_identity(STUDY.conditions[0]))
    rng, bits = random.Random(1), len(line) * 8
    for bit in (*range(bits - 8 * 60, bits), *rng.sample(range(bits), 400)):
        flipped = bytearray(line)
        flipped[bit // 8] ^= 1 << bit % 8
        if bytes(flipped).endswith(b"\n"):
            continue
        with pytest.raises(BadValue):
            trial_from_line(bytes(flipped))
