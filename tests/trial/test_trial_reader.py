"""Reading many lines: the same trials and the same refusals as reading each alone, and equal parts are one object."""

import json
from dataclasses import replace

import pytest
from builders import make_trial
from hypothesis import given
from hypothesis import strategies as st

from lockprobe import run_trial
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.storage.jsonl import with_checksum
from lockprobe.trial.record import TrialError
from lockprobe.trial.trial_json import trial_from_line, trial_to_line
from lockprobe.trial.trial_reader import TrialReader

IDENTITY = "0123456789ab"

PLAYED = [
    run_trial(agent=agent, condition=condition, trial=trial)
    for agent in ("random", "human-inspired", "cognitive:perseverant")
    for condition in ("truth", "flip?p=0.4", "tremble?p=0.3 + nudge", "history?last=2 + drop?p=0.3")
    for trial in (1, 2, 3)
]
LINES = [trial_to_line(trial, IDENTITY) for trial in PLAYED]


def outcome(read, line):
    try:
        return read(line)
    except BadValue as error:
        return str(error)


def warm():
    reader = TrialReader()
    for line in LINES:
        reader.read(line)
    return reader


def test_it_reads_what_was_written():
    reader = TrialReader()
    for line, trial in [*zip(LINES, PLAYED, strict=True)] * 2:
        assert reader.read(line) == (trial, IDENTITY)


def test_equal_steps_and_equal_settings_are_one_object():
    reader = TrialReader()
    first, second = (
        reader.read(trial_to_line(replace(make_trial([0, 1, 2], trial=number), budget=3, ending="budget"), IDENTITY))[0]
        for number in (1, 2)
    )
    assert first != second
    assert all(one is other for one, other in zip(first.steps, second.steps, strict=True))
    assert first.facts is second.facts
    assert first.doses is second.doses


def test_what_only_one_trial_has_is_read_whole():
    reader = warm()
    broken = replace(
        PLAYED[0], ending="error", error=TrialError(boundary="model", message='a,"ending":"b', step=1), steps=()
    )
    noted = replace(PLAYED[0], facts={"repetition": 1, "steps": "x", 'a","study":': '],"ending":'})
    for trial in (broken, noted, replace(noted, called='c","study":"d')):
        line = trial_to_line(replace(trial, key=str(trial.name)), IDENTITY)
        assert reader.read(line) == trial_from_line(line)
        assert reader.read(line) == trial_from_line(line)


CHANGES = [
    (b'"step":2', b'"step":3'),
    (b'"step":2', b'"step":"2"'),
    (b'"joint":"slider-1"', b'"joint":"slider-9"'),
    (b'"moved":false', b'"moved":true'),
    (b'"moved":false', b'"moved":0'),
    (b'"state":"0000"', b'"state":"00002"'),
    (b'"decision":{"joint"', b'"decision":{"extra":1,"joint"'),
    (b'"told":', b'"more":1,"told":'),
    (b'"ending":"budget"', b'"ending":"solved"'),
    (b'"ending":"solved"', b'"ending":"budget"'),
    (b'"budget":20', b'"budget":2'),
    (b'"trial":1', b'"trial":2'),
    (b'"trial":1', b'"trial":-1'),
    (b'"repetition":1', b'"repetition":01'),
    (b'"repetition":1', b'"repetition":true'),
    (b'"study":', b'"study":"x","study":'),
    (b'],"ending"', b',],"ending"'),
    (b'"steps":[{', b'"steps":[{},{'),
    (b'"target":"revolute-left"', b'"target":"nothing"'),
    (b'"changed_steps":', b'"changed_steps":9'),
    (b'{"key":"', b'{"key":"x'),
    (b"rep=1", b"rep\\u003d1"),
]


@pytest.mark.parametrize(("old", "new"), CHANGES)
def test_a_changed_record_is_refused_with_the_same_words(old, new):
    reader, changed = warm(), 0
    for line in LINES:
        said = line[: line.rindex(b',"crc"')] + b"}"
        if old in said:
            changed += 1
            broken = with_checksum(said.replace(old, new, 1))
            assert outcome(reader.read, broken) == outcome(trial_from_line, broken)
    assert changed


@given(st.data())
def test_any_piece_of_a_line_may_be_cut_out_or_repeated(data):
    line = data.draw(st.sampled_from(LINES))
    said = line[: line.rindex(b',"crc"')]
    begin = data.draw(st.integers(1, len(said) - 1))
    end = min(len(said), begin + data.draw(st.integers(1, 60)))
    times = data.draw(st.sampled_from([0, 2]))
    broken = with_checksum(said[:begin] + said[begin:end] * times + said[end:] + b"}")
    assert outcome(READER.read, broken) == outcome(trial_from_line, broken)


def test_members_in_another_order_are_read():
    record = json.loads(LINES[0][: LINES[0].rindex(b',"identity"')] + b"}")
    shuffled = dict(sorted(record.items())) | {"identity": IDENTITY}
    shuffled["identity"] = shuffled.pop("identity")
    line = with_checksum(json.dumps(shuffled, separators=(",", ":")).encode())
    assert warm().read(line) == (PLAYED[0], IDENTITY)


READER = warm()
