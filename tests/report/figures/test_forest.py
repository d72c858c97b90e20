"""A forest plot shows each estimate in its row, whatever is missing."""

from drawn import bars

from lockprobe.report.figures.forest import ForestRow, forest
from lockprobe.report.figures.palette import Style
from lockprobe.report.rows import Estimate


def row(name, value, low=None, high=None):
    return ForestRow(
        name, f"{name} said", Estimate(quantity="x", value=value, low=low, high=high), Style(colour="black")
    )


def test_rows_from_the_top_with_arrows_for_what_lies_outside(axes):
    forest(axes, [row("a", 0.5, 0.2, 0.8), row("b", 3.0), row("c", -3.0), row("d", None)], (0.0, 1.0))
    drawn = [(line.get_marker(), line.get_xdata()[0], line.get_ydata()[0]) for line in axes.lines]
    assert [mark for mark in drawn if mark[0]] == [("o", 0.5, 0), (">", 1.0, 1), ("<", 0.0, 2)]
    assert bars(axes, across=True)[0] == (0, 0.5, 0.2, 0.8)
    assert axes.get_xlim() == (0.0, 1.0)
    assert axes.yaxis_inverted()
    assert [text.get_text() for text in axes.texts[6:]] == ["d", "d said"]
