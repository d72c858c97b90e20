"""The ideal observer: exact figures, equal choices among equals, what it says, and what it refuses."""

import asyncio
from collections import Counter

import numpy as np
import pytest

from lockprobe import run_trial
from lockprobe.agents.ideal_observer import IdealObserver
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.foundation.spec import with_options
from lockprobe.simulation.exact import propagate
from lockprobe.trial.record import Decision, Percept, Situation, Task, Turn

NAIVE = IdealObserver(noise="naive")


def decide(agent, situation, seed=1):
    return asyncio.run(agent.decide(situation, np.random.default_rng(seed)))


def start(target="B", joints=("C", "B", "A", "D")):
    return Situation(
        task=Task(joints=joints, target=target, budget=20), past=(), percept=Percept(positions=(False,) * len(joints))
    )


@pytest.mark.parametrize(
    ("options", "steps", "by_80", "last"),
    [
        ({"prior": "chains", "noise": "naive"}, 5.5, 6, 7),
        ({"prior": "single-parent", "noise": "naive"}, 8.5, 9, 10),
        ({"prior": "single-parent", "noise": "naive", "plan": "information"}, 95 / 12, 8, 10),
        ({}, 25 / 3, 9, 10),
    ],
)
def test_steps_to_solve_the_papers_chain_when_told_the_truth(options, steps, by_80, last):
    course = propagate(with_options(IdealObserver, "ideal-observer", options), listing="panel")
    assert course.steps == pytest.approx(steps)
    assert (course.by(0.8), course.by(1)) == (by_80, last)


@pytest.mark.parametrize("flip", ["re-observed", "integrated", "outcome-only"])
def test_one_who_knows_that_reports_may_be_false_always_solves_the_box(flip):
    """Whatever can be reported at some flip rate can be reported at 0.5; tests/test_quoted_numbers.py has 0.2 to 0.6."""
    course = propagate(IdealObserver(), p=0.5, flip=flip, listing="panel")
    assert course.by(1) <= 16
    assert course.steps < 9.7


@pytest.mark.parametrize("flip", ["re-observed", "integrated", "outcome-only"])
def test_false_reports_hurt_one_who_believes_them(flip):
    found = [propagate(NAIVE, p=p, flip=flip, listing="panel") for p in (0, 0.2, 0.6)]
    steps = [course.steps for course in found]
    assert steps == sorted(steps)
    if flip != "re-observed":
        assert [round(course.success, 2) for course in found] == {
            "integrated": [1.0, 0.71, 0.34], "outcome-only": [1.0, 0.71, 0.33],
        }[flip]  # fmt: skip


def test_played_trials_follow_the_exact_course():
    trials = [run_trial(agent=IdealObserver(prior="chains", noise="naive"), trial=i, seed=3) for i in range(1, 121)]
    steps = Counter(len(trial.steps) for trial in trials)
    assert all(trial.solved for trial in trials)
    for length, share in {4: 1 / 6, 5: 1 / 3, 6: 1 / 3, 7: 1 / 6}.items():
        assert abs(steps[length] / 120 - share) < 4 * (share * (1 - share) / 120) ** 0.5


def test_one_number_is_drawn_per_decision():
    rng, fresh = np.random.default_rng(1), np.random.default_rng(1)
    asyncio.run(NAIVE.decide(start(), rng))
    fresh.random()
    assert rng.random() == fresh.random()


def told(*attempts, joints=("C", "B", "A", "D")):
    """A situation after attempts: label, moved as told, positions as told."""
    first = start(joints=joints)
    past, percept = [], first.percept
    for label, moved, positions in attempts:
        past.append(Turn(percept=percept, decision=Decision(joint=label)))
        percept = Percept(
            joint=label, outcome="moved" if moved else "blocked", positions=tuple(bit == "1" for bit in positions)
        )
    return Situation(task=first.task, past=tuple(past), percept=percept)


def test_it_says_what_it_thinks_its_action_did():
    """It knows better where the box says otherwise: a target that moved would have ended the trial."""
    said = told(("B", True, "0100"))
    assert decide(IdealObserver(), said).claimed == "blocked"
    assert decide(IdealObserver(), start()).claimed is None
    assert decide(NAIVE, told(("C", True, "1000"))).claimed == "moved"
    assert decide(NAIVE, told(("C", False, "0000"))).claimed == "blocked"


def test_a_report_believed_always_false_is_turned_round():
    assert decide(IdealObserver(noise="1"), told(("C", False, "0000"))).claimed == "moved"
    even = decide(IdealObserver(noise="0.5", prior="chains"), told(("C", True, "1000"))).claimed
    assert even == "blocked"  # one chain of three frees this joint, and the report says nothing


def test_it_keeps_nothing_between_calls():
    agent, first, second = IdealObserver(), told(("C", True, "1000")), told(("A", False, "0000"), ("D", True, "0001"))
    alone = [decide(IdealObserver(), situation) for situation in (first, second)]
    for _ in range(2):
        assert [decide(agent, situation) for situation in (first, second)] == alone


def test_what_it_is_stands_in_the_record():
    trial = run_trial(agent="ideal-observer?prior=chains&plan=information", seed=1)
    assert trial.facts == {"prior": "chains", "noise": "aware", "plan": "information", "reading": "outcomes"}
    assert trial.steps[0].decision.probabilities is not None


@pytest.mark.parametrize(
    ("options", "kind", "said"),
    [
        ({"prior": "chain"}, UnknownName, "no prior is called 'chain' .did you mean 'chains'"),
        ({"priors": "chains"}, UnknownName, "no option of ideal-observer is called 'priors'"),
        ({"noise": "2"}, BadValue, "noise: got '2'"),
        ({"plan": "best"}, BadValue, "plan: got 'best', expected one of steps, information"),
        ({"reading": "outcome-only"}, BadValue, "reading: got 'outcome-only'"),
    ],
)
def test_options_that_do_not_exist_are_refused(options, kind, said):
    with pytest.raises(kind, match=said):
        with_options(IdealObserver, "ideal-observer", options)


def test_a_box_too_large_for_its_plan_is_refused_at_the_first_step():
    with pytest.raises(BadValue, match="720 interlocks of prior chains over 7 joints.*plan=information"):
        run_trial(agent=IdealObserver(prior="chains", noise="naive"), box="chain-7")
    with pytest.raises(BadValue, match="prior single-parent over 6 joints: got '46656 interlocks'"):
        run_trial(agent=IdealObserver(), box="chain-6")
    assert run_trial(agent=IdealObserver(prior="chains", noise="naive", plan="information"), box="chain-7").solved
    assert run_trial(agent=IdealObserver(prior="chains"), box=box("chain-6")).solved
