"""Sources of reports: the truth, an arm's verdict, or a camera's reading; the truth decides all else."""

import asyncio
from dataclasses import replace

import pytest

from lockprobe.agents.catalogue import resolve
from lockprobe.boxes.box import bits
from lockprobe.boxes.families import box
from lockprobe.interventions.conditions import read_condition
from lockprobe.interventions.modality import interventions_for
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.trial.loop import play
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Decision
from lockprobe.trial.source import outcomes_by

CHAIN = box("chain-4")
TARGET, FIRST, SECOND, FREE = range(4)


class Sensing(SymbolicPlant):
    """The rules, with an arm and a camera that are right unless told otherwise, by the number of the attempt."""

    def __init__(self, verdicts=None, readings=None):
        super().__init__(CHAIN)
        self.attempts, self.verdicts, self.readings = 0, verdicts or {}, readings or {}

    def observe(self):
        seen = super().observe()
        return replace(seen, sensed={"camera": self.readings.get(0, bits(seen.configuration))})

    def attempt(self, joint):
        self.attempts += 1
        done = super().attempt(joint)
        sensed = {"verdict": done.outcome, "camera": bits(done.configuration)}
        if (verdict := self.verdicts.get(self.attempts)) is not None:
            sensed["verdict"] = verdict
        if (reading := self.readings.get(self.attempts)) is not None:
            sensed["camera"] = reading
        return replace(done, sensed=sensed)


class Doing:
    """Attempts joints one after the other, by place in panel order."""

    def __init__(self, *joints):
        self.joints, self.facts = joints, {}

    async def decide(self, situation, rng):
        return Decision(joint="ABCD"[self.joints[len(situation.past)]])


def played(condition, plant=None, agent=None, **more):
    plan = Plan(
        study="test", agent="random", box=CHAIN, condition=read_condition(condition),
        repetition=1, trial=1, seed=1, **more,
    )  # fmt: skip
    agent = agent or resolve("human-inspired").make()
    interventions = interventions_for(plan.condition)
    return asyncio.run(play(plan, plant=lambda: plant or Sensing(), interventions=interventions, agent=agent))


def done(condition, joints, **plant):
    return played(condition, Sensing(**plant), Doing(*joints), budget=len(joints), shuffle="never")


def told(trial):
    return [(step.told, step.told_moved, step.told_state) for step in trial.steps]


@pytest.mark.parametrize("condition", ["flip?p=0.4 + symbolic", "delay?lag=2 + symbolic?tell=state"])
def test_sources_without_error_tell_the_truth(condition):
    mark = "&" if "?tell" in condition else "?"
    without = played(condition)
    for source in ("truth", "verdict", "camera"):
        trial = played(f"{condition}{mark}source={source}")
        assert (trial.opening, told(trial)) == (without.opening, told(without))
        assert trial.changed == without.changed
        assert trial.opening_sensed == {"camera": "0000"}
        assert source == "truth" or outcomes_by(source, trial) == [step.moved for step in trial.steps]


def test_the_robot_counts_positions_from_its_verdicts_and_a_failed_one_is_no_move():
    """A wrong verdict stays in reports, and is turned round when the joint moves in truth."""
    trial = done("symbolic?source=verdict", (FIRST, FREE, FREE, FREE), verdicts={1: "moved", 2: "failed", 4: "blocked"})
    assert [step.moved for step in trial.steps] == [False, True, True, True]
    assert told(trial) == [
        ("B moved. At 1: B.", True, "0100"),
        ("D did not move. At 1: B.", False, "0100"),
        ("D moved. At 1: B, D.", True, "0101"),
        ("D did not move. At 1: B, D.", False, "0101"),
    ]
    assert [step.told_falsely for step in trial.steps] == [True, True, False, True]
    assert outcomes_by("verdict", trial) == [True, None, True, False]


def test_the_camera_says_what_it_reads_and_an_unclear_joint_keeps_its_last_position():
    readings = {0: "00?1", 1: "000?", 2: "0001", 3: "010?", 4: "0001"}
    trial = done("symbolic?source=camera", (FREE, FREE, TARGET, FREE), readings=readings)
    assert trial.opening == "At 1: D."
    assert [step.moved for step in trial.steps] == [True, True, False, True]
    assert told(trial) == [
        ("D did not move. At 1: D.", False, "0001"),
        ("D did not move. At 1: D.", False, "0001"),
        ("A did not move. At 1: B, D.", False, "0101"),
        ("D did not move. At 1: D.", False, "0001"),
    ]
    assert outcomes_by("camera", trial) == [None, False, False, False]


def test_the_truth_ends_a_trial_whatever_the_source_says():
    trial = done("symbolic?source=verdict", (FREE, SECOND, FIRST, TARGET), verdicts={4: "blocked"})
    assert (trial.ending, trial.steps[-1].told_moved) == ("solved", False)
    assert done("symbolic?source=verdict", (TARGET,), verdicts={1: "moved"}).ending == "budget"


@pytest.mark.parametrize(
    ("source", "message"),
    [("verdict", "the plant gave no verdict"), ("camera", "the camera gave no reading of 4 joints")],
)
def test_what_a_plant_does_not_give_breaks_the_trial(source, message):
    trial = played(f"symbolic?source={source}", SymbolicPlant(CHAIN))
    assert trial.error.boundary == "plant"
    assert message in trial.error.message
