"""Nothing finished is lost, nothing is repeated, whenever the process dies."""

import asyncio
import json
import os
import resource
import signal
import subprocess
from contextlib import closing, contextmanager
from dataclasses import replace
from pathlib import Path

import forked
import pytest
from builders import SOLUTION, call_of, make_trial, small_study, write_study

from lockprobe.foundation.errors import BadFile, DirectoryBusy, SettingsChanged
from lockprobe.foundation.storage.jsonl import LineFile, with_checksum
from lockprobe.interventions.conditions import flips
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.file_names import ASKED, CALLS
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.directory import read_settings
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import LeftOut, left_out, load, read_records
from lockprobe.studies.records.trial_rows import Timing, read_timings, rewritten
from lockprobe.studies.running.runner import run

STUDY = study(StudyOptions(agent=["random"], trials=3, repetitions=2, p=[0, 0.4]))
PLANS = list(STUDY.plans("random"))

# Plays STUDY and dies by SIGKILL at the given write: after `part` of its bytes have reached the file.
DIES = """
import os, signal, sys
from lockprobe.studies.records import journal as module
from lockprobe.studies.running.runner import run
from lockprobe.studies.options.studyfile import StudyOptions, study
directory, at, part = sys.argv[1], int(sys.argv[2]), float(sys.argv[3])
writes = 0
class Dying:
    def __init__(self, file): self.file = file
    def __getattr__(self, name): return getattr(self.file, name)
    def write(self, content):
        global writes
        writes += 1
        if writes == at:
            self.file.write(content[: int(len(content) * part)])
            self.file.flush()
            os.kill(os.getpid(), signal.SIGKILL)
        return self.file.write(content)
plain = Journal.__init__
def init(self, directory, study, records, timings, *others):
    for file in records, timings:
        file._file = Dying(file._file)
    plain(self, directory, study, records, timings, *others)
Journal.__init__ = init
planned = study(StudyOptions(agent=["random"], trials=3, repetitions=2, p=[0, 0.4]))
with Journal.open(directory, planned) as journal:
    run(planned, journal)
"""


def test_what_was_paid_for_is_on_the_disk_no_later_than_its_trial(tmp_path, monkeypatch):
    synced, fsync = [], os.fsync

    def noted(descriptor):
        number = os.fstat(descriptor).st_ino
        synced.append(next(path.name for path in tmp_path.iterdir() if path.stat().st_ino == number))
        fsync(descriptor)

    trial = make_trial([0])
    with Journal.open(tmp_path, STUDY) as journal:
        monkeypatch.setattr("os.fsync", noted)
        asyncio.run(journal.calls.of(PLANS[0]).reserve(call_of(trial, reply=None)))
        journal.calls.write(call_of(trial))
        journal.append(trial, Timing(key=trial.key, seconds=1, steps=1))
    assert synced == [ASKED, CALLS, "trials.jsonl"]


