"""The viewer plays by what it reads from pictures, and by nothing else."""

import asyncio
from dataclasses import replace

import numpy as np
import pytest
from drawn_board import HANDLES, coloured

from lockprobe.agents.catalogue import resolve
from lockprobe.agents.strategies import HumanInspired
from lockprobe.agents.viewer import Viewer
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.conditions import flips
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.loop import play
from lockprobe.trial.pictures import picture_reader
from lockprobe.trial.pictures.frame import to_png
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Percept, Situation, Task

TASK = Task(joints=("C", "A", "B"), target="B", budget=20)
SPEC = "human-inspired:target-first"


class Photographer:
    """A channel that draws the box as it is; or, in the steps that are named, with the attempted joint as it was not."""

    def __init__(self, wrong=()):
        self.wrong, self.step = wrong, 0

    def perceive(self, percept, past, task, rng):
        shown = dict(zip(task.joints, percept.positions, strict=True))
        if self.step in self.wrong:
            shown[percept.joint] ^= True
        self.step += 1
        pictures = (coloured((*shown.values(), False), 3),)
        return replace(percept, outcome=None, positions=None, text="", pictures=pictures, handles=HANDLES[:4])


def played(agent, channels, trial=1):
    shown = flips((0,), modalities=("rgb",))[0]
    plan = Plan(study="s", agent="", box=box(), condition=shown, repetition=1, trial=trial, seed=1, budget=5)
    return asyncio.run(play(plan, plant=lambda: SymbolicPlant(plan.box), interventions=channels, agent=agent))


def test_seeing_well_it_plays_as_its_strategy_does_that_is_told():
    told = run_trial(agent="human-inspired:proximity?lapse=0.3", trial=2, max_steps=5)
    seen = played(resolve("viewer:human-inspired:proximity?lapse=0.3&acuity=80").make(), [Photographer()], 2)
    assert seen.actions == told.actions
    assert len({step.told_moved for step in told.steps}) == 2
    truth = ["moved" if step.moved else "blocked" for step in seen.steps]
    assert [step.decision.claimed for step in seen.steps] == [None, *truth[:-1]]


def test_it_says_what_the_picture_shows_and_acts_on_it():
    """A picture that lies is believed: nothing of the truth reaches it by another way."""
    agent = Viewer(strategy=HumanInspired(), name=SPEC, acuity=80)
    honest, fooled = played(agent, [Photographer()]), played(agent, [Photographer(wrong=(1,))])
    assert fooled.steps[1].decision.claimed == ("blocked" if honest.steps[0].moved else "moved")
    assert fooled.actions != honest.actions


def test_readings_become_reports_and_in_doubt_a_joint_stays_as_it_was_last_read(monkeypatch):
    """Of each moment the pictures that are shown are read; numbers say what they speak for."""
    numbers = [(-0.02, 0.02, 1), (0.04, -0.04, -0.04), (0.06, -0.06, -1), (0.01, 0.01, 0.01)]
    monkeypatch.setattr(picture_reader, "evidence", lambda shown, handles, acuity: numbers[int(shown[-1].png)])
    hidden, percepts = Picture(kind="depth16", png=b"measured", shown=False), []
    for i in range(4):
        pictures = (Picture(kind="rgb", png=str(i).encode()), hidden)
        percepts.append(Percept(joint="A" if i else None, pictures=pictures, handles=HANDLES[:3]))
    reports = Viewer(HumanInspired(), SPEC, acuity=10).reports(TASK, percepts)
    expected = [(False, True, True), (False, True, True), (True, False, False), (True, False, False)]
    assert [r.positions for r in reports] == expected
    assert [r.outcome for r in reports] == [None, "blocked", "moved", "blocked"]  # of A, which was attempted
    assert all(r.pictures == () for r in reports)


def test_pictures_of_which_it_is_not_told_where_handles_are_are_refused():
    percept = Percept(text="", pictures=(coloured((0, 1, 0, 1, 1)),))
    with pytest.raises(BadValue, match="^observation of viewer: got '', expected pictures with the places of handles"):
        asyncio.run(resolve("viewer").make().decide(Situation(task=TASK, past=(), percept=percept), None))


@pytest.mark.parametrize("handle", [2, 14])
def test_handles_of_any_size_are_read_with_no_more_pixels_than_it_takes(handle):
    places = tuple(((40.0 + 90 * i, 60.0), (40.0 + 90 * i, 60.0 + 6 * handle)) for i in range(4))
    acuity = 0
    for number in range(16):
        image = np.full((240, 320, 3), (150, 110, 70), np.uint8)
        for i, pair in enumerate(places):
            column, row = (int(at) - handle // 2 for at in pair[number >> i & 1])
            image[row : row + handle + 1, column : column + handle + 1] = (210, 40, 30)
        shown = (Picture(kind="rgb", png=to_png(image)),)
        acuity = acuity or picture_reader.needed_acuity(shown, places, 10)
        found = picture_reader.evidence(shown, places, acuity=acuity)
        assert [sign > 0 for sign in found] == [bool(number >> i & 1) for i in range(4)]
    assert acuity <= 10 or acuity * handle <= 3 * 320
