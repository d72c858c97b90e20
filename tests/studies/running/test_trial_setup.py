"""One trial: its plant is made, looked at and closed; what breaks in making it is an error at the plant."""

import asyncio
import threading
from typing import ClassVar

import pytest
from seen import PhotographedPlant

from lockprobe import run_trial
from lockprobe.foundation.errors import PlantFault
from lockprobe.plants import catalogue
from lockprobe.plants.catalogue import PlantSource
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.running import trial_setup as play
from lockprobe.trial.record import Decision


@pytest.fixture
def plants(monkeypatch):
    made = []

    def resolve(spec):
        def make(box, labels, rng):
            made.append((PhotographedPlant(box), labels, rng.random()))
            return made[-1][0]

        return PlantSource(spec=spec, picture_size=(640, 480), make=make)

    monkeypatch.setattr(catalogue, "resolve_plant", resolve)
    return made


def test_a_plant_is_made_of_the_trials_own_labels_and_luck_and_closed_once(plants):
    first, again, other = (run_trial(plant="symbolic", trial=number) for number in (1, 1, 2))
    (one, labels, luck), (_, same_labels, same_luck), (_, _, other_luck) = plants
    assert one.closed == 1
    assert labels == same_labels == first.labels
    assert luck == same_luck != other_luck
    assert first == again != other


@pytest.mark.parametrize("fault", [PlantFault("jammed"), ValueError("jammed")])
def test_a_plant_that_cannot_be_made_breaks_its_trial(monkeypatch, fault):
    def make(box, labels, rng):
        raise fault

    monkeypatch.setattr(
        catalogue, "resolve_plant", lambda spec: PlantSource(spec=spec, picture_size=(640, 480), make=make)
    )
    trial = run_trial(plant="symbolic")
    assert (trial.ending, trial.error.boundary, trial.owed_again, trial.plant) == ("error", "plant", True, {})
    assert "jammed" in trial.error.message


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
        with play.plants_place(apart=True) as place:
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
