"""A study against a provider is interrupted, killed at random moments and resumed until it is done.

No finished trial is lost or played again, and no call is made again but those that were on their way when it died.
``LOCKPROBE_KILLS=100`` in the environment kills so often.
"""

import json
import os
import random
import signal
from collections import Counter
from functools import partial

import forked
import pytest
from killed import KILLS, ended, settled, start
from provider_server import Manner, account, elsewhere

from lockprobe.agents.model_access import Access
from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.storage.jsonl import with_checksum
from lockprobe.studies.costs.call_log import read_calls, unanswered
from lockprobe.studies.file_names import ASKED, CALLS
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import left_out, load
from lockprobe.studies.running.runner import Limits, run_study

SPEC = "llm:openai-api/fake/model"
CONNECTIONS = 4
# Many joints, so that no two trials have the same conversation, and one step of it is one request.
STUDY = {"box": "random-8-1", "p": [0.3], "trials": 12 + 2 * KILLS, "repetitions": 1, "max_steps": 10}
OPTIONS = [f"--{name.replace('_', '-')}={value[0] if name == 'p' else value}" for name, value in STUDY.items()]


@pytest.fixture(autouse=True)
def no_keys(monkeypatch):
    for name in os.environ:
        if name.endswith(("_API_KEY", "_BASE_URL")):
            monkeypatch.delenv(name)
    monkeypatch.setenv("FAKE_API_KEY", "sk-private-0123456789")


def runs(directory):
    """Starts ``lockprobe run`` in a process of its own."""
    asked = ["run", "flips", "--agent", SPEC, *OPTIONS, "--connections", CONNECTIONS]
    return start(*asked, "--no-report", "--out", directory)


def test_killed_at_random_moments_nothing_is_lost_and_nothing_is_asked_twice(tmp_path, monkeypatch):
    pytest.importorskip("lockprobe.agents.llm.model")
    planned = study(StudyOptions(agent=[SPEC], **STUDY))
    manner = Manner(median=0.05)
    with elsewhere(manner) as url:
        monkeypatch.setenv("FAKE_BASE_URL", url)
        whole = run_study(planned, tmp_path / "whole", limits=Limits(access=Access(connections=32)))
        asked = account(url)
    assert asked["arrived"] == len(asked["conversations"]) == sum(len(trial.steps) for trial in whole)
    luck, directory, kills, lost = random.Random(7), tmp_path / "killed", 0, 0
    kept = dict.fromkeys(("trials.jsonl", ASKED, CALLS), b"")
    with elsewhere(manner) as url:
        monkeypatch.setenv("FAKE_BASE_URL", url)
        assert ended(partial(runs, directory), directory / CALLS, luck, signal.SIGINT) == 130
        assert unanswered(directory) == []
        lost = settled(url)["arrived"] - sum(call.reply is not None for call in read_calls(directory))
        assert 0 <= lost <= CONNECTIONS
        while kills < KILLS and ended(partial(runs, directory), directory / CALLS, luck) == -signal.SIGKILL:
            kills += 1
            seen, replies = settled(url), sum(call.reply is not None for call in read_calls(directory))
            assert 0 <= seen["arrived"] - replies - lost <= CONNECTIONS
            lost = seen["arrived"] - replies
            for name, before in kept.items():
                content = (directory / name).read_bytes()
                assert content.startswith(before)
                kept[name] = content[: content.rfind(b"\n") + 1]
        assert kills == KILLS
        assert len(load(directory)) < planned.size
        run_study(planned, directory, limits=Limits(access=Access(connections=32)))
        seen = account(url)
    assert {trial.key: trial for trial in load(directory)} == {trial.key: trial for trial in whole}
    assert (left_out(directory).repeated, left_out(directory).replaced) == (0, 0)
    calls = [call for call in read_calls(directory) if call.reply is not None]
    broken = [call for call in read_calls(directory) if call.reply is None]
    assert set(Counter((call.key, call.step, call.turn) for call in calls).values()) == {1}
    assert {(call.key, call.step, call.turn) for call in broken} <= {(call.key, call.step, call.turn) for call in calls}
    assert all(call.broken_off for call in broken)
    assert seen["conversations"].keys() == asked["conversations"].keys()
    assert seen["arrived"] - len(calls) == lost <= len(broken) <= (1 + KILLS) * CONNECTIONS
    assert unanswered(directory) == []
    print(
        f"{kills} kills, {len(calls)} calls, {lost} on their way at a kill, {seen['left']} of them left before the reply"
    )


