"""Records say of which study they are, are what was written, and the hash is of all of them; rows say what records do."""

import json
import zlib
from collections import Counter
from dataclasses import replace
from functools import partial

import pytest
from builders import make_trial, small_study, write_study
from stored import sql

from lockprobe import run_study, study
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.foundation.storage.database import Damaged
from lockprobe.interventions.conditions import read_condition
from lockprobe.studies.records import store
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import (
    load,
    miscounted,
    on_record,
    played,
    results_hash,
    rows_and_records,
    stored_records,
    tally,
)
from lockprobe.studies.records.store import keep_picture, read
from lockprobe.studies.running.runner import run
from lockprobe.studies.study import Shard, settings_of
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.record import Decision
from lockprobe.trial.trial_json import trial_to_json

STUDY = small_study(["random"], p=[0.0, 0.4], repetitions=1, trials=2)


def in_order(trials):
    return map(trial_to_json, sorted(trials, key=lambda trial: trial.key))


def named(label, spec):
    return {"conditions": (read_condition("truth"), read_condition(spec, label))}


@pytest.mark.parametrize(
    ("ours", "theirs"),
    [
        ({}, {"seed": 2}),
        ({}, {"boxes": (box("chain-3"),)}),
        ({}, {"max_steps": 5}),
        ({}, {"shuffle": "never"}),
        ({}, {"trials": 3}),
        ({"agents": ("round-robin",)}, {}),
        ({"names": {"random": "blind"}}, {}),
        (named("x", "flip?p=0.1"), named("x", "flip?p=0.9")),
        (named("x", "flip?p=0.1"), named("y", "flip?p=0.1")),
        ({}, named("z", "flip?p=0.7")),
    ],
)
def test_records_of_other_settings_are_refused_wherever_they_are_read(tmp_path, ours, theirs):
    """Somebody has changed ``study.json`` by hand: what the settings do not say, the identity of a record says."""
    here, there = replace(STUDY, **ours), replace(STUDY, **theirs)
    run_study(there, tmp_path)
    before = (tmp_path / "study.json").read_bytes()
    (tmp_path / "study.json").write_text(json.dumps(settings_of(here)))

    def counted():
        with read(tmp_path) as opened:
            on_record(opened, here)

    for use in (partial(load, tmp_path), counted, partial(run_study, here, tmp_path)):
        with pytest.raises(BadFile, match="which is no trial of the study in study.json: put back the one"):
            use()
    (tmp_path / "study.json").write_bytes(before)
    assert len(run_study(there, tmp_path)) == there.size


@pytest.mark.parametrize(
    ("damage", "why"),
    [
        (lambda record: b"", "it does not end"),
        (lambda record: b"rubbish", "incorrect header check"),
        (lambda record: record[:-1], "it does not end"),
        (lambda record: record[:-4] + b"\0\0\0\0", "incorrect data check"),
        (lambda record: zlib.compress(b" " * 1_000_000), "it does not end"),
        (lambda record: zlib.compress(b"\xff"), "trial record"),
        (lambda record: zlib.compress(b'{"key":' + b"[" * 9000 + b"}"), "trial record"),
        (lambda record: zlib.compress(zlib.decompress(record).replace(b"trial", b"trail")), "trial record"),
        (lambda record: zlib.compress(zlib.decompress(record).replace(b"trial=1", b"trial=2")), "trial record, key"),
        (
            lambda record: zlib.compress(
                zlib.decompress(record).replace(b"trial=1", b"trial=2").replace(b'"trial":1', b'"trial":2')
            ),
            "it is of flips/random/truth/rep=1/trial=2",
        ),
    ],
)
def test_a_record_that_is_none_is_named_with_its_trial_and_nothing_is_overwritten(tmp_path, monkeypatch, damage, why):
    monkeypatch.setattr(store, "LARGEST_INPUT", 100_000)
    write_study(tmp_path, STUDY, [make_trial([0, 1, 2] * 6 + [0, 1])])
    (record,) = sql(tmp_path, "select record from trial")
    sql(tmp_path, "update trial set record = ?", damage(record))
    before = sql(tmp_path, "select * from trial")
    said = f"flips/random/truth/rep=1/trial=1: its record is damaged .*{why}.*`lockprobe import NEW"
    with pytest.raises(Damaged, match=said) as named:
        load(tmp_path)
    assert "\n" not in str(named.value)
    assert len(str(named.value)) < 1000
    with Journal.open(tmp_path, STUDY) as journal, pytest.raises(Damaged, match=said):
        run(STUDY, journal)
    assert sql(tmp_path, "select * from trial") == before


@pytest.mark.parametrize(
    "text", ["", "3", "0/3", "4/3", "3/", "-1/3", "1/3/5", "1/100001", "x/y", " 1/3", "9" * 30 + "/9"]
)
def test_what_is_no_part_is_refused_in_a_line(text):
    with pytest.raises(BadValue) as refused:
        Shard.parse(text)
    assert "\n" not in str(refused.value)


ONE, TWO = Picture(kind="rgb", png=b"one"), Picture(kind="depth16", png=b"two", shown=False)


