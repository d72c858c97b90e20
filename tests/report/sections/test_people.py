"""People in the rows, in the tables and on the page; and nothing of them where nobody was asked."""

import re
import statistics
from dataclasses import replace

import pytest
import seated
import strangers
from builders import SOLUTION, make_trial, play_study, played_by_people, small_study, write_study
from captions import too_long
from seated import under
from taking_part import take_part

from lockprobe.foundation.formatting import NONE
from lockprobe.foundation.plugins import allow
from lockprobe.people.progress import Flow
from lockprobe.people.withdrawal import put
from lockprobe.report.opened import open_study
from lockprobe.report.pages import page_of, tables_of
from lockprobe.report.people_said import conditions_said, flow_said
from lockprobe.report.results import results_of
from lockprobe.report.sections.people import _caption
from lockprobe.report.study_numbers import study_numbers
from lockprobe.statistics.people import people
from lockprobe.studies.records.journal import load
from lockprobe.studies.running.runner import run_study
from lockprobe.trial.record import TrialError

STUDY = small_study(("participant", "random", "round-robin"), (0.0, 0.4), 2, 5)
PLAYED = 14
THEIRS = {"agent": "participant", "modality": "", "condition": ""}


def found_in(path):
    return results_of(study_numbers(open_study(path)))


def with_people(path, study, trials):
    """The results of a study with these trials of people, and those of its agents as they play."""
    agents = tuple(agent for agent in study.agents if agent != "participant")
    played = play_study(replace(study, agents=agents)) if agents else []
    return found_in(write_study(path / "study", study, [*played, *trials]))


def values(found, quantity, **columns):
    return {row.of: row.value for row in found.where(quantity, **columns)}


def table(found, name):
    head, *rows = tables_of(found)[name]
    return [dict(zip(head, row, strict=True)) for row in rows]


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    return with_people(tmp_path_factory.mktemp("people"), STUDY, played_by_people(STUDY, 2)[:PLAYED])


def test_places_of_people_are_a_part_of_the_plan(found):
    assert (found.progress.planned, found.progress.finished) == (60, 40 + PLAYED)
    assert values(found, "boxes", **THEIRS) == {"planned": 20, "finished": PLAYED}


def test_people_are_counted_by_person_and_by_first_boxes(found):
    assert found.one("people", **THEIRS).value == 7
    assert values(found, "boxes_each", **THEIRS) == {"fewest": 2, "most": 2}
    assert [found.one("success", **THEIRS, of=f"position={i}").n for i in (1, 2)] == [7, 7]
    assert [row.condition for row in found.where("people")] == ["", "truth", "flip?p=0.4", ""]
    assert found.one("trials_shown", of="view=panel").value == PLAYED


def test_every_agent_stands_beside_people_on_the_trials_of_both(found):
    rows = found.where("mean_steps_ratio", versus="participant")
    assert [(row.agent, row.condition, row.n) for row in rows] == [
        (agent, condition, n)
        for agent in ("random", "round-robin")
        for condition, n in (("truth", 7), ("flip?p=0.4", 7), ("", 14))
    ]
    assert all(row.value > 0 for row in rows)


def test_people_are_one_agent_in_every_other_number(found):
    cells = [cell.condition for cell in found.cells if cell.agent == "participant"]
    assert cells == ["truth", "flip?p=0.4"]
    assert found.fact("participant", "position") == "1; 2"
    assert "participant:" not in str(found.plain())


def test_the_page_says_how_many_and_what_sets_people_apart(found):
    page = page_of("report", found)
    assert page.count(f"{PLAYED} of 20 boxes for people were played; 6 are still available.") == 1
    assert "people remember earlier boxes, models do not" in page
    assert "reports as panel" in page
    assert "participant:0" not in page
    assert "performance.now" not in page


def test_tables_for_papers(found):
    assert [row["flip rate"] for row in table(found, "people")] == ["0", "0.4", "all"]
    assert [row["agent"] for row in table(found, "people-steps")][::3] == ["random", "round-robin"]
    assert [row["position"] for row in table(found, "people-positions")] == ["1", "2"]
    assert "ms per choice" not in table(found, "people")[0]


STUCK = "python:strange:First"
"""Always the same joint: it solves nothing."""


