"""The exact course under a condition is the sum over every choice and all luck of the interventions themselves."""

import itertools
from math import prod

import numpy as np
import pytest
from scipy.stats import binomtest

from lockprobe.agents.cognitive import LoopBreaker, RandomMap, SoftmaxMemory
from lockprobe.agents.human_inspired import PRESETS, HumanInspired
from lockprobe.agents.policy import Policy, evenly
from lockprobe.agents.strategies import RandomAgent, RandomNoRepeat, RoundRobin
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.catalogue import interventions_of
from lockprobe.interventions.done import Force, Tremble
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.told import Drop, Phantom
from lockprobe.interventions.words import TextChannel
from lockprobe.simulation.exact import propagate
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.protocols import Channel
from lockprobe.trial.record import Decision, Moment, Percept, Situation, Task, Turn


class Loaded:
    """A stream that gives these numbers, one or several at a time."""

    def __init__(self, *numbers):
        self.numbers = numbers

    def random(self, size=None):
        return self.numbers[0] if size is None else np.array(self.numbers[:size])


def luck_of(one, joints):
    """Every way in which an intervention's draws of one step can turn out that makes a difference, and its chance."""
    if isinstance(one, OutcomeFlip | Drop):
        return [(Loaded(0.0), one.p), (Loaded(1 - 2**-53), 1 - one.p)]
    if isinstance(one, Tremble):
        slips = [(Loaded(0.0, (k + 0.5) / (joints - 1)), one.p / (joints - 1)) for k in range(joints - 1)]
        return [*slips, (Loaded(1 - 2**-53, 0.5), 1 - one.p)]
    if isinstance(one, Force):
        return [(Loaded((k + 0.5) / joints), 1 / joints) for k in range(joints)]
    raise AssertionError(one)


def shared_luck(ones, joints):
    """The same for interventions that have the luck of the flip: one number hits for all of them, one chooses."""
    edges = sorted({0.0, 1.0} | {one.p for one in ones})
    choices = joints - 1 if any(isinstance(one, Tremble | Phantom) for one in ones) else 1
    return [
        (Loaded((low + high) / 2, (k + 0.5) / choices), (high - low) / choices)
        for low, high in itertools.pairwise(edges)
        for k in range(choices)
    ]


def lucks(ones, joints):
    """For every way in which all draws of one step can turn out, a stream for each intervention, and the chance."""
    shared = [one for one in ones if getattr(one, "stream", "") == "channel"]
    alone = [one for one in ones if one not in shared]
    for common, chance in shared_luck(shared, joints):
        for luck in itertools.product(*(luck_of(one, joints) for one in alone)):
            streams = {id(one): common for one in shared}
            streams |= {id(one): stream for one, (stream, _) in zip(alone, luck, strict=True)}
            yield [streams[id(one)] for one in ones], chance * prod(share for _, share in luck)


def acted(ones, value, change, joints):
    """What becomes of a value, as each of the interventions changes it, and how probably."""
    for streams, chance in lucks(ones, joints):
        after = value
        for one, stream in zip(ones, streams, strict=True):
            after = change(one, after, stream)
        if chance:
            yield after, chance


def branches(policy, puzzle, ones, tell, left, situation, past, configuration):
    """Every way on: its probability, the step that solves the box (None: none), whether wrong positions were told."""
    if not left:
        yield 1.0, None, ()
        return
    task, joints = situation.task, len(situation.task.joints)
    hands, channels = ([one for one in ones if isinstance(one, Channel) == told] for told in (False, True))
    known = policy.recall(situation)
    for place, chosen in enumerate(policy.probabilities(known.view, known.memory)):
        if not chosen:
            continue
        label = task.joints[place]
        for attempted, slipped in acted(hands, label, lambda h, j, s: h.act(j, past, task, s), joints):
            after, moved = puzzle.attempt(configuration, int(attempted))
            if moved and int(attempted) == puzzle.target_index:
                yield chosen * slipped, len(past), ()
                continue
            truth = Percept(
                joint=attempted,
                outcome="moved" if moved else "blocked",
                positions=tuple(after[int(label)] for label in task.joints),
            )
            for told, luck in acted(channels, truth, lambda c, t, s: c.perceive(t, past, task, s), joints):
                turn = Turn(percept=situation.percept, decision=Decision(joint=label))
                read = TextChannel(tell=tell).perceive(told, past, task, Loaded(0.0))
                onward = Situation(task=task, past=(*situation.past, turn), percept=read)
                moments = (*past, Moment(was=truth, told=told, chosen=label, attempted=attempted))
                wrong = told.positions not in (None, truth.positions)
                for share, end, later in branches(policy, puzzle, ones, tell, left - 1, onward, moments, after):
                    yield chosen * slipped * luck * share, end, (wrong, *later)


