"""What was found, in sentences: of all agents first where there are many, and of plant and panel."""

import re
from html import unescape

from builders import SOLUTION, make_trial, modality_study, small_study, study_of, write_study
from page_parts import part

from lockprobe.boxes.families import box
from lockprobe.report.opened import open_study
from lockprobe.report.pages import page_of
from lockprobe.report.prose.loops import LOOP_DEFINITION
from lockprobe.report.results import results_of
from lockprobe.report.study_numbers import study_numbers
from lockprobe.studies.options.studyfile import study


def found_in(directory, planned, trials=None):
    return results_of(study_numbers(open_study(write_study(directory / "study", planned, trials))))


def part_of(found, name="findings", page="report"):
    """A part of a page."""
    return part(page_of(page, found), name)


def plain(page):
    """A part with P values in plain letters."""
    return unescape(page.replace("<i>P</i>", "P"))


def lines(found):
    """What the lines of the findings say, and the test behind each."""
    items = re.findall(r"<li>(.*?)</li>", plain(part_of(found)))
    parted = [re.fullmatch(r"(?:<details><summary>)?(.*?)(?:</summary>(.*)</details>)?", item) for item in items]
    return [(one[1], one[2] or "") for one in parted]


def words(sentence):
    """The words of a sentence, in the order of the alphabet: a line has those of the test last."""
    return sorted(re.findall(r"[^\s().,;]+", sentence))


def written(found):
    """The words of each line with its test."""
    return [words(f"{said} {test}") for said, test in lines(found)]


def test_a_study_of_many_agents_begins_with_who_rises_and_who_falls(tmp_path):
    agents = ("cognitive:careful", "cognitive:perseverant", "human-inspired?lapse=0.3", "llm:local")
    trials = [
        make_trial(SOLUTION if i < solved else (0,) * 20, agent=agent, p=p, trial=1 + (i + round(7 * p)) % 30)
        for agent, rises in zip(agents, (False, True, False, True), strict=True)
        for p, solved in ((0.0, 5 if rises else 25), (0.4, 25 if rises else 5))
        for i in range(30)
    ]
    found = found_in(
        tmp_path, study_of(name="flips", agents=agents, box=box("chain-4"), repetitions=1, trials=30), trials
    )
    said = (
        "higher at some flip rate for cognitive:perseverant, llm:local; lower for cognitive:careful, "
        "human-inspired?lapse=0.3"
    )
    (courses,) = found.said("findings", "courses")
    assert courses == (
        f"Success compared with flip rate 0: {said}. Tests are corrected for 3 agents and, apart, for 1 baseline "
        "(Bonferroni)."
    )
    assert courses in plain(part_of(found))
    assert all(words(one) in written(found) for one in found.said("findings", "finding"))
    assert '<a href="details.html#findings">Agent by agent</a>' in part_of(found)
    details = plain(part_of(found, page="details"))
    assert "<h3>Agent by agent</h3>" in details
    assert all(one in details for one in found.said("findings", "finding"))


def test_every_sentence_stands_on_the_page_and_belongs_to_its_agent(tmp_path):
    found = found_in(tmp_path, small_study(("human-inspired", "cognitive:careful"), (0.0, 0.3, 0.6)))
    assert all(words(said) in written(found) for said in found.said("findings"))
    assert [one.agent for one in found.findings if one.kind == "finding" and one.section == "findings"] == [
        "cognitive:careful"
    ]
    assert "Flip rate <i>p</i>" in part_of(found)


def test_agents_that_play_alike_have_every_line_under_their_own_name(tmp_path):
    """A line says "the agent": of two agents it names which, and equal lines are not taken for one."""
    agents = ("cognitive:perseverant", "llm:a")
    trials = [
        make_trial(SOLUTION if n <= solved else (0, 1, 2, 0) * 5, agent=agent, p=p, trial=n)
        for agent in agents
        for p, solved in ((0.0, 3), (0.4, 12))
        for n in range(1, 16)
    ]
    planned = study_of(name="flips", agents=agents, box=box("chain-4"), repetitions=1, trials=15)
    found = found_in(tmp_path, planned, trials)
    shown = [said for said, _ in lines(found)]
    first, second = ([one for one in shown if one.startswith(f"{agent}: ")] for agent in agents)
    assert [one.removeprefix(f"{agents[0]}: ") for one in first] == [one.removeprefix("llm:a: ") for one in second]
    assert any("Action loops occur in" in one for one in first)
    assert any("False reports decrease the mean number of steps" in one for one in first)
    assert not any(one.startswith(("Action loops", "False reports decrease")) for one in shown)


