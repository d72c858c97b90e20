"""A film of a trial plays what was recorded, says where it does not, and plays up to where it was interrupted."""

import subprocess
import sys
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from builders import make_trial
from lockprobe_robot.film import make
from lockprobe_robot.film.caption import opening_lines, outcome_lines
from lockprobe_robot.film.make import make_film, plan_of
from mjcf_models import OWN, own_box
from painted import PaintedPlant, painted_twins
from PIL import Image

from lockprobe import run_trial
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadFile, PlantFault
from lockprobe.interventions.conditions import flips
from lockprobe.studies.study import Study
from lockprobe.trial.record import TrialError

AGENT = "human-inspired"


def test_captions_say_truth_beside_told_and_nothing_that_a_model_wrote():
    trial = make_trial([0, 3, 2], false_at=[2], claims=[None, "blocked", "moved"], hypothesis="HIDDEN", budget=3)
    told = [opening_lines(trial), *(outcome_lines(trial, at) for at in range(3))]
    assert "HIDDEN" not in str(told)
    assert [text for text, _ in told[2][1:]] == ["truth moved, told blocked", "the agent then says moved"]
    assert [any(alarming for _, alarming in lines) for lines in told] == [False, False, True, False]
    first = trial.steps[0]
    for change, said, alarming in (
        ({"sensed": {"verdict": "moved", "peak_force": 3.0}}, ", told blocked, robot says moved at 3 N", True),
        ({"pictures": {"rgb": f"{'0' * 20}.png"}}, "", False),
        ({"pictures": {"rgb": f"{'0' * 20}.png"}, "told_moved": True}, ", told moved", True),
        ({"sensed": {"verdict": "<anything else>"}}, ", told blocked", False),
    ):
        seen = outcome_lines(replace(trial, steps=(replace(first, **change),)), 0)[1]
        assert seen == (f"truth blocked{said}", alarming)


def test_a_film_whose_process_is_killed_plays_up_to_there(tmp_path):
    """Each picture as it was, for as long as it was to be held."""
    code = f"""
import os, signal
import numpy as np
from pathlib import Path
from lockprobe_robot.film.files import FilmFile
film = FilmFile(Path({str(tmp_path)!r}, "a.gif"))
for shade in range(60):
    painted = np.full((48, 64, 3), 128, np.uint8)
    painted[shade % 48] = (190, 30, 30)
    film.add(painted, 0.4 if shade else 1.2)
os.kill(os.getpid(), signal.SIGKILL)
"""
    assert subprocess.run([sys.executable, "-c", code]).returncode == -9
    with Image.open(tmp_path / "a.gif") as gif:
        assert (gif.size, gif.info["loop"], gif.n_frames >= 59) == ((64, 48), 0, True)
        for at, milliseconds in ((0, 1200), (58, 400)):
            gif.seek(at)
            assert gif.info["duration"] == milliseconds
            assert gif.convert("RGB").getpixel((3, at % 48)) == (190, 30, 30)


@pytest.fixture
def made(monkeypatch):
    monkeypatch.setattr(make, "STAND_IN", "fast-twin")
    return painted_twins(monkeypatch)


def played(monkeypatch, plant="symbolic", p=0.4, puzzle=None, **asked):
    puzzle = puzzle or box("chain-4")
    study = Study(
        name="trial", agents=(AGENT,), boxes=(puzzle,), conditions=flips((p,)), seed=3, repetitions=1, trials=1, plant=plant,
        **asked,
    )  # fmt: skip
    monkeypatch.setattr(make, "read_study", lambda directory: study)
    return run_trial(agent=AGENT, p=p, seed=3, plant=plant, box=puzzle, **asked), study


def filmed(trial, path, said=None):
    return make_film(path, trial, path, tell=(lambda line: None) if said is None else said.append)


def frames(path):
    with Image.open(path) as film:
        return [np.asarray((film.seek(i), film.convert("RGB"))[1]) for i in range(film.n_frames)]


@pytest.mark.parametrize("plant", ["symbolic", "fast-twin?width=240&height=180"])
def test_the_recorded_actions_are_played_with_the_trials_luck(plant, tmp_path, made, monkeypatch):
    trial, _ = played(monkeypatch, plant)
    film = filmed(trial, tmp_path / "a.gif", said := [])
    assert film.differs is None
    assert ("the film shows fast-twin" in film.note) == (plant == "symbolic")
    shown = frames(tmp_path / "a.gif")
    assert len(shown) == film.pictures == 1 + 2 * len(trial.steps)
    assert said[-1] == f"step {len(trial.steps)} of {len(trial.steps)}, {film.pictures} pictures"
    assert [one.closed for one in made] == [1] * len(made)
    for at, step in enumerate(trial.steps):
        before, after = shown[2 * at + 1][:480], shown[2 * at + 2][:480]
        assert (before != after).any() == step.moved


@pytest.mark.usefixtures("made")
def test_what_differs_from_the_record_is_said(tmp_path, monkeypatch):
    trial, study = played(monkeypatch)
    first = next(at for at, step in enumerate(trial.steps) if step.moved)
    skipped = replace(trial, steps=trial.steps[first + 1 :])
    assert "configuration before it" in filmed(skipped, tmp_path / "b.gif").differs
    with pytest.raises(BadFile, match="its settings do not describe the trial"):
        plan_of(study, replace(trial, labels=trial.labels[::-1]))


@pytest.mark.parametrize(("plant", "note"), [("symbolic", "shows twin in its place"), ("rig?rung=twin", "")])
def test_an_arm_is_filmed_while_it_moves_also_where_a_trial_had_none(plant, note, tmp_path, monkeypatch):
    """The arm of a rig moves in a thread of its own."""
    monkeypatch.setattr(make, "_SPEED", 15)
    trial, _ = played(monkeypatch, plant, p=0.0, max_steps=1)
    film = filmed(trial, tmp_path / "a.gif")
    assert (film.differs, note in film.note) == (None, True)
    shown = frames(tmp_path / "a.gif")
    assert film.pictures > 3
    changes = [int((one[:420] != other[:420]).any(axis=-1).sum()) for one, other in pairwise(shown)]
    assert max(changes) > 2000  # the arm on its way
    assert (abs(shown[-1][:420].astype(int) - shown[0][:420]).max(axis=-1) > 40).sum() < 2000  # at home again
    assert (shown[1][420:] == shown[-1][420:]).all()  # what came of the step is said from its first picture on


def test_a_film_of_a_users_model_says_that_it_shows_no_motion(tmp_path, monkeypatch):
    trial, _ = played(monkeypatch, f"twin?model={OWN}&width=96&height=72", puzzle=own_box(), max_steps=1)
    assert filmed(trial, tmp_path / "a.gif").note.startswith("A force pushed the model")


@pytest.mark.usefixtures("made")
def test_a_trial_that_broke_is_filmed_up_to_there(tmp_path, monkeypatch):
    class Breaking(PaintedPlant):
        def attempt(self, joint):
            raise PlantFault("it jams")

    trial, _ = played(monkeypatch)
    painted_twins(monkeypatch, Breaking)
    with pytest.raises(PlantFault, match="it jams"):
        filmed(trial, tmp_path / "a.gif")
    assert len(frames(tmp_path / "a.gif")) == 2
    broken = replace(trial, ending="error", error=TrialError(boundary="plant", message="it jams", step=1))
    assert filmed(broken, tmp_path / "b.gif").pictures == 2
