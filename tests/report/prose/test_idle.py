"""What changed nothing is named, for whom, and is said to decide nothing."""

from dataclasses import replace

from lockprobe.boxes.families import box
from lockprobe.report.prose.first_screen import flips_answer
from lockprobe.report.prose.idle import idle_doses_said, idle_said, unheeded_said
from lockprobe.report.prose.success import finding
from lockprobe.statistics.idle import Idle, Unheeded
from lockprobe.statistics.summary import summarise
from lockprobe.testing import play_trials


def idle(agent, condition, intervention=""):
    return Idle(agent=agent, condition=condition, intervention=intervention, steps=40)


def test_conditions_are_named_together_for_the_same_agents():
    assert idle_said([idle("a", "x"), idle("a", "y")], ["a"]) == [
        "x and y changed nothing (0 of 80 steps), so nothing is concluded from them."
    ]
    assert idle_said([idle("a", "x"), idle("b", "x"), idle("b", "y")], ["a", "b"]) == [
        "x changed nothing for any agent (0 of 80 steps), so nothing is concluded from it.",
        "y changed nothing for b (0 of 40 steps), so nothing is concluded from it.",
    ]


def test_agents_that_the_study_is_not_about_are_left_out():
    assert idle_said([idle("random", "x")], ["a"]) == []
    assert unheeded_said([Unheeded(agent="random", condition="x", control="truth", changed=10)], ["a"]) == []


def test_one_of_several_is_named_with_its_condition():
    assert idle_said([idle("a", "x + y", "y")], ["a"]) == [
        "y changed nothing under x + y (0 of 40 steps), so nothing there is ascribed to it."
    ]


def test_an_agent_that_chose_as_under_the_control():
    alike = [Unheeded(agent="a", condition=one, control="truth", changed=10) for one in "xy"]
    under = "x (which acted in 10 steps) and y (which acted in 10 steps)"
    assert unheeded_said(alike, ["a"]) == [f"a chose the same joints as under truth in every trial under {under}."]


def test_a_flip_rate_without_a_false_report_is_named_and_no_effect_is_denied():
    trials = [trial for p in (0.0, 0.0001) for trial in play_trials("human-inspired", 6, p=p)]
    summary = summarise(trials, box("chain-4"))
    (agent,) = summary.agents
    steps = sum(len(trial.steps) for trial in trials) // 2
    said = f"At a flip rate of 0.0001, no report was false (human-inspired, {steps} steps), so nothing is concluded from it."
    assert idle_doses_said(agent) == said
    assert finding(agent).endswith(said)
    assert "effect" not in finding(agent) + flips_answer(summary)
    (acting,) = summarise([*trials, *play_trials("human-inspired", 6, p=0.4)], box("chain-4")).agents
    assert said in finding(acting)
    assert "0.0001" not in finding(acting).replace(said, "")


def test_such_a_flip_rate_is_not_the_one_that_is_compared():
    """The agent solves all its trials at each rate, so no difference is seen at those that are compared."""
    trials = [trial for p in (0.0, 0.0001, 0.02) for trial in play_trials("cognitive:careful", 8, p=p)]
    (agent,) = summarise([replace(trial, ending="solved") for trial in trials], box("chain-4")).agents
    assert [one.dose for one in agent.idle] == [0.0001]
    assert "it solved 8 of 8 trials (100 %) when told the truth and 8 of 8 trials (100 %) at a flip rate of 0.02" in (
        finding(agent)
    )
