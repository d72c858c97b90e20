"""Studies to draw."""

from dataclasses import replace

import numpy as np
import pytest
from builders import make_trial, play_study, played_by_people, small_study
from matplotlib.figure import Figure

from lockprobe.analysis import habit_baseline, rationality
from lockprobe.analysis.summary import summarise
from lockprobe.audit.simulate import simulate
from lockprobe.audit.simulated_agents import WORLDS, Design
from lockprobe.lockbox.families import box

P7 = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
REFERENCES = ("random", "round-robin", "human-inspired")


def simulated(world, name, seed):
    """A study of the paper's size by a simulated agent, under a model's name and on chain-4."""
    names = dict(zip("ABCD", box("chain-4").names, strict=True))
    return [
        replace(
            trial,
            agent=name,
            box="chain-4",
            joints=tuple(names.values()),
            target=names[trial.target],
            steps=tuple(replace(step, joint=names[step.joint]) for step in trial.steps),
        )
        for trial in simulate(WORLDS[world], Design(), np.random.default_rng(seed))
    ]


def references():
    """The baselines over all p, in a study of the paper's size."""
    return play_study(small_study(REFERENCES, P7, 3, 10))


def one_model():
    """A model that loops do not matter to."""
    return simulated("loops-irrelevant", "llm:openai/gpt-4o-2024-08-06", 1)


def rivals():
    """Strategies under the names of models, for people to be compared with."""
    played = play_study(small_study(("ideal-observer", "random-no-repeat", "random"), PEOPLE.p, 2, 5))
    return [replace(trial, agent=f"llm:{trial.agent}") if trial.agent != "random" else trial for trial in played]


def unsolved(*p):
    """Two trials of a model at each p that end with the budget."""
    return [make_trial([0] * 20, agent="llm:x", p=one, trial=i) for one in p for i in (1, 2)]


PEOPLE = small_study(("participant",), (0.0, 0.2, 0.4, 0.6), 2, 5)
HOSTILE = ("llm:$\\frac{", "python:" + "mx" * 100, "_hidden\n<script>", "llm:\u4e2d\u0e01")
LONG = [f"cognitive:random-map?window={window}&avoid=failed&lapse=0.1" for window in (1, 2)]
STUDIES = {
    "typical": lambda had: one_model() + had(references),
    "three": lambda had: (
        one_model()
        + simulated("loop-trapped", "llm:anthropic/claude-x", 2)
        + simulated("saturating", "llm:local", 3)
        + had(references)
    ),
    "strategies": lambda had: play_study(small_study(("random", "random-no-repeat", *REFERENCES[1:]), P7, 2, 5)),
    "many p": lambda had: play_study(small_study(("human-inspired", "random"), [i / 20 for i in range(11)], 2, 3)),
    "thirty p": lambda had: play_study(small_study(("human-inspired", "random"), [i / 29 for i in range(30)], 1, 2)),
    "one p": lambda had: [trial for trial in one_model() + had(references) if trial.p == 0.0],
    "one trial": lambda had: [trial for trial in one_model() if trial.repetition == trial.trial == 1],
    "three trials": lambda had: [trial for trial in one_model() if trial.repetition == 1 and trial.trial <= 3],
    "nothing solved": lambda had: unsolved(0.0, 0.3, 0.6),
    "errors": lambda had: [make_trial([0], agent="llm:x", p=p, broken="model") for p in (0.0, 0.3)],
    "hostile names": lambda had: [make_trial([3, 2, 1, 0], agent=name, p=p) for name in HOSTILE for p in (0.0, 0.5)],
    "long names": lambda had: play_study(
        small_study(("cognitive:perseverant", *LONG, "random"), (0.0, 0.3, 0.6), 2, 10)
    ),
    "people": lambda had: played_by_people(PEOPLE) + had(rivals),
    "people alone": lambda had: played_by_people(PEOPLE, 2),
    "people at one p": lambda had: (
        played_by_people(small_study(("participant",), (0.0,), 1, 6), 1)
        + [trial for trial in had(rivals) if trial.p == 0.0]
    ),
    "few people": lambda had: played_by_people(small_study(("participant",), (0.0, 0.6), 1, 2), 1) + unsolved(0.0, 0.6),
}
"""Trials by what is special about them."""


class Summaries(dict):
    """Summaries by what is special about them, each made when it is first asked for, by one worker for all."""

    def __init__(self, once):
        self._once = once

    def __missing__(self, name):
        self[name] = self._once(f"summary of {name}", lambda: self._made(name))
        return self[name]

    def _made(self, name):
        trials = STUDIES[name](lambda played: self._once(f"trials of {played.__name__}", played))
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(habit_baseline, "SIMULATED", 2_000)  # what is drawn needs no exact null hypothesis,
            patch.setattr(rationality, "JUDGED", 6)  # and not every trial of a condition judged
            return summarise(trials, None if name == "one trial" else box("chain-4"))


@pytest.fixture(scope="session")
def studies(once):
    """Summaries by what is special about them."""
    return Summaries(once)


@pytest.fixture(scope="session")
def typical(studies):
    """One model beside references."""
    return studies["typical"]


@pytest.fixture(scope="session")
def model(typical):
    """The model of it."""
    return typical.agents[0]


@pytest.fixture
def axes():
    """Axes to draw on."""
    return Figure().add_subplot()
