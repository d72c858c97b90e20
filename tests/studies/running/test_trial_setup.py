"""One trial: its plant is made, looked at and closed; what breaks in making it is an error at the plant."""

import asyncio
import threading
from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest
from seen import PhotographedPlant

from lockprobe import run_trial
from lockprobe.agents.catalogue import resolve
from lockprobe.foundation.errors import BadValue, PlantFault
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.plants import catalogue
from lockprobe.plants.catalogue import PlantSource
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.running import trial_setup as play
from lockprobe.trial.condition import Condition
from lockprobe.trial.pictures.frame import Camera, Frame
from lockprobe.trial.record import Decision

HANDLES = np.array([[[0.1 * i - 0.15, -0.05, 0.05], [0.1 * i - 0.15, 0.05, 0.05]] for i in range(4)])
PANEL = np.diag([1.0, -1.0, -1.0, 1.0])
PANEL[2, 3] = 0.7
CAMERA = Camera(width=64, height=48, focal=60.0, panel=PANEL)


class Spots(PhotographedPlant):
    """A box whose pictures are a bright spot at each handle."""

    def __init__(self, box):
        super().__init__(box, sensed="moved")
        self.facts = {"renderer": "spots"}

    def picture(self, configuration):
        rgb, depth = np.zeros((48, 64, 3), np.uint8), np.full((48, 64), 0.7, np.float32)
        for handle, position in zip(HANDLES, configuration, strict=True):
            column, row = CAMERA.project(handle[int(position)])[:2].round().astype(int)
            rgb[row, column], depth[row, column] = 255, 0.65
        return Frame(rgb=rgb, depth=depth, camera=CAMERA, handles=HANDLES, renderer="spots")


class Eye:
    """Looks for each spot, and attempts what it has not moved yet, from the right."""

    facts: ClassVar = {}

    def __init__(self):
        self.seen = []

    async def decide(self, situation, rng):
        from lockprobe.trial.pictures.png import from_png

        percept = situation.percept
        assert percept.look is None
        assert percept.outcome is percept.positions is None
        image = from_png(percept.pictures[0].png)
        spots = [image[round(one[1]), round(one[0]), 0] > 128 for _, one in percept.handles]
        self.seen.append(spots)
        places = dict(zip(situation.task.joints, (place[0] for place in situation.task.places), strict=True))
        left = [joint for joint, there in zip(situation.task.joints, spots, strict=True) if not there]
        return Decision(joint=max(left, key=places.__getitem__))


@pytest.fixture
def plants(monkeypatch):
    made = []

    def resolve(spec):
        def make(box, labels, rng):
            made.append((Spots(box), labels, rng.random()))
            return made[-1][0]

        return PlantSource(spec=spec, picture_size=(640, 480), make=make)

    monkeypatch.setattr(catalogue, "resolve_plant", resolve)
    return made


def test_an_agent_that_looks_solves_the_box_from_pictures_alone(plants, tmp_path):
    eye = Eye()
    trial = run_trial(agent=eye, plant="fast-twin", modality="rgbd", pictures=tmp_path)
    assert trial.solved
    assert trial.actions == ("revolute-right", "slider-2", "slider-1", "revolute-left")
    assert [sum(spots) for spots in eye.seen] == [0, 1, 2, 3]
    assert all(step.told_moved == step.moved and step.told_state is None for step in trial.steps)
    assert trial.modality == "rgbd"
    assert trial.plant["renderer"] == "spots"
    named = [trial.opening_pictures, *(step.pictures for step in trial.steps)]
    assert all(list(names) == ["rgb", "depth", "depth16"] for names in named)
    kept = {path.name for path in tmp_path.iterdir()}
    assert kept == {name for names in named for name in names.values()}


def test_a_plant_is_made_of_the_trials_own_labels_and_luck_and_closed_once(plants):
    first, again, other = (run_trial(plant="fast-twin", trial=number) for number in (1, 1, 2))
    (one, labels, luck), (_, same_labels, same_luck), (_, _, other_luck) = plants
    assert one.closed == 1
    assert labels == same_labels == first.labels
    assert luck == same_luck != other_luck
    assert first == again != other


def test_a_plant_is_closed_when_the_trial_breaks(plants):
    class Broken:
        facts: ClassVar = {}

        async def decide(self, situation, rng):
            raise ValueError("no idea")

    assert run_trial(agent=Broken(), plant="fast-twin").error.boundary == "model"
    assert plants[0][0].closed == 1


@pytest.mark.parametrize("fault", [PlantFault("jammed"), ValueError("jammed")])
def test_a_plant_that_cannot_be_made_breaks_its_trial(monkeypatch, fault):
    def make(box, labels, rng):
        raise fault

    monkeypatch.setattr(
        catalogue, "resolve_plant", lambda spec: PlantSource(spec=spec, picture_size=(640, 480), make=make)
    )
    trial = run_trial(plant="fast-twin")
    assert (trial.ending, trial.error.boundary, trial.owed_again, trial.plant) == ("error", "plant", True, {})
    assert "jammed" in trial.error.message


def test_who_reads_reports_is_shown_no_pictures():
    with pytest.raises(
        BadValue, match="modality: got 'rgb', expected symbolic for human-inspired, which reads reports"
    ):
        run_trial(plant="fast-twin", modality="rgb")
    with pytest.raises(BadValue, match="expected a plant with a camera"):
        run_trial(agent="viewer", modality="rgb")