def by_brute_force(policy, puzzle, spec, tell, budget):
    task = Task(
        joints=tuple(str(j) for j in range(len(puzzle.joints))),
        target=str(puzzle.target_index),
        budget=budget,
        places=tuple(joint.place for joint in puzzle.joints),
    )
    opening = Percept(positions=puzzle.initial)
    solved, apart = [0.0] * (budget + 1), [0.0] * (budget + 1)
    first = Percept() if tell == "outcome" else opening
    start, past = Situation(task=task, past=(), percept=first), (Moment(was=opening, told=opening),)
    ones = interventions_of(spec)
    for share, end, wrong in branches(policy, puzzle, ones, tell, budget, start, past, puzzle.initial):
        for step in range(end or budget + 1, budget + 1):
            solved[step] += share
        for step, differs in enumerate(wrong, 1):
            apart[step] += share * differs
    return solved, [part / max(1 - done, 1e-300) for part, done in zip(apart, solved, strict=True)]


class FirstBeliever(Policy):
    """The target after a move that the first statement of a report tells, else any joint that has not failed since."""

    def begin(self, view):
        return 0, False

    def remember(self, view, memory, told):
        moved = told.moved if told.corrects is None else told.corrects.moved
        return (0, True) if moved else (memory[0] | 1 << told.joint, False)

    def probabilities(self, view, memory):
        failed, due = memory
        open_ = [joint for joint in range(view.joints) if not failed >> joint & 1]
        return evenly([view.target] if due else open_ or range(view.joints), view)


POLICIES = [
    HumanInspired(lapse=0.1),
    SoftmaxMemory(target=0.4, closed=0.8, failure=2, decay=0.7, reset=0.4, recent=-0.6, stay=0.9, position=0.5),
    RandomMap(window=1, avoid="last", lapse=0.2),
    LoopBreaker(),
    FirstBeliever(),
]
KNOWN = (LoopBreaker, FirstBeliever)
CONDITIONS = [
    "tremble?p=0.3",
    "drop?p=0.4",
    "flip?p=0.3&only=moved",
    "flip?p=0.3&only=blocked&others=kept",
    "flip?p=0.3&from=2&until=3",
    "flip?p=0.3&at=1;3&others=kept",
    "flip?p=0.3&inverts=outcome",
    "flip?p=0.3&inverts=outcome&others=kept + drop?p=0.4",
    "force?at=2",
    "drop?p=0.2 + drop?p=0.3",
    "flip?p=0.3&others=kept + drop?p=0.4",
    "drop?p=0.4 + flip?p=0.3&others=kept",
    "tremble?p=0.2 + force?at=2 + flip?p=0.4&from=2",
    "correction?p=0.3",
    "correction?p=0.3&first=truth",
    "correction?p=0.3&first=truth&last=lie",
    "correction?p=0.3&last=lie",
    "correction?p=0.3&last=lie&others=kept",
    "correction?p=0.3&last=lie&inverts=position",
    "drop?p=0.3&luck=flip",
    "flip?p=0.4 + drop?p=0.3&luck=flip",
    "correction?p=0.3&last=lie + drop?p=0.2",
    "tremble?p=0.3&luck=flip",
]


ODD = ["flip?p=0.3&only=blocked&others=kept", "drop?p=0.2 + drop?p=0.3", *CONDITIONS[-7:]]
"""Conditions of agents that heed two statements or forms; they have a larger box."""

CASES = [
    pytest.param(policy, spec, id=f"{type(policy).__name__}-{spec}")
    for policy in POLICIES
    for spec in (ODD if isinstance(policy, KNOWN) else CONDITIONS)
]


PARTS = [
    "flip?p=0.3&part=outcome",
    "flip?p=0.3&part=position&inverts=position",
    "flip?p=0.3&part=position&others=kept&only=moved + drop?p=0.4",
]
"""One part of a false report, which needs reports of outcome and positions."""

READINGS = [f"flip?p=0.3{option}" for option in ("", "&others=kept")]
READINGS += [f"{one}&inverts=position" for one in READINGS]
STRATEGIES = [
    RandomAgent(),
    RandomNoRepeat(),
    RoundRobin(),
    *(HumanInspired(**settings) for settings in PRESETS.values()),
    HumanInspired(lapse=0.3),
    *POLICIES[1:3],
]


