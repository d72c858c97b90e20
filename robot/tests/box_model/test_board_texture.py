"""What is painted on the board, and where."""

import sys

import numpy as np
import pytest
from lockprobe_robot.box_model.appearance import appearance_of
from lockprobe_robot.box_model.board_texture import PIXELS_PER_METRE, paint_board, wood
from lockprobe_robot.box_model.mounted_joint import WAY_RADIUS
from lockprobe_robot.box_model.panel import lay_out_panel
from lockprobe_robot.twin_settings import SceneSettings

from lockprobe.boxes.families import box
from lockprobe.foundation.errors import Missing


def appearance(**settings):
    return appearance_of(SceneSettings(**settings), np.random.default_rng(1))


PLAIN = appearance()


def pixel(panel, point):
    column, row = ((np.array(point) * (1, -1) + np.array(panel.size) / 2) * PIXELS_PER_METRE).astype(int)
    return row, column


def test_the_way_is_dark_and_its_ends_are_told_apart():
    panel = lay_out_panel(box("chain-4"))
    board = paint_board(panel, tuple("ABCD"), PLAIN, target=0).astype(int).sum(2)
    for mounted in panel.mounted_joints:
        assert board[pixel(panel, mounted.knob(0))] > 650
        assert board[pixel(panel, mounted.knob(0.5))] < 120
        assert board[pixel(panel, mounted.knob(1))] < 120


def test_without_discs_nothing_tells_one_end_of_a_way_from_the_other():
    panel = lay_out_panel(box("chain-4"))
    usual, without = (
        paint_board(panel, tuple("ABCD"), look, target=0).astype(int) for look in (PLAIN, appearance(discs=False))
    )
    ends = [(mounted.knob(0), mounted.knob(1)) for mounted in panel.mounted_joints]
    for first, last in ends:
        assert (without[pixel(panel, first)] == without[pixel(panel, last)]).all()
    columns, rows = np.nonzero((usual != without).any(2))[::-1]
    changed = (np.stack([columns, rows], axis=1) / PIXELS_PER_METRE - np.array(panel.size) / 2) * (1, -1)
    near = np.linalg.norm(changed[:, None] - np.array(ends).reshape(-1, 2), axis=-1).min(1)
    assert near.max() < WAY_RADIUS + 0.001


def test_a_bare_board_is_wood_with_labels_at_most():
    panel = lay_out_panel(box("chain-4"))
    labels = tuple("ABCD")
    bare, blank = (
        paint_board(panel, labels, appearance(board="bare", labels=shown), target=0) for shown in (True, False)
    )
    plank = wood(blank.shape[:2], PLAIN.wood, PLAIN.grain)
    assert (blank == plank).all()
    painted = paint_board(panel, labels, PLAIN, target=0) != paint_board(
        panel, labels, appearance(labels=False), target=0
    )
    assert ((bare != plank) == painted).all()


def test_each_label_stands_at_its_place_and_nothing_else_differs():
    panel = lay_out_panel(box("chain-4"))
    first, second = (paint_board(panel, labels, PLAIN, target=0) for labels in (tuple("ABCD"), tuple("ABXD")))
    rows, columns = np.nonzero((first != second).any(2))
    row, column = pixel(panel, panel.labels[2])
    reach = 0.62 * panel.letter * PIXELS_PER_METRE
    assert len(rows) > 100
    assert np.abs(rows - row).max() < reach
    assert np.abs(columns - column).max() < reach


def test_the_target_is_marked_at_its_label_and_nowhere_else():
    panel, labels = lay_out_panel(box("chain-4")), tuple("ABCD")
    first, second = (paint_board(panel, labels, PLAIN, target=target) for target in (0, 2))
    rows, columns = np.nonzero((first != second).any(2))
    places = np.array([pixel(panel, panel.labels[target]) for target in (0, 2)])
    far = np.linalg.norm(np.stack([rows, columns], axis=1)[:, None] - places, axis=-1)
    assert far.min(1).max() < 0.75 * panel.letter * PIXELS_PER_METRE
    assert (far.argmin(1) == 0).any()
    assert (far.argmin(1) == 1).any()


def test_a_capital_is_as_high_as_the_panel_says():
    panel = lay_out_panel(box("chain-4"))
    with_it, without = (paint_board(panel, (label, *"BCD"), PLAIN, target=3) for label in ("H", " "))
    inked = np.nonzero((with_it != without).any((1, 2)))[0]
    assert (inked[-1] - inked[0]) / PIXELS_PER_METRE == pytest.approx(panel.letter, rel=0.1)


def test_wood_has_its_colour_on_average_and_its_grain_by_seed():
    plank = wood((120, 400), (0.8, 0.6, 0.4), 5)
    assert plank.reshape(-1, 3).mean(0) == pytest.approx([204, 153, 102], rel=0.03)
    assert (plank == wood((120, 400), (0.8, 0.6, 0.4), 5)).all()
    assert (plank != wood((120, 400), (0.8, 0.6, 0.4), 6)).any()


def test_without_pillow_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "PIL", None)
    with pytest.raises(Missing, match="pillow: pip install"):
        paint_board(lay_out_panel(box("chain-2")), tuple("AB"), PLAIN, target=0)
