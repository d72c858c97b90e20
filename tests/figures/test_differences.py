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
    assert any("llm:a\n\N{MINUS SIGN} llm:b" in text.get_text() for text in axes.texts)


def test_changes_are_those_from_the_lowest_p(axes):
    draw_changes(axes, study(a=(2, 18), b=(10, 10)))
    (mark,) = marks(axes)
    assert mark.get_xdata()[0] == pytest.approx(0.8)


def test_the_change_that_is_drawn_is_the_one_that_the_test_speaks_of(axes):
    """At 0.2 nine of forty blocks change, all one way; at 0.4 more do, both ways."""
    apart = [(1, 1, -1)] * 12 + [(-1, -1, 1)] * 7 + [(0, 1, 0)] * 9 + [(0, 0, 0)] * 12
    made = [
        make_trial(SOLUTION if sign * ahead > 0 else (0,) * 20, agent=agent, p=p, trial=i + 1)
        for agent, sign in (("llm:a", 1), ("llm:b", -1))
        for i, signs in enumerate(apart)
        for p, ahead in zip((0.0, 0.2, 0.4), signs, strict=True)
    ]
    draw_changes(axes, summarise(made))
    (mark,) = marks(axes)
    assert mark.get_xdata()[0] == pytest.approx(9 / 40)
    assert mark.get_markerfacecolor() == mark.get_color()
    assert any(text.get_text().startswith("to 0.2: +22 [") for text in axes.texts)


def test_agents_that_the_test_alone_tells_apart_stay_hollow(axes):
    """One fails in six blocks at the lowest p of seven: the test is below 0.05, the interval holds 0."""
    made = [
        make_trial(SOLUTION if agent == "llm:a" or p or i < 4 else (0,) * 20, agent=agent, p=p / 10, trial=i + 1)
        for agent in ("llm:a", "llm:b")
        for p in range(7)
        for i in range(10)
    ]
    draw_differences(axes, found := summarise(made))
    (mark,) = marks(axes)
    assert found.comparisons[0].success_adjusted < 0.05
    assert mark.get_markerfacecolor() == "white"


def test_more_pairs_than_there_is_room_for_are_counted():
    many = study(**{f"m{i}": (i, i) for i in range(7)})
    assert len(shown(many)) == SHOWN
    axes = Figure().add_subplot()
    draw_differences(axes, many)
    assert "6 more in the tables" in axes.get_title(loc="left")
