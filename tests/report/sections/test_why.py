"""``why.html``: the verdict first, numbers that are those of the records, and a trial told twice."""

from dataclasses import replace
from html import unescape

import pytest
from builders import SOLUTION, make_trial, play_study, write_study
from captions import too_long

from lockprobe.report.opened import open_study
from lockprobe.report.pages import page_of, parts_of, tables_of
from lockprobe.report.results import results_of
from lockprobe.report.study_numbers import study_numbers
from lockprobe.studies.journal import load
from lockprobe.studies.studyfile import study

AGENTS = ["world:perseverant", "world:lost-half"]


def found_in(directory, name="why", **asked):
    return results_of(study_numbers(open_study(write_study(directory, study(name, **asked)))))


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """The directory of a small study of controls, and its results."""
    directory = tmp_path_factory.mktemp("why") / "study"
    return directory, found_in(directory, agent=AGENTS, trials=20, repetitions=1)


def test_every_agent_has_its_arms_as_recorded(told):
    directory, found = told
    trials, rows = load(directory), found.where("success_in_arm")
    for row in rows:
        own = [trial.solved for trial in trials if (trial.agent, trial.condition) == (row.agent, row.condition)]
        assert (row.n, row.count) == (len(own), sum(own))
    assert [row.of for row in rows if row.agent == AGENTS[0]][:3] == ["truth", "lie", "retracted"]
    total = found.one("false_report_effect", agent=AGENTS[0], of="total")
    parts = [found.one("false_report_effect", agent=AGENTS[0], of=of).value for of in ("content", "disturbance")]
    assert total.value == pytest.approx(sum(parts))


def test_the_page_begins_with_the_verdicts(told):
    _, found = told
    page, said = unescape(page_of("why", found, {"why": {"svg": b"<svg/>"}})), found.said("why", "verdict")
    assert len(said) == len(AGENTS)
    assert max(map(page.index, said)) < page.index("<figure")
    assert "<script" not in page
    (conclusion,) = found.said("why", "conclusion", agent=AGENTS[1])
    margin = found.one("equivalence_margin", agent=AGENTS[1])
    assert conclusion == ("no change" if margin.p_value < 0.05 else "not detectable")


def test_a_trial_is_told_twice_from_where_the_two_part(told):
    directory, found = told
    by_key = {trial.key: trial for trial in load(directory)}
    first, second = (one for one in found.exhibits if one.section == "why")  # the other agent plays alike
    truth, lie = by_key[first.key], by_key[second.key]
    assert [first.of, second.of, first.agent] == ["truth", "lie", AGENTS[0]]
    assert (truth.repetition, truth.trial) == (lie.repetition, lie.trial)
    assert (truth.condition, lie.condition) == ("truth", "lie")
    assert truth.solved != lie.solved
    before = first.parted - 1
    assert first.parted == second.parted
    assert truth.actions[:before] == lie.actions[:before]
    assert truth.actions[before : before + 1] != lie.actions[before : before + 1]
    page = page_of("why", found)
    assert page.count('<ol class="strip">') == page.count('<li class="parted">') == 2


def test_the_trial_told_twice_is_the_first_with_different_outcomes_in_either_direction(tmp_path):
    planned = study("why", agent=AGENTS[0], trials=8, repetitions=1)
    trials = play_study(planned)
    outcomes = {("truth", 3): True, **{("lie", i): True for i in (5, 6, 7)}}
    made = [_ended(one, solved=outcomes.get((one.condition, one.trial), False)) for one in trials]
    found = results_of(study_numbers(open_study(write_study(tmp_path / "study", planned, made))))
    assert found.one("false_report_effect", of="total").value > 0
    first, second = (one for one in found.exhibits if one.section == "why")
    third = {one.condition: one.key for one in made if one.trial == 3}
    assert [first.key, second.key] == [third["truth"], third["lie"]]
    assert (first.ending, second.ending) == ("solved", "budget")


def _ended(trial, *, solved):
    """The trial with steps that solve the box, or do not."""
    made = make_trial(SOLUTION if solved else (0,) * 20)
    return replace(trial, steps=made.steps, ending=made.ending, changed={}, changed_steps=0)


def test_tables_have_every_estimand(told):
    tables = tables_of(told[1])
    assert [len(tables[name]) for name in ("why", "arms")] == [1 + 2 * 6, 1 + 2 * 9]


def test_on_a_narrow_screen_each_estimate_and_each_arm_is_a_card(told):
    cards = [part.partition("</table>")[0] for part in page_of("why", told[1]).split('<table class="cards">')[1:]]
    assert [part.count('data-head="P"') for part in cards] == [2 * 6, 2 * 9]


def test_where_nobody_is_judged_no_verdict_stands(told):
    _, found = told
    kept = [one for one in found.findings if not one.judges]
    assert all(one.judges for one in found.findings if one.section == "why")
    page = page_of("why", found.changed(findings=kept, not_judged="No agent is judged."))
    assert page.count("No agent is judged.") == len(AGENTS)
    assert "The effect of false reports and its two parts, for 2 agents." in page


def test_other_studies_have_no_such_page(tmp_path):
    asked = {"agent": "random", "sweep": "tremble?p=0,0.2", "trials": 2, "repetitions": 1}
    found = found_in(tmp_path / "study", "flips", **asked)
    assert parts_of(found, "why") == []
    assert tables_of(found)["why"] == tables_of(found)["arms"] == []


def test_captions_are_short(told):
    page = page_of("why", told[1])
    assert too_long(page, told[1].plain()) == []
    assert "How is this computed?" in page
