"""``lockprobe learn``: a file that plays, what it can do in words and as JSON, refusals in one line."""

import json
import shlex

import pytest
from forked import run

from lockprobe.agents.network.network_file import load, shipped


def test_a_learner_is_trained_written_and_plays(tmp_path):
    file = tmp_path / "two.npz"
    done = run(["learn", "--updates", "2", "--out", file])
    assert (done.returncode, load(file).sha256) == (0, shipped("novice").sha256)
    first, told, play = done.stdout.splitlines()
    assert first.startswith(f"{file}: 2 updates in ")
    assert told.startswith("Told the truth, it opens 56 % of 10000 boxes that it has never seen within 20 steps")
    played = run(
        ["run", "flips", "--agent", shlex.split(play)[-1], "--p", "0", "--trials", "2", "--repetitions", "1",
         "--no-report", "--out", tmp_path / "study"]
    )  # fmt: skip
    assert played.returncode == 0, played.stderr


def test_machines_are_told_all_of_it(tmp_path):
    done = run(["learn", "--updates", "1", "--box", "chain-5", "--hidden", "8", "--told-lies", "--json",
                "--out", tmp_path / "one.npz"])  # fmt: skip
    found = json.loads(done.stdout)
    assert (found["updates"], found["joints"], found["hidden"], found["box"]) == (1, 5, 8, "chain-5")
    assert found["told_lies"]
    assert set(found["success"]) == {"greedy", "sampled"}


@pytest.mark.parametrize(
    "wrong",
    [
        ["--updates", "0"],
        ["--joints", "9"],
        ["--hidden", "0"],
        ["--box", "nowhere"],
        ["--out", "/nowhere/at/all.npz"],
        ["--out", "."],
    ],
)
def test_what_cannot_be_is_refused_in_one_line(tmp_path, wrong):
    done = run(["learn", "--out", tmp_path / "x.npz", *wrong])
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 1)
    assert not (tmp_path / "x.npz").exists()
