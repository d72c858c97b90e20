"""The example of a trained agent does what its page says."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from lockprobe import run_trial
from lockprobe.boxes.families import box
from lockprobe.boxes.solve import optimum, random_success

PATH = Path(__file__).parents[3] / "examples" / "fitted_q.py"


@pytest.fixture(scope="module")
def fitted_q():
    spec = importlib.util.spec_from_file_location("fitted_q", PATH)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_it_reaches_the_optimum_and_training_is_what_does_it(fitted_q):
    steps = fitted_q.play(fitted_q.train(fitted_q.boxes(50), rounds=8), fitted_q.boxes(100))
    assert set(steps) == {optimum(box("chain-4"))}
    unlearned = fitted_q.play(lambda told: np.zeros(len(told), dtype=int), fitted_q.boxes(100))
    assert not np.isfinite(unlearned).any()


def test_where_joints_are_listed_anew_it_still_beats_random_by_far_and_repeats_itself(fitted_q):
    def steps(trained, rounds, played):
        policy = fitted_q.train(fitted_q.boxes(trained, p=0.2, shuffle="trial"), rounds=rounds)
        return fitted_q.play(policy, fitted_q.boxes(played, p=0.2, shuffle="trial"))

    assert np.isfinite(steps(100, 4, 300)).mean() > random_success(box("chain-4")) + 0.2
    assert (steps(10, 2, 20) == steps(10, 2, 20)).all()


def test_it_plays_a_study_as_an_agent(fitted_q):
    trial = run_trial(agent=fitted_q.FittedQ(), p=0.4, shuffle="never", seed=3)
    assert (trial.ending, len(trial.steps)) == ("solved", 4)
    assert trial.facts["algorithm"] == "fitted Q iteration"
