"""Sentences about pairs of agents say what the numbers bear, and no more."""

import re

from builders import SOLUTION, make_trial

from lockprobe.report.prose.agent_comparison import comparison_said
from lockprobe.statistics.summary import summarise


def trials(agent, solved, of=20):
    return [
        make_trial(SOLUTION if i < n else (0,) * 20, agent=agent, p=p, trial=i + 1)
        for p, n in zip((0.0, 0.4), solved, strict=True)
        for i in range(of)
    ]


def said(*agents):
    summary = summarise([trial for name, solved in agents for trial in trials(name, solved)])
    return comparison_said(summary.comparisons[0], summary)


def test_agents_that_differ_are_said_to_with_the_largest_question_first():
    success, noise, steps = said(("llm:a", (18, 19)), ("llm:b", (2, 1)))
    assert success.startswith("llm:a solves the box more often than llm:b: 92 % against 8 % of the 40 trials that both")
    assert re.search(
        r"\(\+85 points, 95 % interval \+\d+ to \+\d+; permutation test within blocks, P < 0\.001\)", success
    )
    assert noise.startswith("No difference between the two in the effect of false reports was detected")
    assert steps.startswith("llm:a needs fewer steps than llm:b")


def test_agents_that_cannot_be_told_apart_are_said_so():
    success, _, steps = said(("llm:a", (10, 11)), ("llm:b", (10, 10)))
    assert success.startswith("No difference in success between llm:a and llm:b was detected: 52 % against 50 %")
    assert steps.startswith("No difference in the number of steps was detected")


def test_noise_that_helps_one_is_said_with_its_direction():
    _, noise, _ = said(("llm:a", (2, 19)), ("llm:b", (10, 10)))
    assert noise.startswith(
        "False reports affect the two differently: from a flip rate of 0 to 0.4 the success of llm:a rises more, or falls less, "
        "than that of llm:b (+85 points"
    )
    _, other, _ = said(("llm:b", (10, 10)), ("llm:a", (2, 19)))
    assert "llm:b rises less, or falls more, than that of llm:a (\N{MINUS SIGN}85 points" in other


def test_noise_is_said_to_act_where_the_test_sees_it():
    """At 0.2 nine of forty blocks change for the better; at 0.4 the change is larger, for the worse, and not sure."""
    apart = [(1, 1, -1)] * 12 + [(-1, -1, 1)] * 7 + [(0, 1, 0)] * 9 + [(0, 0, 0)] * 12
    made = [
        make_trial(SOLUTION if sign * ahead > 0 else (0,) * 20, agent=agent, p=p, trial=i + 1)
        for agent, sign in (("llm:a", 1), ("llm:b", -1))
        for i, signs in enumerate(apart)
        for p, ahead in zip((0.0, 0.2, 0.4), signs, strict=True)
    ]
    summary = summarise(made)
    noise = comparison_said(summary.comparisons[0], summary)[1]
    assert noise.startswith(
        "False reports affect the two differently: from a flip rate of 0 to 0.2 the success of llm:a rises more, or falls less, "
        "than that of llm:b (+22 points"
    )


def test_several_pairs_are_corrected_and_counted():
    success, *_ = said(("llm:a", (18, 19)), ("llm:b", (2, 1)), ("llm:c", (2, 2)))
    assert "corrected for 3 pairs" in success


def test_one_agent_is_compared_with_the_baseline_alone():
    success, *more = said(("llm:a", (18, 19)), ("random", (2, 1)))
    assert success.startswith("llm:a solves the box more often than random")
    assert len(more) == 1
