"""The picture of differences block by block."""

import pytest

from lockprobe.report.figures.stopping import stopping
from lockprobe.report.rows import Curve, Estimate


@pytest.fixture
def stopped(studies):
    """Eight differences of two agents, two of them total effects; the first is decided."""
    rows, curves = [], []
    for agent in ("a", "b"):
        for of in ("one", "two", "three", "total"):
            x = tuple(range(1, 31))
            ends = [1 / i**0.5 for i in x]
            value = tuple(0.3 for _ in x)
            low, high = (tuple(0.3 + way * end for end in ends) for way in (-1, 1))
            curves.append(
                Curve(
                    quantity="difference_by_block",
                    agent=agent,
                    of=of,
                    axis="block",
                    x=x,
                    value=value,
                    low=low,
                    high=high,
                )
            )
    rows.append(Estimate(quantity="decided_at_block", agent="a", of="total", unit="blocks", value=12, note="an effect"))
    found = studies["typical"]
    return found.changed(
        rows=(*found.rows, *rows), curves=(*found.curves, *curves), study=found.study | {"until": {"points": 0.1}}
    )


def test_six_differences_are_drawn_total_effects_first(stopped):
    drawn = stopping(stopped)
    titles = [axes.get_title("left").replace("\n", " ") for axes in drawn.axes if axes.get_visible()]
    assert len(titles) == 6
    assert [title.split()[-1] for title in titles[:2]] == ["total", "total"]


def test_the_block_with_which_it_was_decided_is_marked(stopped):
    first, second, *_ = stopping(stopped).axes
    assert [text.get_text() for text in first.texts if "block" in text.get_text()] == ["an effect,\nblock 12"]
    assert not [text for text in second.texts if "block" in text.get_text()]


def test_a_study_without_blocks_has_no_picture(studies):
    assert stopping(studies["typical"]) is None
