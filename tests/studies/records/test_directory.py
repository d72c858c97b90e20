"""The directory of a study: what a start leaves behind that fails, which settings may differ, and what a withdrawal leaves."""

import asyncio
import errno
import fcntl
import os
import stat
import zlib
from dataclasses import replace

import pytest
from builders import call_of, make_trial, small_study, write_study
from stored import contents, records, sql, timings

from lockprobe.agents.catalogue import resolve
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadFile, DirectoryBusy, SettingsChanged
from lockprobe.interventions.conditions import flips
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load, replaced_records
from lockprobe.studies.running import runner
from lockprobe.studies.running.executor import Observer
from lockprobe.studies.running.runner import Limits, run, run_study
from lockprobe.trial.condition import Condition
from lockprobe.trial.trial_json import trial_to_json

STUDY = small_study(["random"], p=[0.0, 0.4], repetitions=1, trials=2)
CANNOT_START = replace(STUDY, agents=("random", "llm:gguf:none.gguf"))


def test_a_start_that_fails_leaves_nothing(tmp_path):
    with pytest.raises(BadFile, match="none.gguf"):
        run_study(CANNOT_START, tmp_path / "runs" / "d")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("played", [True, False])
def test_a_start_that_fails_leaves_the_study_that_is_there_as_it_was(tmp_path, played):
    write_study(tmp_path, STUDY, [make_trial([0, 1], budget=2)] if played else [])
    before = contents(tmp_path)
    with pytest.raises(BadFile):
        run_study(CANNOT_START, tmp_path)
    assert contents(tmp_path) == before


class Reads(Observer):
    """Reads what is on disk whenever it is told of a trial."""

    def __init__(self, directory):
        self.directory, self.told, self.missing = directory, [], []

    def trial(self, trial, seconds):
        self.told.append(trial.key)
        self.missing += [] if trial in load(self.directory) else [trial.key]


@pytest.mark.parametrize("engine", ["inline", "process"])
def test_a_trial_is_on_disk_before_anybody_is_told_of_it(tmp_path, monkeypatch, engine):
    monkeypatch.setattr(runner, "resolve", lambda *asked: replace(resolve(*asked), engine=engine))
    with Journal.open(tmp_path / "d", STUDY) as journal:
        reads = Reads(tmp_path / "d")
        run(STUDY, journal, observer=reads, limits=Limits(workers=2))
    assert reads.missing == []
    assert sorted(reads.told) == sorted(trial.key for trial in load(tmp_path / "d"))
    alone = run_study(STUDY, tmp_path / "alone")
    assert sorted(map(trial_to_json, load(tmp_path / "d"))) == sorted(map(trial_to_json, alone))


def test_an_agent_is_added_to_a_finished_study_and_meets_the_same_luck(tmp_path):
    run_study(STUDY, tmp_path)
    before = records(tmp_path)
    added = replace(STUDY, agents=("round-robin",))
    run_study(added, tmp_path)
    assert records(tmp_path)[: len(before)] == before
    both = read_study(tmp_path)
    assert both == replace(STUDY, agents=("random", "round-robin"))
    assert both.identity not in (STUDY.identity, added.identity)
    by_agent = {agent: [t for t in load(tmp_path) if t.agent == agent] for agent in both.agents}
    for first, second in zip(by_agent["random"], by_agent["round-robin"], strict=True):
        assert (first.labels, first.listing, first.p) == (second.labels, second.listing, second.p)
    together = run_study(both, tmp_path / "together")
    assert sorted(together, key=lambda t: t.key) == sorted(load(tmp_path), key=lambda t: t.key)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"seed": 2}, "(seed is 1 there, 2 asked)"),
        ({"conditions": flips((0.0,))}, "(conditions is 'truth; flip?p=0.4' there, 'truth' asked)"),
        ({"conditions": (Condition(), Condition(modality="symbolic"))}, "'truth; symbolic' asked"),
        ({"conditions": (Condition(name="honest"),)}, "(conditions is 'truth; flip?p=0.4' there, 'honest=truth' asked)"),
        ({"max_steps": 5, "conditions": flips((0.0, 0.4), "integrated")}, "there, 'truth; flip?p=0.4&others=kept' asked; max_steps is 20 there, 5 asked)"),
        ({"assessment": False}, "(assessment is True there, False asked)"),
        ({"boxes": (box("chain-5"),)}, "(box is 'chain-4' there, 'chain-5' asked)"),
        ({"boxes": (replace(box("chain-4"), target="slider-1"),)}, "(box is 'chain-4' there, 'another chain-4' asked)"),
    ],
)  # fmt: skip
def test_any_other_setting_that_differs_is_named_with_both_values(tmp_path, change, said):
    write_study(tmp_path, STUDY, [make_trial([0, 1], budget=2)])
    before = contents(tmp_path)
    with pytest.raises(SettingsChanged) as refused:
        run_study(replace(STUDY, agents=("round-robin",), **change), tmp_path)
    assert said in str(refused.value)
    assert len(str(refused.value)) < 400 + len(str(tmp_path))
    assert contents(tmp_path) == before


