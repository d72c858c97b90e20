"""A policy of somebody else that returns no probabilities, or no joint, stops with one line and yields no number."""

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import pytest

from lockprobe import Policy, propagate, run_trial
from lockprobe.agents.human_inspired import HumanInspired
from lockprobe.agents.policy import View
from lockprobe.foundation.errors import UserMistake

VIEW = View(joints=4, target=0)


class Returning(Policy[None]):
    """Returns one value again and again, and counts how often it was asked."""

    def __init__(self, value):
        self.value, self.asked = value, 0

    def begin(self, view):
        return None

    def remember(self, view, memory, told):
        return None

    def probabilities(self, view, memory):
        self.asked += 1
        return self.value


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ((0.5, 0.2, 0.2, 0.2), "(0.5, 0.2, 0.2, 0.2)"),
        ((0.5, 0.5), "(0.5, 0.5)"),
        ((0.2,) * 5, "(0.2, 0.2, 0.2, 0.2, 0.2)"),
        ((2, -1, 0, 0), "(2, -1, 0, 0)"),
        ((0, 0, 0, 0), "(0, 0, 0, 0)"),
        ((float("nan"), 1, 0, 0), "(nan, 1, 0, 0)"),
        ((float("inf"), 0, 0, 0), "(inf, 0, 0, 0)"),
        ((1 + 2e-6, 0, 0, 0), "(1.000002, 0, 0, 0)"),
        ((), "()"),
        ("1000", "'1000'"),
        (0.25, "0.25"),
        (None, "None"),
    ],
)
def test_a_return_that_is_no_probabilities_stops_the_trial_in_one_line(value, said):
    for using in (
        lambda policy: run_trial(agent=policy),
        lambda policy: propagate(policy, "chain-4", p=0),
        lambda policy: policy.probabilities(VIEW, None),
    ):
        with pytest.raises(UserMistake) as caught:
            using(Returning(value))
        expected = f"Returning.probabilities returned {said}: 4 numbers >= 0 that sum to 1 are expected"
        assert str(caught.value) == expected


@pytest.mark.parametrize(
    "value",
    [
        (0.25, 0.25, 0.25, 0.25),
        [0.7, 0.1, 0.1, 0.1],
        (True, False, False, False),
        (1 - 9e-7, 0, 0, 0),
        np.array([0.5, 0.5, 0, 0], dtype=np.float32),
        (Fraction(1, 3), Fraction(2, 3), 0, 0),
    ],
)
def test_numbers_of_any_kind_pass_as_floats(value):
    found = Returning(value).probabilities(VIEW, None)
    assert found == tuple(float(number) for number in value)
    assert {type(number) for number in found} == {float}


def test_every_class_is_checked_once_however_it_came_to_its_methods():
    class Later(Returning):
        """Overrides nothing."""

    class Mixed:
        def probabilities(self, view, memory):
            return (1.0,)

    class WithMixed(Mixed, Returning):
        pass

    @dataclass(frozen=True, slots=True)
    class Slotted(HumanInspired):
        def probabilities(self, view, memory):
            return (1.0,)

    assert Later.probabilities is Returning.probabilities
    for policy in (WithMixed(None), Slotted()):
        with pytest.raises(UserMistake, match="4 numbers"):
            policy.probabilities(VIEW, None)


def test_the_policies_of_lockprobe_are_called_as_they_are():
    assert not hasattr(HumanInspired.probabilities, "checked")
