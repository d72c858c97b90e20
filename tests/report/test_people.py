"""People in results.json, in the tables and on the page; and nothing of them where nobody was asked."""

import csv
import io
import json
import statistics
from dataclasses import replace
from types import SimpleNamespace

import pytest
import seated
import strangers
from builders import play_study, played_by_people, small_study, write_study
from captions import too_long
from seated import under
from taking_part import take_part

from lockprobe.analysis.relative_steps import RelativeSteps
from lockprobe.analysis.summary import summarise
from lockprobe.people.progress import Flow
from lockprobe.people.withdrawal import put
from lockprobe.plugins import allow
from lockprobe.record import TrialError
from lockprobe.report import write_report
from lockprobe.report.people import flow_said, people_said, people_steps_table
from lockprobe.studies.journal import load
from lockprobe.studies.runner import run_study

STUDY = small_study(("participant", "random", "round-robin"), (0.0, 0.4), 2, 5)
PLAYED = 14


@pytest.fixture(scope="module")
def directory(tmp_path_factory, drawn):
    agents = play_study(small_study(("random", "round-robin"), STUDY.p, 2, 5))
    people = played_by_people(STUDY, 2)[:PLAYED]
    path = write_study(tmp_path_factory.mktemp("people") / "study", STUDY, [*agents, *people])
    with drawn("people"):
        write_report(path)
    return path


@pytest.fixture(scope="module")
def content(directory):
    return json.loads((directory / "results.json").read_text("utf-8"))


def table(directory, name):
    return list(csv.DictReader(io.StringIO((directory / "tables" / f"{name}.csv").read_text("utf-8"))))


def test_places_of_people_are_a_part_of_the_plan(content, directory):
    assert content["progress"] == {"planned": 60, "finished": 40 + PLAYED, "partial": True}
    page = (directory / "report.html").read_text("utf-8")
    assert f"Partial: {40 + PLAYED} of 60 trials." in page
    assert f"{40 + PLAYED} trials of 2 agents and people." in page
    assert f"{40 + PLAYED} of 60 finished; of these, people: {PLAYED} of 20</dd>" in page
    people = content["people"]
    assert (people["planned"], people["finished"], people["owed"]) == (20, PLAYED, 6)
    assert content["left_out"]["not_asked_for"] == 0


def test_people_are_counted_by_person_and_by_first_boxes(content):
    found = content["people"]["found"]
    assert (found["people"], found["trials"], found["fewest"], found["most"]) == (7, PLAYED, 2, 2)
    assert [row["success"]["n"] for row in found["positions"]] == [7, 7]
    assert found["first"]["n"] == 7
    assert [row["p"] for row in found["at"]] == [0.0, 0.4]
    assert found["saw"]["view"] == {"panel": PLAYED}


def test_every_agent_stands_beside_people_on_the_trials_of_both(content):
    rows = content["people"]["found"]["relative"]
    assert [(row["agent"], row["p"], row["trials"]) for row in rows] == [
        (agent, p, n) for agent in ("random", "round-robin") for p, n in ((0.0, 7), (0.4, 7), (None, 14))
    ]
    assert all(row["mean_ratio"] > 0 for row in rows)


def test_people_are_one_agent_in_every_other_number(content):
    assert [row["agent"] for row in content["leaderboard"]].count("participant") == 1
    assert {row["key"] for row in content["conditions"] if row["agent"] == "participant"} == {
        "flips/participant/truth", "flips/participant/flip?p=0.4",
    }  # fmt: skip
    assert content["agents"]["participant"]["position"] == "1; 2"
    assert not [
        row for rows in content.values() if isinstance(rows, list) for row in rows if "participant:" in str(row)
    ]


def test_the_page_says_how_many_and_what_sets_people_apart(directory):
    page = (directory / "report.html").read_text("utf-8")
    assert '<a href="#people">People</a>' in page
    assert f"{PLAYED} of 20 boxes for people were played; 6 are still available." in page
    assert "people remember earlier boxes, models do not" in page
    assert "reports as panel" in page
    assert (
        "Student&#39;s t with a variance clustered by person and block" in page
        or "Student's t with a variance clustered by person and block" in page
    )
    assert "participant:0" not in page
    assert (directory / "figures" / "people.png").stat().st_size > 5000


def test_tables_for_papers(directory):
    assert [row["p"] for row in table(directory, "people")] == ["0", "0.4", "all"]
    assert [row["agent"] for row in table(directory, "people-steps")][::3] == ["random", "round-robin"]
    assert [row["position"] for row in table(directory, "people-positions")] == ["1", "2"]
    assert (directory / "tables" / "people.tex").is_file()


