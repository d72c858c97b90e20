"""A forest plot shows each estimate in its row, whatever is missing."""

import pytest
from drawn import bars
from matplotlib.figure import Figure

from lockprobe.report.figures.forest import ForestRow, forest, height
from lockprobe.report.figures.palette import Style
from lockprobe.report.rows import Estimate


def row(name, value, low=None, high=None):
    return ForestRow(
        name, f"{name[0]} said", Estimate(quantity="x", value=value, low=low, high=high), Style(colour="black")
    )


def test_rows_from_the_top_with_arrows_for_what_lies_outside(axes):
    rows = [row("a", 0.5, 0.2, 0.8), row("b", 3.0), row("c", -3.0), row("d", None)]
    first, second, third, _ = forest(axes, rows, (0.0, 1.0))
    assert 0 < first < second < third < height(rows)
    drawn = [(line.get_marker(), line.get_xdata()[0], line.get_ydata()[0]) for line in axes.lines]
    assert [mark for mark in drawn if mark[0]] == [("o", 0.5, first), (">", 1.0, second), ("<", 0.0, third)]
    assert bars(axes, across=True)[0] == (first, 0.5, 0.2, 0.8)
    assert axes.get_xlim() == (0.0, 1.0)
    assert axes.yaxis_inverted()
    assert [text.get_text() for text in axes.texts[6:]] == ["d", "d said"]


def test_a_row_is_as_high_as_its_own_text(axes):
    short, long = row("a", 0.5), row("a name\nof two lines", 0.5)
    assert height([short]) < height([long]) < height([short, long]) == height([short]) + height([long])
    places = forest(axes, [short, long, short], (0.0, 1.0))
    assert places[1] - places[0] == pytest.approx(height([long]))
    assert places[2] - places[1] == pytest.approx(height([short]))


def test_beside_a_longer_panel_the_axis_stays_below_the_last_row(axes):
    rows = [row("a", 0.5), row("b", 0.5)]
    forest(axes, rows, (0.0, 1.0), room=3 * height(rows))
    assert axes.get_ylim() == (3 * height(rows), 0)
    assert axes.spines["bottom"].get_position() == ("data", height(rows))


def test_a_name_stands_right_above_its_mark_however_high_the_axes_are():
    for inches in (1.0, 6.0):
        figure = Figure(figsize=(3.5, inches))
        axes = figure.add_subplot()
        places = forest(axes, [row("a", 0.5), row("b", 0.5)], (0.0, 1.0))
        marks = [axes.transData.transform((0.5, place))[1] for place in places]
        names = [text.get_window_extent() for text in axes.texts if text.get_text() in {"a", "b"}]
        assert all(3 < name.y0 - mark < 16 for name, mark in zip(names, marks, strict=True))
