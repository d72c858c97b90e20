"""The forest of paired differences: one row for each pair, the right way round, filled where they can be told apart."""

import pytest
from builders import SOLUTION, make_trial
from matplotlib.figure import Figure

from lockprobe.analysis.summary import summarise
from lockprobe.figures.differences import SHOWN, draw_changes, draw_differences, shown


def study(**solved):
    """Models that solve so many of 20 trials at p = 0 and at 0.4."""
    return summarise(
        [
            make_trial(SOLUTION if i < n else (0,) * 20, agent=f"llm:{name}", p=p, trial=i + 1)
            for name, both in solved.items()
            for p, n in zip((0.0, 0.4), both, strict=True)
            for i in range(20)
        ]
    )


def marks(axes):
    return [line for line in axes.lines if line.get_marker() not in ("None", None, "")]


def test_every_pair_has_a_row_with_its_difference(axes):
    draw_differences(axes, study(a=(18, 20), b=(2, 0), c=(2, 1)))
    first, second, third = marks(axes)
    assert [mark.get_xdata()[0] for mark in (first, second, third)] == pytest.approx([0.9, 0.875, -0.025])
    assert [mark.get_markerfacecolor() == mark.get_color() for mark in (first, second, third)] == [True, True, False]
    assert any("llm:a \N{MINUS SIGN} llm:b" in text.get_text() for text in axes.texts)


def test_changes_are_those_from_the_lowest_p(axes):
    draw_changes(axes, study(a=(2, 18), b=(10, 10)))
    (mark,) = marks(axes)
    assert mark.get_xdata()[0] == pytest.approx(0.8)


def test_more_pairs_than_there_is_room_for_are_counted():
    many = study(**{f"m{i}": (i, i) for i in range(7)})
    assert len(shown(many)) == SHOWN
    axes = Figure().add_subplot()
    draw_differences(axes, many)
    assert "6 more in the tables" in axes.get_title(loc="left")
