"""The report in words adds and hides nothing."""

import numpy as np

from lockprobe.interventions.words import TextChannel
from lockprobe.record import Percept, Task

TASK = Task(joints=("B", "A"), target="A", budget=20)


def text(percept):
    return TextChannel().perceive(percept, (), TASK, np.random.default_rng(1)).text


def test_the_first_look_tells_positions_in_the_listed_order():
    assert text(Percept(positions=(True, False))) == "At 1: B."


def test_outcome_and_positions():
    moved = Percept(joint="A", outcome="moved", positions=(True, True))
    assert text(moved) == "A moved. At 1: B, A."
    blocked = Percept(joint="A", outcome="blocked", positions=(True, False))
    assert text(blocked) == "A did not move. At 1: B."


def test_without_positions_only_the_outcome_is_told():
    assert text(Percept(joint="B", outcome="blocked")) == "B did not move."
    assert text(Percept()) == ""
    assert text(Percept(positions=(False, False))) == "At 1: none."