# Plays a study and dies by SIGKILL at the given write to a file: after `part` of its bytes have reached it.
DIES = """
import json, os, signal, sys
from pathlib import Path
from lockprobe.studies.running.runner import run_study
from lockprobe.studies.options.studyfile import StudyOptions, study
directory, name, at, part, request = sys.argv[1], sys.argv[2], int(sys.argv[3]), float(sys.argv[4]), sys.argv[5]
plain, writes = Path.open, 0
class Dying:
    def __init__(self, file): self.file = file
    def __getattr__(self, name): return getattr(self.file, name)
    def __enter__(self): return self
    def __exit__(self, *error): self.file.close()
    def write(self, content):
        global writes
        writes += 1
        if writes == at:
            self.file.write(content[: int(len(content) * part)])
            self.file.flush()
            os.kill(os.getpid(), signal.SIGKILL)
        return self.file.write(content)
def opened(self, mode="r", *others, **more):
    file = plain(self, mode, *others, **more)
    return Dying(file) if self.name == name and "a" in mode else file
Path.open = opened
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
            self.book.write(call)
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


@pytest.mark.parametrize("part", [0.0, 0.5, 1.0])
@pytest.mark.parametrize(("name", "at"), [(ASKED, 1), (ASKED, 9), (CALLS, 1), (CALLS, 9)])
def test_killed_while_writing_a_line_about_a_call(tmp_path, monkeypatch, unbroken, name, at, part):
    whole, once = unbroken
    monkeypatch.setenv("PAID", str(tmp_path / "killed.txt"))
    died = forked.run([tmp_path / "killed", name, at, part, json.dumps(ASK)], script=DIES)
    assert died.returncode == -signal.SIGKILL
    assert run_study(study(StudyOptions(**ASK)), tmp_path / "killed") == whole
    paid = (tmp_path / "killed.txt").read_text().splitlines()
    assert len(once) == len(set(once)) == sum(len(trial.steps) for trial in whole) > 9
    assert set(paid) == set(once)
    assert len(paid) - len(once) == (name == CALLS and part < 1)
    broken = [call.step for call in read_calls(tmp_path / "killed") if call.broken_off]
    assert len(broken) == ((name, part) in {(ASKED, 1.0), (CALLS, 0.0), (CALLS, 0.5)})
    for book in (ASKED, CALLS):
        assert (tmp_path / "killed" / book).read_bytes().count(b"\n") == len(once) + len(broken)


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


@pytest.mark.parametrize("most", [500, 700, 1500, 3000])
def test_a_full_disk_stops_a_run_and_loses_nothing(tmp_path, monkeypatch, unbroken, most):
    whole, once = unbroken
    monkeypatch.setenv("PAID", str(tmp_path / "full.txt"))
    done = forked.run([tmp_path / "full", most, json.dumps(ASK)], script=FULL)
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert "File too large" in done.stderr
    assert run_study(study(StudyOptions(**ASK)), tmp_path / "full") == whole
    paid = (tmp_path / "full.txt").read_text().splitlines()
    assert set(paid) == set(once)
    assert len(paid) <= len(once) + 1


REAL = {"key": "flips/x/truth/rep=1/trial=1", "step": 1, "turn": 1, "request": "0f", "reply": "A"}


@pytest.mark.parametrize(
    "damage",
    [
        b"rubbish",
        b"[]",
        b"{}",
        b"null",
        b'{"key":"k","ending":"solved"}',
        b"\xff\xfe",
        b'{"key":' + b"[" * 100_000 + b"}",
        *(
            json.dumps(REAL | change).encode()
            for change in (
                {"key": 1},
                {"step": 1.5},
                {"step": 10**400},
                {"step": True},
                {"reply": 1},
                {"reply": "\ud800"},
                {"seconds": float("nan")},
                {"seconds": float("inf")},
                {"seconds": -1},
                {"seconds": 1e12},
                {"usage": {"input_tokens": 1e30}},
                {"usage": {"input_tokens": -1}},
                {"usage": None},
                {"surprise": 1},
            )
        ),
    ],
    ids=lambda line: line.decode("latin-1").removeprefix(json.dumps(REAL)[:-1])[-60:],
)
def test_a_damaged_line_is_named_and_nothing_is_overwritten(tmp_path, damage):
    """Those that are objects have the checksum that they would have."""
    whole = with_checksum(json.dumps(REAL).encode())
    damage = with_checksum(damage) if damage.startswith(b"{") else damage
    planned = study(StudyOptions(agent=["random"], p=[0], trials=1, repetitions=1))
    run_study(planned, tmp_path)
    content = whole + b"\n\n" + damage + b"\n" + whole + b"\n"
    (tmp_path / CALLS).write_bytes(content)
    with pytest.raises(BadFile, match=r"calls.jsonl: line 3: ") as mistake:
        list(read_calls(tmp_path))
    assert "\n" not in str(mistake.value)
    assert len(str(mistake.value)) < 1000
    with pytest.raises(BadFile, match=r"calls.jsonl: line 3: "):
        run_study(planned, tmp_path)
    assert (tmp_path / CALLS).read_bytes() == content


@pytest.mark.usefixtures("unbroken")
def test_calls_of_another_study_are_neither_used_nor_lost(tmp_path, monkeypatch):
    monkeypatch.setenv("PAID", str(tmp_path / "paid.txt"))
    planned = study(StudyOptions(**(ASK | {"trials": 1})))
    with Journal.open(tmp_path / "d", planned):
        pass
    foreign = with_checksum(json.dumps(REAL).encode()) + b"\n"
    (tmp_path / "d" / CALLS).write_bytes(foreign)
    (trial,) = run_study(planned, tmp_path / "d")
    assert len((tmp_path / "paid.txt").read_text().splitlines()) == len(trial.steps)
    content = (tmp_path / "d" / CALLS).read_bytes()
    assert content.startswith(foreign)
    assert content.count(b"\n") == 1 + len(trial.steps)