@contextmanager
def full_disk(path):
    """A disk on which no file may be longer than this one and a few bytes: not even what pytest writes to, so shortly."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (path.stat().st_size + 10, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.mark.parametrize("name", ["trials.jsonl", CALLS])
def test_a_full_disk_is_one_line_that_names_the_file_and_tears_nothing(tmp_path, name):
    first, second = make_trial(SOLUTION), make_trial(SOLUTION, trial=2)
    call = call_of(second, reply="said" * 100)

    def one_more(journal):
        if name == CALLS:
            journal.calls.write(call)
        else:
            journal.append(second, Timing(key=second.key, seconds=1, steps=1))

    with Journal.open(tmp_path, STUDY) as journal:
        journal.append(first, Timing(key=first.key, seconds=1, steps=1))
        journal.calls.write(call_of(first))
    before = (tmp_path / name).read_bytes()
    with pytest.raises(BadFile) as full, full_disk(tmp_path / name), Journal.open(tmp_path, STUDY) as journal:
        one_more(journal)
    assert str(full.value) == f"{tmp_path / name}: cannot be written (File too large)"
    assert (tmp_path / name).read_bytes() == before


def resume(directory):
    with Journal.open(directory, STUDY) as journal:
        owed = [plan.key for plan in STUDY.plans("random") if journal.owes(plan.key)]
        run(STUDY, journal)
    return owed


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    directory = tmp_path_factory.mktemp("whole")
    resume(directory)
    return (directory / "trials.jsonl").read_bytes()


@pytest.mark.parametrize("part", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("at", [1, 2, 23])
def test_killed_while_writing(tmp_path, whole, at, part):
    """Odd writes are records, even ones are clock readings."""
    assert forked.run([tmp_path, at, part], script=DIES).returncode == -signal.SIGKILL
    finished = at // 2 + (part == 1.0 and at % 2 == 1)
    assert len(load(tmp_path)) == finished
    assert len(resume(tmp_path)) == STUDY.size - finished
    assert (tmp_path / "trials.jsonl").read_bytes() == whole


def test_killed_at_any_moment(tmp_path, whole):
    """A real command, killed from outside again and again until it gets through."""
    command = ["run", "flips", "--agent", "random", "--trials", "150",
               "--repetitions", "1", "--p", "0,0.4", "--no-report", "--out", str(tmp_path / "d")]  # fmt: skip
    kept = 0
    for attempt in range(60):
        process = forked.start(command, stdout=subprocess.PIPE)
        for line in process.stdout:
            if "trials to play" in line:
                break
        try:
            process.wait(timeout=0.01 + 0.05 * attempt)
        except subprocess.TimeoutExpired:
            process.kill()
        process.communicate()
        lines = load(tmp_path / "d")
        assert len(lines) >= kept
        kept = len(lines)
        if process.returncode == 0:
            break
    assert process.returncode == 0
    content = (tmp_path / "d" / "trials.jsonl").read_bytes().splitlines()
    keys = [json.loads(line)["key"] for line in content]
    assert len(keys) == len(set(keys)) == 300
    again = forked.run([*command[:-1], tmp_path / "e"])
    assert again.returncode == 0
    assert (tmp_path / "e" / "trials.jsonl").read_bytes().splitlines() == content


def test_a_finished_study_owes_nothing(tmp_path):
    assert len(resume(tmp_path)) == STUDY.size
    assert resume(tmp_path) == []


def test_settings_cannot_change_once_somebody_has_joined(tmp_path):
    people = study(StudyOptions(agent=["participant"], trials=4, p=[0]))
    with Journal.open(tmp_path, people):
        pass
    (tmp_path / "people").mkdir()
    (tmp_path / "people" / "aaaa01.jsonl").touch()
    with (
        pytest.raises(SettingsChanged, match=r"\(conditions is 'truth' there, 'flip\?p=0.4' asked\)"),
        Journal.open(tmp_path, replace(people, agents=("random",), conditions=flips((0.4,)))),
    ):
        pass
    with Journal.open(tmp_path, replace(people, agents=("random",))):
        pass
    assert read_settings(tmp_path)["agents"] == ["random", "participant"]


def test_calls_are_held_until_their_trial_is_finished_and_no_longer(tmp_path):
    trials = make_trial([0, 1], budget=2), make_trial([0], broken="model", trial=2)
    plans = [next(plan for plan in PLANS if plan.key == trial.key) for trial in trials]
    calls = [call_of(trial) for trial in trials]

    def held(journal):
        return [journal.calls.of(plan).recall(1, 1, "r") for plan in plans]

    with Journal.open(tmp_path, STUDY) as journal:
        for i, (trial, call) in enumerate(zip(trials, calls, strict=True)):
            journal.calls.write(call)
            assert held(journal)[i] == call
            journal.append(trial, Timing(key=trial.key, seconds=1, steps=1))
        assert held(journal) == [None, calls[1]]
    with Journal.open(tmp_path, STUDY) as journal:
        assert held(journal) == [None, calls[1]]


def test_settings_cannot_change_once_a_call_was_paid_for(tmp_path):
    call = call_of(PLANS[0])
    with Journal.open(tmp_path, STUDY) as journal:
        journal.calls.write(call)
    with (
        pytest.raises(SettingsChanged, match="trials is 3 there, 4 asked"),
        Journal.open(tmp_path, study(StudyOptions(agent=["random"], trials=4, repetitions=2, p=[0, 0.4]))),
    ):
        pass
    assert list(read_calls(tmp_path)) == [call]
    (tmp_path / "study.json").unlink()
    with pytest.raises(BadFile, match=r"holds calls.jsonl but no study.json: put it back, or give another --out"):
        resume(tmp_path)


def test_damaged_clock_readings_are_passed_over(tmp_path):
    resume(tmp_path)
    path = tmp_path / "timings.jsonl"
    first = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(first[0] + b"rubbish\n[1]\n{}\n" + first[0])
    assert [timing.key for timing in read_timings(tmp_path)] == [load(tmp_path)[0].key]


@pytest.mark.parametrize("settings", ["{}", "[]", '{"agents": 1}', "{"])
def test_settings_that_are_none_are_refused(tmp_path, settings):
    resume(tmp_path)
    (tmp_path / "study.json").write_text(settings)
    with pytest.raises(BadFile, match=r"study.json: not"):
        read_settings(tmp_path)


def test_two_writers_are_one_too_many(tmp_path):
    with (
        Journal.open(tmp_path, STUDY),
        pytest.raises(
            DirectoryBusy,
            match=r"by another lockprobe: wait for a run, stop a server \(lockprobe serve, which loses nothing\) with Ctrl-C",
        ),
        Journal.open(tmp_path, STUDY),
    ):
        pass


def test_damage_within_the_journal_is_named_and_kept(tmp_path):
    resume(tmp_path)
    path = tmp_path / "trials.jsonl"
    lines = path.read_bytes().splitlines(keepends=True)
    lines[2] = with_checksum(b'{"key":"k","identity":"0123456789ab"}') + b"\n"
    path.write_bytes(b"".join(lines))
    with (
        pytest.raises(BadFile, match=r"trials.jsonl: line 3: trial record: got 'study'"),
        Journal.open(tmp_path, STUDY),
    ):
        pass
    assert path.read_bytes() == b"".join(lines)


def test_a_directory_without_a_study(tmp_path):
    with pytest.raises(BadFile, match=r"no trials.jsonl here; is it the directory of a study\?"):
        load(tmp_path)
    with pytest.raises(BadFile, match=r"no study.json here"):
        read_settings(tmp_path)
    (tmp_path / "file").touch()
    with pytest.raises(BadFile, match="cannot be written"), Journal.open(tmp_path / "file" / "x", STUDY):
        pass


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_ctrl_c_leaves_a_directory_to_resume_and_says_so(tmp_path):
    command = ["run", "flips", "--agent", "random", "--trials", "20000",
               "--repetitions", "1", "--p", "0", "--out", str(tmp_path)]  # fmt: skip
    process = forked.start(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    for line in process.stdout:
        if "trials ·" in line:
            break
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=20)
    assert process.returncode == 130
    assert f"Stopped. Every finished trial is in {tmp_path}; run the same command again to go on." in out
    assert "Traceback" not in err
    assert 0 < len(load(Path(tmp_path))) < 20000


def test_what_a_journal_leaves_out_is_counted(tmp_path):
    study = small_study(["random"])
    broken, played = make_trial([0], broken="model"), make_trial([0, 1], budget=2)
    directory = write_study(tmp_path / "study", study, [broken, played, make_trial([0, 1], budget=2, trial=2)])
    assert left_out(directory) == LeftOut(unfinished_lines=0, replaced=1, repeated=0)
    with (directory / "trials.jsonl").open("ab") as file:
        file.write(b'{"key":"flips/ran')
    assert left_out(directory) == LeftOut(unfinished_lines=1, replaced=1, repeated=0)
    assert len(load(directory)) == 2
    assert read_records(directory) == (load(directory), left_out(directory))


def test_a_second_record_of_a_finished_trial_is_counted_apart(tmp_path):
    study = small_study(["random"])
    first, second = make_trial([0, 1], budget=2), make_trial([0, 2], budget=2)
    directory = write_study(tmp_path / "study", study, [first, second])
    assert left_out(directory) == LeftOut(unfinished_lines=0, replaced=0, repeated=1, contradicted=1)
    assert load(directory) == [second]


INVITING = small_study(["participant"], trials=3)
ANN, BOB = "participant:aaaa", "participant:bbbb"


def journal_of(directory, *trials):
    with Journal.open(directory, INVITING) as journal:
        for seconds, trial in enumerate(trials, 1):
            journal.append(trial, Timing(key=trial.key, seconds=float(seconds), steps=len(trial.steps)))
    return directory


def trial(agent, number, **more):
    """One of people's trials: its key is the same whoever plays it."""
    return make_trial([0, 1, 2], agent=agent, trial=number, budget=3, **more)