def test_the_order_of_agents_and_conditions_is_no_setting(tmp_path):
    planned = replace(STUDY, agents=("random", "round-robin"), conditions=(*STUDY.conditions, *flips((0.2,))))
    reordered = replace(planned, agents=planned.agents[::-1], conditions=planned.conditions[::-1])
    assert (reordered.identity, reordered.settings()) != (planned.identity, planned.settings())
    assert reordered.identity == planned.identity
    run_study(planned, tmp_path)
    before = contents(tmp_path)
    run_study(reordered, tmp_path)
    assert contents(tmp_path) == before
    run_study(replace(reordered, agents=("human-inspired",)), tmp_path)
    assert read_study(tmp_path) == replace(planned, agents=(*planned.agents, "human-inspired"))
    assert reordered.ordered_as(planned).conditions == planned.conditions
    assert STUDY.ordered_as(planned) == STUDY


def busy(directory):
    said = (
        r"by another lockprobe: wait for a run, or stop a server \(lockprobe serve, which loses nothing\) with Ctrl-C"
    )
    with Journal.open(directory, STUDY), pytest.raises(DirectoryBusy, match=said), Journal.open(directory, STUDY):
        pass


def test_a_second_writer_is_refused_also_where_a_file_system_locks_no_directories(tmp_path, monkeypatch):
    busy(tmp_path / "d")
    plain = fcntl.flock

    def of_files_alone(handle, how):
        if stat.S_ISDIR(os.fstat(handle).st_mode):
            raise OSError(errno.EBADF, "Bad file descriptor")
        plain(handle, how)

    monkeypatch.setattr(fcntl, "flock", of_files_alone)
    busy(tmp_path / "d")
    with pytest.raises(BadFile):
        run_study(CANNOT_START, tmp_path / "e")
    assert not (tmp_path / "e").exists()


def test_settings_cannot_change_once_somebody_has_joined(tmp_path):
    people = small_study(["participant"], p=[0.0], trials=4)
    with Journal.open(tmp_path, people):
        pass
    sql(tmp_path, "insert into act values (1, 'aaaa01', 1, '{}', 0)")
    with (
        pytest.raises(SettingsChanged, match=r"\(conditions is 'truth' there, 'flip\?p=0.4' asked\)"),
        Journal.open(tmp_path, replace(people, agents=("random",), conditions=flips((0.4,)))),
    ):
        pass
    with Journal.open(tmp_path, replace(people, agents=("random",))):
        pass
    assert read_study(tmp_path).agents == ("random", "participant")


def test_settings_cannot_change_once_a_call_was_paid_for(tmp_path):
    call = call_of(next(STUDY.plans("random")))
    with Journal.open(tmp_path, STUDY) as journal:
        asyncio.run(journal.calls.write(call))
    with pytest.raises(SettingsChanged, match="trials is 2 there, 4 asked"):
        Journal.open(tmp_path, replace(STUDY, trials=4)).__enter__()
    assert list(read_calls(tmp_path)) == [call]
    (tmp_path / "study.json").unlink()
    with pytest.raises(BadFile, match=r"holds study.db but no study.json: put it back, or give another --out"):
        run_study(STUDY, tmp_path)


INVITING = small_study(["participant", "random"], trials=3)
ANN, BOB = "participant:aaaa", "participant:bbbb"


def trial(agent, number, **more):
    """One of people's trials: its key is the same whoever plays it."""
    return make_trial([0, 1, 2], agent=agent, trial=number, budget=3, **more)


@pytest.mark.parametrize(
    ("gone", "seconds"),
    [(ANN, [3.0, 4.0, 5.0]), (BOB, [1.0, 2.0, 4.0, 6.0]), ("participant:cccc", [3.0, 4.0, 5.0, 6.0])],
)
def test_who_withdraws_is_gone_and_what_others_played_of_the_same_trial_counts(tmp_path, gone, seconds):
    """The times say which record: the first two trials broke with ANN before BOB played them."""
    played = [
        trial(ANN, 1, broken="plant"), trial(ANN, 2, broken="plant"), trial(BOB, 1), trial("random", 1), trial(BOB, 2),
        trial(ANN, 3),
    ]  # fmt: skip
    with Journal.open(tmp_path, INVITING) as journal:
        for number, one in enumerate(played, 1):
            journal.append(one, number + 4e-7)  # times are kept in microseconds
        journal.delete_participant(gone)
        journal.erase()
        assert {one.agent for one in journal.trials.values()} <= {ANN, BOB, "random"} - {gone}
        assert journal.owes(trial(ANN, 3).key) == (gone == ANN)
        if gone == BOB:  # while the server runs: the records that broke before count again, and somebody plays on
            journal.append(trial("participant:eeee", 1), 8.0)
            journal.delete_participant("participant:eeee")
    assert timings(tmp_path) == seconds
    assert gone not in {one.agent for one in (*load(tmp_path), *replaced_records(tmp_path))}
    assert gone.encode() not in b"".join(map(zlib.decompress, sql(tmp_path, "select record from trial")))
    with Journal.open(tmp_path, INVITING) as journal:
        journal.append(trial("participant:dddd", 3), 9.0)
    assert load(tmp_path)[-1].agent == "participant:dddd"
