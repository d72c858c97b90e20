"""Labels stand where they are put, and only there."""

import numpy as np
from lockprobe_robot.user_model.label_overlay import draw_labels


def test_each_label_is_around_its_place_and_those_outside_are_not_seen():
    grey = np.full((120, 160, 3), 128, np.uint8)
    drawn = draw_labels(grey, ("A", "B", "C"), np.array([[40.0, 30.0], [120.0, 90.0], [500.0, 10.0]]))
    rows, columns = np.nonzero((drawn != grey).any(2))
    near = [(np.abs(columns - x) < 8) & (np.abs(rows - y) < 8) for x, y in ((40, 30), (120, 90))]
    assert all(one.any() for one in near)
    assert (near[0] | near[1]).all()
    assert (grey == 128).all()