@pytest.mark.parametrize(
    ("people", "agent", "median", "compared", "ratio"),
    [
        ("human-inspired", STUCK, "Half of the boxes were open by step", f"{STUCK} needs at least ", "at least "),
        (
            STUCK,
            "human-inspired",
            "They opened fewer than half of the boxes, so",
            "human-inspired needs at most ",
            "at most ",
        ),
        (STUCK, STUCK, "They opened fewer than half of", f"Neither {STUCK} nor people solved half of the 6", NONE),
        (
            "round-robin",
            "round-robin",
            "Half of the boxes were open by step",
            "round-robin needs 1.00 times (95 % interval 1.00 to 1.00) the human median",
            "1.00 [1.00, 1.00]",
        ),
    ],
)
def test_where_a_median_is_beyond_the_budget_there_is_a_bound(
    tmp_path, monkeypatch, people, agent, median, compared, ratio
):
    strangers.install(tmp_path, monkeypatch)
    allow(STUCK)
    study = small_study(("participant", agent), (0.0,), 1, 6)
    found = with_people(tmp_path, study, played_by_people(study, 1, people))
    _, steps, said, _ = found.said("people")
    assert steps.startswith(median)
    assert said.startswith(compared)
    assert "on the 6 trials that both played" in said or "of the 6 trials that both played" in said
    assert ("since it solved fewer than half" in said) == ("at least" in said)
    assert ("since people solved fewer than half" in said) == ("at most" in said)
    (row,) = table(found, "people-steps")
    assert row["ratio"].startswith(ratio)
    assert ("beyond the budget" in row["median steps"]) == (agent == STUCK)
    assert ("beyond the budget" in row["median of people"]) == (people == STUCK)
    assert ("open" in row["ratio"]) == ("at" in ratio)


def test_before_anybody_came_the_report_says_so(tmp_path):
    found = with_people(tmp_path, small_study(("participant", "random"), (0.0,), 1, 3), [])
    assert values(found, "boxes") == {"planned": 3, "finished": 0}
    assert not found.said("people")
    assert "0 of 3 boxes for people were played; 3 are still available." in page_of("report", found)
    assert tables_of(found)["people"] == tables_of(found)["people-steps"] == tables_of(found)["people-positions"] == []


def test_people_alone_are_reported_too(tmp_path):
    study = small_study(("participant",), (0.0, 0.4), 1, 3)
    found = with_people(tmp_path, study, played_by_people(study, 2))
    assert not found.progress.partial
    assert not found.where("mean_steps_ratio")
    assert "3 people opened" in found.said("people")[0]


def test_a_study_of_people_is_partial_until_every_place_is_filled(tmp_path):
    study = small_study(("participant",), (0.0, 0.4), 1, 3)
    found = with_people(tmp_path, study, played_by_people(study, 2)[:4])
    assert (found.progress.planned, found.progress.finished, found.progress.partial) == (6, 4, True)


def test_a_place_that_two_people_played_is_filled_once():
    study = small_study(("participant",), (0.0,), 1, 3)
    first, second, *_ = played_by_people(study, 2)
    again = replace(first, agent="participant:zzzz99")
    assert study.places_filled([first, again, second]) == 2
    broken = replace(second, ending="error", error=TrialError(boundary="plant", message="gone", step=1))
    assert study.places_filled([first, broken]) == 1


def test_without_people_nothing_is_said_of_them(tmp_path):
    found = found_in(write_study(tmp_path / "study", small_study(("random",), (0.0,), 1, 3)))
    assert not found.where("boxes")
    assert "eople" not in page_of("report", found).split("</style>")[-1]


def test_the_page_says_who_came_to_the_end_and_how_long_choices_took(tmp_path):
    study = small_study(("participant", "random"), (0.0, 0.4), 1, 3)
    path = write_study(tmp_path / "study", study, [])
    take_part(path, study, "aaaa01", [(0.4, 1, 1), (0.0, 1, 2)])
    take_part(path, study, "bbbb02", [(0.0, 1, 1), (0.4, 1, 2)], left_after=1, check=False)
    put(path / "people" / "withdrawn.json", {"withdrawn": 1})
    found = found_in(path)
    assert values(found, "participants") == {
        "consented": 3, "withdrawn": 1, "screened": 0, "left_open": 1, "finished": 1, "analysed": 2,
    }  # fmt: skip
    assert values(found, "boxes", condition="truth") == {"given": 2, "left_open": 0}
    assert values(found, "boxes", condition="flip?p=0.4") == {"given": 2, "left_open": 1}
    page = page_of("report", found)
    assert (
        "3 people agreed to take part: 1 withdrew (their data are deleted), 1 left boxes unfinished or is still playing, "
        "1 finished all their boxes. 2 are in the analysis, with at least one finished box." in page
    )
    assert "Unfinished boxes, by condition: 0 of 2 under truth, 1 of 2 under flip?p=0.4." in page
    checks = found.one("attention_checks")
    assert f"Attention checks: {checks.count} of {checks.n} answered correctly." in page
    lies, truth, both = (found.where("response_time", condition=condition) for condition in ("flip?p=0.4", "truth", ""))
    steps = [step.step for trial in load(path) for step in trial.steps if trial.p == 0.4]
    assert (lies[0].n, lies[-1].of, lies[-1].value) == (len(steps), "first choices", 1001.5)  # the diary says 1000.5 ms
    assert lies[0].value == 1000.5 + statistics.median(steps)  # and the step
    assert both[0].n == truth[0].n + lies[0].n
    row = next(row for row in table(found, "people") if row["flip rate"] == "0.4")
    assert row["ms of first choices"] == "1002"
    assert row["ms per choice"].startswith(f"{lies[0].value:.0f} [")
    assert "performance.now" in page