def test_every_picture_is_kept_under_its_name(tmp_path):
    """One that a killed process left half written is written anew; one that is there is left alone."""
    (tmp_path / "pictures").mkdir()
    (tmp_path / "pictures" / TWO.name).write_bytes(b"t")
    for picture in (ONE, TWO):
        keep_picture(tmp_path / "pictures", picture)
    before = [path.stat().st_mtime_ns for path in (tmp_path / "pictures").iterdir()]
    keep_picture(tmp_path / "pictures", ONE)
    assert [path.stat().st_mtime_ns for path in (tmp_path / "pictures").iterdir()] == before
    kept = {path.name: path.read_bytes() for path in (tmp_path / "pictures").iterdir()}
    assert kept == {ONE.name: b"one", TWO.name: b"two"}


SEVERAL = small_study(["random", "human-inspired", "participant"], p=[0.0, 0.3], trials=3)


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
    write_study(tmp_path, SEVERAL, played)
    trials, told = load(tmp_path), Counter()
    with read(tmp_path) as store:
        for one in tally(store, SEVERAL):
            told[one.agent, one.player, one.ending, one.boundary, one.owed_again] += one.number
        assert sum(one.steps for one in tally(store, SEVERAL)) == sum(len(trial.steps) for trial in trials)
        assert list(in_order(trials)) == list(stored_records(store))
    assert told == Counter(
        (one.spec, one.player, one.ending, one.error.boundary if one.error else "", one.owed_again) for one in trials
    )


OTHER = {
    "agent": "'human-inspired'", "player": "'participant:aaaa'", "condition": "'flip?p=0.3'", "repetition": "2",
    "trial": "2", "fork": "'lie'", "ending": "'solved'", "owed": "1", "steps": "19", "boundary": "'model'",
    "kind": "7", "shorthand": "'0000 0 A00-0000'", "crc": "7",
}  # fmt: skip


@pytest.mark.parametrize("column", OTHER)
def test_a_row_that_says_something_else_than_its_record_is_found(tmp_path, column):
    write_study(tmp_path, SEVERAL, [make_trial([0] * 20), make_trial([0] * 20, trial=2)])
    sql(tmp_path, f"update trial set {column} = {OTHER[column]} where id = 1")
    with read(tmp_path) as store:
        assert [said for *_, said in rows_and_records(store)] == [
            f"flips/random/truth/rep=1/trial=1: its {column} are not those of its record", ""
        ]  # fmt: skip


def test_the_last_record_of_a_trial_counts_and_no_earlier_one_is_finished(tmp_path):
    write_study(tmp_path, SEVERAL, [make_trial([0], broken="model"), make_trial([0] * 20)])
    with read(tmp_path) as store:
        assert (list(miscounted(store)), [counts for _, counts, _ in rows_and_records(store)]) == ([], [False, True])
    write_study(tmp_path / "twice", SEVERAL, [make_trial([0] * 20), make_trial([1] * 20)])
    sql(tmp_path, "delete from trial where id = 2")
    for directory in (tmp_path / "twice", tmp_path):
        with read(directory) as store:
            said = "flips/random/truth/rep=1/trial=1: its last record does not count, or an earlier one is finished"
            assert list(miscounted(store)) == [said]
    sql(tmp_path, "update trial set key = 'another' where id = 1")
    with read(tmp_path) as store, pytest.raises(BadFile, match="another: its record is damaged"):
        list(rows_and_records(store))


WORDLESS = {"listing": (), "opening": ""}


def without_words(trial):
    steps = [
        replace(one, told="", remark="", decision=Decision(joint="", claimed=one.decision.claimed))
        for one in trial.steps
    ]
    return replace(trial, steps=tuple(steps), **WORDLESS)


@pytest.mark.parametrize(
    "more",
    [
        {
            "agent": ["random", "ideal-observer", "cognitive:careful"],
            "p": [0, 0.4],
            "box": ["chain-4", "fork"],
            "trials": 2,
        },
        {"agent": ["human-inspired"], "condition": ["correction?p=0.5", "drop?p=0.5", "tremble?p=0.3"], "trials": 3},
        {"agent": ["human-inspired"], "modality": ["symbolic", "symbolic?tell=outcome"], "p": [0, 1], "trials": 2},
    ],
)
def test_numbers_are_made_of_what_the_records_say(tmp_path, more):
    """Of each trial all but words; of one whose record says more, such as a correction, the whole record."""
    planned = study("flips", repetitions=2, max_steps=8, **more)
    whole = run_study(planned, tmp_path)
    found, hashed = played(tmp_path, planned)
    assert hashed == results_hash(planned, in_order(whole))
    short = [without_words(one) != one and two == without_words(one) for one, two in zip(whole, found, strict=True)]
    assert [two if is_short else one for one, two, is_short in zip(whole, found, short, strict=True)] == found
    assert sum(short) > len(found) / 4


@pytest.mark.parametrize("column", ["kind", "shorthand", "ending"])
def test_no_number_is_made_of_a_shorthand_that_is_not_the_one_that_was_written(tmp_path, column):
    write_study(tmp_path, STUDY, [make_trial([0] * 20, trial=number) for number in (1, 2)])
    sql(tmp_path, f"update trial set {column} = {OTHER[column]} where id = 1")
    with pytest.raises(BadFile, match="trial=1, in shorthand: its checksum is that of something else; save the rest"):
        played(tmp_path, STUDY)
