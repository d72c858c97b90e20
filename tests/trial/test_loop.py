"""The closed loop: truth decides, what is told never leaks the truth, what breaks is attributed."""

import asyncio
import re
from dataclasses import dataclass, replace

import pytest
from seen import PhotographedPlant

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import Missing
from lockprobe.interventions.conditions import flips
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.words import TextChannel
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.trial.loop import play
from lockprobe.trial.model_call import Usage
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.plan import Fork, Plan
from lockprobe.trial.record import Decision, ForkName
from lockprobe.trial.trial_json import trial_from_json, trial_to_json

PLAN = Plan(
    study="test", agent="fake", box=box(), condition=flips((0.0,))[0],
    repetition=1, trial=1, seed=1,
)  # fmt: skip


class Fake:
    """Decides by a function of the situation."""

    def __init__(self, choose):
        self.choose = choose
        self.facts = {"fake": True}
        self.seen = []

    async def decide(self, situation, rng):
        self.seen.append(situation)
        return self.choose(situation)


def joint(i):
    return lambda situation: Decision(joint=situation.task.joints[i])


def played(agent, plan=PLAN, channels=(), plant=None):
    return asyncio.run(play(plan, plant=lambda: plant or SymbolicPlant(plan.box), interventions=channels, agent=agent))


SHOWN = replace(PLAN, shuffle="never", condition=flips((0.0,), modalities=("rgb",))[0])


@dataclass(frozen=True)
class Photograph:
    """The picture's first row, as bytes, instead of a report."""

    def perceive(self, percept, past, task, rng):
        png = percept.look().rgb[0, :4, 0].tobytes()
        pictures = (Picture(kind="rgb", png=png), Picture(kind="depth16", png=b"depth", shown=False))
        return replace(percept, outcome=None, positions=None, text="Look.", pictures=pictures)


@dataclass(frozen=True)
class OfAReport(Photograph):
    """The same, made of what interventions told."""

    def shown(self, percept):
        return percept.positions


@pytest.mark.parametrize("channel", [Photograph(), OfAReport()])
def test_pictures_are_kept_and_named_and_the_agent_gets_no_camera(channel):
    kept, told = {}, []
    agent = Fake(lambda situation: Decision(joint="DCBA"[len(situation.past)]))
    plant = PhotographedPlant(SHOWN.box, sensed="failed")
    trial = asyncio.run(
        play(
            SHOWN,
            plant=lambda: plant,
            interventions=(channel,),
            agent=agent,
            on_step=told.append,
            keep=lambda p: kept.update({p.name: p.png}),
        )
    )
    assert trial.solved
    assert tuple(told) == trial.steps
    assert kept[trial.opening_pictures["rgb"]] == bytes(4)
    assert [kept[step.pictures["rgb"]][::-1] for step in trial.steps] == [
        b"\xff" * i + bytes(4 - i) for i in (1, 2, 3, 4)
    ]
    assert all(kept[step.pictures["depth16"]] == b"depth" for step in trial.steps)
    assert {(step.told_moved, step.told_state) for step in trial.steps} == {(True, None)}
    assert plant.looks == 5
    assert all(situation.percept.look is None and situation.percept.outcome is None for situation in agent.seen)
    assert all(turn.percept.look is None for situation in agent.seen for turn in situation.past)
    assert trial.plant == {"plant": "symbolic", "robot": "made up"}
    assert trial_from_json(trial_to_json(trial)) == trial


def test_a_picture_that_cannot_be_taken_is_an_error_of_the_plant():
    class Dark(SymbolicPlant):
        def observe(self):
            return replace(super().observe(), look=lambda: 1 / 0)

    trial = played(Fake(joint(0)), SHOWN, (Photograph(),), Dark(SHOWN.box))
    assert (trial.error.boundary, trial.error.message) == ("plant", "ZeroDivisionError: division by zero")


def test_the_trial_ends_when_the_target_really_moves():
    shortest = replace(PLAN, shuffle="never")
    agent = Fake(lambda situation: Decision(joint="DCBA"[len(situation.past)]))
    trial = played(agent, shortest, (OutcomeFlip(p=1.0),))
    assert (trial.ending, len(trial.steps)) == ("solved", 4)
    assert [step.moved for step in trial.steps] == [True] * 4
    assert [step.told_moved for step in trial.steps] == [False] * 4
    assert [step.state for step in trial.steps] == ["0000", "0001", "0011", "0111"]


@pytest.mark.parametrize("tell", ["both", "state"])
def test_the_agent_sees_what_is_told_and_never_the_truth(tell):
    agent = Fake(lambda situation: Decision(joint=situation.task.joints[len(situation.past) % 4]))
    trial = played(
        agent, replace(PLAN, condition=flips((0.5,))[0], trial=2), (OutcomeFlip(p=0.5), TextChannel(tell=tell))
    )
    assert any(step.moved != step.told_moved for step in trial.steps)
    for situation, step in zip(agent.seen[1:], trial.steps, strict=False):
        assert (situation.outcome == "moved") == step.told_moved
        told = dict(zip(situation.task.joints, situation.percept.positions, strict=True))
        assert "".join(str(int(told[label])) for label in trial.labels) == step.told_state
        assert situation.percept.text == step.told
    assert set(agent.seen[0].task.joints) == set("ABCD")
    assert not any(name in str(agent.seen) for name in box().names)


