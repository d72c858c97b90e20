"""An agent that reads reports refuses pictures; whoever is told an outcome or positions has been told enough."""

import asyncio

import numpy as np
import pytest

from lockprobe.agents.local import LocalModel
from lockprobe.agents.modalities import refuse_pictures
from lockprobe.agents.strategies import RandomAgent
from lockprobe.foundation.errors import BadValue
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.record import Percept, Situation, Task

PICTURES = (Picture(kind="rgb", png=b"a box"),)
SEEN = Situation(task=Task(joints=("A", "B"), target="B", budget=20), past=(), percept=Percept(pictures=PICTURES))


def test_pictures_alone_are_refused_in_one_line():
    with pytest.raises(BadValue) as refused:
        refuse_pictures(SEEN.percept, "Reader")
    assert str(refused.value) == (
        "modality: got 'pictures', expected reports: Reader cannot read pictures; viewer:STRATEGY can"
    )


@pytest.mark.parametrize(
    "percept",
    [Percept(), Percept(pictures=PICTURES, outcome="moved"), Percept(pictures=PICTURES, positions=(True, False))],
)
def test_a_report_is_enough(percept):
    refuse_pictures(percept, "Reader")


def test_a_local_model_refuses_before_it_thinks():
    model = LocalModel.__new__(LocalModel)
    with pytest.raises(BadValue, match="reports: a local model cannot read pictures"):
        asyncio.run(model.decide(SEEN, np.random.default_rng(1)))


def test_who_heeds_no_reports_may_play_on_pictures():
    assert asyncio.run(RandomAgent().decide(SEEN, np.random.default_rng(1))).joint in ("A", "B")
