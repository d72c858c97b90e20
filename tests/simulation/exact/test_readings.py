"""Success under every reading of a false report and under its parts: the published table, and shares of false outcomes."""

import re
from itertools import chain
from math import isnan
from pathlib import Path

import pytest

from lockprobe.agents.policy import Policy
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import UserMistake
from lockprobe.interventions.conditions import read_condition
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.simulation.exact import readings
from lockprobe.simulation.exact.propagation import propagate
from lockprobe.simulation.exact.readings import AGENTS, FALSE_REPORTS, cell, conditions_table, success_under
from lockprobe.studies.running.single import run_trial

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "readings.md").read_text("utf-8")
QUICK = tuple(name for name in FALSE_REPORTS if name != "independent state noise")
FOUND = {
    "cognitive:perseverant": {
        "memoryless state noise": (0.296, 0.508, 0.640, 0.742),
        "re-observed outcome noise": (0.296, 0.523, 0.653, 0.716),
        "latched state noise": (0.296, 0.330, 0.254, 0.182),
        "integrated outcome noise": (0.296, 0.239, 0.218, 0.213),
        "outcome noise, no positions": (0.296, 0.239, 0.218, 0.213),
        "false outcome alone": {0.4: 0.624},
        "phantom": {0.4: 0.270},
        "hidden moves alone": {0.4: 0.724},
    },
    "cognitive:insistent": {
        "memoryless state noise": (0.225, 0.342, 0.358, 0.284),
        "re-observed outcome noise": (0.225, 0.336, 0.343, 0.307),
        "latched state noise": (0.225, 0.157, 0.083, 0.034),
        "integrated outcome noise": (0.225, 0.110, 0.066, 0.046),
        "false position alone": {0.4: 0.407},
        "invented moves alone": {0.4: 0.606},
    },
}
"""From 200 000 trials a cell of another program, written with three digits."""


def on_page(agent):
    """The cells of the table of an agent on the page, by kind: one for each rate."""
    (table,) = (one for one in PAGE.split("\n\n") if one.startswith(f"| `{agent}`, by flip rate |"))
    return {
        row[1].strip(): [one.strip() for one in row[2:-1]]
        for row in (line.split("|") for line in table.splitlines()[2:])
    }


@pytest.fixture(scope="module")
def exact():
    """Cells at p = 0.4, but those of noise on all joints, by agent and kind."""
    return {(one.agent, one.name): one for one in success_under(p=[0.4], names=QUICK)}


def test_the_table_on_the_page_is_what_the_command_prints(exact):
    assert conditions_table() in PAGE
    for agent in FOUND:
        cells = on_page(agent)
        assert list(cells) == list(FALSE_REPORTS)
        assert {name: row[2] for name, row in cells.items() if name in QUICK} == {
            name: cell(exact[agent, name]) for name in QUICK
        }


@pytest.mark.parametrize("agent", FOUND)
def test_success_on_the_page_is_as_sampled_by_another_program(agent):
    for name, shares in FOUND[agent].items():
        cells = dict(zip(readings.P, on_page(agent)[name], strict=True))
        for p, share in shares.items() if isinstance(shares, dict) else zip(readings.P, shares, strict=True):
            assert float(cells[p].split()[0]) == pytest.approx(share, abs=0.0051), (name, p)


def test_under_outcome_noise_the_share_of_false_outcomes_is_p(exact):
    for (agent, name), one in exact.items():
        if "outcome noise" in name or name in ("both parts", "false outcome alone"):
            assert one.false_outcomes == pytest.approx(0.4, abs=1e-12), (agent, name)


@pytest.mark.parametrize(
    "agent",
    [
        *AGENTS, "random", "random-no-repeat", "round-robin", "human-inspired:per-configuration", "cognitive:loop-breaker",
        "ideal-observer?noise=naive", "cognitive:random-map?avoid=last",
    ],
)  # fmt: skip
@pytest.mark.parametrize("spec", ["flip?p=0.3", "flip?p=0.3&others=kept"])
def test_every_agent_infers_a_share_p_of_false_outcomes_under_outcome_noise(agent, spec):
    """In its own trials, as they are recorded; within 4 standard errors of 40 trials."""
    trials = [run_trial(agent=agent, condition=spec, trial=trial) for trial in range(1, 41)]
    false = list(chain.from_iterable((step.told_falsely for step in trial.steps) for trial in trials))
    assert abs(sum(false) / len(false) - 0.3) < 4 * (0.21 / len(false)) ** 0.5


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


def test_human_inspired_infers_other_shares_than_p_under_memoryless_noise():
    found = [propagate(p=p, flip="memoryless").false_outcomes for p in (0.2, 0.4, 0.6, 0.8, 1)]
    assert found == pytest.approx([0.24, 0.43, 0.56, 0.66, 0.73], abs=0.012)


def test_an_exact_cell_and_a_sampled_one_agree(monkeypatch):
    names = ("false outcome alone", "phantom", "latched state noise")
    given = {"names": names, "p": [0.4], "max_steps": 14}
    exact = success_under(["cognitive:perseverant"], **given)
    monkeypatch.setattr(readings, "_FOLLOWED", 1)
    sampled = success_under(["cognitive:perseverant"], trials=200, **given)
    for one, other in zip(exact, sampled, strict=True):
        assert (one.trials, other.trials) == (None, 200)
        assert other.low - 0.03 < one.success < other.high + 0.03
        assert other.false_outcomes == pytest.approx(one.false_outcomes, abs=0.05)


def test_every_kind_is_a_condition_that_does_nothing_at_rate_0():
    for name, spec in FALSE_REPORTS.items():
        assert read_condition(spec.format(p="0")).does_nothing, name
    cells = success_under(["human-inspired?lapse=0.3"], box("chain-3"), p=[0], max_steps=6)
    assert len({round(one.success, 12) for one in cells}) == 1
    assert {one.false_outcomes for one in cells} == {0}


def test_without_reports_there_is_no_share():
    assert isnan(propagate("random", condition="drop?p=1").false_outcomes)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"p": [1.2]}, "rate p: got 1.2, expected a number from 0 to 1"),
        ({"agents": ["llm:local"]}, "agent: got 'llm:local', expected one whose whole memory is one value"),
        ({"agents": ["nobody"]}, "no agent is called 'nobody'"),
    ],
)
def test_what_cannot_be_computed_is_refused_in_one_line(asked, said):
    with pytest.raises(UserMistake, match=f"^{re.escape(said)}"):
        success_under(**asked)
