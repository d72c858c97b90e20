"""The first screen: question, answer and key numbers, as rows and on the page."""

import re
from dataclasses import replace
from html import unescape
from urllib.parse import unquote

import pytest
from builders import SOLUTION, make_trial, modality_study, play_study, small_study, study_of, write_study

from lockprobe.boxes.families import box
from lockprobe.foundation.formatting import percent, share
from lockprobe.report.opened import open_study
from lockprobe.report.pages import page_of
from lockprobe.report.report_files import drawn_figure
from lockprobe.report.results import results_of
from lockprobe.report.rows import LeftOut
from lockprobe.report.sections import all_sections
from lockprobe.report.sections.first_screen import SECTIONS, without_answer
from lockprobe.report.sections.key_numbers import condition_numbers
from lockprobe.report.study_numbers import study_numbers
from lockprobe.report.svg import image
from lockprobe.statistics.conditions.effects import effects
from lockprobe.studies.options.studyfile import study
from lockprobe.testing import make_trial as trial_of
from lockprobe.trial.record import TrialError

UNSOLVED = (0, 1, 0, 1)


def found_in(directory, planned, trials=None):
    return results_of(study_numbers(open_study(write_study(directory / "study", planned, trials))))


def screen(page):
    """The text above the first part."""
    return re.sub(r"\s+", " ", re.sub("<[^>]*>", "", page.partition("<body>")[2].partition("<nav>")[0]))


def solving(condition, many, of=40):
    """Trials of which the first ``many`` are solved."""
    trials = [trial_of(list(SOLUTION if i < many else UNSOLVED), trial=i + 1) for i in range(of)]
    return [replace(trial, condition=condition) for trial in trials]


def test_a_study_of_one_condition_that_is_not_the_truth_asks_how_well_agents_open_the_box(tmp_path):
    told = "symbolic?source=verdict"
    trial = make_trial(SOLUTION, agent="human-inspired", modality=told, study="modalities", verdicts=["moved"] * 4)
    found = found_in(tmp_path, modality_study(["human-inspired"], [told], trials=1, plant="rig"), [trial])
    assert found.sections_left_out == ()
    assert "How well do agents open chain-4?" in screen(page_of("report", found))


def test_of_equal_p_values_the_largest_effect_is_the_clearest():
    found = effects({name: solving(name, many) for name, many in (("truth", 10), ("x", 10), ("y", 11))}, "truth")
    assert len({one.difference.p_value for one in found.effects}) == 1
    row = condition_numbers(found, found.agent)
    assert row.against == "clearest change under y"
    assert row.change.startswith("+2")


def test_an_interval_without_0_whose_test_does_not_reject_is_explained(tmp_path):
    """Of 25 pairs, 9 are solved at the flip rate alone and 2 at 0 alone: the exact test does not reject."""
    solved = {0.0: range(1, 12), 0.4: [*range(1, 10), *range(12, 21)]}
    trials = [
        make_trial(SOLUTION if n in own else (0,) * 20, agent="llm:a", p=p, trial=n)
        for p, own in solved.items()
        for n in range(1, 26)
    ]
    planned = study_of(name="flips", agents=("llm:a",), box=box("chain-4"), repetitions=1, trials=25)
    found = found_in(tmp_path, planned, trials)
    row = found.one("clearest_success_difference")
    assert row.low > 0
    assert row.p_value > 0.05
    explained = "A change whose interval excludes 0 is detected only if its test rejects, too."
    assert found.fact("first screen", "undetected") == explained
    assert explained in screen(page_of("report", found))


@pytest.fixture(scope="module")
def models(tmp_path_factory):
    """Five models that false reports help, so that one is left out of the key numbers."""
    agents = [f"llm:acme/{name}" for name in "abcde"]
    trials = [
        make_trial(SOLUTION if i < solved else (0,) * 20, agent=agent, p=p, trial=i + 1)
        for agent in agents
        for p, solved in ((0.0, 3), (0.4, 9))
        for i in range(10)
    ]
    planned = study_of(name="flips", agents=(*agents,), box=box("chain-4"), repetitions=1, trials=10)
    return found_in(tmp_path_factory.mktemp("models"), planned, trials)


def test_the_first_screen_is_in_the_results_and_on_the_page(models):
    said = {one.kind: one for one in models.findings if one.section == "overview"}
    assert [kind for kind, one in said.items() if not one.judges] == ["question", "trial", "untested"]
    assert models.answer == said["answer"].text
    assert models.facts_about("first screen 1") == {
        "agent": "llm:acme/a",
        "success": "30 % [11, 60]",
        "where": "of 10 trials solved when told the truth",
        "change": models.fact("first screen 1", "change"),
        "against": "change from flip rate 0 to 0.4",
    }
    assert models.facts_about("first screen") == {
        "figure": "overview",
        "more": "and 1 more in the sections below",
        "intervals": "Brackets: 95 % intervals, for one look, after all planned trials; changes: corrected for 5 agents.",
        "undetected": "A change whose interval excludes 0 is detected only if its test rejects, too.",
        "random agents": "39 / 69 %",
    }
    assert not models.facts_about("first screen 5")
    top = screen(page_of("report", models))
    shown = [one.text for one in said.values()]
    shown += [fact.text for fact in models.facts if fact.about.startswith("first screen") and fact.name != "figure"]
    assert all(one in top for one in shown)
    assert "Partial" not in top


