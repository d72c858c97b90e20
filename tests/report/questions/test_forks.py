"""Forks: their effects stand in the part of the page and nowhere else."""

import pytest
from builders import write_study
from reported import tables_of

from lockprobe.report.page import parts_of
from lockprobe.report.results import results
from lockprobe.studies.branch import FORKS, branching, play_forks
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """The results of a small study with forks."""
    planned = study("flips", trials=8, repetitions=1, agent="cognitive:perseverant", p=[0.0, 0.4])
    directory = write_study(tmp_path_factory.mktemp("forked") / "study", planned)
    wanted = branching(planned, load(directory), keys=(), at=["4", "8"], told=["lie", "lie-truth"])
    with Journal.open(directory / FORKS, planned) as journal:
        play_forks(wanted, journal)
    return results(directory)


def test_the_part_has_the_sentence_and_the_table_and_no_other_number_counts_forks(found):
    (own,) = (part for part in parts_of(found) if part.name == "forks")
    tested = [row for row in found.where("fork_change") if row.of.startswith("success")]
    assert (
        own.answer
        == f"{sum(row.detected for row in tested)} of {len(tested)} effects of one report on success detected."
    )
    assert len(tables_of(found)["forks"]) == 1 + len(tested)
    assert found.progress.finished == sum(
        row.value + found.one("broken", agent=row.agent, condition=row.condition).value
        for row in found.where("trials", of="")
        if row.condition
    )
