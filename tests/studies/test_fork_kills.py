"""Forks of a hosted model: what is on record is not asked again, and a killed run loses and repeats nothing."""

import os
import random
import shutil
import signal
from collections import Counter
from functools import partial

import pytest
from killed import KILLS, ended, settled, start
from provider_server import Manner, account, elsewhere
from stored import unanswered

from lockprobe.agents.llm.settings import Access
from lockprobe.studies.branch import FORKS, branching, play_forks
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.costs.spending import Budget
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load
from lockprobe.studies.records.trial_rows import replaced_records
from lockprobe.studies.running.runner import Limits, run_study

SPEC = "llm:openai-api/fake/model"
KEY = "sk-private-0123456789"
CONNECTIONS = 4
STUDY = {"box": "random-8-1", "p": [0.3], "trials": 12 + KILLS, "repetitions": 1, "max_steps": 10}
AT = ["2", "5", "first-lie"]
LIMITS = Limits(access=Access(connections=32))


@pytest.fixture(autouse=True)
def no_keys(monkeypatch):
    for name in os.environ:
        if name.endswith(("_API_KEY", "_BASE_URL")):
            monkeypatch.delenv(name)
    monkeypatch.setenv("FAKE_API_KEY", KEY)


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    """A finished study in a directory, and the conversations that its provider has seen."""
    planned, directory = study(StudyOptions(agent=[SPEC], **STUDY)), tmp_path_factory.mktemp("played") / "study"
    with elsewhere(Manner()) as url, pytest.MonkeyPatch.context() as patch:
        patch.setenv("FAKE_API_KEY", KEY)
        patch.setenv("FAKE_BASE_URL", url)
        run_study(planned, directory, limits=LIMITS)
        return planned, directory, set(account(url)["conversations"])


@pytest.fixture
def recorded(played, tmp_path):
    """The same in a directory of this test."""
    planned, directory, seen = played
    return planned, shutil.copytree(directory, tmp_path / "study"), seen


def forked(planned, directory, budget=None, **asked):
    wanted = branching(planned, load(directory), **({"at": AT} | asked))
    with Journal.open(directory / FORKS, planned) as journal:
        if budget is not None:
            journal.calls.limit(Budget(planned, budget))
        play_forks(wanted, journal, limits=LIMITS)
    return wanted


def test_no_request_on_record_is_sent_again_and_what_was_told_costs_nothing(recorded, monkeypatch):
    planned, directory, known = recorded
    with elsewhere(Manner()) as url:
        monkeypatch.setenv("FAKE_BASE_URL", url)
        few = [trial.key for trial in load(directory)[:2]]
        forked(planned, directory, keys=few, told=["truth", "lie", "lie-truth", "withheld"], times=2)
        seen = account(url)
    assert seen["conversations"]
    assert not known & seen["conversations"].keys()
    parents = {trial.key: trial for trial in load(directory)}
    asked = {call.key for call in read_calls(directory / FORKS)}
    as_recorded, forks = 0, {fork.key: fork for fork in load(directory / FORKS)}
    for fork in forks.values():
        name = fork.fork
        if fork.steps == parents[name.parent].steps:
            as_recorded += 1
            assert fork.key not in asked
            assert name.time == 1
        else:
            assert fork.key in asked
    assert as_recorded
    assert all(call.step > forks[call.key].fork.at for call in read_calls(directory / FORKS))


@pytest.mark.slow
def test_killed_at_random_moments_forks_are_not_lost_and_nothing_is_asked_twice(recorded, tmp_path, monkeypatch):
    planned, directory, _ = recorded
    whole = tmp_path / "whole"
    shutil.copytree(directory, whole)
    manner = Manner(median=0.05)
    with elsewhere(manner) as url:
        monkeypatch.setenv("FAKE_BASE_URL", url)
        wanted = forked(planned, whole)
        asked = account(url)
    luck, kills, forks = random.Random(7), 0, directory / FORKS
    command = ["branch", directory, "--at", ",".join(AT), "--connections", CONNECTIONS]
    with elsewhere(manner) as url:
        monkeypatch.setenv("FAKE_BASE_URL", url)
        branch = partial(start, *command)
        assert ended(branch, forks, luck, signal.SIGINT) == 130
        while kills < KILLS and ended(branch, forks, luck) == -signal.SIGKILL:
            kills += 1
            settled(url)
        assert kills == KILLS
        forked(planned, directory)
        seen = settled(url)
    assert {fork.key: fork for fork in load(forks)} == {fork.key: fork for fork in load(whole / FORKS)}
    assert {fork.key for fork in load(forks)} == {plan.key for plan in wanted.plans(SPEC)}
    assert len(replaced_records(forks)) == 0
    calls = [call for call in read_calls(forks) if call.reply is not None]
    assert set(Counter((call.key, call.step, call.turn) for call in calls).values()) == {1}
    assert seen["conversations"].keys() == asked["conversations"].keys()
    assert seen["arrived"] - len(calls) <= (1 + KILLS) * CONNECTIONS  # those on their way at a kill
    assert unanswered(forks) == []
    print(f"{kills} kills, {len(calls)} calls, {seen['arrived'] - len(calls)} on their way at a kill")
