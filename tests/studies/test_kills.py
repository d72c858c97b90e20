"""A study against a provider is interrupted, killed at random moments and resumed until it is done.

No finished trial is lost or played again, and no call is made again but those that were on their way when it died.
``LOCKPROBE_KILLS=100`` in the environment kills so often.
"""

import json
import os
import random
import re
import shutil
import signal
import sqlite3
import subprocess
import time
from collections import Counter
from contextlib import closing, suppress
from functools import partial

import forked
import pytest
from provider_server import Manner, account, elsewhere

from lockprobe.agents.llm.settings import Access
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load, replaced_records
from lockprobe.studies.records.store import STORE, read
from lockprobe.studies.running.runner import Limits, run_study

KILLS = int(os.environ.get("LOCKPROBE_KILLS", "2"))
"""How often a run is killed; ``LOCKPROBE_KILLS=100`` in the environment kills so often."""

MOMENTS = 0.2
"""Within so many seconds from its first call a run is killed: that is several replies on each connection."""


def settled(url):
    """The server's account once nothing is on its way."""
    while (seen := account(url))["on_their_way"]:
        time.sleep(0.02)
    return seen


def replies(directory):
    """How many replies are stored in a directory, by whatever is writing there now."""
    with suppress(sqlite3.Error), closing(sqlite3.connect(f"file:{directory / STORE}?mode=ro", uri=True)) as db:
        return db.execute("select count(call ->> 'reply') from call").fetchone()[0]
    return 0


def ended(start, directory, luck, by=signal.SIGKILL, copy=None):
    """The exit status of a run in a directory that gets a signal some moments after its first reply.

    Just before, its files are copied one after the other, in any order, as a power cut leaves them.
    """
    before, began = replies(directory), time.monotonic()
    process = start()
    while replies(directory) <= before and process.poll() is None and time.monotonic() - began < 60:
        time.sleep(0.005)
    time.sleep(luck.uniform(0, MOMENTS))
    if copy is not None:
        copy.mkdir()
        for name in luck.sample(["study.json", "study.db", "study.db-wal"], 3):
            shutil.copyfile(directory / name, copy / name)
    process.send_signal(by)
    return process.wait()


SPEC = "llm:openai-api/fake/model"
CONNECTIONS = 4
MANY = Limits(access=Access(connections=32))
DONE = {"trial": "current", "call": "call ->> 'reply' is not null"}
"""The rows of a table that never change again."""
# Many joints, so that no two trials have the same conversation, and one step of it is one request.
STUDY = {"box": "random-8-1", "p": [0.3], "trials": 6 + 2 * KILLS, "repetitions": 1, "max_steps": 10}
OPTIONS = [f"--{name.replace('_', '-')}={value[0] if name == 'p' else value}" for name, value in STUDY.items()]


def runs(directory):
    """Starts ``lockprobe run`` in a process of its own."""
    asked = ["run", "flips", "--agent", SPEC, *OPTIONS, "--connections", CONNECTIONS]
    return forked.start([*asked, "--no-report", "--out", directory], stdout=subprocess.DEVNULL)


