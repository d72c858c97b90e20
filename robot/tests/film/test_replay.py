"""A film of a trial plays what was recorded, and says where it does not."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from lockprobe_robot.film.replay import film_trial, plan_of
from painted import PaintedPlant, painted_twins
from PIL import Image

from lockprobe import run_trial
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadFile, BadValue, PlantFault
from lockprobe.interventions.conditions import flips
from lockprobe.studies.study import Study
from lockprobe.trial.record import TrialError

AGENT = "human-inspired"


@pytest.fixture(autouse=True)
def made(monkeypatch):
    monkeypatch.setattr("lockprobe_robot.film.replay.STAND_IN", "fast-twin")
    return painted_twins(monkeypatch)


def played(plant="symbolic", **asked):
    study = Study(
        name="trial",
        agents=(AGENT,),
        boxes=(box("chain-4"),),
        conditions=flips((0.4,)),
        seed=3,
        repetitions=1,
        trials=1,
        plant=plant,
    )
    trial = run_trial(agent=AGENT, p=0.4, seed=3, plant=plant, **asked)
    return trial, plan_of(study, trial)


def frames(path):
    return [np.asarray(Image.open(one).convert("RGB")) for one in sorted(path.iterdir())]


@pytest.mark.parametrize("plant", ["symbolic", "fast-twin?width=240&height=180"])
def test_the_recorded_actions_are_played_with_the_trials_luck(plant, tmp_path, made):
    trial, plan = played(plant)
    said = []
    film = film_trial(trial, plan, tmp_path / "film", tell=said.append)
    assert film.differs is None
    assert film.plant == ("fast-twin" if plant == "symbolic" else plant)
    shown = frames(film.path)
    assert len(shown) == film.pictures == 1 + 2 * len(trial.steps)
    assert [one.shape for one in shown] == [(570, 640, 3)] * film.pictures
    assert said[-1] == f"step {len(trial.steps)} of {len(trial.steps)}, {film.pictures} pictures"
    assert [one.closed for one in made] == [1] * len(made)
    wood = plan.luck.physics().integers(80, 120, size=3)
    assert (abs(shown[0][478, 320].astype(int) - wood) <= 1).all()
    for at, step in enumerate(trial.steps):
        before, after = shown[2 * at + 1][:480], shown[2 * at + 2][:480]
        assert (before != after).any() == step.moved


def test_what_differs_from_the_record_is_said(tmp_path):
    trial, plan = played()
    wrong = replace(trial.steps[1], moved=not trial.steps[1].moved)
    other = replace(trial, steps=(trial.steps[0], wrong, *trial.steps[2:]))
    film = film_trial(other, plan, tmp_path / "film")
    assert film.differs.startswith("step 2 differs from the record: outcome ")
    assert film.pictures == 1 + 2 * len(trial.steps)
    first = next(at for at, step in enumerate(trial.steps) if step.moved)
    skipped = replace(trial, steps=trial.steps[first + 1 :])
    assert "configuration before it" in film_trial(skipped, plan, tmp_path / "other").differs
    robot = replace(trial.steps[0], sensed={"verdict": "moved"})  # a painted plant has no robot
    assert film_trial(replace(trial, steps=(robot,)), plan, tmp_path / "third").differs is None


@pytest.mark.parametrize("plant", ["twin?pose_error=0.002&force_noise=0.3", "symbolic"])
def test_an_arm_is_filmed_while_it_moves_also_where_a_trial_had_none(plant, tmp_path, monkeypatch):
    monkeypatch.setattr("lockprobe_robot.film.replay.STAND_IN", "twin")
    study = Study(
        name="trial", agents=(AGENT,), boxes=(box("chain-4"),), conditions=flips((0.0,)), repetitions=1, trials=1, max_steps=1,
        plant=plant,
    )  # fmt: skip
    trial = run_trial(agent=AGENT, max_steps=1, plant=study.plant)
    film = film_trial(trial, plan_of(study, trial), tmp_path / "film", speed=8)
    assert film.differs is None
    shown = frames(film.path)
    assert film.pictures > 5
    changes = [int((one[:420] != other[:420]).any(axis=-1).sum()) for one, other in pairwise(shown)]
    assert max(changes) > 2000  # the arm on its way
    assert (abs(shown[-1][:420].astype(int) - shown[0][:420]).max(axis=-1) > 40).sum() < 2000  # at home again
    assert (shown[1][420:] == shown[-1][420:]).all()  # what came of the step is said from its first picture on


class Breaking(PaintedPlant):
    def attempt(self, joint):
        raise PlantFault("it jams")


def test_a_trial_that_broke_is_filmed_up_to_there(tmp_path, monkeypatch):
    trial, plan = played()
    painted_twins(monkeypatch, Breaking)
    with pytest.raises(PlantFault, match="it jams"):
        film_trial(trial, plan, tmp_path / "a.gif")
    with Image.open(tmp_path / "a.gif") as gif:
        assert gif.n_frames == 2
    broken = replace(trial, ending="error", error=TrialError(boundary="plant", message="it jams", step=1))
    said = []
    assert film_trial(broken, plan, tmp_path / "a.gif", tell=said.append).pictures == 2
    assert said == ["it breaks as it did then: it jams"]


def test_a_trial_that_the_settings_do_not_describe_is_refused(tmp_path):
    trial, plan = played()
    for other in (replace(trial, key="trial/none"), replace(trial, labels=trial.labels[::-1])):
        study = Study(
            name="trial",
            agents=(AGENT,),
            boxes=(box("chain-4"),),
            conditions=flips((0.4,)),
            seed=3,
            repetitions=1,
            trials=1,
        )
        with pytest.raises(BadFile, match="its settings do not describe the trial"):
            plan_of(study, other)
    with pytest.raises(BadValue, match="speed: got 17, expected a whole number from 1 to 16"):
        film_trial(trial, plan, tmp_path / "a.gif", speed=17)
