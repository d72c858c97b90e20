"""The agents of known truth in benchmarks/ do what is said of them."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from benchmarked import benchmark
from fitted_trials import flip_trials

from lockprobe.simulation.fit.candidate_models import candidates_named
from lockprobe.simulation.fit.choices import choices_of, hear
from lockprobe.simulation.fit.model_comparison import compare_models
from lockprobe.trial.protocols import Agent
from lockprobe.trial.record import Decision, Percept, Situation, Task, Turn

KNOWN = benchmark("known_agents")
WORLDS, Favourites, FirstFour, Switching = KNOWN.WORLDS, KNOWN.Favourites, KNOWN.FirstFour, KNOWN.Switching

TASK = Task(joints=("C", "A", "D", "B"), target="D", budget=8)
DEAF = [
    name for name, world in WORLDS.items() if isinstance(world.agent, KNOWN.RuleAgent) and "reports" not in world.pulls
]


def after(*reports, outcome=None):
    """What an agent knows after attempts, each a label with ``+`` if it was reported to have moved."""
    percepts = [
        Percept(),
        *(Percept(joint=one[0], outcome=outcome or ("moved" if one[1:] else "blocked")) for one in reports),
    ]
    past = tuple(
        Turn(percept=percept, decision=Decision(joint=one[0])) for percept, one in zip(percepts, reports, strict=False)
    )
    return Situation(task=TASK, past=past, percept=percepts[-1])


def test_favourites_fall_from_the_first_label_or_place_to_the_last():
    falling = np.exp(-np.arange(4.0)) / np.exp(-np.arange(4.0)).sum()
    assert Favourites(by="place", pull=1.0).probabilities(after()) == pytest.approx(falling)
    assert Favourites(by="label", pull=1.0).probabilities(after()) == pytest.approx(falling[[2, 0, 3, 1]])
    assert Favourites(repeats=False).probabilities(after("A+")) == pytest.approx([1 / 3, 0, 1 / 3, 1 / 3])


def test_what_just_failed_is_left_by_so_much():
    agent = Favourites(failure=1.0)
    weights = agent.weights(after("A"))
    assert weights[1] == pytest.approx(np.exp(-1) * weights[0])
    assert agent.weights(after("A+")) == agent.weights(after("B", "A+")) == [1, 1, 1, 1]


def test_the_first_four_are_all_joints_once():
    agent = FirstFour(then="stays")
    assert agent.probabilities(after("A", "D")) == (0.5, 0, 0, 0.5)
    assert agent.probabilities(after("A", "D", "B", "C", "C")) == (1, 0, 0, 0)
    assert replace(agent, then="any").probabilities(after("A", "D", "B", "C")) == (0.25,) * 4
    trials = flip_trials(FirstFour(), p=(0.0, 0.5), repetitions=1, trials=5)
    assert all(len({step.joint for step in trial.steps[:4]}) == len(trial.steps[:4]) for trial in trials)


def test_rules_change_midway_or_by_a_coin():
    first, second = Favourites(by="place", pull=9.0), Favourites(repeats=False)
    switching = Switching(first=first, second=second)
    assert switching.probabilities(after("A", "B", "C")) == pytest.approx(first.probabilities(after()))
    assert switching.probabilities(after("A", "B", "C", "A")) == pytest.approx(second.probabilities(after("A")))
    either = replace(switching, when="any").probabilities(after("A"))
    assert either == pytest.approx(np.mean([first.probabilities(after()), second.probabilities(after("A"))], axis=0))


@pytest.mark.parametrize("name", DEAF)
def test_reports_change_nothing_where_none_is_said_to(name):
    agent, attempts = WORLDS[name].agent, ("A", "D", "B", "C", "B", "A")
    for steps in range(7):
        moved, failed = (after(*attempts[:steps], outcome=outcome) for outcome in ("moved", "blocked"))
        assert agent.probabilities(moved) == agent.probabilities(failed)


def test_nine_of_them_are_deaf_and_all_are_agents():
    assert len(DEAF) == 9
    assert all(isinstance(WORLDS[name].agent, Agent) for name in DEAF)


def test_choices_are_drawn_by_their_probabilities():
    trials = flip_trials(Favourites(by="label", pull=1.0), 3, p=(0.0,), repetitions=2, trials=15)
    chosen = Counter(step.decision.joint for trial in trials for step in trial.steps)
    shares = np.array([chosen[label] for label in "ABCD"]) / chosen.total()
    falling = np.exp(-np.arange(4.0)) / np.exp(-np.arange(4.0)).sum()
    assert shares == pytest.approx(falling, abs=4 * 0.5 / chosen.total() ** 0.5)


def test_favourites_alone_are_among_the_rivals():
    for by in ("label", "place"):
        trials = flip_trials(Favourites(by=by, pull=1.5), 2, p=(0.0, 0.3), repetitions=1)
        heard = [hear(trial) for trial in trials]
        held = compare_models(
            choices_of(trials, heard), heard, candidates_named(["favourite-labels", "favourite-places"])
        )
        assert held.best.rival.name == f"favourite-{by}s"
