"""The figure of a suite: every score of every agent in its panel, every text apart from every other."""

from itertools import combinations

import pytest

from lockprobe.report.figures.suite import SHOWN, suite_drawing
from lockprobe.statistics.suite.scores import Rational, Score, SuiteScore


def scores(value, *, asked=True):
    def one(at):
        return Score(value=at, low=at - 0.1, high=at + 0.1)

    return SuiteScore(
        trials=288,
        broken=0,
        competence=one(value),
        robustness=one(-value),
        misreading=one(0.2) if asked else None,
        loops=one(value / 2),
        rationality=Rational(value=value, low=value - 0.1, high=value + 0.1, chance=0.3, actions=9),
        levels=(),
    )


def marks(axes):
    return [float(line.get_xdata()[0]) for line in axes.lines if line.get_marker() == "o"]


def test_every_score_is_drawn_and_what_is_not_asked_is_said():
    figure = suite_drawing([("a", scores(0.8)), ("b", scores(0.1, asked=False))])
    assert [marks(axes) for axes in figure.axes] == [[0.8, 0.1], [-0.8, -0.1], [0.2], [0.4, 0.05], [0.8, 0.1]]
    assert [text.get_text() for axes in figure.axes for text in axes.texts] == ["not asked"]


def test_every_score_has_a_scale_that_shows_more_than_0():
    figure = suite_drawing([("a", scores(0.27)), ("b", scores(-0.38))])
    assert all(2 <= len(axes.get_xticks()) <= 3 for axes in figure.axes)


@pytest.mark.parametrize("agents", [1, 3, SHOWN + 2])
def test_texts_are_inside_and_touch_no_other(agents):
    name = "human-inspired:proximity?lapse=0, $x_$ <b>"
    figure = suite_drawing([(f"{i} {name}", scores(0.02 * i, asked=i % 2 > 0)) for i in range(agents)])
    figure.draw_without_rendering()
    found = [text for axes in figure.axes for text in (*axes.texts, axes.xaxis.label, axes._left_title)]
    found += [text for axes in figure.axes for text in axes.get_xticklabels()] + figure.axes[0].get_yticklabels()
    found = [(text.get_text(), text.get_window_extent()) for text in found if text.get_text()]
    for text, place in found:
        assert max(-place.x0, -place.y0, place.x1 - figure.bbox.x1, place.y1 - figure.bbox.y1) <= 1, text
    for (one, first), (other, second) in combinations(found, 2):
        apart = min(first.x1, second.x1) - max(first.x0, second.x0)
        above = min(first.y1, second.y1) - max(first.y0, second.y0)
        assert apart <= 1.5 or above <= 1.5, (one, other)
