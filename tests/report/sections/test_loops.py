"""Action loops: their rates beside chance, and a definition where they are first named."""

import pytest
from builders import make_trial, small_study, write_study

from lockprobe.report.opened import open_study
from lockprobe.report.pages import page_of, tables_of
from lockprobe.report.prose.loops import LOOP_DEFINITION
from lockprobe.report.results import results_of
from lockprobe.report.sections import loops
from lockprobe.report.study_numbers import study_numbers

STARS = "Hollow stars"


def found_in(directory, planned, trials=None):
    return results_of(study_numbers(open_study(write_study(directory / "study", planned, trials))))


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    return found_in(tmp_path_factory.mktemp("loops"), small_study(("random", "cognitive:perseverant")))


def table(found, name):
    head, *rows = tables_of(found)[name]
    return [dict(zip(head, row, strict=True)) for row in rows]


def caption(found, figure="fig5b"):
    (one,) = (one for one in loops.SECTIONS[0].figures if one.name == figure)
    return one.caption(found).shown


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


def test_an_action_loop_is_defined_where_it_is_first_named(found):
    page = page_of("report", found)
    part = page.partition('id="loops"')[2]
    assert LOOP_DEFINITION in part[: part.index("<figure")] if "<figure" in part else LOOP_DEFINITION in part
    assert found.answer_of("loops") in part


def test_a_caption_names_stars_only_where_they_are_drawn(found, tmp_path):
    assert STARS in caption(found)
    far = [make_trial([0] * 20, agent="llm:x", p=p) for p in (0.5, 0.9)]
    assert STARS not in caption(found_in(tmp_path, small_study(("llm:x",), (0.5, 0.9), 1, 1), far))


def test_a_caption_names_the_share_by_step_only_where_it_is_drawn(found, tmp_path):
    single = found_in(tmp_path, small_study(("cognitive:perseverant",), (0.0,), 1, 2))
    assert ["looped by each step" in caption(one, "fig5b-corrected") for one in (found, single)] == [True, False]


def test_a_study_without_an_ended_trial_has_no_numbers_of_loops(tmp_path):
    broken = [make_trial([0], agent="llm:x", broken="model")]
    found = found_in(tmp_path, small_study(("llm:x",), (0.0,), 1, 1), broken)
    assert not any(found.where(quantity) for quantity in ("loop_rate", "coverage"))
    assert 'id="loops"' in page_of("report", found)
