"""Studies to draw."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from builders import make_trial, play_study, played_by_people, small_study
from known_truth import records
from matplotlib.figure import Figure

from lockprobe.boxes.families import box
from lockprobe.interventions.conditions import flips
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.questions import all_sections
from lockprobe.report.results import results_of
from lockprobe.statistics import rationality
from lockprobe.studies.study import Study
from lockprobe.trial.record import STATES

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
            condition=flips((trial.p,))[0].label,
            modality=STATES,
            joints=tuple(names.values()),
            target=names[trial.target],
            steps=tuple(replace(step, joint=names[step.joint]) for step in trial.steps),
        )
        for trial in records(world, np.random.default_rng(seed))
    ]


def references():
    """The baselines over all p, in a study of the paper's size."""
    return play_study(small_study(REFERENCES, P7, 3, 10))


def one_model():
    """A model that loops do not matter to."""
    return simulated("loops-irrelevant", "llm:openai/gpt-4o-2024-08-06", 1)


def rivals():
    """A strategy under the name of a model and a baseline, for people to be compared with."""
    played = play_study(small_study(("ideal-observer", "random"), PEOPLE.p, 2, 5))
    return [replace(trial, agent=f"llm:{trial.agent}") if trial.agent != "random" else trial for trial in played]


PEOPLE = small_study(("participant",), (0.0, 0.2, 0.4, 0.6), 2, 5)
HOSTILE = ("llm:$\\frac{", "python:" + "mx" * 96, "_hidden<script>", "llm:\u4e2d\u0e01")
LONG = tuple(f"cognitive:random-map?window={window}&avoid=failed&lapse=0.1" for window in (1, 2))
STUDIES = {
    "typical": lambda had: one_model() + had(references),
    "strategies": lambda had: play_study(small_study(("random", "random-no-repeat", *REFERENCES[1:]), PEOPLE.p, 2, 5)),
    "thirty p": lambda had: play_study(small_study(("human-inspired", "random"), [i / 29 for i in range(30)], 1, 2)),
    "one p": lambda had: [trial for trial in one_model() + had(references) if trial.p == 0.0],
    "one trial": lambda had: [trial for trial in one_model() if trial.repetition == trial.trial == 1],
    "hostile names": lambda had: [
        make_trial([0] * (p > 0) + [3, 2, 1, 0], agent=name, p=p) for name in (*HOSTILE, *LONG) for p in (0.0, 0.5)
    ],
    "people": lambda had: played_by_people(PEOPLE) + had(rivals),
}
"""Trials by what is special about them."""


def results_of_trials(trials):
    """The results of a study on chain-4 with these trials and no others."""
    planned = Study(
        name="flips",
        agents=tuple(dict.fromkeys(trial.group for trial in trials)),
        boxes=(box("chain-4"),),
        conditions=flips(sorted({trial.p for trial in trials})),
        repetitions=max(trial.repetition for trial in trials),
        trials=max(trial.trial for trial in trials),
    )
    opened = OpenedStudy(
        directory=Path(),
        study=planned,
        trials=tuple(sorted(trials, key=planned.place_of)),
        results_hash="",
        replaced=0,
        diaries=(),
        withdrawn=0,
    )
    return results_of(opened)


class Studies(dict):
    """Results by what is special about them, each made when it is first asked for, by one worker for all."""

    def __init__(self, once):
        self._once = once

    def __missing__(self, name):
        self[name] = self._once(f"results of {name}", lambda: self._made(name))
        return self[name]

    def _made(self, name):
        trials = STUDIES[name](lambda played: self._once(f"trials of {played.__name__}", played))
        all_sections()  # their captions say how many trials are judged, so they are imported before that changes
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(rationality, "JUDGED", 6)  # and not every trial of a condition judged
            return results_of_trials(trials)


@pytest.fixture(scope="session")
def studies(once):
    """Results by what is special about them."""
    return Studies(once)


@pytest.fixture(scope="session")
def typical(studies):
    """One model beside references."""
    return studies["typical"]


@pytest.fixture(scope="session")
def model(typical):
    """The model of it, over the flip rates."""
    return typical.courses()[0]


@pytest.fixture
def axes():
    """Axes to draw on."""
    return Figure().add_subplot()