def test_what_stays_stands_there_as_it_did(tmp_path):
    kept = [trial(BOB, 2), trial("random", 1)]
    journal_of(tmp_path, trial(ANN, 1), *kept, trial(ANN, 3))
    before = (tmp_path / "trials.jsonl").read_bytes().splitlines(keepends=True)
    with Journal.open(tmp_path, INVITING) as journal:
        journal.delete_agent(ANN)
        assert [one.agent for one in journal.trials.values()] == [BOB, "random"]
        assert journal.owes(trial(ANN, 1).key)
        journal.append(trial(BOB, 3), Timing(key=trial(BOB, 3).key, seconds=9.0, steps=3))
    assert (tmp_path / "trials.jsonl").read_bytes().splitlines(keepends=True)[:2] == before[1:3]
    assert load(tmp_path) == [*kept, trial(BOB, 3)]
    assert [timing.seconds for timing in read_timings(tmp_path)] == [2.0, 3.0, 9.0]


def test_a_trial_that_broke_and_was_played_by_somebody_else_stays_theirs(tmp_path):
    journal_of(tmp_path, trial(ANN, 1, broken="plant"), trial(ANN, 2), trial(BOB, 1))
    with Journal.open(tmp_path, INVITING) as journal:
        journal.delete_agent(ANN)
        assert not journal.owes(trial(BOB, 1).key)
    assert load(tmp_path) == [trial(BOB, 1)]
    assert [(timing.key, timing.seconds) for timing in read_timings(tmp_path)] == [(trial(BOB, 1).key, 3.0)]
    assert (tmp_path / "timings.jsonl").read_text().count("\n") == 1


