"""Learners as agents: what they choose is what the network gives, in the loop as in a batch."""

import numpy as np
import pytest

from lockprobe import run_trial
from lockprobe.agents.catalogue import resolve
from lockprobe.agents.learner import Learner
from lockprobe.agents.network.boxes import copies
from lockprobe.agents.network.network_file import shipped
from lockprobe.agents.network.training import play
from lockprobe.agents.policy import Told, View
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadFile, BadValue, UnknownName

VIEW = View(joints=4, target=2)


def test_a_greedy_learner_told_the_truth_plays_in_the_loop_as_in_a_batch():
    """chain-4 with its joints in every order: equal trials, step by step, wherever the order of the listing is equal."""
    agent = Learner(learned=shipped("apprentice"), temperature=0)
    dealt = copies(box("chain-4"), 60, np.random.default_rng(5))
    course = play(agent.learned.network, dealt, temperature=0)
    for row in range(60):
        view, state, chosen = View(joints=4, target=int(dealt.target[row])), 0, []
        memory = agent.begin(view)
        while len(chosen) < course.steps[row]:
            chances = agent.probabilities(view, memory)
            joint = chances.index(1.0)
            chosen.append(joint)
            moved = bool(dealt.may_move[row, state, joint])
            state ^= moved << joint
            memory = agent.remember(view, memory, Told(joint=joint, moved=moved, shifted=state))
        assert chosen == course.actions[row, : len(chosen)].tolist()


@pytest.mark.parametrize("p", [0.0, 0.4])
def test_trials_are_solved_as_often_as_in_a_batch(p):
    dealt = copies(box("chain-4"), 2000, np.random.default_rng(6))
    expected = play(shipped("novice").network, dealt, p=p, temperature=0).solved.mean()
    solved = [run_trial(agent="learner:novice?temperature=0", p=p, trial=i).solved for i in range(1, 151)]
    assert np.mean(solved) == pytest.approx(expected, abs=4 * (0.25 / 150 + 0.25 / 2000) ** 0.5)


def test_its_chances_and_its_origin_are_in_the_record():
    trial = run_trial(agent="learner:apprentice", p=0.4)
    assert all(sum(step.decision.probabilities) == pytest.approx(1) for step in trial.steps)
    assert trial.facts.items() >= {"updates": 5, "temperature": 1.0, "sha256": shipped("apprentice").sha256}.items()
    assert "lockprobe learn --updates 5" in trial.facts["training"]
    assert trial == run_trial(agent="learner:apprentice", p=0.4)


def test_the_temperature_flattens_its_chances():
    told = Told(joint=1, moved=True, shifted=0b10)
    found = []
    for temperature in (0, 0.5, 1, 1000):
        agent = Learner(learned=shipped("adept"), temperature=temperature)
        found.append(max(agent.probabilities(VIEW, agent.remember(VIEW, agent.begin(VIEW), told))))
    assert found[0] == 1
    assert found == sorted(found, reverse=True)
    assert found[-1] == pytest.approx(0.25, abs=0.01)


def test_without_positions_outcomes_count_and_without_a_report_it_knows_what_it_tried():
    agent = Learner(learned=shipped("adept"))
    begun = agent.begin(VIEW)
    told = agent.remember(VIEW, begun, Told(joint=1, moved=True))
    assert told == agent.remember(VIEW, begun, Told(joint=1, moved=True, shifted=0b10))
    assert told != agent.remember(VIEW, begun, Told(joint=1, moved=False))
    silent = agent.remember_silence(VIEW, begun, 1)
    assert (silent.opened, silent != begun) == (0, True)


def test_what_cannot_be_is_refused_in_one_line():
    for spec, error in (
        ("learner", UnknownName),
        ("learner:nobody.npz", BadFile),
        ("learner:novice?temperature=-1", BadValue),
        ("learner:novice?speed=1", UnknownName),
    ):
        with pytest.raises(error):
            resolve(spec)
    with pytest.raises(BadValue, match="lockprobe learn --joints 6 --out FILE"):
        run_trial(agent="learner:novice", box="chain-6")