def test_bounds_are_written_as_bounds():
    row = RelativeSteps(
        agent="llm:a", modality="symbolic", p=None, trials=3, steps=None, people=8,
        ratio=None, least=2.625, most=None, low=1.5, high=None, mean_ratio=1.5, mean_low=1.25, mean_high=2.0,
    )  # fmt: skip
    _, cells = people_steps_table(SimpleNamespace(relative=[row]), {})
    assert cells == ["llm:a", "all", "3", "beyond the budget", "8", "at least 2.62 [1.50, open]", "1.50 [1.25, 2.00]"]


STUCK = "python:strange:First"
"""Always the same joint: it solves nothing."""


@pytest.mark.parametrize(
    ("people", "agent", "median", "compared"),
    [
        ("human-inspired", STUCK, "Half of the boxes were open by step", f"{STUCK} needs at least "),
        (STUCK, "human-inspired", "They opened fewer than half of the boxes, so", "human-inspired needs at most "),
        (
            STUCK,
            STUCK,
            "They opened fewer than half of the boxes, so",
            f"Neither {STUCK} nor people solved half of the 6",
        ),
        (
            "round-robin",
            "round-robin",
            "Half of the boxes were open by step",
            "round-robin needs 1.00 times (95 % interval 1.00 to 1.00) the human median",
        ),
    ],
)
def test_where_a_median_is_beyond_the_budget_the_sentence_has_a_bound(
    tmp_path, monkeypatch, people, agent, median, compared
):
    strangers.install(tmp_path, monkeypatch)
    allow(STUCK)
    study = small_study(("participant", agent), (0.0,), 1, 6)
    trials = [*play_study(small_study((agent,), (0.0,), 1, 6)), *played_by_people(study, 1, people)]
    _, steps, ratio, _ = people_said(summarise(trials))
    assert steps.startswith(median)
    assert ratio.startswith(compared)
    assert "on the 6 trials that both played" in ratio or "of the 6 trials that both played" in ratio
    assert ("since it solved fewer than half" in ratio) == ("at least" in ratio)
    assert ("since people solved fewer than half" in ratio) == ("at most" in ratio)


def test_before_anybody_came_the_report_says_so(tmp_path):
    study = small_study(("participant", "random"), (0.0,), 1, 3)
    path = write_study(tmp_path / "study", study, play_study(small_study(("random",), (0.0,), 1, 3)))
    write_report(path)
    found = json.loads((path / "results.json").read_text("utf-8"))["people"]
    nothing = {"flow": None, "response_times": [], "found": None, "said": []}
    assert found == {"planned": 3, "finished": 0, "owed": 3, "others": 0, **nothing}
    assert "0 of 3 boxes for people were played" in (path / "report.html").read_text("utf-8")
    assert not (path / "figures" / "people.png").exists()
    assert not (path / "tables" / "people.csv").exists()


def test_people_alone_are_reported_too(tmp_path):
    study = small_study(("participant",), (0.0, 0.4), 1, 3)
    path = write_study(tmp_path / "study", study, played_by_people(study, 2))
    write_report(path)
    found = json.loads((path / "results.json").read_text("utf-8"))
    assert found["progress"] == {"planned": 6, "finished": 6, "partial": False}
    assert found["people"]["found"]["relative"] == []
    assert "3 people opened" in found["people"]["said"][0]
    page = (path / "report.html").read_text("utf-8")
    assert "; 6 of 6 finished</dd>" in page
    assert "6 trials of people." in page
    assert "Partial: " not in page


def test_a_study_of_people_is_partial_until_every_place_is_filled(tmp_path):
    study = small_study(("participant",), (0.0, 0.4), 1, 3)
    path = write_study(tmp_path / "study", study, played_by_people(study, 2)[:4])
    write_report(path)
    found = json.loads((path / "results.json").read_text("utf-8"))
    assert found["progress"] == {"planned": 6, "finished": 4, "partial": True}
    assert "Partial: 4 of 6 trials." in (path / "report.html").read_text("utf-8")
    assert "4 trials of people." in (path / "report.html").read_text("utf-8")


def test_a_place_that_two_people_played_is_filled_once():
    study = small_study(("participant",), (0.0,), 1, 3)
    first, second, *_ = played_by_people(study, 2)
    again = replace(first, agent="participant:zzzz99")
    assert study.places_filled([first, again, second]) == 2
    broken = replace(second, ending="error", error=TrialError(boundary="plant", message="gone", step=1))
    assert study.places_filled([first, broken]) == 1


