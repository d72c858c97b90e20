"""People in the rows, in the tables and on the page; and nothing of them where nobody was asked."""

from dataclasses import replace

import pytest
from builders import SOLUTION, make_trial, play_study, played_by_people, small_study, write_study
from reported import tables_of
from taking_part import take_part

from lockprobe.foundation.formatting import p_cell
from lockprobe.people.withdrawal import withdraw
from lockprobe.report.page import Page
from lockprobe.report.results import results
from lockprobe.studies.records.journal import Journal

STUDY = small_study(("participant", "random", "round-robin"), (0.0, 0.4), 2, 5)
PLAYED = 14
BY = "by person"
THEIRS = {"agent": "participant", "modality": "", "condition": ""}


def with_people(path, study, trials):
    """The results of a study with these trials of people, and those of its agents as they play."""
    agents = tuple(agent for agent in study.agents if agent != "participant")
    played = play_study(replace(study, agents=agents)) if agents else []
    return results(write_study(path / "study", study, [*played, *trials]))


def values(found, quantity, **columns):
    return {row.of: row.value for row in found.where(quantity, **columns)}


def each(found):
    return [found.one("boxes", **THEIRS, of=f"{end} of a person").value for end in ("fewest", "most")]


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    return with_people(tmp_path_factory.mktemp("people"), STUDY, played_by_people(STUDY, 2)[:PLAYED])


def test_people_are_counted_by_person_and_by_first_boxes_and_are_one_agent_elsewhere(found):
    assert (found.progress.planned, found.progress.finished) == (60, 40 + PLAYED)
    assert values(found, "boxes", **THEIRS).items() >= {"planned": 20, "finished": PLAYED}.items()
    assert found.one("people", **THEIRS).value == 7
    assert each(found) == [2, 2]
    assert [found.one("success", **THEIRS, of=f"position={i}").n for i in (1, 2)] == [7, 7]
    assert [row.condition for row in found.where("people", of="")] == ["", "truth", "flip?p=0.4"]
    assert found.fact("participant", "view") == "panel"
    assert found.one("success", **THEIRS, of="every person alike").value == found.one("success", **THEIRS, of=BY).value
    assert [cell.condition for cell in found.cells if cell.agent == "participant"] == ["truth", "flip?p=0.4"]
    assert found.fact("participant", "position") == "1; 2"
    page = Page(found=found).text()
    assert page.count(f"{PLAYED} of 20 boxes for people were played; 6 are still available.") == 1
    assert "people remember earlier boxes, agents do not" in page
    assert "participant:" not in str(found.plain())
    assert "participant:0" not in page


def test_who_left_early_counts_as_every_person_does(tmp_path):
    """Of three people one opened both boxes, one the second of two, and one none of one."""
    opened = [("aaaa", 1, 1), ("aaaa", 2, 1), ("bbbb", 1, 0), ("bbbb", 2, 1), ("cccc", 1, 0)]
    trials = [
        replace(
            make_trial(SOLUTION if solved else (0,) * 20, agent=f"participant:{who}", trial=i + 1),
            facts={"position": at, "view": "panel", "feedback": bool(solved)},
        )
        for i, (who, at, solved) in enumerate(opened)
    ]
    found = with_people(tmp_path, small_study(("participant",), (0.0,), 1, 5), trials)
    assert each(found) == [1, 2]
    every = found.one("success", **THEIRS, of=BY)
    assert (every.count, every.n, every.clusters) == (3, 5, 3)
    assert found.one("success", **THEIRS, of="every person alike").value == pytest.approx((1 + 0.5 + 0) / 3)
    positions = [found.one("success", **THEIRS, of=f"position={i}") for i in (1, 2)]
    assert [(one.count, one.n) for one in positions] == [(1, 3), (2, 2)]
    assert "with every person counted alike it is 50&nbsp;%." in Page(found=found).text()
    assert "Of their first boxes they opened 1 of 3 (" in Page(found=found).text()


def test_nothing_is_decided_of_fewer_people_than_a_test_needs(tmp_path):
    trials = [make_trial((0,) * 20, agent="participant:aaaa", trial=i) for i in range(1, 11)]
    found = with_people(tmp_path, small_study(("participant", "random"), (0.0,), 1, 10), trials)
    said = {tuple(row[6:]) for row in tables_of(found)["claims"] if row[4] == "people"}
    assert said == {("not decided", "fewer than 7 people", p_cell(None))}


def test_the_page_says_who_came_to_the_end(tmp_path):
    study = small_study(("participant", "random"), (0.0, 0.4), 1, 3)
    path = write_study(tmp_path / "study", study, [])
    take_part(path, study, "aaaa01", [(0.4, 1, 1), (0.0, 1, 2)])
    take_part(path, study, "bbbb02", [(0.0, 1, 1), (0.4, 1, 2)], left_after=1, check=False)
    take_part(path, study, "cccc03", [(0.0, 1, 3)])
    with Journal.open(path, study) as journal:
        withdraw(journal, "cccc03")
    found = results(path)
    ends = {"consented": 3, "withdrawn": 1, "left_open": 1, "finished": 1, "analysed": 2}
    assert values(found, "people", modality="").items() >= ends.items()
    assert values(found, "boxes", condition="truth") == {"given": 2, "left_open": 0}
    assert values(found, "boxes", condition="flip?p=0.4") == {"given": 2, "left_open": 1}
    page = Page(found=found).text()
    assert (
        "3 people agreed to take part: 1 withdrew (their data are deleted), 1 left boxes unfinished or still playing, "
        "1 finished all their boxes. 2 are in the analysis." in page
    )
    assert "Unfinished boxes: 0 of 2 under truth, 1 of 2 under flip?p=0.4." in page
    checks = found.one("people", of="attention checks")
    assert f"Attention checks: {checks.count} of {checks.n} answered correctly." in page
