"""``why.html``: the sentence first, numbers that are those of the records, and a trial told twice."""

import json

import pytest
from builders import write_study
from captions import too_long

from lockprobe.report import write_report
from lockprobe.report.results import results
from lockprobe.studies.journal import load
from lockprobe.studies.studyfile import study


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """The directory of a small study of controls with its report."""
    planned = study("why", agent=["world:perseverant", "world:lost-half"], trials=20, repetitions=1)
    directory = write_study(tmp_path_factory.mktemp("why") / "study", planned)
    write_report(directory)
    return directory, json.loads((directory / "results.json").read_text())["why"]


def test_every_agent_has_its_arms_as_recorded(told):
    directory, rows = told
    assert [row["agent"] for row in rows] == ["world:perseverant", "world:lost-half"]
    trials = load(directory)
    for row in rows:
        for one in row["arms"]:
            own = [
                trial.solved for trial in trials if (trial.agent, trial.condition) == (row["agent"], one["condition"])
            ]
            assert (one["trials"], one["solved"]) == (len(own), sum(own))
    assert [one["arm"] for one in rows[0]["arms"]][:3] == ["truth", "lie", "retracted"]
    assert rows[1]["verdict"] == "not detectable" or rows[1]["equivalence"] < 0.05


def test_the_page_begins_with_the_sentence_and_the_report_leads_to_it(told):
    directory, rows = told
    page, report = ((directory / name).read_text() for name in ("why.html", "report.html"))
    for row in rows:
        assert row["said"][0] in page
        assert row["said"][0] in report
    assert page.index(rows[0]["said"][0]) < page.index("<figure")
    assert 'href="why.html"' in report
    assert "<script" not in page


def test_a_trial_is_told_twice_from_where_the_two_part(told):
    directory, rows = told
    by_key = {trial.key: trial for trial in load(directory)}
    twice = rows[0]["twice"]
    truth, lie = (by_key[twice[of]["key"]] for of in ("truth", "lie"))
    assert (truth.repetition, truth.trial) == (lie.repetition, lie.trial)
    assert (truth.condition, lie.condition) == ("truth", "lie")
    assert truth.solved != lie.solved
    before = twice["parted"] - 1
    assert truth.actions[:before] == lie.actions[:before]
    assert truth.actions[before : before + 1] != lie.actions[before : before + 1]
    assert rows[1]["twice"] is None  # it plays the same trials whatever it is told


def test_results_read_back(told):
    directory, rows = told
    found = results(directory)
    assert [row.verdict for row in found.why] == [row["verdict"] for row in rows]
    assert type(found).model_validate(json.loads((directory / "results.json").read_text())) == found


def test_tables_have_every_estimand(told):
    directory, _ = told
    lines = (directory / "tables" / "why.csv").read_text().splitlines()
    assert len(lines) == 1 + 2 * 6
    assert len((directory / "tables" / "arms.csv").read_text().splitlines()) == 1 + 2 * 9


def test_other_studies_have_no_such_page(tmp_path):
    planned = study("flips", agent="random", sweep="tremble?p=0,0.2", trials=2, repetitions=1)
    directory = write_study(tmp_path / "study", planned)
    write_report(directory)
    assert not (directory / "why.html").exists()
    assert json.loads((directory / "results.json").read_text())["why"] == []


def test_captions_are_short(told):
    directory, _ = told
    content = json.loads((directory / "results.json").read_text())
    assert [too_long((directory / f"{name}.html").read_text(), content) for name in ("why", "report")] == [[], []]
    assert "How is this computed?" in (directory / "why.html").read_text()


def test_on_a_narrow_screen_each_estimate_and_each_arm_is_a_card(told):
    directory, rows = told
    page = (directory / "why.html").read_text()
    cards = [part.partition("</table>")[0] for part in page.split('<div class="brief">')[1:]]
    assert [part.count('data-head="P"') for part in cards] == [6 * len(rows), sum(len(row["arms"]) for row in rows)]
