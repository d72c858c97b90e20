"""The figure of the first screen: agents named where their lines end, over flip rates or steps."""

import pytest
from drawn import course
from matplotlib.collections import LineCollection
from matplotlib.path import Path

from lockprobe.report.figures import first_screen, render
from lockprobe.report.figures.first_screen import draw_overview
from lockprobe.report.figures.frame import label_in_lines


def names(figure):
    (axes,) = figure.axes
    return [text.get_text() for text in axes.texts]


def stars(figure):
    return [line for line in figure.axes[0].get_lines() if line.get_gid() == "paper"]


def test_success_over_flip_rates_stands_beside_chance_and_the_paper(studies):
    figure = draw_overview(studies["three"])
    assert names(figure).count("random agents, exact") == 1
    assert "llm:local" in names(figure)
    assert len(stars(figure)[0].get_xdata()) == 2
    assert "flip rate" in figure.axes[0].get_xlabel()


def test_no_patch_behind_the_name_of_the_paper_hides_lines(studies):
    named = [text for text in draw_overview(studies["three"]).axes[0].texts if "Zenkri" in text.get_text()]
    assert named
    assert all(text.get_bbox_patch() is None for text in named)


@pytest.mark.parametrize("case", ["typical", "three", "strategies", "people", "hostile names"])
def test_no_line_crosses_the_name_of_the_paper(studies, case):
    figure = draw_overview(studies[case])
    render(figure, "png")
    (axes,) = figure.axes
    named = [text for text in axes.texts if "Zenkri" in text.get_text()]
    bars = [line for bar in axes.collections if isinstance(bar, LineCollection) for line in bar.get_segments()]
    drawn = [line.get_xydata() for line in axes.lines if line.get_transform() == axes.transData]
    lines = [Path(axes.transData.transform(one)) for one in (*bars, *(one for one in drawn if len(one) > 2))]
    assert named
    for text in named:
        assert not any(line.intersects_bbox(text.get_window_extent(), filled=False) for line in lines)


def test_stars_without_room_for_a_name_are_named_at_the_edge(studies, monkeypatch):
    monkeypatch.setattr(first_screen, "_STAR_NAME", (2.0, 0.1))
    assert "\N{WHITE STAR} Zenkri & Brock" in names(draw_overview(studies["typical"]))
    assert "\N{WHITE STAR} Zenkri & Brock" in names(draw_overview(studies["typical"], "column"))


def test_an_agent_shown_in_several_ways_keeps_one_name():
    ways = [course("viewer:human-inspired?acuity=7", shown=shown) for shown in ("positions in words", "RGB")]
    first, second = (label_in_lines(way, 28).split("\n") for way in ways)
    assert first[0] == second[0]
    assert (first[1], second[1]) == ("(positions in words)", "(RGB)")


def test_a_single_flip_rate_is_shown_by_step_without_the_paper(studies):
    figure = draw_overview(studies["one p"])
    assert figure.axes[0].get_xlabel() == "number of interactions"
    assert not stars(figure)


def test_a_column_of_print_has_few_ticks(studies):
    screen, column = (draw_overview(studies["thirty p"], size) for size in ("screen", "column"))
    assert screen.get_figwidth() > column.get_figwidth() == 3.5
    assert len(column.axes[0].get_xticks()) <= 3


def test_nothing_is_drawn_before_a_trial_has_ended(studies):
    assert draw_overview(studies["errors"]) is None
