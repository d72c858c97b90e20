"""Success and its tests: rows are the numbers of the analysis, and a conclusion follows from its P value."""

import re
from dataclasses import replace
from html import unescape

import pytest
from builders import play_study, small_study, write_study
from page_parts import part

from lockprobe.report.opened import open_study
from lockprobe.report.page import page_of
from lockprobe.report.prose.hypothesis_tests import limits_said, unit_of_effect
from lockprobe.report.results import results_of
from lockprobe.report.study_numbers import BOUNDS, study_numbers
from lockprobe.report.svg import image
from lockprobe.trial.record import TrialError

AGENTS = ("cognitive:perseverant", "human-inspired", "random")
RATES = (0.0, 0.2, 0.4, 0.6)
DRAWN = {name: image(b"<svg />") for name in ("fig4", "fig4-corrected")}


def numbers_in(directory, planned, trials=None):
    return study_numbers(open_study(write_study(directory / "study", planned, trials)))


def section(found, name="success"):
    return unescape(part(page_of(found, DRAWN), name))


def broke(trial):
    error = TrialError(boundary="reply", message="not one JSON object", step=4)
    return replace(trial, steps=trial.steps[:3], ending="error", error=error, changed={}, changed_steps=0)


@pytest.fixture(scope="module")
def numbers(tmp_path_factory):
    return numbers_in(tmp_path_factory.mktemp("success"), small_study(AGENTS, RATES, 2, 8))


@pytest.fixture(scope="module")
def found(numbers):
    return results_of(numbers)


@pytest.fixture(scope="module")
def broken(tmp_path_factory):
    """Numbers of a study in which every seventh trial broke."""
    planned = small_study(AGENTS[:2], RATES, 2, 8)
    trials = [broke(trial) if i % 7 == 3 else trial for i, trial in enumerate(play_study(planned))]
    return numbers_in(tmp_path_factory.mktemp("broken"), planned, trials)


def test_rows_are_the_numbers_of_the_analysis(numbers, found):
    for agent, course in zip(numbers.flips.agents, found.courses(), strict=True):
        fit, model, tested = agent.success_fit, agent.inference.orders, agent.inference.difference
        assert course.value("success_fit_order", "AIC") == fit.order_by_aic
        assert course.value("success_model_order", "AICc") == model.order
        for quantity, curve in (("success_fit", fit.quadratic), ("success_model", model.curve)):
            drawn = course.curve(quantity)
            assert (drawn and (drawn.x, drawn.value, drawn.low)) == (curve and (curve.dose, curve.value, curve.low))
        rows = {row.doses["flip.p"]: row for row in course.against_lowest("success_difference")}
        assert {p: (row.value, row.p_value) for p, row in rows.items()} == {
            one.dose: (one.value, one.p_value) for one in tested.at
        }


def test_the_contrast_is_the_clearest_difference(found):
    for course in found.courses():
        rows = course.against_lowest("success_difference")
        clearest = course.get("clearest_success_difference")
        assert (clearest is None) == (not rows) == course.blind
        if clearest is not None:
            best = min(rows, key=lambda row: (row.p_value, -abs(row.value)))
            assert (clearest.value, clearest.p_value, clearest.doses) == (best.value, best.p_value, best.doses)
            assert clearest.corrected_for == 3  # flip rates; agents and baselines are families of one each
            assert f">0 and {best.doses['flip.p']:g}, the " in section(found)


def test_broken_trials_bound_every_difference(broken):
    found = results_of(broken)
    for agent, course in zip(broken.flips.agents, found.courses(), strict=True):
        for one in agent.inference.difference.at:
            for end, bound in zip(BOUNDS, one.bounds, strict=True):
                rows = course.against_lowest("success_difference", end)
                (row,) = [row for row in rows if row.doses["flip.p"] == one.dose]
                assert row.value == bound
            assert one.low <= one.bounds[0] <= one.bounds[1] <= one.high
        shares = {float(row.of): row.count for row in course.where("broken_share")}
        assert shares == {p: share.count for p, share in agent.inference.broken.at}
    said = r"in all begun pairs the difference is between \S+ and \S+ points, whatever became of them"
    assert len(re.findall(said, re.sub("</?i>", "", section(found)))) == 2
    assert "trials finished at both" in section(found)


def cells(found):
    """The rows of the table of tests, as text."""
    rows = re.findall(r'<tr>(<td class="asks">.*?)</tr>', section(found, "hypothesis_tests"))
    plain = [row.replace('<span class="concluded">', "").replace("</span>", "", 1) for row in rows]
    return [re.findall(r"<td[^>]*>(.*?)</td>", row) for row in plain]


def test_every_test_is_a_row(numbers, found):
    for agent, course in zip(numbers.flips.agents, found.courses(), strict=True):
        tests = [] if agent.blind else agent.inference.tests
        rows = {row.of: row for row in course.where("test")}
        assert set(rows) == {test.question for test in tests}
        for test in tests:
            row = rows[test.question]
            assert (row.test, row.value, row.p_value, row.low, row.high) == (
                test.name,
                test.effect,
                test.p_value,
                test.low,
                test.high,
            )
            assert (row.unit, row.note) == (unit_of_effect(test.name), limits_said(test))
            assert (course.value("test_direction", row.of) or 0) == test.direction


@pytest.mark.parametrize(("p_value", "said"), [(0.01, "yes"), (0.9, "not detected"), (None, "\N{EN DASH}")])
def test_a_conclusion_follows_from_the_p_value(found, p_value, said):
    changed = [row.model_copy(update={"p_value": p_value} if row.quantity == "test" else {}) for row in found.rows]
    shown = cells(found.changed(rows=tuple(changed)))
    assert {re.sub("<br>.*", "", row[4]) for row in shown} == {said}
