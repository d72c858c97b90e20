"""``compare.html``: the sentence first, every number, no script, nothing from outside."""

import re
from dataclasses import replace

import pytest
from builders import play_study, small_study, write_study

from lockprobe.foundation.errors import BadFile
from lockprobe.report.compare.page import difference_table, study_table, success_table, write_comparison
from lockprobe.report.compare.studies import compare_studies

STUDY = small_study(agents=("cognitive:careful", "random"), p=(0.0, 0.3))
ATTACK = "<script>alert(1)</script>"


@pytest.fixture(scope="module")
def compared(tmp_path_factory):
    root = tmp_path_factory.mktemp("compared")
    other = replace(STUDY, agents=("cognitive:perseverant",), seed=3)
    first, second = write_study(root / "a", STUDY), write_study(root / "b", other, play_study(other)[:10])
    found = compare_studies([first, second])
    return found, write_comparison(found, root / "compare.html").read_text("utf-8")


def test_the_page_begins_with_the_sentence_and_holds_every_number(compared):
    found, page = compared
    text = re.sub(r"\s+", " ", re.sub(r"<[^>]*>", "", page))
    assert text.index(found.said) < text.index("Difference in success")
    assert "10 of 16 trials of b" in text
    tables = (success_table(found), study_table(found), difference_table(found, found.differences))
    for cell in {cell for table in tables for row in table for cell in row}:
        assert cell in text
    assert page.count("<figure") == 1
    assert "more differences: with baselines, and within one study" in text


def test_it_runs_nothing_and_loads_nothing(compared):
    _, page = compared
    assert "default-src 'none'; img-src data:; style-src 'unsafe-inline'\"" in page
    assert "<script" not in page
    sources = re.findall(r'(?:src|href)="([^"]*)"', page)
    assert sources
    assert all(source.startswith("data:image/svg+xml,") for source in sources)


def test_what_agents_and_directories_are_called_is_text(tmp_path):
    study = small_study(agents=("llm:a",), p=(0.0,), repetitions=1, trials=2)
    played = play_study(replace(study, agents=("random",)))
    labs = []
    for seed, name in enumerate(("<img src=x onerror=alert(1)>", "b")):
        facts = {"<b>model</b>": f"{ATTACK}{seed}"}
        trials = [replace(t, agent="llm:a", key=t.key.replace("random", "llm:a"), facts=facts) for t in played]
        labs.append(write_study(tmp_path / name, study, trials))
    found = compare_studies(labs)
    page = write_comparison(found, tmp_path / "compare.html").read_text("utf-8")
    assert ATTACK in found.unlike[0]
    assert "<img src=x" in found.said
    assert not re.search("<script|<img src=x|<b>", page)


def test_two_studies_without_a_trial_are_said_to_have_none(tmp_path):
    labs = [write_study(tmp_path / name, STUDY, []) for name in "ab"]
    page = write_comparison(compare_studies(labs), tmp_path / "compare.html").read_text("utf-8")
    assert "No two agents have a trial to compare." in page
    assert "<figure" not in page


def test_a_page_that_cannot_be_written_is_a_mistake_in_one_line(compared, tmp_path):
    with pytest.raises(BadFile, match="cannot be written"):
        write_comparison(compared[0], tmp_path / "none" / "compare.html")


@pytest.mark.parametrize(("name", "section"), [("_picture", "Figure differences"), ("study_table", "Table studies")])
def test_no_figure_or_table_keeps_the_page_from_being_written(monkeypatch, compared, tmp_path, name, section):
    def broken(*_):
        raise RuntimeError("broken on purpose")

    monkeypatch.setattr(f"lockprobe.report.compare.page.{name}", broken)
    told = []
    page = write_comparison(compared[0], tmp_path / "compare.html", left_out=told.append).read_text("utf-8")
    assert [one.section for one in told] == [section]
    assert f"{section} (RuntimeError: broken on purpose)" in page
