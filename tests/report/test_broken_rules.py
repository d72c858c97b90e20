"""Where attempts broke the rules of the box the answer says so, comparisons stay, and no claim of the paper is judged."""

import pytest
from builders import write_study
from clumsy import CLUMSY, HAND

from lockprobe.foundation.plugins import allow
from lockprobe.report.compare.studies import compare_studies
from lockprobe.report.page import tables_of
from lockprobe.report.questions.claims import not_judged
from lockprobe.report.rows import Results
from lockprobe.report.write import write_report
from lockprobe.studies.options.studyfile import study

AGENTS = ["cognitive:careful", "human-inspired"]


@pytest.fixture(scope="module")
def studies(tmp_path_factory):
    """Two conditions with a hand that misses in one of them, with one that always misses, and with one that never does."""
    found = []
    for plant, condition in (
        (HAND, "plant?misses=3;4;5;6;7;8"),
        (CLUMSY, "tremble?p=0.3"),
        ("symbolic", "tremble?p=0.3"),
    ):
        planned = study(
            "flips", agent=AGENTS, p=[0], trials=6, repetitions=2, plant=plant, condition=condition, max_steps=9
        )
        directory = write_study(tmp_path_factory.mktemp("study") / "study", planned)
        write_report(directory)
        found.append(Results.model_validate_json((directory / "results.json").read_bytes()))
    return found


def test_the_answer_counts_them_and_success_is_compared_all_the_same(studies):
    missing, clumsy, kept = studies
    for found in (missing, clumsy):
        rows = found.where("against_rules")
        broken = (
            f" {sum(row.count for row in rows)} of {sum(row.n for row in rows)} attempts broke the rules of the box."
        )
        assert found.answer.endswith(broken)
        assert len(found.answer) > len(broken) + 10
        assert {row[6] for row in tables_of(found)["claims"][1:]} == {"not judged", "not measured"}
        assert found.said("overview", "chance") == []
    (effect,) = missing.where("success_difference", agent="human-inspired", of="", condition="plant?misses=3;4;5;6;7;8")
    assert effect.value < 0
    quantities = {row.quantity for row in clumsy.rows}
    assert quantities >= {row.quantity for row in kept.rows}
    assert "broke the rules" not in kept.answer
    assert not_judged(kept) == ""


def test_misses_are_counted_by_condition_with_success_of_trials_without_one(studies):
    missing, _, kept = studies
    assert kept.where("missed_share") == kept.where("attempts") == []
    by_condition = {(row.agent, row.condition): row for row in missing.where("missed_share")}
    assert {row.count for (_, condition), row in by_condition.items() if condition == "truth"} == {0}
    row = by_condition["human-inspired", "plant?misses=3;4;5;6;7;8"]
    assert 0 < row.low < row.value < row.high < 1
    assert row.clusters == 12
    (forced,) = missing.where("forced_share", agent=row.agent, condition=row.condition)
    (attempts,) = missing.where("attempts", agent=row.agent, condition=row.condition)
    assert (forced.count, forced.n + row.n) == (0, attempts.value)
    for cell in missing.cells:
        without = cell.get("success_without_miss")
        assert without is None or without.n <= cell.trials
        if cell.condition == "truth":
            assert (without.count, without.n) == (cell.get("success").count, cell.get("success").n)


@pytest.mark.parametrize("plant", [CLUMSY, "symbolic"])
def test_compared_studies_say_how_many_attempts_broke_the_rules(tmp_path, plant):
    allow(plant)
    for seed in (1, 2):
        planned = study("flips", agent="cognitive:careful", p=[0], trials=4, repetitions=1, plant=plant, seed=seed)
        write_study(tmp_path / str(seed), planned)
    said = compare_studies([tmp_path / "1", tmp_path / "2"]).said
    assert said.endswith("attempts broke the rules of the box.") == (plant == CLUMSY)
    assert said.count(".") > (plant == CLUMSY)
