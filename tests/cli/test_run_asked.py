"""What ``lockprobe run`` is asked, in a directory that holds a study or holds none, and what the other commands say of it."""

import json
import re
from contextlib import nullcontext

import pytest

from lockprobe.foundation.workers import Cluster
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import load

ASKED = ("run", "flips", "--no-report", "--out", "d")
SMALL = (*ASKED, "--agent", "random", "--trials", 2, "--repetitions", 1)
RATES = ("--p", "0,0.4")


@pytest.fixture(autouse=True)
def here(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)


def test_a_study_grows_and_stays_as_large_as_it_is(lockprobe):
    assert lockprobe(*ASKED, *RATES, "--agent", "random", "--repetitions", 1, "--trials", 3)[0] == 0
    assert lockprobe(*ASKED, *RATES, "--trials", 5, "--repetitions", 1, "--estimate")[0] == 0
    assert lockprobe(*ASKED, *RATES, "--trials", 5, "--repetitions", 1)[0] == 0
    assert len(load("d")) == 10
    before = read_study("d")
    status, said, err = lockprobe(*ASKED, *RATES)
    assert (status, err) == (0, "")
    assert "10 of 10 trials are done already; 0 are owed" in said
    assert (read_study("d"), read_study("d").earlier) == (before, before.earlier)
    status, _, said = lockprobe(*ASKED, *RATES, "--trials", 3, "--repetitions", 1)
    assert (status, len(said.splitlines())) == (2, 1)
    assert "(trials is 5 there, 3 asked): repeat its settings to resume it, or give another --out" in said
    assert lockprobe(*ASKED, *RATES, "--until", "decided", "--trials", 8)[0] == 0
    assert lockprobe(*ASKED, *RATES)[0] == 0
    assert str(read_study("d").until) == "decided"
    assert lockprobe("verify", "d")[0] == 0


def test_a_file_and_the_set_up_of_the_paper_can_stop_early(lockprobe, tmp_path):
    (tmp_path / "u.toml").write_text('agent = ["random"]\np = [0, 0.4]\nuntil = "decided"\ntrials = 5\n')
    assert lockprobe("run", "u.toml", "--trials", 10, "--no-report", "--out", "d")[0] == 0
    assert (str(read_study("d").until), read_study("d").trials) == ("decided", 10)
    (tmp_path / "v.toml").write_text('agent = ["random", "python:\\u001b[31m:Red"]\np = [0]\ntrials = 1\n')
    other = lockprobe("run", "v.toml", "--agent", "round-robin", "--no-report", "--out", "other")
    assert (other[0], other[2]) == (0, "--agent replaces the agents of v.toml: random, python:?[31m:Red\n")
    asked = ("--as-paper", "--until", "±30", "--agent", "random", "--p", "0,0.4", "--trials", 5)
    assert lockprobe("run", "flips", *asked, "--no-report", "--out", "paper")[0] == 0
    assert json.loads((tmp_path / "paper" / "study.json").read_text())["until"] == {"rule": "width", "points": 0.3}


def test_conditions_are_played_beside_the_truth_and_resumed(lockprobe):
    acting = ("--condition", "told twice=flip?p=0.4 + nudge", "--sweep", "tremble?p=0,0.2", "--condition", "own=truth")
    status, said, _ = lockprobe(*SMALL, *acting)
    assert status == 0
    assert "Study flips on chain-4: 3 conditions: own; told twice; tremble?p=0.2" in said
    assert "6 of 6 trials are done already" in lockprobe(*SMALL, *acting)[1]
    (mine,) = {(one.specs, tuple(one.doses.items())) for one in load("d") if one.condition == "told twice"}
    assert mine == (("flip?p=0.4", "nudge"), (("flip.p", 0.4),))
    header = lockprobe("export", "d")[1].splitlines()[0].split(",")
    assert header[4] == "condition"
    assert lockprobe("replay", "d", "flips/random/tremble?p=0.2/rep=1/trial=1")[1].startswith("flips/random/tremble")


