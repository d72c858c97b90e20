"""Exact courses: against brute force over every choice and every flip, and against published figures."""

from dataclasses import dataclass
from types import MappingProxyType

import pytest

from lockprobe.agents.cognitive import SoftmaxMemory
from lockprobe.agents.human_inspired import HumanInspired
from lockprobe.boxes.families import box
from lockprobe.boxes.solve import random_curve
from lockprobe.foundation.errors import BadValue
from lockprobe.simulation.exact import propagate
from lockprobe.trial.record import Decision


def test_a_false_position_that_lives_longer_turns_the_sign_of_the_effect():
    truth = propagate("cognitive:perseverant").success
    found = [
        propagate("cognitive:perseverant", condition=f"flip?p=0.4&inverts=position&keep={q}").success
        for q in (0, 0.5, 0.9, 1)
    ]
    assert found == pytest.approx([0.641, 0.553, 0.359, 0.256], abs=0.006)
    assert found[2] > truth > found[3]


@pytest.mark.parametrize("name", ["chain-4", "chain-5", "bichain-4", "fork", "converge", "reset", "gray-code"])
@pytest.mark.parametrize("p", [0.0, 0.4])
def test_blind_agents_have_the_curves_of_the_box(name, p):
    """0.392655 for the uniform agent on chain-4, whatever it is told."""
    for agent, repeats in (("random", True), ("random-no-repeat", False)):
        course = propagate(agent, name, p=p, flip="sticky")
        assert course.solved == pytest.approx(random_curve(box(name), repeats=repeats), abs=1e-12)
    assert propagate("random").success == pytest.approx(0.392655, abs=5e-7)


@pytest.mark.parametrize(
    ("agent", "mean", "eighty", "last"),
    [
        ("human-inspired", 8.5, 9, 10),
        ("human-inspired:target-last", 5.5, 6, 7),
        ("human-inspired:target-any", 7.0, 8, 10),
        ("human-inspired:proximity", 5.5, 7, 7),
        ("human-inspired:target-first-per-configuration", 9.75, 11, 13),
        ("round-robin", 8.5, 10, 13),
    ],
)
def test_strategies_have_their_figures_on_chain_4(agent, mean, eighty, last):
    course = propagate(agent)
    assert course.steps == pytest.approx(mean)
    assert (course.by(0.8), course.by(1)) == (eighty, last)


def test_noise_hurts_a_competent_agent_by_as_much_as_was_found():
    """An agent that takes any closed joint that has not failed, told outcomes only."""
    found = [propagate("human-inspired:target-any", p=p, flip="outcome-only").success for p in (0, 0.2, 0.4, 0.6)]
    assert found == pytest.approx([1.0, 0.74, 0.63, 0.60], abs=0.025)
    assert found == sorted(found, reverse=True)


@dataclass(frozen=True, kw_only=True)
class Unknown(HumanInspired):
    """Of a class that might heed the order in which joints are listed."""


def test_the_order_of_the_listing_is_averaged_where_it_may_matter():
    for settings in ({"target": "any", "nearest": True}, {"lapse": 0.2}):
        every = propagate(Unknown(**settings), p=0.2, max_steps=7)
        assert every.solved == pytest.approx(propagate(HumanInspired(**settings), p=0.2, max_steps=7).solved)
        assert every.solved[7] > 0.1
        assert every.states >= 24
    assert propagate("round-robin", listing="panel").by(1) == 13
    assert propagate("round-robin", listing="panel").solved[12] == 0
    assert propagate(SoftmaxMemory(position=800), listing="panel").success == 0
    assert propagate(SoftmaxMemory(position=800), "chain-2", max_steps=3).solved == (0, 0, 0, 0)


class OneWithoutMemory:
    facts = MappingProxyType({})

    async def decide(self, situation, rng):
        return Decision(joint=situation.task.joints[0])


def test_what_cannot_be_followed_is_refused_in_one_line():
    with pytest.raises(BadValue, match=r"^states of RandomMap on chain-4: got 'more than 50', expected fewer .*sample"):
        propagate("cognitive:random-map", most_states=50)
    with pytest.raises(BadValue, match=r"^listing: got 'x', expected one of shuffled, panel$"):
        propagate(listing="x")
    with pytest.raises(BadValue, match=r"^max_steps: got 0, expected a whole number from 1 to 10000$"):
        propagate(max_steps=0)
    with pytest.raises(BadValue, match=r"^flip rate p: got 2"):
        propagate(p=2)
    with pytest.raises(
        BadValue, match=r"^agent: got .*OneWithoutMemory.*, expected one whose whole memory is one value"
    ):
        propagate(OneWithoutMemory())
