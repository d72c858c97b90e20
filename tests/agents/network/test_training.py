"""Training: the same bytes whatever the machine does, and learners that learn."""

import os
import subprocess
import sys

import numpy as np
import pytest

from lockprobe.agents.network.boxes import copies
from lockprobe.agents.network.network_file import SHIPPED, load, save, shipped
from lockprobe.agents.network.training import TrainingSettings, play, success, train
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.seeds import generator
from lockprobe.interventions.flip import DEFAULT
from lockprobe.simulation.montecarlo.populations import population
from lockprobe.trial.record import STATES

TRAINED = """
import sys
from pathlib import Path
from lockprobe.agents.network.network_file import save
from lockprobe.agents.network.training import TrainingSettings, train
schooling = TrainingSettings(updates=2)
*_, network = train(schooling)
save(Path(sys.argv[1]), network, schooling)
"""


@pytest.mark.parametrize(("threads", "kernel"), [("2", "Haswell"), ("1", "Sandybridge")])
def test_a_learner_comes_out_the_same_byte_by_byte(tmp_path, threads, kernel):
    """The shipped file, on other numbers of threads and other kernels of the same machine."""
    way = {"OPENBLAS_NUM_THREADS": threads, "OPENBLAS_CORETYPE": kernel}
    subprocess.run([sys.executable, "-c", TRAINED, str(tmp_path / "again.npz")], check=True, env=os.environ | way)
    assert load(tmp_path / "again.npz").sha256 == shipped("novice").sha256


def test_more_updates_teach_more():
    novice, apprentice, adept = (success(shipped(name).network, boxes=800, temperature=0) for name in SHIPPED)
    assert novice < 0.65
    assert 0.8 < apprentice < adept


def test_the_rule_by_which_they_ship_chooses_them():
    """Seed 1, greedy on chain-4: the novice is below one half, and the apprentice is the next checkpoint."""
    known = [shipped(name) for name in SHIPPED]
    assert [one.trained.updates for one in known] == [2, 5, 900]
    dealt = copies(box("chain-4"), 1000, generator(1, "learner", "chain-4"))
    novice, apprentice = (float(play(one.network, dealt, temperature=0).solved.mean()) for one in known[:2])
    assert novice < 0.5 < apprentice


def test_lies_raise_the_success_of_a_greedy_novice_and_not_of_one_that_draws():
    dealt = copies(box("chain-4"), 1500, generator(2, "lies"))
    novice = shipped("novice").network
    truth, lies, always = (play(novice, dealt, p=p, temperature=0).solved.mean() for p in (0.0, 0.4, 1.0))
    assert lies - truth > 0.04
    assert always < lies
    drawn = [play(novice, dealt, p=p).solved.mean() for p in (0.0, 0.4)]
    assert abs(drawn[1] - drawn[0]) < 0.04


def test_false_reports_in_a_batch_are_those_of_a_study():
    """At a flip rate of 1, where readings differ most."""
    dealt = copies(box("chain-4"), 4000, generator(2, "lies"))
    batch = play(shipped("novice").network, dealt, p=1.0, temperature=0).solved.mean()
    own, other = (
        population("learner:novice?temperature=0", p=1.0, flip=kind, trials=600, modality=STATES).success
        for kind in (DEFAULT, "memoryless")
    )
    assert abs(batch - own) < 0.05
    assert abs(batch - other) > 0.06


def test_trials_end_when_the_target_moves_and_nothing_moves_after():
    dealt = copies(box("chain-4"), 500, generator(3, "ends"))
    course = play(shipped("apprentice").network, dealt)
    assert ((course.actions >= 0).sum(axis=1) == course.steps).all()
    last = course.actions[np.arange(500), course.steps - 1]
    assert (last[course.solved] == dealt.target[course.solved]).all()
    assert (course.steps[~course.solved] == 20).all()
    assert course.steps.min() >= 4


def test_other_boxes_and_lies_are_learned_too(tmp_path):
    for schooling in (TrainingSettings(updates=3, joints=6, hidden=16), TrainingSettings(updates=3, told_lies=True),
                      TrainingSettings(updates=3, box=box("chain-4"), hidden=16)):  # fmt: skip
        *_, network = train(schooling)
        save(tmp_path / "one.npz", network, schooling)
        found = load(tmp_path / "one.npz")
        assert all(np.array_equal(found.network.arrays()[name], array) for name, array in network.arrays().items())
        assert found.trained.told_lies == schooling.told_lies


def test_settings_that_cannot_be_are_refused():
    for wrong in (
        {"updates": 0},
        {"updates": 901},
        {"updates": 1, "schedule": 0},
        {"updates": 1, "box": box("chain-6")},
    ):
        with pytest.raises(BadValue):
            TrainingSettings(**wrong)