@pytest.mark.parametrize(
    ("policy", "spec", "tell"),
    [
        *(
            pytest.param(*case.values, tell, id=f"{case.id}-{tell}")
            for case in CASES
            for tell in ("both", "state")
            if tell == "both" or not isinstance(case.values[0], HumanInspired)
        ),
        *(pytest.param(one, spec, "both", id=f"{type(one).__name__}-{spec}") for one in POLICIES[:3] for spec in PARTS),
        *(
            (one, spec, tell)
            for one in STRATEGIES
            for spec, tell in [*itertools.product(READINGS, ["both"]), (READINGS[0], "outcome")]
        ),
    ],
)
def test_the_course_is_the_sum_over_every_choice_and_all_luck(policy, spec, tell):
    name, budget = ("chain-3", 3) if isinstance(policy, KNOWN) else ("chain-2", 3 if spec.count("+") > 1 else 4)
    if spec in READINGS:
        name = "chain-3"
    solved, apart = by_brute_force(policy, box(name), spec, tell, budget)
    modality = f"symbolic?tell={tell}"
    course = propagate(policy, name, condition=spec, modality=modality, max_steps=budget, listing="panel")
    assert course.solved == pytest.approx(solved, abs=1e-12)
    assert course.apart == (None if tell == "outcome" else pytest.approx(apart, abs=1e-12))


IN_THE_LOOP = [
    *itertools.product(
        ["human-inspired?lapse=0.1"],
        ["tremble?p=0.2 + drop?p=0.3", "flip?p=0.6&only=blocked&at=2;4;6 + force?at=5",
         "phantom?p=0.8 + drop?p=0.2&luck=flip", "flip?p=0.3&inverts=position&others=noisy&at=3;5;6"],
        ["symbolic", "symbolic?tell=state"],
    ),
    *itertools.product(
        ["cognitive:loop-breaker"],
        ["truth", "flip?p=0.4 + distract?p=0.4&luck=flip", "distract?p=0.4", "correction?p=0.4",
         "drop?p=0.4&luck=flip", "tremble?p=0.4&luck=flip"],
        ["symbolic?tell=state"],
    ),
]  # fmt: skip


@pytest.mark.parametrize(
    ("agent", "spec", "modality"),
    [pytest.param(*one, marks=[pytest.mark.slow] * (i % 3 > 0)) for i, one in enumerate(IN_THE_LOOP)],
)
def test_trials_of_the_loop_come_to_the_same(agent, spec, modality):
    asked = {"condition": spec, "modality": modality, "max_steps": 12}
    trials = [run_trial(agent=agent, **asked, trial=trial) for trial in range(1, 101)]
    exact = propagate(agent, **asked)
    for step in (8, 12):
        found = sum(trial.solved and len(trial.steps) <= step for trial in trials)
        assert binomtest(found, 100, exact.solved[step]).pvalue > 0.001
    assert 0.05 < exact.success < 1


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ({"modality": "rgb"}, "modality: got 'rgb'"),
        ({"modality": "symbolic?tell=state", "flip": "outcome-only"}, "flip: got 'outcome-only'"),
        ({"modality": "symbolic?source=camera"}, "modality: got .*, expected symbolic without source=camera"),
    ],
)
def test_what_shows_pictures_or_states_where_none_are_told_is_refused(given, named):
    with pytest.raises(BadValue, match=named):
        propagate(p=0.1, **given)


def test_what_may_remark_has_to_be_sampled_for_an_agent_that_heeds_remarks():
    with pytest.raises(BadValue, match="condition: got 'nudge', expected distract alone"):
        propagate(LoopBreaker(), condition="nudge")


@pytest.mark.parametrize(
    ("spec", "named"),
    [("delay?lag=1", "delay"), ("history?last=3", "history?last=3"), ("flip?p=0.2&while=looping", "flip?p=0.2&while"),
     ("yoked?p=0.2", "yoked")],
)  # fmt: skip
def test_what_has_to_be_sampled_is_refused_in_one_line(spec, named):
    with pytest.raises(BadValue) as refused:
        propagate(condition=spec)
    assert str(refused.value).startswith(f"condition: got '{named}")
    assert "sample others" in str(refused.value)


def test_reports_are_flipped_once():
    for given in (
        {"condition": "flip?p=0.2", "p": 0.1},
        {"condition": "flip?p=0.2 + flip?p=0.1"},
        {"condition": "flip?p=0.2&until=5 + flip?p=0.1&from=5"},
        {"condition": "flip?p=0.2&until=5 + flip?p=0.1&from=6&others=kept"},
    ):
        with pytest.raises(
            BadValue, match="one flip a step at most, several only without keep and of one reading, and none with p"
        ):
            propagate(**given)
