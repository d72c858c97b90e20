"""The heading of the section on one false report: the change of success of the first agents, with intervals."""

import pytest

from lockprobe.prose.subject import Subject
from lockprobe.report.excursions import ExcursionResult, LieResult, lie_rows, lies_answer
from lockprobe.testing import play_trials


def row(agent, *effects, among="all"):
    found = [
        ExcursionResult(
            outcome="solved", among=among, what="", where="", effect=effect, low=effect - 0.1, high=effect + 0.1,
            p_value=0.5, points=800, clusters=18, smallest=0.15,
        )
        for effect in effects
    ]  # fmt: skip
    return LieResult(agent=agent, modality="symbolic", said="", effects=found, left_out=[], agents=1)


def test_the_heading_has_the_change_of_success_with_its_interval():
    assert lies_answer([row("a", -0.01), row("b", 0.2)]) == (
        "Success after one more false report, in points: \N{MINUS SIGN}1 [\N{MINUS SIGN}11, +9] a; +20 [+10, +30] b."
    )


def test_further_agents_are_counted_and_effects_on_some_reports_are_left_out():
    many = [row(name, 0.2) for name in "abcde"]
    assert lies_answer(many).endswith("c and 2 more.")
    assert lies_answer([row("a", 0.2, among="in a loop"), row("b")]) == ""


def test_several_agents_are_one_family():
    """P values are multiplied and intervals are wider than of the agent alone; those without an estimate do not count."""
    agents = ("cognitive:insistent", "cognitive:perseverant", "human-inspired")
    trials = {agent: play_trials(agent, 60 if agent != agents[2] else 4, p=0.4) for agent in agents}

    def found(*agents):
        played = [trial for agent in agents for trial in trials[agent]]
        return {
            row.agent: row for row in lie_rows(played, [(one, played[0].modality, Subject.of(one)) for one in agents])
        }

    alone, all_of_them = found(agents[0])[agents[0]], found(*agents)
    assert [row.agents for row in all_of_them.values()] == [2, 2, 2]
    assert not all_of_them[agents[2]].effects
    for one, two in zip(alone.effects, all_of_them[agents[0]].effects, strict=True):
        assert two.p_value == pytest.approx(min(1, 2 * one.p_value))
        assert (two.low < one.low, two.high > one.high, two.effect) == (True, True, one.effect)
    assert "corrected for 2 agents" in all_of_them[agents[0]].said
    assert "corrected for" not in alone.said
