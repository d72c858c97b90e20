"""The picture of rationality has the numbers of the results."""

import numpy as np
import pytest
from drawn import bars

from lockprobe.report.figures.rationality import rationality

OBSERVERS = ("naive", "aware")


def chance_of(axes):
    return {line.get_linestyle(): list(line.get_ydata()) for line in axes.lines if line.get_linestyle() in {":", "--"}}


@pytest.mark.parametrize(("place", "quantity"), [(0, "optimal_actions"), (1, "steps_lost")])
def test_both_observers_stand_with_their_intervals_beside_chance(typical, model, place, quantity):
    axes = rationality(typical).axes[place]
    rows = [cell.get(quantity, of) for of in OBSERVERS for cell in model.cells]
    assert np.allclose([bar[1:] for bar in bars(axes)], [(row.value, row.low, row.high) for row in rows])
    assert np.allclose([bar[0] for bar in bars(axes)], [cell.p for cell in model.cells] * 2, atol=0.01)
    expected = {
        dash: [cell.value(f"{quantity}_chance", of) for cell in model.cells]
        for dash, of in zip((":", "--"), OBSERVERS, strict=True)
    }
    assert chance_of(axes) == expected


def test_steps_lost_have_one_axis(studies):
    lower = rationality(studies["three"]).axes[2:4]
    assert lower[0].get_ylim() == lower[1].get_ylim()


def test_everything_is_in_sight(studies):
    found = studies["strategies"]
    shown = [axes for axes in rationality(found).axes if axes.get_ylabel() == "steps lost per action"]
    assert len(shown) == len(found.courses())
    for axes, course in zip(shown, found.courses(), strict=True):
        low, high = axes.get_ylim()
        assert low < 0
        assert all(cell.value("steps_lost_chance", of) < high for cell in course.cells for of in OBSERVERS)


def test_the_number_of_actions_is_said(typical, model):
    sizes = [cell.get("optimal_actions", "naive").n for cell in model.cells]
    said = rationality(typical).axes[0].get_title(loc="left")
    assert f"n = {min(sizes)} to {max(sizes)} actions per flip rate" in said


def test_chance_can_be_seen_at_a_single_p(studies):
    axes, _ = rationality(studies["one p"]).axes
    (line,) = [line for line in axes.lines if line.get_linestyle() == ":"]
    low, high = line.get_xdata()
    assert low < 0 < high


def test_there_is_no_picture_of_what_was_not_judged(studies):
    assert rationality(studies["one trial"]) is not None
    assert rationality(studies["errors"]) is None
