"""``lockprobe run`` in a directory that holds a study: what its size becomes, and what is refused."""

import json

import pytest

from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import load

ASKED = ("run", "flips", "--no-report", "--out", "d")


@pytest.fixture(autouse=True)
def here(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)


def test_a_study_grows_and_stays_as_large_as_it_is(lockprobe):
    rates = ("--p", "0,0.4")
    assert lockprobe(*ASKED, *rates, "--agent", "random", "--repetitions", 1, "--trials", 3)[0] == 0
    assert lockprobe(*ASKED, *rates, "--trials", 5, "--repetitions", 1, "--estimate")[0] == 0
    assert lockprobe(*ASKED, *rates, "--trials", 5, "--repetitions", 1)[0] == 0
    assert len(load("d")) == 10
    before = read_study("d")
    status, said, err = lockprobe(*ASKED, *rates)
    assert (status, err) == (0, "")
    assert "10 of 10 trials are done already; 0 are owed" in said
    assert (read_study("d"), read_study("d").earlier) == (before, before.earlier)
    status, _, said = lockprobe(*ASKED, *rates, "--trials", 3, "--repetitions", 1)
    assert (status, len(said.splitlines())) == (2, 1)
    assert "(trials is 5 there, 3 asked): repeat its settings to resume it, or give another --out" in said
    assert lockprobe(*ASKED, *rates, "--until", "decided", "--most", 8)[0] == 0
    assert lockprobe(*ASKED, *rates)[0] == 0
    assert str(read_study("d").until) == "decided"
    assert lockprobe("verify", "d")[0] == 0


@pytest.mark.parametrize(
    ("arguments", "refused"),
    [
        (["--until", "soon"], "until: got 'soon', expected decided, ±10"),
        (["--until", "60"], "until: got '60', expected decided, ±10 or another number of points, from 1 to 50"),
        (["--until", "decided", "--most", "0"], "most: got 0, expected a whole number from 1"),
        (["--most", "5"], "most: got 5, expected --until with it"),
        (["--until", "decided", "--trials", "5"], "trials: got 5, expected none with --until decided; --most says"),
        (["--until", "decided", "--repetitions", "2"], "repetitions: got 2, expected none with --until decided"),
        (["--until", "decided", "--full"], "full: got True, expected none with --until decided; --most says"),
        (["--until", "decided", "--agent", "participant"], "until: got 'decided', expected none with people"),
    ],
)
def test_mistakes_are_one_line(lockprobe, tmp_path, arguments, refused):
    arguments = arguments if "--agent" in arguments else [*arguments, "--agent", "random"]
    status, _, said = lockprobe(*ASKED, *arguments)
    assert (status, len(said.splitlines())) == (2, 1)
    assert refused in said
    assert not (tmp_path / "d").exists()


def test_a_file_and_the_set_up_of_the_paper_can_stop_early(lockprobe, tmp_path):
    (tmp_path / "u.toml").write_text(
        'study = "flips"\nagent = ["random"]\np = [0, 0.4]\nuntil = "decided"\nmost = 10\n'
    )
    assert lockprobe("run", "u.toml", "--no-report", "--out", "d")[0] == 0
    assert (str(read_study("d").until), read_study("d").trials) == ("decided", 10)
    assert "got 20, expected none with --until decided" in lockprobe("run", "u.toml", "--trials", 20)[2]
    asked = ("--as-paper", "--until", "±30", "--agent", "random", "--p", "0,0.4", "--most", 5)
    assert lockprobe("run", "flips", *asked, "--no-report", "--out", "paper")[0] == 0
    assert json.loads((tmp_path / "paper" / "study.json").read_text())["until"] == {"rule": "width", "points": 0.3}
