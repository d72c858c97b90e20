"""Records say of which study they are, and whether they are what was written."""

import random
from dataclasses import replace

import pytest
from builders import make_trial, small_study, strip_checksums, write_study

from lockprobe.errors import BadFile, BadValue
from lockprobe.interventions.condition import flips
from lockprobe.lockbox.families import box
from lockprobe.studies.journal import left_out, load
from lockprobe.studies.records import read_records
from lockprobe.studies.runner import run_study
from lockprobe.studies.study import record_identity
from lockprobe.trial_json import trial_from_json, trial_from_line, trial_to_json, trial_to_line

STUDY = small_study(["random"], p=[0.0, 0.4], repetitions=1, trials=2)


def appended(directory, other):
    """The records of another study, at the end of those of the first, as ``cat`` does it."""
    with (directory / "trials.jsonl").open("ab") as file:
        file.write((other / "trials.jsonl").read_bytes())


@pytest.mark.parametrize("older", [False, True], ids=["with its identity", "older"])
@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"seed": 2}, "seed is 2, not 1"),
        ({"box": box("chain-3")}, "box is 'chain-3', not 'chain-4'"),
        ({"max_steps": 5}, "budget is 5, not 20"),
    ],
)
def test_records_of_another_study_hide_none_and_are_counted_and_named(tmp_path, change, why, older):
    ours = run_study(STUDY, tmp_path / "a")
    theirs = run_study(replace(STUDY, **change), tmp_path / "b")
    if older:
        strip_checksums(tmp_path / "a")
        strip_checksums(tmp_path / "b")
    appended(tmp_path / "a", tmp_path / "b")
    trials, left = read_records(tmp_path / "a")
    assert trials == ours
    assert (left.foreign, left.repeated, left.replaced) == (len(theirs), 0, 0)
    assert left.first_foreign == f"line 5, {theirs[0].key}: {why}"
    assert run_study(STUDY, tmp_path / "a") == ours


def test_what_no_value_of_a_record_says_its_identity_says(tmp_path):
    run_study(STUDY, tmp_path / "a")
    run_study(other := replace(STUDY, shuffle=False), tmp_path / "b")
    appended(tmp_path / "a", tmp_path / "b")
    assert left_out(tmp_path / "a").first_foreign.endswith(
        f"its study is {other.record_identity}, not {STUDY.record_identity}"
    )


def test_records_of_a_study_that_was_added_to_are_of_it():
    more = replace(STUDY, agents=("random", "round-robin"), conditions=flips((0.0, 0.1)), trials=9, repetitions=3)
    assert more.record_identity == STUDY.record_identity
    assert record_identity({**STUDY.settings(), "added": {"x": "today"}, "layout": "fixed"}) == STUDY.record_identity
    assert replace(STUDY, seed=2).record_identity != STUDY.record_identity


def test_older_lines_read_as_before(tmp_path):
    played = run_study(STUDY, tmp_path)
    before = strip_checksums(tmp_path).read_bytes()
    assert b"crc" not in before
    assert load(tmp_path) == played
    assert run_study(STUDY, tmp_path) == played
    assert (tmp_path / "trials.jsonl").read_bytes() == before


def test_a_line_reads_back_with_its_study():
    trial = make_trial([0, 1], budget=2)
    line = trial_to_line(trial, "0123456789ab")
    assert trial_from_line(line + b"\n") == (trial, "0123456789ab")
    assert trial_from_json(line) == trial_from_json(line.decode()) == trial
    assert trial_from_line(trial_to_json(trial)) == (trial, "")
    assert trial_to_json(trial)[:-1] == line[: line.index(b',"identity"')]


def test_a_line_that_was_changed_is_refused_and_named(tmp_path):
    write_study(tmp_path, STUDY, [make_trial([0, 1, 2]), make_trial([2, 1, 0], trial=2)])
    path = tmp_path / "trials.jsonl"
    path.write_bytes(path.read_bytes().replace(b'"moved":false', b'"moved":true', 1))
    with pytest.raises(BadFile, match=r"trials.jsonl: line 1: checksum: .* the line was changed; without"):
        load(tmp_path)


def test_no_single_bit_flips_unseen():
    trial = make_trial([0, 1, 2, 3, 0, 1], claims=[None, "moved"])
    line = trial_to_line(trial, STUDY.record_identity)
    rng, bits = random.Random(1), len(line) * 8
    for bit in (*range(bits - 8 * 60, bits), *rng.sample(range(bits), 400)):
        flipped = bytearray(line)
        flipped[bit // 8] ^= 1 << bit % 8
        if bytes(flipped).endswith(b"\n"):
            continue
        with pytest.raises(BadValue):
            trial_from_line(bytes(flipped))
