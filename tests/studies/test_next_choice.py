"""The exact chances of the next choice are those that the records of exact policies hold."""

import pytest

from lockprobe.foundation.errors import BadFile
from lockprobe.studies.branch import FORKS, branching, play_forks
from lockprobe.studies.next_choice import next_choices, read_choices, write_choices
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running.runner import run_study


def test_chances_are_those_on_record_and_of_policies_alone(tmp_path):
    planned = study("flips", agent=["cognitive:insistent", "human-inspired"], p=[0.4], trials=4, repetitions=1)
    wanted = branching(planned, run_study(planned, tmp_path), at=["2", "5"], told=["truth", "lie", "remark"], times=2)
    with Journal.open(tmp_path / FORKS, planned) as journal:
        play_forks(wanted, journal)
    forks = {fork.key: fork for fork in load(tmp_path / FORKS)}
    found = next_choices(wanted, forks)
    assert found.keys() == {key for key in forks if key.endswith("time=1")}
    for key, chances in found.items():
        at = 2 if "/at=2/" in key else 5
        on_record = forks[key].steps[at].decision.probabilities
        assert sum(chances) == 1 or abs(sum(chances) - 1) < 1e-12
        assert on_record in (None, chances)
        chosen = forks[key].listing.index(forks[key].steps[at].decision.joint)
        assert chances[chosen] > 0
    assert any(forks[key].steps[2].decision.probabilities for key in found)
    assert next_choices(wanted, ()) == {}
    assert read_choices(tmp_path) == {}
    written = write_choices(tmp_path, wanted, list(forks)[:3])
    assert written.keys() <= found.keys()
    assert write_choices(tmp_path, wanted, forks) == read_choices(tmp_path) == found
    (tmp_path / FORKS / "next_choices.json").write_text('{"a": [NaN]}')
    with pytest.raises(BadFile, match="not the probabilities of next choices"):
        read_choices(tmp_path)
