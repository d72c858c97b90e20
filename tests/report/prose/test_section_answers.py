"""Each section of a report has one sentence in its heading, with the numbers of the summary."""

import pytest
from builders import SOLUTION, make_trial, play_study, small_study, write_study

from lockprobe.boxes.families import box
from lockprobe.report.pages import parts_of
from lockprobe.report.prose.section_answers import section_answers
from lockprobe.report.results import results
from lockprobe.statistics.summary import summarise
from lockprobe.studies.options.studyfile import study


def test_every_section_has_one_short_sentence_with_the_numbers_of_its_agents():
    planned = small_study(["human-inspired", "cognitive:insistent", "random"], (0.0, 0.4), 1, 8)
    summary = summarise(play_study(planned), box("chain-4"))
    found = section_answers(summary)
    assert set(found) == {
        "agents_compared",
        "speed",
        "loops",
        "optimal_actions",
        "hypothesis_tests",
        "misinterpretations",
    }
    assert all(said.endswith(".") and len(said.split()) <= 28 for said in found.values())
    (subject,) = summary.subjects
    first = subject.conditions[0]
    loops, chance = first.behaviour.loops, first.behaviour.chance_uniform
    assert found["loops"].startswith(
        f"Trials with a loop when told the truth (chance): {100 * loops.value:.0f} % ({100 * chance:.0f} to "
    )
    assert found["loops"].endswith(" %) cognitive:insistent.")
    assert found["speed"].startswith("Area under the success curve when told the truth (random agent 0")
    assert found["optimal_actions"] == (
        f"When told the truth: {100 * first.optimal.share.value:.0f} % cognitive:insistent."
    )


def test_tests_are_counted_for_each_agent():
    agents = ("llm:a", "llm:b")
    trials = [
        make_trial(SOLUTION if i < solved else (0, 1, 2) * 6, agent=agent, p=p, trial=i + 1)
        for agent, by_p in zip(agents, ((2, 18), (9, 9)), strict=True)
        for p, solved in zip((0.0, 0.4), by_p, strict=True)
        for i in range(20)
    ]
    summary = summarise(trials, box("chain-4"))
    done = [[t.rejects for t in a.inference.tests if t.p_value is not None] for a in summary.agents]
    said = section_answers(summary)["hypothesis_tests"]
    assert len(done[0]) == len(done[1])
    n = len(done[0])
    assert said == f"Recommended tests that reject: {sum(done[0])}/{n} for llm:a, {sum(done[1])}/{n} for llm:b."
    assert sum(done[0]) > sum(done[1])


def test_misread_claims_are_pooled_as_in_the_tables():
    """One claim of one is misread, and none of three: 25 % of all claims, while the mean over trials is 50 %."""
    trials = [
        make_trial((0, 0), agent="llm:a", claims=[None, "moved"], trial=1, budget=2),
        make_trial((0,) * 4, agent="llm:a", claims=[None, *["blocked"] * 3], trial=2, budget=4),
    ]
    summary = summarise(trials, box("chain-4"))
    assert summary.agents[0].conditions[0].claims.mean_rate == 0.5
    said = section_answers(summary)["misinterpretations"]
    assert said == "When told the truth: 25 % llm:a."


def test_nothing_is_said_of_a_study_without_trials():
    assert section_answers(summarise([make_trial([], broken="model")], box("chain-4"))) == {}


def test_a_tie_for_the_highest_success_names_all():
    trials = [
        make_trial(SOLUTION if i < 4 else (0, 1, 2) * 6, agent=agent, trial=i + 1)
        for agent in ("llm:a", "llm:b")
        for i in range(8)
    ]
    assert (
        section_answers(summarise(trials, box("chain-4")))["agents_compared"]
        == "Highest success: llm:a, llm:b, 50 % each."
    )


def test_an_agent_that_was_shown_the_box_in_two_ways_is_named_with_each():
    shown = ("symbolic", "symbolic?tell=state")
    trials = [make_trial(SOLUTION, agent="llm:a", modality=one, trial=i + 1) for one in shown for i in range(8)]
    assert section_answers(summarise(trials, box("chain-4")))["agents_compared"] == (
        "Highest success: llm:a (positions and outcomes in words), llm:a (positions in words), 100 % each."
    )


@pytest.mark.parametrize("agents", [("viewer", "human-inspired"), ("random",)])
def test_every_folded_heading_says_something_even_where_nothing_was_solved_or_tested(tmp_path, agents):
    planned = study("flips", agent=agents, p=[0], trials=1, repetitions=1, max_steps=3)
    found = results(write_study(tmp_path / "study", planned))
    parts = {part.heading: part.answer for part in parts_of(found, "report") if part.name not in ("overview", "trials")}
    assert {"Hypothesis tests", "Action loops", "Speed"} <= parts.keys()
    assert [heading for heading, answer in parts.items() if not answer] == []