def test_a_figure_of_several_panels_is_there_with_all_of_them(tmp_path):
    agents = ("cognitive:perseverant", "cognitive:careful")
    found = found_in(tmp_path, study("flips", agent=agents, p=(0,), condition=("nudge", "tremble?p=0.2"), trials=8))
    assert found.fact("first screen", "figure") == "effects"
    (effects_drawn,) = (one for of in all_sections() for one in of.figures if one.name == "effects")
    forms = drawn_figure(found, effects_drawn)
    top = (
        page_of("report", found, {"effects": image(forms["svg"])})
        .partition('<div class="screen">')[2]
        .partition('class="facts"')[0]
    )
    (source,) = re.findall(r'<img src="([^"]*)"', top)
    assert unquote(unescape(source)) == unquote(image(forms["svg"]).source)


def test_quantities_that_the_sentences_rest_on_exist(models):
    known = {row.quantity for row in models.rows}
    for one in models.findings:
        if one.section == "overview":
            assert not one.rests_on or known & {*one.rests_on}, one.kind


def test_several_agents_are_named_and_a_single_one_without_description_is_not(models, tmp_path):
    assert screen(page_of("report", models)).count("llm:acme/d") == 1
    trials = [make_trial(SOLUTION, agent="llm:acme/a", p=p, trial=i) for p in (0.0, 0.4) for i in (1, 2)]
    alone = page_of("report", found_in(tmp_path, small_study(["llm:acme/a"], (0.0, 0.4), 1, 2), trials))
    assert '<div class="numbers only">' in alone
    assert '<p class="who">' not in alone


def test_a_study_that_has_only_begun_has_no_numbers(tmp_path):
    found = found_in(tmp_path, small_study(), [])
    assert found.answer == "No trial has ended yet."
    assert not found.facts_about("first screen")
    assert "Partial: 0 of 48 trials." in screen(page_of("report", found))


@pytest.mark.parametrize("p", [(0.0, 0.4), (0.4,)])
@pytest.mark.parametrize("other", ["llm:b", "random", "human-inspired"])
def test_an_agent_that_always_breaks_is_named_and_the_others_are_judged(tmp_path, other, p):
    planned = small_study(["llm:a", other], p, 1, 2)
    trials = [
        make_trial((0,), agent=agent, p=rate, trial=i, broken="reply")
        if agent == "llm:a"
        else make_trial(SOLUTION, agent=agent, p=rate, trial=i)
        for agent in planned.agents
        for rate in p
        for i in (1, 2)
    ]
    found = found_in(tmp_path, planned, trials)
    named, _, rest = found.answer.partition(". ")
    assert named == f"All {2 * len(p)} trials of llm:a ended as an error"
    assert other in rest
    assert (found.fact("first screen 1", "agent"), found.fact("first screen 2", "agent")) == (other, "")
    alone = found_in(tmp_path / "alone", planned, trials[: 2 * len(p)])
    assert alone.answer == f"{named}."


def test_one_that_breaks_under_every_condition_is_named_too(tmp_path):
    asked = {"p": [0], "condition": ["drop?p=0.5"], "trials": 2, "repetitions": 1}
    planned = study("flips", agent=["cognitive:careful", "human-inspired"], **asked)
    broken = {"steps": (), "ending": "error", "error": TrialError(boundary="reply", message="!", step=1), "changed": {}}
    trials = [
        replace(one, **broken, changed_steps=0) if one.agent == "cognitive:careful" else one
        for one in play_study(planned)
    ]
    found = found_in(tmp_path, planned, trials)
    assert found.answer.startswith(
        "All 4 trials of cognitive:careful ended as an error. Inconclusive: no effect of drop?p=0.5 on"
    )
    assert found.fact("first screen 1", "agent") == "human-inspired"


def test_attempts_against_the_rules_stand_in_the_answer(tmp_path):
    """A free joint that does not move breaks the rules of the box."""
    trials = [make_trial((3, 2, 0, 1, 0), agent="llm:a", p=p, trial=i) for p in (0.0, 0.4) for i in (1, 2)]
    missed = replace(trials[0].steps[0], moved=False)
    trials[0] = replace(trials[0], steps=(missed, *trials[0].steps[1:]))
    found = found_in(tmp_path, small_study(["llm:a"], (0.0, 0.4), 1, 2), trials)
    assert found.answer.startswith("Inconclusive: ")
    assert found.answer.endswith(" 1 of 20 attempts broke the rules of the box.")
    (answer,) = [one for one in found.findings if (one.section, one.kind) == ("overview", "answer")]
    assert "against_rules" in answer.rests_on
    assert found.said("overview", "chance") == []


