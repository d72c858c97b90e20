"""Success under the readings of a false report and under its parts, and shares of false outcomes."""

import pytest

from lockprobe.agents.policy import Policy
from lockprobe.interventions.conditions import read_condition
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.simulation.exact import propagate

CONDITIONS = {
    "re-observed outcome noise": "flip?p={p}",
    "integrated outcome noise": "flip?p={p}&others=kept",
    "memoryless state noise": "flip?p={p}&inverts=position",
    "latched state noise": "flip?p={p}&inverts=position&others=kept",
    "outcome noise, no positions": "flip?p={p} + symbolic?tell=outcome",
    "false outcome alone": "flip?p={p}&part=outcome + symbolic",
    "false position alone": "flip?p={p}&inverts=position&part=position + symbolic",
    "phantom": "phantom?p={p}",
    "hidden moves alone": "flip?p={p}&inverts=position&only=moved",
    "invented moves alone": "flip?p={p}&inverts=position&only=blocked",
}
FOUND = {
    "cognitive:perseverant": {
        "memoryless state noise": 0.640,
        "re-observed outcome noise": 0.653,
        "latched state noise": 0.254,
        "integrated outcome noise": 0.218,
        "outcome noise, no positions": 0.218,
        "false outcome alone": 0.624,
        "phantom": 0.270,
        "hidden moves alone": 0.724,
    },
    "cognitive:insistent": {
        "memoryless state noise": 0.358,
        "re-observed outcome noise": 0.343,
        "latched state noise": 0.083,
        "integrated outcome noise": 0.066,
        "false position alone": 0.407,
        "invented moves alone": 0.606,
    },
}
"""At a rate of 0.4, from 200 000 trials a cell of another program, written with three digits."""


@pytest.mark.parametrize("agent", FOUND)
def test_exact_success_is_as_sampled_by_another_program(agent):
    for name, share in FOUND[agent].items():
        asked = read_condition(CONDITIONS[name].format(p=0.4))
        course = propagate(agent, condition=asked.interventions, modality=asked.modality)
        assert course.success == pytest.approx(share, abs=0.0051), name
        if "outcome" in name:
            assert course.false_outcomes == pytest.approx(0.4, abs=1e-12)


class Stubborn(Policy[None]):
    """An agent that attempts one joint that is not the target."""

    def begin(self, view):
        return None

    def remember(self, view, memory, told):
        return None

    def probabilities(self, view, memory):
        return tuple(float(joint == (view.target + 1) % view.joints) for joint in range(view.joints))


@pytest.mark.parametrize(("p", "share"), [(0.2, 0.31), (0.4, 0.48), (0.6, 0.49), (0.8, 0.34), (1, 0.05)])
def test_after_a_repeat_two_false_positions_cancel(p, share):
    """p at the first of 20 attempts, 2p(1 - p) at all others; with outcome noise p at all of them."""
    memoryless = propagate(Stubborn(), condition=[OutcomeFlip(p=p, inverts="position")])
    assert memoryless.false_outcomes == pytest.approx((p + 19 * 2 * p * (1 - p)) / 20)
    assert memoryless.false_outcomes == pytest.approx(share, abs=0.01)
    assert propagate(Stubborn(), p=p).false_outcomes == pytest.approx(p)


def test_noise_on_all_joints_makes_every_later_outcome_false_with_probability_2p_1_minus_p():
    """Of two independent positions of the attempted joint, exactly one is false; the first look is true."""
    noise = [OutcomeFlip(p=0.3, inverts="position", others="noisy")]
    for agent in (Stubborn(), "random", "round-robin"):
        course = propagate(agent, condition=noise, max_steps=2)
        given = course.false_outcomes
        solved = propagate(agent, condition=noise, max_steps=1).success
        second = (1 - course.success) / (2 - solved - course.success)
        assert given == pytest.approx((1 - second) * 0.3 + second * 0.42)
