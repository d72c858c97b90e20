"""Figures of loops show the loop rates and chance levels of the results."""

import numpy as np
import pytest
from drawn import bars, dots, lines, published, shades, staircases

from lockprobe.report.figures.loops import loops_against_success, loops_by_p, loops_with_chance


def shares(course, quantity="loop_rate", of=""):
    return [cell.value(quantity, of) for cell in course.cells]


def points(course):
    return [(cell.p, success.value, loops.value) for cell in course.cells for success, loops in cell.points]


def title(axes):
    return " ".join(axes.get_title(loc="left").split())


def test_loop_rates_stand_beside_two_levels_of_chance(typical, model):
    axes, _ = loops_with_chance(typical).axes
    rates = [cell.get("loop_rate") for cell in model.cells]
    assert np.allclose(bars(axes), [(c.p, r.value, r.low, r.high) for c, r in zip(model.cells, rates, strict=True)])
    chance = {of: shares(model, "loop_rate_chance", of) for of in ("uniform", "no-repeat")}
    (band,) = shades(axes)
    for of, dash in (("uniform", ":"), ("no-repeat", "--")):
        assert band >= set(zip([cell.p for cell in model.cells], chance[of], strict=True))
        assert [list(line.get_ydata()) for line in axes.lines if line.get_linestyle() == dash] == [chance[of]]
    assert [text.get_text() for text in axes.texts] == ["random", "no-repeat"]


def test_chance_can_be_seen_at_a_single_p(studies):
    found = studies["one p"]
    (axes,) = loops_with_chance(found).axes  # and no onset of loops, which needs two
    (line,) = [line for line in axes.lines if line.get_linestyle() == ":"]
    assert list(line.get_ydata()) == shares(found.courses()[0], "loop_rate_chance", "uniform") * 2
    low, high = line.get_xdata()
    assert low < 0 < high


def test_loop_onset_of_the_lowest_p_against_all_higher(typical, model):
    _, axes = loops_with_chance(typical).axes
    groups = [typical.curve("loop_onset", agent=model.agent, of=of) for of in ("lowest", "higher")]
    assert [tuple(line.get_ydata()[:-1]) for line in staircases(axes)] == [group.value for group in groups]
    for band, group in zip(shades(axes), groups, strict=True):
        assert band >= set(enumerate(group.low)) | set(enumerate(group.high))
    ratio, said = model.get("hazard_ratio_of_first_loop"), title(axes)
    assert f"hazard ratio {ratio.value:.2f}, log-rank: $P$ = {ratio.p_value:.2g}" in said
    assert {text.get_text() for text in axes.texts} == {"$p$ = 0\nn = 30", "$p$ = 0.1 to 0.6\nn = 180"}


def test_where_there_is_no_onset_to_compare_that_is_said(studies):
    found = studies["strategies"]
    blind = next(i for i, course in enumerate(found.courses()) if course.blind)
    axes = loops_with_chance(found).axes[blind // 2 * 4 + blind % 2 + 2]
    (text,) = axes.texts
    assert "the same at every flip rate" in text.get_text().replace("\n", " ")
    assert not axes.lines


def test_loop_rates_of_figure_5b(typical, model):
    (axes,) = loops_by_p(typical).axes
    fit = model.curve("loop_fit")
    assert [tuple(y) for _, y in lines(axes)] == [fit.value, tuple(shares(model))]
    assert set(dots(axes)) == {(p, loops) for p, _, loops in points(model)}
    (band,) = shades(axes)
    assert band >= set(zip(fit.x, fit.low, strict=True)) | set(zip(fit.x, fit.high, strict=True))


def test_dots_and_line_of_figure_5a(typical, model):
    (axes,) = loops_against_success(typical).axes
    found = points(model)
    assert set(dots(axes)) == {(loops, success) for _, success, loops in found}
    assert sum(dots(axes).values()) == len(found)
    _, y, x = np.array(found).T
    ((ends, heights),) = lines(axes)
    assert np.allclose(heights, np.polyval(np.polyfit(x, y, 1), ends))
    assert ends.tolist() == [x.min(), x.max()]
    assert f"r = \N{MINUS SIGN}{-model.value('loop_success_correlation'):.2f} [" in title(axes)
    assert "n = 21 dots" in title(axes)


def test_no_line_where_r_is_not_defined(studies):
    (axes,) = loops_against_success(studies["nothing solved"]).axes
    assert lines(axes) == []
    assert "r is not defined" in title(axes)


@pytest.mark.parametrize("draw", [loops_against_success, loops_by_p])
def test_blind_agents_say_so(studies, draw):
    axes, *_ = draw(studies["strategies"]).axes
    assert "random, the same at every flip rate" in title(axes)


def test_a_fit_without_a_band_does_not_claim_one(studies):
    found = studies["one trial"]
    assert found.courses()[0].curve("loop_fit").low == ()
    (axes,) = loops_by_p(found).axes
    assert "second-order fit" in title(axes)
    assert "band" not in title(axes)


def test_the_papers_loop_rates_are_hollow_stars(studies):
    for name in ("typical", "nothing solved"):  # of which 0.4 lies between 0.3 and 0.6
        (axes,) = loops_by_p(studies[name]).axes
        assert published(axes) == ([(0.0, 0.8), (0.4, 16 / 30)], ["the paper, reconstructed"])


def test_nothing_is_drawn_of_nothing_or_over_a_single_p(studies):
    assert not any(draw(studies["errors"]) for draw in (loops_against_success, loops_by_p, loops_with_chance))
    assert loops_against_success(studies["one p"]) is None
    assert loops_by_p(studies["one p"]) is None
