"""``lockprobe run modalities`` as users meet it: what is said before the first trial, and what is refused."""

import subprocess
import sys

import pytest
from builders import SOLUTION, make_trial

from lockprobe import load
from lockprobe.agents.catalogue import resolve
from lockprobe.cli.progress import Plain, Tally
from lockprobe.studies.journal import Journal
from lockprobe.studies.settings import read_study
from lockprobe.studies.studyfile import Request, study


def lockprobe(*arguments, **settings):
    return subprocess.run(
        [sys.executable, "-m", "lockprobe", *map(str, arguments)], capture_output=True, text=True, check=False, **settings
    )  # fmt: skip


def test_pictures_are_played_and_reported(tmp_path):
    pytest.importorskip("mujoco")
    arguments = ("run", "modalities", "--agent", "viewer", "--agent", "random", "--trials", 1, "--max-steps", 3,
                 "--plant", "fast-twin?width=320&height=240&renderer=rays", "--workers", 1, "--out", tmp_path)  # fmt: skip
    done = lockprobe(*arguments)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0] == (
        "Modality study on chain-4: shown as rgb, rgbd, symbolic; 1 repetition of 1 trial of 3 steps; "
        "agents viewer, random; seed 1"
    )
    assert lines[1].startswith("Plant: fast-twin?width=320&height=240&renderer=rays; pictures by rays (mujoco ")
    assert lines[2] == "Reports only, since they look at no pictures: random"
    assert any("viewer  3/3 trials · solved rgb: 0/1, rgbd: 0/1, symbolic: 0/1" in line for line in lines)
    trials = load(tmp_path)
    assert [trial.error for trial in trials] == [None] * 4
    assert {trial.plant["renderer"] is None for trial in trials if trial.modality == "symbolic"} == {True}
    assert {trial.plant["renderer"].split()[0] for trial in trials if trial.modality != "symbolic"} == {"rays"}
    assert (tmp_path / "report.html").read_text("utf-8").count("data:image/png;base64,") >= 6
    there = read_study(tmp_path)
    assert [there.asks_for(trial) for trial in trials] == [True] * there.size


def test_the_symbolic_plant_leaves_pictures_out_and_says_so(tmp_path, capsys):
    planned = study(Request(study="modalities", plant="symbolic", agent=["human-inspired"]))
    with Journal.open(tmp_path, planned) as journal:
        Plain().begin(planned, journal, planned.size)
    said = capsys.readouterr().out
    assert said.startswith("Modality study on chain-4: p = 0; 1 repetition of 10 trials of 20 steps;")
    assert "Plant: symbolic, which has no camera: pictures are left out (--plant fast-twin has one)" in said


def test_what_is_counted_names_modalities_or_p():
    tally = Tally()
    tally.turn(resolve("viewer"), 4, [], slow=True)
    for modality, joints in (("rgb", SOLUTION), ("rgb", [0] * 20), ("rgbd", SOLUTION)):
        tally.trial(make_trial(joints, agent="viewer", modality=modality, study="modalities"))
    assert "3/4 trials · solved rgb: 1/2, rgbd: 1/1" in tally.line()
    tally.turn(resolve("random"), 1, [make_trial(SOLUTION, p=0.4)], slow=False)
    assert "0/1 trials · solved p=0.4: 1/1" in tally.line()


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["--agent", "random", "--modality", "rgb"], "modality: got 'rgb', expected symbolic too for random"),
        (["--plant", "symbolic", "--modality", "rgbd"], "modality: got 'rgbd', expected a plant with a camera"),
        (["--p", "0,0.2"], "p: got [0.0, 0.2], expected 0 with rgb: a picture shows the truth"),
        (["--modality", "smell"], "no modality is called 'smell'; there are: symbolic, rgb, rgbd"),
        (["--plant", "fast-twin?colour=red"], "no option of fast-twin is called 'colour'; there are: mechanism"),
    ],
)
def test_what_cannot_be_shown_is_refused_in_one_line(tmp_path, arguments, line):
    done = lockprobe("run", "modalities", *arguments, cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert done.stderr.startswith("lockprobe: " + line)
    assert list(tmp_path.iterdir()) == []