@pytest.mark.parametrize(("part", "boundary"), [("agent", "model"), ("plant", "plant")])
def test_facts_that_no_record_can_hold_are_an_error_of_whose_they_are_but_what_broke_first_is_said(part, boundary):
    plant, agent = SymbolicPlant(box()), Fake(joint(0))
    (plant if part == "plant" else agent).facts = "no mapping"
    assert played(agent, plant=plant).error.boundary == boundary
    agent.choose = lambda situation: None
    assert played(agent, plant=plant).error.boundary == "reply"


def broken_at(boundary, error):
    """A trial in which this part raises an error."""

    def choose(situation):
        raise error

    class Plant(SymbolicPlant):
        def attempt(self, joint):
            raise error

    @dataclass(frozen=True)
    class Channel:
        def perceive(self, percept, past, task, rng):
            raise error

    return {
        "model": lambda: played(Fake(choose)),
        "channel": lambda: played(Fake(joint(0)), channels=(Channel(),)),
        "plant": lambda: played(Fake(joint(0)), plant=Plant(box())),
    }[boundary]()


class Mute(Exception):
    """Breaks when it is printed."""

    def __str__(self):
        raise ValueError


@pytest.mark.parametrize("boundary", ["model", "channel", "plant"])
@pytest.mark.parametrize(
    "error",
    [
        ValueError("no"), SystemExit("no"), BaseException("no"), BaseExceptionGroup("no", [OSError()]), Mute(),
        asyncio.CancelledError("no"),  # the task goes on, so this is an error of theirs
    ],
)  # fmt: skip
def test_anybody_s_error_is_attributed_and_never_a_failure_to_solve(boundary, error):
    trial = broken_at(boundary, error)
    where = r"in the agent \(test_loop.py, line \d+\): " if boundary == "model" else ""
    assert re.match(f"{where}{type(error).__name__}({'$' if isinstance(error, Mute) else ': no'})", trial.error.message)
    assert (trial.ending, trial.solved, trial.error.boundary) == ("error", False, boundary)
    assert trial.owed_again
    assert trial_from_json(trial_to_json(trial)) == trial


@pytest.mark.parametrize("boundary", ["model", "channel", "plant"])
@pytest.mark.parametrize("error", [Missing("key", "set it"), KeyboardInterrupt(), GeneratorExit()])
def test_a_users_mistake_and_the_end_of_the_run_are_not_swallowed(boundary, error):
    with pytest.raises(type(error)) as caught:
        broken_at(boundary, error)
    assert caught.value is error


def test_the_end_of_the_task_is_no_error():
    class Cancelled(Fake):
        async def decide(self, situation, rng):
            asyncio.current_task().cancel()
            await asyncio.sleep(0)

    with pytest.raises(asyncio.CancelledError):
        played(Cancelled(joint(0)))


class Returning:
    """An intervention that returns a value at its place, here after the words were made."""

    def __init__(self, place, value):
        setattr(self, place, lambda given, *others: value(given))


class Odd(SymbolicPlant):
    """Says another configuration than there is."""

    def __init__(self, configuration):
        super().__init__(box())
        self.configuration = configuration

    def attempt(self, joint):
        return replace(super().attempt(joint), configuration=self.configuration)


@pytest.mark.parametrize(
    ("settings", "boundary", "message"),
    [
        ({"perceive": lambda told: replace(told, text="\ud800")}, "channel", "UnicodeEncodeError"),
        ({"perceive": lambda told: replace(told, positions=(True,))}, "channel", "positions (True,) are not one"),
        ({"perceive": lambda told: replace(told, positions=(0, 1, 2, 0))}, "channel", "positions (0, 1, 2, 0) are not"),
        ({"perceive": lambda told: replace(told, joint="Z")}, "channel", "'Z' is not a joint"),
        ({"brief": lambda asked: asked.remarking("\ud800")}, "channel", "UnicodeEncodeError"),
        ({"brief": lambda asked: None}, "channel", "AttributeError"),
        ({"recall": lambda turns: None}, "channel", "recall returned NoneType, and no tuple of turns"),
        ({"act": lambda chosen: "Z"}, "channel", "'Z' is not a joint"),
        ((True, True), "plant", "2 positions of 4 joints"),
        ((True,) * 5, "plant", "5 positions of 4 joints"),
        ((0, 1, 2, 0), "plant", "IndexError"),
    ],
)
def test_what_no_record_can_hold_is_an_error_of_the_part_that_made_it(settings, boundary, message):
    if isinstance(settings, dict):
        channels = (TextChannel(), *(Returning(*one) for one in settings.items()))
        trial = played(Fake(joint(0)), channels=channels)
    else:
        trial = played(Fake(joint(0)), plant=Odd(settings))
    assert (trial.ending, trial.error.boundary) == ("error", boundary)
    assert trial.error.message.startswith(message)
    assert trial_from_json(trial_to_json(trial)) == trial


