"""Studies to draw."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from builders import make_trial, play_study, played_by_people, small_study
from matplotlib.figure import Figure

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


class Summaries(dict):
    """Summaries by what is special about them, each made when it is first asked for."""

    def __init__(self, studies):
        self._studies = studies

    def __missing__(self, name):
        known = None if name == "one trial" else box("chain-4")
        self[name] = summarise(self._studies()[name], known)
        return self[name]


@cache
def played():
    """Trials by what is special about them."""
    references = play_study(small_study(REFERENCES, P7, 3, 10))
    model = simulated("loops-irrelevant", "llm:openai/gpt-4o-2024-08-06", 1)
    others = simulated("loop-trapped", "llm:anthropic/claude-x", 2) + simulated("saturating", "llm:local", 3)
    names = ("llm:$\\frac{", "python:" + "mx" * 100, "_hidden\n<script>", "llm:\u4e2d\u0e01")
    found = {
        "typical": model + references,
        "three": model + others + references,
        "strategies": play_study(small_study(("random", "random-no-repeat", *REFERENCES[1:]), P7, 2, 5)),
        "many p": play_study(small_study(("human-inspired", "random"), [i / 20 for i in range(11)], 2, 3)),
        "thirty p": play_study(small_study(("human-inspired", "random"), [i / 29 for i in range(30)], 1, 2)),
        "one p": [trial for trial in model + references if trial.p == 0.0],
        "one trial": [trial for trial in model if trial.repetition == trial.trial == 1],
        "three trials": [trial for trial in model if trial.repetition == 1 and trial.trial <= 3],
        "nothing solved": [make_trial([0] * 20, agent="llm:x", p=p, trial=i) for p in (0.0, 0.3, 0.6) for i in (1, 2)],
        "errors": [make_trial([0], agent="llm:x", p=p, broken="model") for p in (0.0, 0.3)],
        "hostile names": [make_trial([3, 2, 1, 0], agent=name, p=p) for name in names for p in (0.0, 0.5)],
    }
    maps = [f"cognitive:random-map?window={window}&avoid=failed&lapse=0.1" for window in (1, 2)]
    found["long names"] = play_study(small_study(("cognitive:perseverant", *maps, "random"), (0.0, 0.3, 0.6), 2, 10))
    people = small_study(("participant",), (0.0, 0.2, 0.4, 0.6), 2, 5)
    rivals = play_study(small_study(("ideal-observer", "random-no-repeat", "random"), people.p, 2, 5))
    rivals = [replace(trial, agent=f"llm:{trial.agent}") if trial.agent != "random" else trial for trial in rivals]
    found |= {
        "people": played_by_people(people) + rivals,
        "people alone": played_by_people(people, 2),
        "people at one p": played_by_people(small_study(("participant",), (0.0,), 1, 6), 1)
        + [trial for trial in rivals if trial.p == 0.0],
        "few people": played_by_people(small_study(("participant",), (0.0, 0.6), 1, 2), 1)
        + [make_trial([0] * 20, agent="llm:x", p=p, trial=i) for p in (0.0, 0.6) for i in (1, 2)],
    }
    return found


@pytest.fixture(scope="session")
def studies():
    """Summaries by what is special about them."""
    return Summaries(played)


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
