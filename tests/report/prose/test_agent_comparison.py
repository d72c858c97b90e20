"""Sentences about pairs of agents say what the numbers bear, and no more."""

import re

from builders import SOLUTION, make_trial

from lockprobe.report.prose.agent_comparison import comparison_said, ranking_said
from lockprobe.statistics.summary import summarise


def trials(agent, solved, of=20):
    return [
        make_trial(SOLUTION if i < n else (0,) * 20, agent=agent, p=p, trial=i + 1)
        for p, n in zip((0.0, 0.4), solved, strict=True)
        for i in range(of)
    ]


def said(*agents):
    summary = summarise([trial for name, solved in agents for trial in trials(name, solved)])
    return ranking_said(summary), comparison_said(summary.comparisons[0], summary)


def test_agents_that_differ_are_said_to_with_the_largest_question_first():
    ranking, (success, noise, steps) = said(("llm:a", (18, 19)), ("llm:b", (2, 1)))
    assert ranking.startswith(
        "Success over all flip rates (rank of these 2 agents): llm:a 92 % (rank 1), llm:b 8 % (rank 2). A difference "
        "between the two was detected on the 40 trials that both played (llm:a 92 %, llm:b 8 %), with the same"
    )
    assert success.startswith("llm:a solves the box more often than llm:b: 92 % against 8 % of the 40 trials that both")
    assert re.search(
        r"\(\+85 points, 95 % interval \+\d+ to \+\d+; permutation test within blocks, P < 0\.001\)", success
    )
    assert noise.startswith("No difference between the two in the effect of false reports was detected")
    assert steps.startswith("llm:a needs fewer steps than llm:b")


def test_agents_that_cannot_be_told_apart_are_said_so():
    ranking, (success, _, steps) = said(("llm:a", (10, 11)), ("llm:b", (10, 10)))
    assert ranking.endswith(
        "No difference between the two was detected on the 40 trials that both played (llm:a 52 %, llm:b 50 %), with "
        "the same false reports."
    )
    assert "(rank 1 to 2)" in ranking
    assert success.startswith("No difference in success between llm:a and llm:b was detected: 52 % against 50 %")
    assert steps.startswith("No difference in the number of steps was detected")


def test_noise_that_helps_one_is_said_with_its_direction():
    _, (_, noise, _) = said(("llm:a", (2, 19)), ("llm:b", (10, 10)))
    assert noise.startswith(
        "False reports affect the two differently: from a flip rate of 0 to 0.4 the success of llm:a rises more, or falls less, "
        "than that of llm:b (+85 points"
    )
    _, (_, other, _) = said(("llm:b", (10, 10)), ("llm:a", (2, 19)))
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


def test_agents_are_ranked_among_those_that_saw_the_box_alike():
    solved = {"rgb": {"llm:a": 19, "llm:b": 1}, "symbolic": {"llm:a": 9, "llm:b": 9}}
    made = [
        make_trial(SOLUTION if i < n else (0,) * 20, agent=agent, p=p, trial=i + 1, modality=modality)
        for modality, agents in solved.items()
        for agent, n in agents.items()
        for p in (0.0, 0.4)
        for i in range(20)
    ]
    ranking = ranking_said(summarise(made))
    first, second = ranking.split("Success over all flip rates, ")[1:]
    assert first.startswith("box shown as rgb (rank of these 2 agents): ")
    assert "95 % (rank 1)" in first
    assert "A difference between the two was detected on the 40 trials that both played (" in first
    assert second.startswith("box shown as symbolic (rank of these 2 agents): ")
    assert second.count("(rank 1 to 2)") == 2
    assert "No difference between the two was detected" in second


def test_several_pairs_are_corrected_and_counted():
    ranking, (success, *_) = said(("llm:a", (18, 19)), ("llm:b", (2, 1)), ("llm:c", (2, 2)))
    assert "Differences were detected in 2 of 3 pairs, on" in ranking
    assert "corrected for 3 pairs" in success


def test_baselines_are_said_to_have_no_rank():
    ranking, _ = said(("llm:a", (10, 11)), ("llm:b", (10, 10)), ("random", (2, 1)))
    assert ranking.startswith("Success over all flip rates (rank of these 2 agents; baselines are not ranked): ")


def test_one_agent_is_not_ranked():
    ranking, (success, *more) = said(("llm:a", (18, 19)), ("random", (2, 1)))
    assert ranking == ""
    assert success.startswith("llm:a solves the box more often than random")
    assert len(more) == 1
