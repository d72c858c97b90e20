"""A forest plot shows each estimate in its row, whatever is missing."""

from lockprobe.figures.forest import ForestRow, forest


def row(name, value, low=None, high=None):
    return ForestRow(name=name, said=f"{name} said", value=value, low=low, high=high, colour="black", face="black")


def test_rows_from_the_top_with_arrows_for_what_lies_outside(axes):
    forest(axes, [row("a", 0.5, 0.2, 0.8), row("b", 3.0), row("c", -3.0), row("d", None)], (0.0, 1.0))
    drawn = [(line.get_marker(), list(line.get_xdata()), set(line.get_ydata())) for line in axes.lines]
    assert drawn == [
        ("None", [0.2, 0.8], {0}),
        ("o", [0.5], {0}),
        (">", [1.0], {1}),
        ("<", [0.0], {2}),
    ]
    assert axes.get_xlim() == (0.0, 1.0)
    assert axes.yaxis_inverted()
    assert [text.get_text() for text in axes.texts[6:]] == ["d", "d said"]