def test_a_simulated_box_gives_the_same_trial_as_the_rules():
    pytest.importorskip("mujoco")
    trial = run_trial(plant="fast-twin", p=0.4, seed=5)
    assert trial.plant["engine"].startswith("mujoco ")
    assert replace(trial, plant={}) == run_trial(p=0.4, seed=5)


def test_a_robot_without_nuisances_needs_the_steps_that_the_rules_give():
    pytest.importorskip("mujoco")
    trial, expected = run_trial(plant="twin", seed=1), run_trial(seed=1)
    assert [step.sensed["verdict"] == "moved" for step in trial.steps] == [step.moved for step in expected.steps]
    assert replace(trial, plant={}, steps=tuple(replace(step, sensed={}) for step in trial.steps)) == expected


@pytest.mark.parametrize("plant", ["fast-twin?looks=varied&depth_noise=0.002", "twin?pose_error=0.004&force_noise=0.3"])
def test_the_same_seed_gives_the_same_trial_pictures_included(plant, tmp_path):
    pytest.importorskip("mujoco")
    plant += "&width=160&height=120"
    one, other = (
        run_trial(agent="viewer", plant=plant, modality="rgbd", seed=3, max_steps=2, pictures=tmp_path / name)
        for name in ("one", "other")
    )
    assert one == other
    files = {name: (tmp_path / "one" / name).read_bytes() for name in one.picture_names}
    assert len(files) >= 6  # a blocked attempt may leave the picture as it was
    assert files == {path.name: path.read_bytes() for path in (tmp_path / "other").iterdir()}
    assert run_trial(agent="viewer", plant=plant, modality="rgbd", seed=4, max_steps=2) != one


def test_all_plants_of_a_run_act_in_one_thread_and_hold_nobody_up(monkeypatch):
    """An attempt ends only when somebody else has had a turn meanwhile."""
    threads, closed = set(), []

    class Slow(SymbolicPlant):
        def __init__(self, box):
            super().__init__(box)
            threads.add(threading.get_ident())

        def observe(self):
            threads.add(threading.get_ident())
            return super().observe()

        def attempt(self, joint):
            threads.add(threading.get_ident())
            turn = threading.Event()
            loop.call_soon_threadsafe(turn.set)
            assert turn.wait(10)
            return super().attempt(joint)

        def close(self):
            threads.add(threading.get_ident())
            closed.append(self)

    class InTurn:
        facts: ClassVar = {}

        async def decide(self, situation, rng):
            return Decision(joint=situation.task.joints[len(situation.past) % 4])

    def slow(spec):
        return PlantSource(spec=spec, make=lambda box, labels, rng: Slow(box))

    async def played():
        nonlocal loop
        loop = asyncio.get_running_loop()
        with play.own_thread() as place:
            planned = study(StudyOptions(agent=["random"], p=[0], trials=3))
            plans = list(planned.plans("random"))[:3]
            timed = (play.play_timed(plan, InTurn(), place=place) for plan in plans)
            return await asyncio.gather(*timed)

    loop = None
    monkeypatch.setattr(catalogue, "resolve_plant", slow)
    assert [trial.solved for trial, _ in asyncio.run(played())] == [True] * 3
    assert len(closed) == 3
    assert len(threads) == 1
    assert threads.isdisjoint({threading.get_ident()})


def test_a_run_that_is_ended_waits_for_what_a_plant_is_doing_and_then_closes_it(monkeypatch):
    course, begun, go_on = [], threading.Event(), threading.Event()

    class Slow(SymbolicPlant):
        def attempt(self, joint):
            begun.set()
            assert go_on.wait(10)
            course.append("attempted")
            return super().attempt(joint)

        def close(self):
            course.append("closed")

    class First:
        facts: ClassVar = {}

        async def decide(self, situation, rng):
            return Decision(joint=situation.task.joints[0])

    async def ended():
        planned = study(StudyOptions(agent=["random"], p=[0], trials=1))
        plan = planned.plan("random", planned.conditions[0], 1, 1)
        with play.own_thread() as place:
            task = asyncio.ensure_future(play.play_timed(plan, First(), place=place))
            assert await asyncio.to_thread(begun.wait, 10)
            task.cancel()
            await asyncio.sleep(0)
            go_on.set()
            with pytest.raises(asyncio.CancelledError):
                await task

    monkeypatch.setattr(
        catalogue, "resolve_plant", lambda spec: PlantSource(spec=spec, make=lambda box, labels, rng: Slow(box))
    )
    asyncio.run(ended())
    assert course == ["attempted", "closed"]


def test_equal_conditions_that_hold_other_interventions_are_not_taken_for_each_other():
    conditions = [Condition(interventions=(OutcomeFlip(p=p),)) for p in (0, 0.0)]
    assert conditions[0] == conditions[1]
    plan = next(study(StudyOptions(agent=["random"], p=[0.0])).plans("random"))
    plans, agent = [replace(plan, condition=one) for one in conditions * 2], resolve("random").make()
    trials = [asyncio.run(play.play_timed(one, agent))[0] for one in plans]
    assert [repr(trial.channels[0]["p"]) for trial in trials] == ["0", "0.0"] * 2