def test_no_answer_stands_where_its_numbers_are_missing(models):
    failed = (LeftOut(section="All numbers of trials", reason="RuntimeError"),)
    assert without_answer(models.changed(sections_left_out=failed)).answer == models.answer
    empty = models.changed(sections_left_out=failed, facts=())
    assert without_answer(empty.changed(sections_left_out=())).answer == models.answer
    for answer in (without_answer(empty).answer, without_answer(empty).answer_of("overview")):
        assert answer.startswith("The answer could not be computed")


def test_a_caption_names_stars_and_bars_only_where_they_are_drawn(models, tmp_path):
    """They are drawn over flip rates, stars if these hold one of the paper's."""
    (figure, *_) = SECTIONS[0].figures
    single = found_in(tmp_path / "one", small_study(["random"], (0.0,), 1, 2))
    beyond = found_in(tmp_path / "beyond", small_study(["random"], (0.5, 0.6), 1, 2))
    said = [figure.caption(found).shown for found in (models, single, beyond)]
    assert ["Stars" in one for one in said] == [True, False, False]
    assert ["Bars" in figure.caption(found).computed for found in (models, single, beyond)] == [True, False, True]


def test_other_conditions_and_flip_rates_share_a_screen(tmp_path):
    planned = study("flips", agent=["cognitive:careful"], p=[0, 0.4], condition=["nudge"], trials=6, repetitions=1)
    found = found_in(tmp_path, planned)
    (question,) = found.said("overview", "question")
    assert question == "Do false reports and 1 other condition change how agents open chain-4?"
    where = "of 6 trials solved when told the truth"
    assert [found.fact(f"first screen {i}", "where") for i in (1, 2)] == [where, where]
    page = page_of("report", found)
    assert page.count(where) == page.count('<p class="who">') == 1  # one card, with both changes
    assert all(page.count(f">{found.fact(f'first screen {i}', 'against')}<") == 1 for i in (1, 2))
    assert found.fact("first screen", "figure") == "overview"


@pytest.mark.parametrize(
    ("kept", "said"),
    [
        ([], "No two conditions have a trial in common yet."),
        (
            ["random"],
            "Too few trials for an answer: random has finished 1 of 2 trials and round-robin none of 2.",
        ),
        (
            ["random", "round-robin"],
            "Too few trials for an answer: random has finished 1 of 2 trials and round-robin 1 of 2.",
        ),
    ],
)
def test_while_no_two_conditions_share_a_trial_the_screen_says_so(tmp_path, kept, said):
    """Only the control of these agents has been played."""
    planned = study("flips", agent=["random", "round-robin"], condition=["nudge"], p=[0], trials=1, repetitions=1)
    trials = [one for one in play_study(planned) if one.agent in kept and one.condition == "truth"]
    found = found_in(tmp_path, planned, trials)
    assert found.answer == said
    assert not found.facts_about("first screen")
    assert {one.kind for one in found.findings if one.section == "overview"} == {
        "question",
        "trial",
        "answer",
        "every_look",
    }


def test_an_idle_condition_is_the_answer_only_where_nothing_else_is(tmp_path):
    asked = {"agent": ["cognitive:careful"], "trials": 6, "repetitions": 1}
    idle = {"condition": ["history?last=50"]}
    said = "history?last=50 changed nothing"
    only, beside, alone = (
        found_in(tmp_path / name, study("flips", **asked, **more))
        for name, more in (
            ("only", {"p": [0], **idle}),
            ("beside", {"p": [0, 0.4], **idle}),
            ("alone", {"p": [0, 0.4]}),
        )
    )
    assert only.answer.startswith(said)
    assert not only.said("overview", "changed_nothing")
    assert beside.answer == alone.answer
    assert said in beside.said("overview", "changed_nothing")[0]


def test_no_other_condition_is_spoken_of_where_agents_play_alike(tmp_path):
    asked = {"agent": ["round-robin"], "p": [0, 0.4], "condition": ["tremble?p=0.9"], "trials": 6, "repetitions": 1}
    found = found_in(tmp_path, study("flips", **asked))
    assert "at every flip rate" in found.answer
    assert "under every condition" not in found.answer


def test_who_does_not_exceed_chance_is_named_beside_the_level(tmp_path):
    asked = {"agent": ["cognitive:perseverant"], "p": [0], "condition": ["nudge"], "trials": 8, "repetitions": 2}
    found = found_in(tmp_path, study("flips", **asked))
    own = found.one("success", agent="cognitive:perseverant", condition="truth", axis="", control="", versus="")
    level = found.one("success_chance", of="no-repeat", axis="").value
    assert own.low < level
    (said,) = found.said("overview", "chance")
    assert said.startswith("When told the truth, ")
    assert said.endswith(f" random agents without immediate repeats ({percent(level)}).")
    assert found.fact("first screen 1", "success") == share(own.value, own.low, own.high)