def test_killed_at_random_moments_nothing_is_lost_and_nothing_is_asked_twice(tmp_path):
    """Nor is it after a power cut: of some logs the disk has not got the end."""
    planned = study(StudyOptions(agent=[SPEC], **STUDY))
    manner = Manner(median=0.03)
    with elsewhere(manner) as url:
        whole = run_study(planned, tmp_path / "whole", limits=MANY)
        asked = account(url)
    assert asked["arrived"] == len(asked["conversations"]) == sum(len(trial.steps) for trial in whole)
    luck, directory, kills, lost = random.Random(7), tmp_path / "killed", 0, 0
    kept, copies = {table: [] for table in DONE}, [tmp_path / f"copy-{kill}" for kill in range(KILLS)]
    with elsewhere(manner) as url:
        assert ended(partial(runs, directory), directory, luck, signal.SIGINT) == 130
        lost = settled(url)["arrived"] - sum(call.reply is not None for call in read_calls(directory))
        assert 0 <= lost <= CONNECTIONS
        while kills < KILLS and ended(partial(runs, directory), directory, luck, copy=copies[kills]) == -signal.SIGKILL:
            kills += 1
            seen, replies = settled(url), sum(call.reply is not None for call in read_calls(directory))
            assert 0 <= seen["arrived"] - replies - lost <= CONNECTIONS
            lost = seen["arrived"] - replies
            with read(directory) as store:
                for table, before in kept.items():
                    kept[table] = list(store.rows(f"select * from {table} where {DONE[table]} order by id", nulls=True))
                    assert set(kept[table]) >= set(before)
        assert kills == KILLS
        assert len(load(directory)) < planned.size
        run_study(planned, directory, limits=MANY)
        seen, in_order = account(url), [trial.key for trial in load(directory)]
        for copy in copies[::2]:
            log = copy / "study.db-wal"
            os.truncate(log, luck.randrange(log.stat().st_size * 2 // 3, log.stat().st_size))
        for copy in copies:
            with Journal.open(copy, planned) as journal:
                assert list(journal.trials) == in_order[: len(journal.trials)]
            there = {trial.key: trial for trial in load(copy)}
            assert there == {trial.key: trial for trial in whole if trial.key in journal.trials}
            answered = {call.key for call in read_calls(copy) if call.reply is not None}
            assert answered >= there.keys()  # what was paid for is there before its trial
        run_study(planned, copy, limits=MANY)
    for one in (directory, copy):
        assert {trial.key: trial for trial in load(one)} == {trial.key: trial for trial in whole}
    assert len(replaced_records(directory)) == 0
    calls = [call for call in read_calls(directory) if call.reply is not None]
    broken = [call for call in read_calls(directory) if call.reply is None]
    assert set(Counter((call.key, call.step, call.turn) for call in calls).values()) == {1}
    assert {(call.key, call.step, call.turn) for call in broken} <= {(call.key, call.step, call.turn) for call in calls}
    assert all(call.broken_off for call in broken)
    assert seen["conversations"].keys() == asked["conversations"].keys()
    assert seen["arrived"] - len(calls) == lost <= len(broken) <= (1 + KILLS) * CONNECTIONS
    print(f"{kills} kills, {len(calls)} calls, {lost} on their way at a kill")


def test_what_a_run_of_strategies_has_told_of_is_on_disk_when_it_is_killed(tmp_path):
    # more than a quick machine plays before it is killed
    planned = study(StudyOptions(agent=["ideal-observer", "random"], p=[0.3], trials=200 + 200 * KILLS, repetitions=1))
    asked = ["run", "flips", "--agent=ideal-observer", "--agent=random", "--p=0.3", "--no-report", "--json"]
    asked += [f"--trials={planned.trials}", "--repetitions=1", f"--out={tmp_path / 'killed'}"]
    luck, told = random.Random(3), set()
    for kill in range(KILLS):
        process = forked.start([*asked, f"--workers={1 + kill % 2}"], stdout=subprocess.PIPE)
        line = ""
        while '"event": "trial"' not in line:
            line = process.stdout.readline()
        time.sleep(luck.uniform(0, 0.4))
        process.kill()
        events = [
            json.loads(one) for one in (line + process.stdout.read()).splitlines(keepends=True) if one[-1] == "\n"
        ]
        process.stdout.close()
        assert process.wait() == -signal.SIGKILL
        told |= {event["key"] for event in events if event["event"] == "trial"}
        found = [trial.key for trial in load(tmp_path / "killed")]
        assert told <= set(found)
        assert len(set(found)) == len(found) < planned.size
    assert len({trial.key for trial in run_study(planned, tmp_path / "killed")}) == planned.size
    assert len(replaced_records(tmp_path / "killed")) == 0
    print(f"{KILLS} kills, {len(told)} trials told of")


# Plays a study and dies by SIGKILL at the given commit of such a statement, before or after it is done.
DIES = """
import json, os, signal, sys
from contextlib import contextmanager
from lockprobe.foundation.storage.database import Database
from lockprobe.studies.running.runner import run_study
from lockprobe.studies.options.studyfile import StudyOptions, study
directory, statement, at, when, request = sys.argv[1], sys.argv[2], int(sys.argv[3]), sys.argv[4], sys.argv[5]
plain, commits = Database.transaction, 0
def dies(said, now):
    if commits == at and now == when and any(one.startswith(statement) for one in said):
        os.kill(os.getpid(), signal.SIGKILL)
@contextmanager
def dying(store, **how):
    global commits
    said = []
    with plain(store, **how) as writing:
        writing.set_trace_callback(said.append)
        yield writing
        writing.set_trace_callback(None)
        commits += any(one.startswith(statement) for one in said)
        dies(said, "before")
    dies(said, "after")
Database.transaction = dying
run_study(study(StudyOptions(**json.loads(request))), directory)
"""


# An agent that pays for its replies, and notes beside them what it was asked.
PAID = """
import os
from dataclasses import replace
from lockprobe.trial.model_call import Call, Usage
from lockprobe.trial.record import Decision
class Agent:
    facts = {"model": "paid"}
    def with_calls(self, key, book):
        return InTrial(key, book)
    async def decide(self, situation, rng):
        raise NotImplementedError
class InTrial:
    facts = {"model": "paid"}
    def __init__(self, key, book):
        self.key, self.book = key, book
    async def decide(self, situation, rng):
        step = len(situation.past) + 1
        call = self.book.recall(step, 1, "request")
        if call is None:
            asked = Call(key=self.key, step=step, turn=1, request="request", reply=None, most=Usage(calls=1))
            await self.book.reserve(asked)
            with open(os.environ["PAID"], "a") as account:
                account.write(f"{self.key} {step}\\n")
            joints = situation.task.joints
            call = replace(asked, most=None, reply=joints[step % len(joints)])
            await self.book.write(call)
        return Decision(joint=call.reply, replies=(call.reply,))
"""


ASK = {"agent": ["python:paid:Agent"], "p": [0], "trials": 2, "repetitions": 1}


@pytest.fixture(scope="module")
def unbroken(tmp_path_factory):
    """The folder of the agent that pays, the trials of a run that nothing breaks off, and what was paid for."""
    folder = tmp_path_factory.mktemp("paid")
    (folder / "paid.py").write_text(PAID)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)
        patch.setenv("PYTHONPATH", str(folder), prepend=os.pathsep)
        patch.setenv("PAID", str(folder / "whole.txt"))
        whole = run_study(study(StudyOptions(**ASK)), folder / "whole")
        yield whole, (folder / "whole.txt").read_text().splitlines()


ASKED, ANSWERED, RECORDED = (
    ("insert or replace into call", 1),
    ("insert or replace into call", 18),
    ("insert into trial", 1),
)


@pytest.mark.parametrize("when", ["before", "after"])
@pytest.mark.parametrize("what", [ASKED, ANSWERED, RECORDED])
def test_killed_when_a_call_or_a_trial_is_written(tmp_path, monkeypatch, unbroken, what, when):
    (whole, once), (statement, at) = unbroken, what
    monkeypatch.setenv("PAID", str(tmp_path / "killed.txt"))
    died = forked.run([tmp_path / "killed", statement, at, when, json.dumps(ASK)], script=DIES)
    assert died.returncode == -signal.SIGKILL
    if what is RECORDED:
        assert len(load(tmp_path / "killed")) == at - (when == "before")
    assert run_study(study(StudyOptions(**ASK)), tmp_path / "killed") == whole
    paid = (tmp_path / "killed.txt").read_text().splitlines()
    assert len(once) == len(set(once)) == sum(len(trial.steps) for trial in whole) > 9
    assert set(paid) == set(once)
    assert len(paid) - len(once) == ((what, when) == (ANSWERED, "before"))
    calls = read_calls(tmp_path / "killed")
    assert sum(call.broken_off for call in calls) == ((what, when) in {(ASKED, "after"), (ANSWERED, "before")})
    assert sum(not call.broken_off for call in calls) == len(once)


# Plays a study where no file can grow beyond so many bytes, as on a full disk.
FULL = """
import json, resource, sys
from lockprobe.foundation.errors import UserMistake
from lockprobe.studies.running.runner import run_study
from lockprobe.studies.options.studyfile import StudyOptions, study
most = int(sys.argv[2])
resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
try:
    run_study(study(StudyOptions(**json.loads(sys.argv[3]))), sys.argv[1])
except (UserMistake, OSError) as error:
    sys.exit(str(error))
"""


@pytest.mark.parametrize("most", [20_000, 70_000])
def test_a_full_disk_stops_a_run_and_loses_nothing(tmp_path, monkeypatch, unbroken, most):
    whole, once = unbroken
    monkeypatch.setenv("PAID", str(tmp_path / "full.txt"))
    done = forked.run([tmp_path / "full", most, json.dumps(ASK)], script=FULL)
    assert done.returncode == 1
    assert re.fullmatch(rf"{tmp_path}/full/study.db: cannot be written .*", done.stderr.strip())
    assert run_study(study(StudyOptions(**ASK)), tmp_path / "full") == whole
    paid = (tmp_path / "full.txt").read_text().splitlines()
    assert set(paid) == set(once)
    assert len(paid) <= len(once) + 1