def test_without_people_nothing_is_said_of_them(tmp_path):
    study = small_study(("random",), (0.0,), 1, 3)
    path = write_study(tmp_path / "study", study)
    write_report(path)
    assert json.loads((path / "results.json").read_text("utf-8"))["people"] is None
    page = (path / "report.html").read_text("utf-8")
    assert "eople" not in page.split("</style>")[-1]


def test_the_page_says_who_came_to_the_end_and_how_long_choices_took(tmp_path):
    study = small_study(("participant", "random"), (0.0, 0.4), 1, 3)
    path = write_study(tmp_path / "study", study, [])
    take_part(path, study, "aaaa01", [(0.4, 1, 1), (0.0, 1, 2)])
    take_part(path, study, "bbbb02", [(0.0, 1, 1), (0.4, 1, 2)], left_after=1, check=False)
    put(path / "people" / "withdrawn.json", {"withdrawn": 1})
    write_report(path)
    people = json.loads((path / "results.json").read_text("utf-8"))["people"]
    flow = people["flow"]
    assert (flow["joined"], flow["finished"], flow["left_open"], flow["withdrawn"]) == (2, 1, 1, 1)
    assert flow["boxes"] == [
        {"condition": "truth", "given": 2, "left_open": 0},
        {"condition": "flip?p=0.4", "given": 2, "left_open": 1},
    ]
    page = (path / "report.html").read_text("utf-8")
    assert (
        "2 people joined: 1 finished all their boxes, 1 left boxes unfinished or are still playing; "
        "1 more withdrew, and their data are deleted." in page
    )
    assert "Unfinished boxes, by condition: 0 of 2 under truth, 1 of 2 under flip?p=0.4." in page
    assert f"Attention checks: {flow['right']} of {flow['checks']} answered correctly." in page
    took = {row["p"]: row for row in people["response_times"]}
    steps = [step.step for trial in load(path) for step in trial.steps if trial.p == 0.4]
    assert (took[0.4]["choices"], took[0.4]["first"]) == (len(steps), 1001.5)  # the diary says 1000.5 ms and the step
    assert took[0.4]["median"] == 1000.5 + statistics.median(steps)
    assert took[None]["choices"] == took[0.0]["choices"] + took[0.4]["choices"]
    row = next(row for row in table(path, "people") if row["p"] == "0.4")
    assert row["ms of first choices"] == "1002"
    assert row["ms per choice"].startswith(f"{took[0.4]['median']:.0f} [")
    assert "performance.now" in page


def test_what_is_not_known_of_times_is_not_in_the_table(directory):
    assert "ms per choice" not in table(directory, "people")[0]
    assert "performance.now" not in (directory / "report.html").read_text("utf-8")


def test_people_stand_beside_agents_under_every_condition(tmp_path):
    """Effects, conditions, speed and loops have them; the section on people counts flip rates and says so."""
    conditions = ("truth", "flip?p=0.4", "flip?p=0.4 + nudge", "reword?p=1", "tremble?p=0.3")
    study = under(*conditions, agents=("random", "participant"), trials=5)
    run_study(study, tmp_path)
    seated.take_part(tmp_path, study, seated.short(), people=5)
    write_report(tmp_path)
    found = json.loads((tmp_path / "results.json").read_text("utf-8"))
    assert (found["people"]["finished"], found["people"]["others"], found["people"]["found"]["trials"]) == (25, 15, 10)
    (said,) = [one for one in found["people"]["said"] if "other conditions" in one]
    assert said.startswith("What follows counts boxes under flip rates alone. People finished 15 boxes under other")
    times = {row["p"]: row["choices"] for row in found["people"]["response_times"]}
    steps = {p: sum(len(trial.steps) for trial in load(tmp_path) if trial.player and trial.p == p) for p in (0.0, 0.4)}
    assert times == steps | {None: sum(steps.values())}
    for part in ("conditions", "effects", "speed", "loops"):
        rows = [row for row in table(tmp_path, part) if row["agent"] == "participant"]
        theirs = {row["condition"] for row in rows}
        assert theirs == set(conditions) - ({"truth"} if part == "effects" else set()), part
        assert len(rows) == len(theirs)
    assert {row["agent"] for row in found["effects"]} == {"random", "participant"}
    assert "the success of people was detected" in found["overview"]["answer"]


def test_nobody_who_is_left_is_said_so():
    said = [*flow_said(Flow(joined=0, finished=0, left_open=0, withdrawn=2, checks=0, right=0, boxes=()))]
    assert said == ["No participants remain; 2 withdrew, and their data are deleted."]


def test_captions_are_short(directory, content):
    assert too_long((directory / "report.html").read_text("utf-8"), content) == []
