"""The viewer plays by what it reads from pictures, and by nothing else."""

import asyncio
from dataclasses import replace

import numpy as np
import pytest
from drawn_board import HANDLES, coloured
from mjcf_models import OWN, own_box

from lockprobe.agents import viewer
from lockprobe.agents.catalogue import resolve
from lockprobe.agents.strategies import HumanInspired, RandomAgent
from lockprobe.agents.viewer import Viewer
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.conditions import flips
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.loop import play
from lockprobe.trial.pictures import picture_reader
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.pictures.png import to_png
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Decision, Percept, Situation, Task, Turn

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
        positions = (*shown.values(), False)
        return replace(
            percept, outcome=None, positions=None, text="", pictures=(coloured(positions, 3),), handles=HANDLES[:4]
        )


def played(agent, channels, trial=1):
    plan = Plan(
        study="s",
        agent="",
        box=box(),
        condition=flips((0,), modalities=("rgb",))[0],
        repetition=1,
        trial=trial,
        seed=1,
    )
    return asyncio.run(play(plan, plant=SymbolicPlant(plan.box), interventions=channels, agent=agent))


@pytest.mark.parametrize(
    ("spec", "trial"), [(SPEC, 1), ("human-inspired:proximity?lapse=0.3", 2), ("ideal-observer?noise=naive", 1)]
)
def test_seeing_well_it_plays_as_its_strategy_does_that_is_told(spec, trial):
    told = run_trial(agent=spec, trial=trial)
    seen = played(resolve(f"viewer:{spec}{'&' if '?' in spec else '?'}acuity=80").make(), [Photographer()], trial)
    assert seen.actions == told.actions
    assert seen.solved
    assert [step.decision.claimed for step in seen.steps] == [None, *truth(seen)[:-1]]


def truth(trial):
    return ["moved" if step.moved else "blocked" for step in trial.steps]


def test_it_says_what_the_picture_shows_and_acts_on_it():
    """A picture that lies is believed: nothing of the truth reaches it by another way."""
    agent = Viewer(strategy=HumanInspired(), name=SPEC, acuity=80)
    honest, fooled = played(agent, [Photographer()]), played(agent, [Photographer(wrong=(1,))])
    assert fooled.steps[1].decision.claimed == ("blocked" if honest.steps[0].moved else "moved")
    assert fooled.actions != honest.actions


class Listener(RandomAgent):
    """A strategy that keeps what it was told."""

    async def decide(self, situation, rng):
        self.heard = [*(turn.percept for turn in situation.past), situation.percept]
        return Decision(joint="A", claimed=None)


@pytest.fixture
def heard(monkeypatch):
    """What a strategy hears of pictures that speak for positions as these numbers say, the claim, and what was read."""
    asked = []

    def listen(*numbers):
        def evidence(pictures, handles, acuity):
            asked.append(pictures)
            return numbers[int(pictures[0].png)]

        monkeypatch.setattr(picture_reader, "evidence", evidence)
        viewer._evidence.cache_clear()
        listener, past = Listener(), ()
        agent = Viewer(strategy=listener, name="listener", acuity=10, doubt=0.1)
        hidden = Picture(kind="depth16", png=b"measured", shown=False)
        for i in range(len(numbers)):
            pictures = (Picture(kind="rgb", png=str(i).encode()), hidden)
            percept = Percept(joint="A" if i else None, pictures=pictures, handles=HANDLES[:3])
            now = Situation(task=TASK, past=past, percept=percept)
            decision = asyncio.run(agent.decide(now, np.random.default_rng(1)))
            past = (*past, Turn(percept=percept, decision=Decision(joint="A")))
        return listener.heard, decision.claimed, asked

    yield listen
    viewer._evidence.cache_clear()


def test_each_picture_that_is_shown_is_read_once_and_readings_become_reports(heard):
    reports, claimed, asked = heard((-1, -1, 1), (-1, 1, 1), (1, 1, 1))
    assert [r.positions for r in reports] == [(False, False, True), (False, True, True), (True, True, True)]
    assert [r.outcome for r in reports] == [None, "moved", "blocked"]  # C changed, but A was attempted
    assert claimed == "blocked"
    assert all(r.pictures == () for r in reports)
    assert [[picture.png for picture in pictures] for pictures in asked] == [[b"0"], [b"1"], [b"2"]]


def test_in_doubt_a_joint_stays_as_it_was_last_read(heard):
    reports, _, _ = heard((-0.02, 0.02, 1), (0.09, -0.09, -0.09), (0.11, -0.11, -1), (0.01, 0.01, 0.01))
    expected = [(False, True, True), (False, True, True), (True, False, False), (True, False, False)]
    assert [r.positions for r in reports] == expected
    assert [r.outcome for r in reports] == [None, "blocked", "moved", "blocked"]


def test_the_record_says_how_it_saw_and_who_decided():
    facts = resolve("viewer:human-inspired:proximity?acuity=40&lapse=0.1").make().facts
    assert (facts["acuity"], facts["strategy"]) == (40, "human-inspired:proximity?lapse=0.1")
    assert (facts["nearest"], facts["lapse"]) == (True, 0.1)


def test_pictures_of_which_it_is_not_told_where_handles_are_are_refused():
    percept = Percept(text="", pictures=(coloured((0, 1, 0, 1, 1)),))
    with pytest.raises(BadValue, match="^observation of viewer: got '', expected pictures with the places of handles"):
        asyncio.run(resolve("viewer").make().decide(Situation(task=TASK, past=(), percept=percept), None))


@pytest.mark.parametrize("handle", [2, 6, 14])
def test_the_first_picture_says_how_many_pixels_are_needed(handle):
    """Handles of any size are read, and with no more pixels than it takes."""
    places = tuple(((40.0 + 90 * i, 60.0), (40.0 + 90 * i, 60.0 + 6 * handle)) for i in range(4))

    def shown(positions):
        image = np.full((240, 320, 3), (150, 110, 70), np.uint8)
        for pair, position in zip(places, positions, strict=True):
            column, row = map(int, pair[position])
            image[row - handle // 2 : row + handle // 2 + 1, column - handle // 2 : column + handle // 2 + 1] = (
                210,
                40,
                30,
            )
        return (Picture(kind="rgb", png=to_png(image)),)

    first = shown((False,) * 4)
    acuity = picture_reader.needed_acuity(first, places, 10)
    for number in range(16):
        positions = tuple(bool(number >> i & 1) for i in range(4))
        found = picture_reader.evidence(shown(positions), places, acuity=acuity)
        assert tuple(sign > 0 for sign in found) == positions
    assert acuity <= 10 or acuity * handle <= 3 * 320


def test_a_model_of_a_user_is_read_without_an_option():
    own = {"box": own_box(), "plant": f"twin?model={OWN}", "modality": "rgb", "p": 0, "seed": 1}
    trial = run_trial(agent="viewer:round-robin", max_steps=6, **own)
    claims = [step.decision.claimed for step in trial.steps[1:]]
    assert claims == ["moved" if step.moved else "blocked" for step in trial.steps[:-1]]