def test_what_cannot_be_written_leaves_all_as_it_was(tmp_path):
    path = tmp_path / "lines.jsonl"
    path.write_bytes(b"a\nb\n")
    with closing(LineFile(path)) as old:
        (tmp_path / ".lines.jsonl.draft").mkdir()
        with pytest.raises(BadFile):
            rewritten(old, [b"a\n"])
        old.append(b"c")
    assert path.read_bytes() == b"a\nb\nc\n"


@pytest.mark.parametrize(("agent", "stays"), [(ANN, 1.0), (BOB, 2.0)])
def test_of_a_trial_that_two_have_played_the_reading_of_the_other_stays(tmp_path, agent, stays):
    journal_of(tmp_path, trial(BOB, 1, broken="plant"), trial(ANN, 1))
    with Journal.open(tmp_path, INVITING) as journal:
        journal.delete_agent(agent)
    assert [timing.seconds for timing in read_timings(tmp_path)] == [stays]


def test_a_reading_of_which_it_cannot_be_told_whose_it_is_goes(tmp_path):
    journal_of(tmp_path, trial(BOB, 1, broken="plant"), trial(ANN, 1), trial(BOB, 2))
    path = tmp_path / "timings.jsonl"
    path.write_bytes(b"".join(path.read_bytes().splitlines(keepends=True)[1:]))
    with Journal.open(tmp_path, INVITING) as journal:
        journal.delete_agent(ANN)
    assert [timing.seconds for timing in read_timings(tmp_path)] == [3.0]