def test_a_run_until_it_is_decided_and_its_status_say_what_is(lockprobe):
    asked = ("run", "flips", "--agent", "careful=human-inspired", "--p", "0,0.9", "--trials", "40", *ASKED[2:])
    status, said, _ = lockprobe(*asked, "--until", "decided")
    assert status == 0
    said = said.splitlines()
    (first,) = [line for line in said if line.startswith("1 of 1 difference between conditions decided")]
    (each,) = [line for line in said if line.startswith("  careful, flip?p=0.9: an effect (block ")]
    assert first.endswith("of at most 80 trials")
    assert "until decided, at most 40 trials per condition, looking after every 5 blocks, of 20 steps" in said[0]
    status = lockprobe("status", "d")[1]
    assert f"decided     {first}" in status
    assert each.strip() in status
    facts = json.loads(lockprobe("status", "d", "--json")[1])
    (one,) = facts["decided"]
    value = f"{100 * one['value']:+.0f}".replace("-", "\N{MINUS SIGN}")
    assert f"); {value} points, " in each
    assert re.search("points, .?[0-9]+ in the first half of the blocks and .?[0-9]+ in the second$", each)
    assert (one["agent"], one["difference"], one["verdict"]) == ("careful", "flip?p=0.9", "effect")
    assert one["block"] <= one["blocks"] < 40
    assert facts["done"] == facts["trials"] == 2 * one["blocks"]
    lines = lockprobe(*asked, "--until", "decided", "--json")[1].splitlines()
    (event,) = [one for line in lines if (one := json.loads(line))["event"] == "decided"]
    assert event["message"].startswith("1 of 1 difference between conditions decided")
    assert event["answers"][0]["verdict"] == "effect"


def test_hashes_are_said_around_the_trials_and_known_again(lockprobe, tmp_path):
    def hashes(text):
        return dict(re.findall(r"^(Settings|Results): ([0-9a-f]{32}) ", text, re.MULTILINE))

    lines = lockprobe(*SMALL[:2], *SMALL[3:], *RATES)[1].splitlines()
    said = hashes("\n".join(lines))
    order = [
        next(i for i, line in enumerate(lines) if line.startswith(start)) for start in ("Settings", "random", "Res")
    ]
    assert order == sorted(order)
    assert json.loads(lockprobe("status", "d", "--json")[1])["settings_hash"] == said["Settings"]
    assert said["Settings"] in lockprobe("status", "d")[1]
    assert all(found in (tmp_path / "d" / "report.html").read_text("utf-8") for found in said.values())
    status, told, _ = lockprobe("verify", "d", "--settings", said["Settings"], "--results", said["Results"])
    assert (status, f"these results have the hash {said['Results']}" in told) == (0, True)
    status, told, _ = lockprobe("verify", "d", "--settings", said["Results"])
    assert status == 1
    assert f"FAILS  settings hash  these settings have the hash {said['Settings']}, not {said['Results']}\n" in told
    assert hashes(lockprobe(*SMALL, *RATES, "--estimate")[2]) == {"Settings": said["Settings"]}


def test_shards_that_are_joined_are_the_study_byte_for_byte(lockprobe):
    agents = ("--agent", "human-inspired", "--agent", "random")
    asked = ("run", "flips", *agents, "--p", "0,0.4", "--trials", "3", "--no-report")
    for number in (1, 2, 3):
        status, _, _ = lockprobe(*asked, "--shard", f"{number}/3", "--out", f"part-{number}")
        assert status == 0
        played = len(load(f"part-{number}"))
        assert read_study(f"part-{number}").size == played < 36
        assert lockprobe(*asked, "--shard", f"{number}/3", "--out", f"part-{number}")[0] == 0
        assert len(load(f"part-{number}")) == played
    lockprobe("import", "joined", "part-1", "part-2", "part-3")
    lockprobe(*asked, "--out", "whole")
    of = ("--table", "records", "--format", "jsonl")
    joined, whole = (lockprobe("export", name, *of)[1] for name in ("joined", "whole"))
    assert joined == whole
    assert whole.count("\n") == 36


class Here:
    """A cluster that is this process."""

    def processors(self):
        return 2

    def __init__(self):
        self.played = 0

    def each(self, begin, jobs):
        work = begin()
        for self.played, job in enumerate(jobs, 1):
            yield job, work(job)


def test_a_study_is_played_on_a_cluster_and_an_estimate_needs_none(lockprobe, monkeypatch):
    connected, cluster = [], Here()
    monkeypatch.setattr(Cluster, "connect", lambda address: (connected.append(address), nullcontext(cluster))[1])
    conditions = ("--condition", "tremble?p=0.2", "--condition", "nudge")  # which the kernel does not know
    asked = ("run", "flips", "--agent", "human-inspired", *conditions, "--trials", "2", "--no-report", "--out")
    status, _, told = lockprobe(*asked, "there", "--cluster", "head:6399")
    assert (status, connected) == (0, ["head:6399"])
    assert cluster.played > 0
    assert told.startswith("Cluster: 2 processors\n")
    assert lockprobe(*asked, "here")[0] == 0
    here, there = (lockprobe("export", name, "--table", "records", "--format", "jsonl") for name in ("here", "there"))
    assert here == there
    assert lockprobe(*asked, "S", "--cluster", "auto", "--estimate")[0] == 0
    assert connected == ["head:6399"]
