"""Whole pictures: of any study, legible, deterministic, without touching global state."""

import io
import re
import sys
from itertools import combinations

import matplotlib as mpl
import numpy as np
import pytest
from PIL import Image

from lockprobe import figures

CASES = (
    "typical",
    "three",
    "strategies",
    "many p",
    "thirty p",
    "one p",
    "one trial",
    "three trials",
    "nothing solved",
    "errors",
    "hostile names",
    "long names",
    "people",
    "people alone",
    "people at one p",
    "few people",
)
NAMES = ["overview", "overview-column", "fig3", "fig3-corrected", "fig3-by-p", "fig4", "fig4-corrected", "rationality"]
NAMES += ["fig5a", "fig5a-corrected", "fig5b", "fig5b-corrected"]


def written(figure):
    """Every text that is to be read, and where it stands in pixels."""
    found = [figure._supxlabel] if figure._supxlabel else []
    for legend in figure.legends:
        found += legend.get_texts()
    for axes in figure.axes:
        if not axes.get_visible():
            continue
        found += [*axes.texts, axes._left_title]
        if not axes.axison:
            continue
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            ticks = [tick for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]
            found += [axis.label, *(tick.label1 for tick in ticks)]
    return [(text, text.get_window_extent()) for text in found if text.get_text().strip()]


@pytest.mark.parametrize("case", CASES)
def test_every_text_is_large_enough_inside_and_touches_no_other(studies, case):
    for name, figure in figures.pictures(studies[case]).items():
        figure.draw_without_rendering()
        texts = written(figure)
        assert texts
        for text, place in texts:
            assert text.get_fontsize() >= 9, (name, text)
            assert not re.search(r"\bp\b|(?<!\$)\bP\b", text.get_text().replace("$p$", "")), (name, text)
            beyond = [-place.x0, -place.y0, place.x1 - figure.bbox.x1, place.y1 - figure.bbox.y1]
            assert max(beyond) <= 1, (name, text)
        for (one, first), (other, second) in combinations(texts, 2):
            apart = min(first.x1, second.x1) - max(first.x0, second.x0)
            above = min(first.y1, second.y1) - max(first.y0, second.y0)
            assert apart <= 1.5 or above <= 1.5, (name, one, other)


def test_the_names_of_the_pictures(studies):
    assert list(figures.pictures(studies["one trial"])) == NAMES


def test_people_have_a_picture_of_their_own(studies):
    assert [name for name in figures.pictures(studies["people"]) if name == "people"] == ["people"]
    drawn = [len(figures.drawings(studies[case])["people"]().axes) for case in ("people", "people alone", "few people")]
    assert drawn == [2, 1, 2]


def test_panels_are_a_column_of_print_wide_and_two_beside_each_other(studies):
    for case, columns, rows in (("typical", 1, 1), ("three", 2, 2), ("strategies", 2, 2)):
        figure = figures.panels(figures.draw_loops_against_success, studies[case].subjects)
        assert tuple(figure.get_size_inches()) == (3.5 * columns, 2.9 * rows)
        assert sum(axes.get_visible() for axes in figure.axes) == len(studies[case].subjects)


@pytest.mark.parametrize("case", ["three", "hostile names"])
@pytest.mark.parametrize("draw", [figures.draw_success_curves, figures.draw_success_by_p])
def test_every_agent_is_named(studies, case, draw):
    (legend,) = figures.single(draw, studies[case]).legends
    names = [text.get_text() for text in legend.get_texts()]
    assert names.count("the paper") == 1
    assert len(names) == len(studies[case].agents) + 1


def test_what_cannot_be_compared_takes_no_room(studies):
    for case, axes in (("three trials", [2, 2]), ("one trial", [1, 2]), ("one p", [2, 1]), ("errors", [1, 1])):
        made = figures.pictures(studies[case])
        assert [len(made[name].axes) for name in ("fig3-corrected", "fig5b-corrected")] == axes


def test_a_single_flip_rate_is_no_axis(studies):
    """Nothing is drawn over one flip rate, and no axis has the single tick 0."""
    made = figures.pictures(studies["one p"])
    assert not {"fig4", "fig4-corrected", "courses", "fig5a", "fig5b", "fig3-by-p"} & made.keys()
    (axes,) = figures.panels(figures.draw_loops_with_chance, studies["one p"].subjects[:1]).axes
    assert not len(axes.get_xticks())
    assert axes.get_xlabel() == "flip rate $p$ = 0"


def test_no_line_runs_through_the_words_of_a_forest(studies):
    """Upright lines stop where the name of a row and its numbers stand."""
    figure = figures.pictures(studies["typical"])["fig3-corrected"]
    figure.draw_without_rendering()
    forest = figure.axes[1]
    words = [text.get_window_extent() for text in forest.texts]
    upright = [line for line in forest.lines if len(set(line.get_xdata())) == 1 and len(line.get_xdata()) == 2]
    assert len(upright) == 2 * len(forest.texts) / 2
    assert not any(line.get_window_extent().overlaps(word) for line in upright for word in words)


def test_equal_figures_are_equal_bytes(typical):
    for form, head in (("svg", b"<?xml"), ("png", b"\x89PNG")):
        first, second = (
            figures.render(figures.single(figures.draw_success_curves_corrected, typical), form) for _ in range(2)
        )
        assert first == second
        assert first.startswith(head)


def test_what_is_laid_out_once_looks_as_if_matplotlib_had_done_it(typical):
    """Matplotlib lays a figure out again for every file; ours is laid out before the first, to the same pixels."""
    by_hand, ours = (figures.panels(figures.draw_loops_by_p, typical.subjects, note="a note") for _ in range(2))
    expected = io.BytesIO()
    by_hand.savefig(expected, format="png", dpi=200, metadata={"Software": None})
    drawn = [np.asarray(Image.open(io.BytesIO(file))) for file in (figures.render(ours, "png"), expected.getvalue())]
    assert np.array_equal(*drawn)
    places = [axes.get_position().bounds for axes in ours.axes]
    figures.render(ours, "svg")
    assert [axes.get_position().bounds for axes in ours.axes] == places


def test_names_are_text_in_the_file(studies):
    assert b"<script>" not in figures.render(figures.single(figures.draw_success_by_p, studies["hostile names"]), "svg")


def test_nothing_global_is_touched(typical):
    settings = [name for name in mpl.rcParams if name != "backend"]  # asking for that one imports pyplot
    before = [mpl.rcParams[name] for name in settings]
    figures.render(figures.single(figures.draw_success_by_p, typical), "svg")
    assert [mpl.rcParams[name] for name in settings] == before
    assert "matplotlib.pyplot" not in sys.modules