def test_the_test_of_a_finding_stands_behind_its_sentence(tmp_path):
    found = found_in(tmp_path, small_study(("cognitive:perseverant",), (0.0, 0.4), 2, 10))
    tested = [(said, test) for said, test in lines(found) if test]
    assert tested
    for said, test in tested:
        assert re.search(r"\bP [=<] ", test)
        assert not re.search(r"\bP [=<] ", said)
        assert said.endswith(".")


def test_a_sweep_alone_has_its_finding_first_and_what_baselines_solved_after_it(tmp_path):
    agents = ["cognitive:perseverant", "random"]
    small = {"agent": agents, "trials": 4, "repetitions": 1, "p": [0]}
    found = found_in(tmp_path, study("flips", **small, sweep="tremble?p=0.1,0.3,0.6"))
    ((finding,), (baselines,)) = found.said("doses", "finding"), found.said("findings", "baselines")
    first, *others = written(found)
    assert first == words(finding)
    assert words(baselines) in others


def test_an_action_loop_is_defined_where_it_is_first_named(tmp_path):
    found = found_in(tmp_path, small_study(["random"], (0.0,), 1, 2))
    assert LOOP_DEFINITION in part_of(found)
    assert f"{LOOP_DEFINITION} A loop is no fault by itself" in part_of(found, "loops")


def test_only_a_study_without_trials_is_said_to_have_none(tmp_path):
    said = "No trial has been played yet."
    assert said in part_of(found_in(tmp_path / "a", small_study(), []))
    broken = make_trial([], agent="random", p=0.3, broken="model")
    assert said not in part_of(found_in(tmp_path / "b", small_study(["random"]), [broken]))


def test_what_is_said_of_plant_and_panel_judges_nobody(tmp_path, modal):
    found = found_in(tmp_path, modality_study(), modal)
    judged = {one.kind: one.judges for one in found.findings if one.section == "findings"}
    assert judged.items() >= {"modalities": True, "verdicts": False, "panel": False}.items()
    wrong = found.one("wrong_verdicts")
    parts = [found.one("wrong_verdicts", of=of) for of in ("blocked for moved", "moved for blocked")]
    assert wrong.count == sum(row.count for row in parts)
    assert found.one("undecided_verdicts").count == 0
    assert f"was wrong at {wrong.count} of {wrong.n} attempts" in plain(part_of(found))
    assert written(found)[0] == words(found.said("findings", "modalities")[0])
    assert "Agent by agent</a>" in part_of(found)


def test_conditions_that_changed_nothing_are_named(tmp_path):
    planned = study("flips", agent=["cognitive:careful"], p=[0], condition=["history?last=50"], trials=3, repetitions=1)
    found = found_in(tmp_path, planned)
    (said,) = found.said("findings", "conditions")
    assert said.startswith("history?last=50 changed nothing")
    assert f"<li>{said}</li>" in part_of(found)


def test_the_verdict_of_a_study_of_controls_comes_first(tmp_path):
    found = found_in(tmp_path, study("why", agent=["cognitive:careful"], trials=4, repetitions=1))
    (said, *_) = found.said("why", "verdict")
    part = part_of(found)
    assert f'<p class="first">{said} <a href="why.html">' in part
    assert '<a href="why.html">' in page_of("report", found).partition("<nav>")[2].partition("</nav>")[0]
    (again,) = found.said("findings", "finding")
    assert words(again) not in written(found)  # the same difference, by another test
    assert words(found.said("findings", "loops")[0]) in written(found)
