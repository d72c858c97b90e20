"""``lockprobe withdraw``, as typed."""

import pytest
from seated import diary_of, people_study, short, take_part
from stored import timings

from lockprobe.cli import build
from lockprobe.foundation.errors import BadValue, DirectoryBusy
from lockprobe.people.withdrawal import withdrawn
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load

STUDY = people_study(p=(0.0,), plant="fast-twin?width=64&height=64", modalities=("rgb",), max_steps=2)


def withdraw(directory, participant):
    build(["withdraw"])(["withdraw", str(directory), participant], standalone_mode=False)


def test_no_byte_of_a_participant_stays(tmp_path):
    (stays,) = take_part(tmp_path, STUDY, short(), "random", platform={"PROLIFIC_PID": "pid76"})
    kept = {path.name for path in (tmp_path / "pictures").iterdir()}
    (leaves,) = take_part(tmp_path, STUDY, short(), "random", platform={"PROLIFIC_PID": "pid77"})
    with Journal.open(tmp_path, STUDY), pytest.raises(DirectoryBusy):
        withdraw(tmp_path, "pid77")  # a server runs
    with pytest.raises(BadValue, match="the ID of one participant"):
        withdraw(tmp_path, "nobody")
    token = diary_of(tmp_path, leaves.identity)[0].token
    withdraw(tmp_path, "pid77")
    for path in (path for path in tmp_path.rglob("*") if path.is_file()):
        assert leaves.identity not in path.name
        assert not any(word.encode() in path.read_bytes() for word in (leaves.identity, token, "pid77"))
    assert {path.name for path in (tmp_path / "pictures").iterdir()} == kept
    assert [trial.agent for trial in load(tmp_path)] == [f"participant:{stays.identity}"]
    assert [timing.key for timing in timings(tmp_path)] == [trial.key for trial in load(tmp_path)]
    withdraw(tmp_path, stays.identity)
    assert (load(tmp_path), list((tmp_path / "pictures").iterdir()), withdrawn(tmp_path)) == ([], [], 2)