@pytest.mark.parametrize(
    ("decision", "message"),
    [
        (None, "decide returned None; return Decision(joint=…)"),
        (1, "decide returned 1; return Decision(joint=…)"),
        (["A"], "decide returned an object of type list; return Decision(joint=…)"),
        (Decision(joint="Z", replies=("Z!",)), "its decision: got 'Z', expected one of A, D, C, B"),
        (Decision(joint="A", claimed="banana"), "its claimed: got 'banana', expected one of moved, blocked, None"),
        (Decision(joint="A", probabilities=(float("nan"),) * 4), "its probabilities.0 cannot be written"),
        (Decision(joint="A", probabilities=0.5), "its probabilities cannot be written (Input should be a valid array"),
        (Decision(joint="A", probabilities=(1.0,)), "its probabilities: got (1.0,), expected 4 numbers"),
        (Decision(joint="A", claim_probability=1.5), "its claim_probability cannot be written (Input should be less"),
        (Decision(joint="A", hypothesis="\ud800"), "it cannot be written"),
        (Decision(joint="A", replies=None), "its replies cannot be written (Input should be a valid array)"),
        (Decision(joint="A", usage=Usage(calls=-1)), "its usage.calls cannot be written (Input should be greater"),
    ],
)
def test_a_decision_that_cannot_be_written_down_ends_the_trial_and_poisons_no_journal(decision, message):
    trial = played(Fake(lambda situation: decision))
    assert trial.error.boundary == "reply"
    assert trial.error.message.startswith(message)
    assert not trial.owed_again
    assert trial_from_json(trial_to_json(trial)) == trial


def forked(agent, choose=None, recorded=3, at=4, **name):
    """A trial of five steps, and the fork of its first ones; the agent then chooses otherwise, if that is given."""
    plan = replace(PLAN, budget=5)
    steps = played(agent, plan).steps
    agent.seen, agent.choose = [], choose or agent.choose
    fork = Fork(
        name=ForkName(parent=plan.key, at=at, arm="truth", **name),
        condition=plan.label,
        acting=(),
        recorded=steps[:recorded],
    )
    return steps, played(agent, replace(plan, fork=fork))


def by_luck(situation):
    return Decision(joint=situation.task.joints[len(situation.past) % 2])


def test_a_fork_asks_nothing_that_is_on_record_and_an_agent_with_a_stream_again():
    agent = Fake(by_luck)
    steps, again = forked(agent)
    assert (again.steps, len(agent.seen)) == (steps, 5)
    agent.unseeded = True
    steps, again = forked(agent)
    assert (again.steps, len(agent.seen)) == (steps, 2)


def test_a_past_that_cannot_be_replayed_breaks_the_fork():
    _, other = forked(Fake(by_luck), joint(3))
    assert other.error.message == "step 1 cannot be replayed from the record without asking the agent again"
    assert other.owed_again
    assert forked(Fake(by_luck), joint(3), at=1)[1].error is None


@pytest.mark.parametrize(
    ("lies", "truthful", "false"), [(False, False, [1, 3, 4, 5]), (False, True, [1]), (True, True, [1, 2])]
)
def test_an_arm_acts_on_the_true_report_in_place_of_the_condition(lies, truthful, false):
    always, agent, plan = OutcomeFlip(p=1.0), Fake(joint(0)), replace(PLAN, budget=5)
    fork = Fork(
        name=ForkName(parent=plan.key, at=2, arm="lie" if lies else "truth", truthful=truthful),
        condition=plan.label,
        acting=(OutcomeFlip(p=1.0, at=(2,)),) if lies else (),
        recorded=played(agent, plan, (always,)).steps,
    )
    again = played(agent, replace(plan, fork=fork), (always, *fork.acting))
    assert [step.step for step in again.steps if step.told_falsely] == false


def test_another_continuation_has_another_luck_after_the_fork_alone():
    class Drawing(Fake):
        async def decide(self, situation, rng):
            return Decision(joint=situation.task.joints[int(rng.random() * 4)])

    (steps, same), *others = (forked(Drawing(None), at=3, time=time) for time in range(1, 5))
    assert same.steps == steps
    for _, other in others:
        assert (other.steps[:3], other.error) == (steps[:3], None)
    assert len({str(other.steps) for _, other in others}) > 1


def test_what_is_remembered_and_asked_has_the_luck_of_the_report_before():
    heard = []

    class Listening:
        def recall(self, turns, past, task, rng):
            heard.append((len(past), rng.random()))
            return turns

    played(Fake(joint(0)), channels=(Listening(),))
    assert heard == [(step, PLAN.luck.at("Listening-0", step - 1).random()) for step in range(1, len(heard) + 1)]
