"""A study that stops when it is decided plays the same trials in whatever order they end, and wherever it is stopped."""

import random
from collections import Counter
from dataclasses import replace

import pytest

from lockprobe.studies.decisions import answers, broken_by_agent, counted, due, planned_now
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.merge import gather
from lockprobe.studies.records.read_records import load, replaced_records
from lockprobe.studies.running.runner import next_plans, run, run_study
from lockprobe.studies.study import EarlierSize, Shard
from lockprobe.trial.record import TrialError

AGENT = "round-robin"
CONDITIONS = ["tremble?p=1", "tremble?p=0.1"]
STUDY = study("flips", agent=AGENT, box="chain-3", max_steps=7, condition=CONDITIONS, until="decided", trials=40)
FIXED = replace(STUDY, until=None)


@pytest.fixture(scope="module")
def every(tmp_path_factory):
    """All trials of the fixed study, by key."""
    return {trial.key: trial for trial in run_study(FIXED, tmp_path_factory.mktemp("fixed"))}


@pytest.fixture(scope="module")
def stopped(tmp_path_factory):
    return {trial.key: trial for trial in run_study(STUDY, tmp_path_factory.mktemp("stopped"))}


def decided(planned, trials):
    return [(one.question.name, one.verdict, one.at) for one in answers(planned, AGENT, trials)]


def played(planned, every, luck, breaks=0.0):
    """Trials as they are played by runs that end anywhere, in which trials end in any order and some break."""
    there = {}
    while plans := due(planned, AGENT, there.values()):
        for plan in luck.sample(plans, luck.randint(1, len(plans))):
            trial = every[plan.key]
            if luck.random() < breaks:
                trial = replace(trial, error=TrialError(step=1, boundary="model", message="down"), ending="error")
            there[plan.key] = trial
    return there


def test_a_condition_that_is_decided_is_dropped_and_the_luck_of_the_others_stays(every, stopped):
    bought = Counter(trial.condition for trial in stopped.values())
    assert bought["tremble?p=1"] < bought["tremble?p=0.1"] == bought["truth"] < 40
    assert {key: every[key] for key in stopped} == stopped
    assert len(due(STUDY, AGENT, [])) == 3 * 5  # looks come after five blocks


@pytest.mark.parametrize("seed", range(2))
def test_neither_the_order_of_arrival_nor_interruptions_nor_faults_change_it(every, stopped, seed):
    there = played(STUDY, every, random.Random(seed), breaks=0.2 * (seed % 2))
    assert there == stopped
    assert decided(STUDY, there.values()) == decided(STUDY, stopped.values())


@pytest.mark.parametrize("seed", range(3))
def test_what_lies_behind_an_open_block_is_not_counted(every, seed):
    luck = random.Random(seed)
    before = EarlierSize(repetitions=2, trials=3, strategy_trials=None)
    planned = replace(FIXED, repetitions=3, trials=6, earlier=(before,))
    order = [(r, t) for r in (1, 2) for t in (1, 2, 3)]
    order += [(r, t) for r in (1, 2, 3) for t in range(1, 7) if (r, t) not in order]
    every = [
        replace(next(iter(every.values())), condition=label, repetition=r, trial=t)
        for label in ("truth", "tremble?p=1")
        for r, t in order
    ]
    there = [trial for trial in every if luck.random() < 0.9]
    luck.shuffle(there)
    expected = set()
    for label in ("truth", "tremble?p=1"):
        own = {(trial.repetition, trial.trial) for trial in there if trial.condition == label}
        first_open = next((i for i, block in enumerate(order) if block not in own), len(order))
        expected |= {(label, *block) for block in order[:first_open]}
    found = counted(planned, there)
    assert {(trial.condition, trial.repetition, trial.trial) for trial in found} == expected
    assert list(found) == [trial for trial in there if trial in found]


@pytest.mark.parametrize("planned", [STUDY, FIXED], ids=["stops", "fixed"])
@pytest.mark.parametrize("of", [1, 5])
def test_shards_are_parts_of_a_study_and_whole_blocks_of_one_that_stops(planned, of):
    parts = [replace(planned, shard=Shard(number=i, of=of)) for i in range(1, of + 1)]
    keys = [[plan.key for plan in part.plans(AGENT)] for part in parts]
    assert [len(own) for own in keys] == [part.size for part in parts]
    assert sorted(key for own in keys for key in own) == sorted(plan.key for plan in planned.plans(AGENT))
    assert {part.settings_hash for part in parts} == {planned.settings_hash}
    if planned.until:
        blocks = [{plan.trial for plan in part.plans(AGENT)} for part in parts]
        assert sum(map(len, blocks)) == planned.trials


def test_merged_parts_go_on_until_they_are_decided_together(tmp_path, every, stopped):
    for i in (1, 2):
        run_study(replace(STUDY, shard=Shard(number=i, of=2)), tmp_path / f"{i}")
        assert read_study(tmp_path / f"{i}").shard == Shard(number=i, of=2)
    gather(tmp_path / "both", [tmp_path / f"{i}" for i in (1, 2)])
    there = run_study(STUDY, tmp_path / "both")
    assert {trial.key for trial in there} >= stopped.keys()
    assert all(trial == every[trial.key] for trial in there)
    assert decided(STUDY, there) == decided(STUDY, stopped.values())
    assert read_study(tmp_path / "both").shard is None


FLAKY = """
from lockprobe.foundation.errors import ModelFault
from lockprobe.trial.record import Decision
class Agent:
    facts = {}
    broken = 0
    async def decide(self, situation, rng):
        if Agent.broken < 3 and len(situation.past) == 1 and rng.random() < 0.5:
            Agent.broken += 1
            raise ModelFault("down")
        return Decision(joint=situation.task.joints[len(situation.past) % len(situation.task.joints)])
class Down:
    facts = {}
    async def decide(self, situation, rng):
        raise ModelFault("down")
"""


def test_trials_that_broke_are_played_again_before_the_next_look_as_long_as_others_end(tmp_path, monkeypatch):
    (tmp_path / "flaky_until.py").write_text(FLAKY)
    monkeypatch.syspath_prepend(tmp_path)
    planned = study("flips", agent="python:flaky_until:Agent", box="chain-3", until="±30", p=[0, 0.4], trials=40)
    trials = run_study(planned, tmp_path / "d")
    assert len(replaced_records(tmp_path / "d")) == 3
    assert not any(trial.owed_again for trial in trials)
    assert due(planned, planned.agents[0], trials) == []
    down = study("flips", agent="python:flaky_until:Down", p=[0, 0.5], until="decided", trials=4)
    with Journal.open(tmp_path / "down", down) as journal:
        run(down, journal)
        assert len(journal.trials) == 8
        assert len(next_plans(down, journal)(down.agents[0])) == 8
    broken = load(tmp_path / "down")
    assert broken_by_agent(down, broken) == {down.agents[0]: 8}
    assert broken_by_agent(down, broken[1:]) == broken_by_agent(planned, trials) == {}
    sizes = planned_now(down, broken), planned_now(planned, trials), planned_now(FIXED, trials)
    assert sizes == (8, len(trials), FIXED.size)
    larger = replace(down, until=None, trials=9)
    broken += [
        replace(one, key=f"{one.key}0") for one in broken[:2]
    ]  # as many as a run plays before it gives an agent up
    assert (broken_by_agent(larger, broken), broken_by_agent(larger, broken[1:])) == ({down.agents[0]: 18}, {})
