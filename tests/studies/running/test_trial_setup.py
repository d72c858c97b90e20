"""One trial: its plant is made, looked at and closed; what breaks in making it is an error at the plant."""

import asyncio
import threading
from dataclasses import replace
from typing import ClassVar

import pytest
from seen import PhotographedPlant

from lockprobe import run_trial
from lockprobe.agents.catalogue import resolve
from lockprobe.foundation.errors import PlantFault
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.plants import catalogue
from lockprobe.plants.catalogue import PlantSource
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.running import trial_setup as play
from lockprobe.trial.condition import Condition
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


def test_equal_conditions_that_hold_other_interventions_are_not_taken_for_each_other():
    conditions = [Condition(interventions=(OutcomeFlip(p=p),)) for p in (0, 0.0)]
    assert conditions[0] == conditions[1]
    plan = next(study(StudyOptions(agent=["random"], p=[0.0])).plans("random"))
    plans, agent = [replace(plan, condition=one) for one in conditions * 2], resolve("random").make()
    trials = [asyncio.run(play.play_timed(one, agent))[0] for one in plans]
    assert [repr(trial.channels[0]["p"]) for trial in trials] == ["0", "0.0"] * 2