def test_people_stand_beside_agents_under_every_condition(tmp_path):
    """Effects, conditions, speed and loops have them, and so does the section on people."""
    conditions = ("truth", "flip?p=0.4", "flip?p=0.4 + nudge", "reword?p=1", "tremble?p=0.3")
    study = under(*conditions, agents=("random", "participant"), trials=5)
    run_study(study, tmp_path)
    seated.take_part(tmp_path, study, seated.short(), people=5)
    found = found_in(tmp_path)
    own = {one: [trial for trial in load(tmp_path) if trial.player and trial.condition == one] for one in conditions}
    assert values(found, "boxes", condition="")["finished"] == found.one("success", **THEIRS, of="by person").n == 25
    counted = {row.condition: (row.count, row.n) for row in found.where("success", of="by person") if row.condition}
    assert counted == {one: (sum(trial.solved for trial in trials), 5) for one, trials in own.items()}
    assert found.one("success", condition="tremble?p=0.3", of="by person").doses == {"tremble.p": 0.3}
    times = {row.condition: row.n for row in found.where("response_time", of="")}
    steps = {one: sum(len(trial.steps) for trial in trials) for one, trials in own.items()}
    assert times == steps | {"": sum(steps.values())}
    ratios = {row.condition: row.n for row in found.where("mean_steps_ratio", versus="participant")}
    assert ratios == dict.fromkeys(conditions, 5) | {"": 25}
    (said,) = [one for one in found.said("people") if one.startswith("Boxes opened, with")]
    assert [f"] under {one}" in said for one in conditions] == [True] * 5
    assert [row["condition"] for row in table(found, "people")] == [*conditions, "all"]
    assert [row["condition"] for row in table(found, "people-steps")] == [*conditions, "all"]
    for part in ("conditions", "effects", "speed", "loops"):
        rows = [row for row in table(found, part) if row["agent"] == "participant"]
        theirs = {row["condition"] for row in rows}
        assert theirs == set(conditions) - ({"truth"} if part == "effects" else set()), part
        assert len(rows) == len(theirs)


def test_a_sentence_names_conditions_as_far_as_there_is_room():
    trials = [
        replace(make_trial(SOLUTION, agent=f"participant:{who}"), condition=condition)
        for condition in ("one", "two")
        for who in ("aaaa", "bbbb")
    ]
    (said,) = conditions_said(people(trials), {"one": "under one", "two": "under two"})
    assert re.fullmatch(r"Boxes opened, with 95 % intervals: 100 % \[.*\] under one, 100 % \[.*\] under two\.", said)
    assert not [*conditions_said(people(trials), {"one": "under one" * 9, "two": "under two" * 9})]
    assert not [*conditions_said(people(trials[:2]), {"one": "under one"})]


def flow(**counts):
    return Flow(**{**dict.fromkeys(Flow.__dataclass_fields__, 0), "boxes": (), **counts})


def test_the_flow_of_participants_is_said_as_far_as_there_is_any():
    (gone,) = flow_said(flow(consented=2, withdrawn=2), 0)
    assert gone.startswith(
        "2 people agreed to take part: 2 withdrew (their data are deleted), 0 finished all their boxes."
    )
    said, rounds = flow_said(flow(consented=9, screened=1, left_open=2, finished=6, questioned=8, second_round=3), 7)
    assert said == (
        "9 people agreed to take part: 1 was screened out by the questions on the instructions, 2 left boxes unfinished "
        "or are still playing, 6 finished all their boxes. 7 are in the analysis, with at least one finished box. Who "
        "did not agree is not recorded."
    )
    assert rounds == "3 of 8 needed more than one round of the questions on the instructions."


def test_the_caption_says_which_trials_are_in_the_upper_panel(found):
    assert "in all their trials (for each flip rate 7 of people and 10 of an agent)" in _caption(found).shown
    fewer = [with_n(row, 4) if row.agent == "participant" and row.condition == "truth" else row for row in found.rows]
    assert "(for each flip rate 4 to 7 of people and 10 of" in _caption(found.changed(rows=tuple(fewer))).shown


def with_n(row, n):
    return row.model_copy(update={"n": n}) if row.quantity == "success" else row


def test_captions_are_short(found):
    assert too_long(page_of("report", found), found.plain()) == []
