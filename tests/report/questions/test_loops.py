"""Action loops: their rates beside chance, and a definition where they are first named."""

import pytest
from builders import make_trial, small_study
from reported import found_in

from lockprobe.report.page import page_of, tables_of


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    return found_in(tmp_path_factory.mktemp("loops"), small_study(("random", "cognitive:perseverant")))


def table(found, name):
    head, *rows = tables_of(found)[name]
    return [dict(zip(head, row, strict=True)) for row in rows]


def test_every_loop_rate_stands_beside_two_levels_of_chance(found):
    for cell in found.cells:
        levels = {
            row.of: row.value for row in found.where("loop_rate_chance", condition=cell.condition, agent=cell.agent)
        }
        assert list(levels) == ["uniform", "no-repeat"]
        assert levels["uniform"] <= levels["no-repeat"]
        assert all(cell.value("loop_rate_chance_error", of) is not None for of in levels)
        rate = cell.get("loop_rate")
        assert 0 <= rate.low <= rate.value <= rate.high <= 1
        assert rate.value == pytest.approx(sum(one.value * one.n for _, one in cell.points) / rate.n)
    rows = table(found, "loops")
    assert [row["flip rate"] for row in rows] == ["every flip rate", "0", "0.3", "0.6"]  # a blind agent once
    assert list(rows[0])[3:] == ["uniform", "without repeats"]


def test_a_study_without_an_ended_trial_has_no_numbers_of_loops(tmp_path):
    broken = [make_trial([0], agent="llm:x", broken="model")]
    found = found_in(tmp_path, small_study(("llm:x",), (0.0,), 1, 1), broken)
    assert not any(found.where(quantity) for quantity in ("loop_rate", "coverage"))
    assert 'id="loops"' in page_of(found)
