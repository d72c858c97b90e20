"""Actions judged by an ideal observer: by hand, by identity and by enumeration."""

from dataclasses import replace

import pytest
from clumsy import HAND

from lockprobe import run_trial
from lockprobe.agents.ideal_observer import IdealObserver
from lockprobe.boxes.beliefs import begin, interlocks, noise_model, update
from lockprobe.boxes.families import box
from lockprobe.boxes.planning import best_joints
from lockprobe.statistics.rationality import optimal_actions, prior_for
from lockprobe.statistics.rules import Rules, unbroken
from lockprobe.testing import play_trials
from lockprobe.trial.record import STATES

FLIPS = ("re-observed", "integrated", "outcome-only")


def played(agent, n, p=0.0, **settings):
    return [run_trial(agent=agent, p=p, trial=i, seed=4, **settings) for i in range(1, n + 1)]


def counts(trials, *more):
    share, _ = optimal_actions(trials, *more)
    return share.count, share.n


@pytest.mark.parametrize("flip", FLIPS)
def test_an_ideal_observer_is_optimal_to_itself(flip):
    assert optimal_actions(played(IdealObserver(noise="naive"), 12, p=0.3, flip=flip))[0].value == 1


@pytest.mark.parametrize("condition", ["flip?p=0.4", "flip?p=0.4&others=kept", "flip?p=0.4&inverts=position"])
@pytest.mark.parametrize(("name", "modality"), [("chain-4", STATES), ("reset", "symbolic"), ("gray-code-5", STATES)])
def test_actions_are_judged_as_by_the_beliefs_of_an_observer_that_believes_every_report(condition, name, modality):
    trials = play_trials("random", 6, condition=condition, box=name, modality=modality)
    optimal = impossible = 0
    for trial in trials:
        numbers = {joint: i for i, joint in enumerate(dict.fromkeys((trial.target, *trial.actions, *trial.joints)))}
        belief = begin(interlocks(prior_for(len(trial.joints)), len(trial.joints)), noise_model("naive"))
        for step in trial.steps:
            optimal += best_joints(belief)[numbers[step.joint]]
            start = zip(trial.joints, step.told_state, trial.steps[0].state, strict=True)
            told = sum(1 << numbers[joint] for joint, at, was in start if at != was)
            if step is not trial.steps[-1] or not trial.solved:
                before, belief = belief, update(belief, numbers[step.joint], step.told_moved, told, trial.states_only)
                impossible += belief.told <= before.told
    assert counts(trials) == (optimal, sum(len(trial.steps) for trial in trials))
    assert optimal_actions(trials)[1] == (impossible > 0)


def test_actions_before_a_broken_rule_are_judged_and_none_after_it():
    trials = play_trials("random", 10, box="chain-3", plant=f"{HAND}?misses=1;3;5&forces=4")
    judged = Rules(box("chain-3")).judged
    firsts = [unbroken(trial, judged(trial)) for trial in trials]
    assert {0, 2} < {*firsts}
    cut = [
        replace(trial, steps=trial.steps[:first], ending="budget") for trial, first in zip(trials, firsts, strict=True)
    ]
    assert counts(trials, judged) == counts(cut)
    assert counts(cut)[1] == sum(firsts)
    assert not optimal_actions(trials, judged)[1]
    assert optimal_actions(trials)[1]  # what they were told of these attempts no interlock explains
