"""Whole pictures: of any study, legible, deterministic, without touching global state."""

import io
import re
import sys

import matplotlib as mpl
import numpy as np
import pytest
from drawn import pictures, touching, written
from PIL import Image

from lockprobe.report.figures import files, render, sheet
from lockprobe.report.figures.loops import loops_with_chance
from lockprobe.report.figures.success_by_flip_rate import fig4
from lockprobe.report.figures.success_by_step import success_curves, success_curves_by_p, success_curves_corrected

CASES = ("strategies", "thirty p", "one p", "one trial", "hostile names", "people", "few people")
"""What is special about other studies changes no text."""


@pytest.mark.parametrize("case", CASES)
def test_every_text_is_large_enough_inside_and_touches_no_other(studies, case):
    for name, figure in pictures(studies[case]).items():
        if name == "box":  # which is the same in all of them, and drawn by hand
            continue
        figure.draw_without_rendering()
        found = written(figure)
        assert found
        for text, place in found:
            assert text.get_fontsize() >= 9, (name, text)
            assert not re.search(r"\bp\b|(?<!\$)\bP\b", text.get_text().replace("$p$", "")), (name, text)
            beyond = [-place.x0, -place.y0, place.x1 - figure.bbox.x1, place.y1 - figure.bbox.y1]
            assert max(beyond) <= 1, (name, text)
        assert touching(figure) == [], name


def test_panels_are_a_column_of_print_wide_and_two_beside_each_other():
    for count, columns, rows in ((1, 1, 1), (2, 2, 1), (3, 2, 2)):
        figure = sheet(range(count), lambda axes, number: axes.set_title(str(number)))
        assert tuple(figure.get_size_inches()) == (3.5 * columns, 2.9 * rows)
        assert [axes.get_title() for axes in figure.axes if axes.get_visible()] == [str(i) for i in range(count)]


@pytest.mark.parametrize("case", ["strategies", "hostile names"])
@pytest.mark.parametrize("draw", [success_curves, fig4])
def test_every_agent_is_named(studies, case, draw):
    (legend,) = draw(studies[case]).legends
    names = [text.get_text() for text in legend.get_texts()]
    assert names.count("the paper") == 1
    assert len(names) == len(studies[case].courses()) + 1


def test_what_cannot_be_compared_takes_no_room(studies):
    """The onset of loops needs two flip rates; where every trial broke there is no figure but that of the box."""
    made = pictures(studies["one p"])
    assert [len(made[name].axes) for name in ("fig3-corrected", "fig5b-corrected")] == [2, 1]
    assert set(pictures(studies["errors"])) == {"box"}


def test_a_single_flip_rate_is_no_axis(studies):
    """Nothing is drawn over one flip rate, and no axis has the single tick 0."""
    assert not {"fig4", "fig4-corrected", "fig5a", "fig5b", "fig3-by-p"} & pictures(studies["one p"]).keys()
    axes, *_ = loops_with_chance(studies["one p"]).axes
    assert not len(axes.get_xticks())
    assert axes.get_xlabel() == "flip rate $p$ = 0"


def test_no_line_runs_through_the_words_of_a_forest(typical):
    """Upright lines stop where the name of a row and its numbers stand."""
    figure = success_curves_corrected(typical)
    figure.get_layout_engine().execute(figure)
    forest = figure.axes[1]
    words = [text.get_window_extent() for text in forest.texts]
    upright = [line for line in forest.lines if len(set(line.get_xdata())) == 1 and len(line.get_xdata()) == 2]
    assert len(upright) == 2 * len(forest.texts) / 2
    assert not any(line.get_window_extent().overlaps(word) for line in upright for word in words)


def test_equal_figures_are_equal_bytes(typical):
    first, second = (files(success_curves_corrected(typical)) for _ in range(2))
    assert first == second
    assert {form: file[:4] for form, file in first.items()} == {"svg": b"<?xm", "png": b"\x89PNG"}


def test_what_is_laid_out_once_looks_as_if_matplotlib_had_done_it(typical):
    """Matplotlib lays a figure out again for every file; ours is laid out before the first, to the same pixels."""
    by_hand, ours = (sheet(typical.courses()[:1], _named, note="a note") for _ in range(2))
    expected = io.BytesIO()
    by_hand.savefig(expected, format="png", dpi=200, metadata={"Software": None})
    drawn = [
        np.asarray(Image.open(io.BytesIO(file)).convert("RGB")) for file in (render(ours, "png"), expected.getvalue())
    ]
    assert np.array_equal(*drawn)
    places = [axes.get_position().bounds for axes in ours.axes]
    render(ours, "svg")
    assert [axes.get_position().bounds for axes in ours.axes] == places


def test_a_note_stands_above_the_legend():
    figure = sheet(
        "ab", lambda axes, shown: axes.plot([0, 1], label=shown), note="What is the same in all of these. " * 3
    )
    render(figure, "png")
    assert not touching(figure)
    assert figure.legends[0].get_window_extent().width < figure.bbox.width / 2  # a column has room for it


def _named(axes, course):
    axes.plot([0, 1], [0, 1], label=course.agent)


def test_names_are_text_in_the_file(studies):
    assert b"<script>" not in render(success_curves(studies["hostile names"]), "svg")


def test_nothing_global_is_touched(typical):
    settings = [name for name in mpl.rcParams if name != "backend"]  # asking for that one imports pyplot
    before = [mpl.rcParams[name] for name in settings]
    render(success_curves_by_p(typical), "svg")
    assert [mpl.rcParams[name] for name in settings] == before
    assert "matplotlib.pyplot" not in sys.modules
