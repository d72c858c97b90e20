"""The contract of boxes holds for ours and finds what breaks it."""

from dataclasses import replace
from itertools import count

import pytest

from lockprobe.boxes.families import box, named_boxes
from lockprobe.testing import check_box

CHAIN = box("chain-4")
NUMBERS = count(2)


@pytest.mark.parametrize("name", [*named_boxes()[::4], "random-5-17"])
def test_boxes_that_keep_it(name, tmp_path):
    check_box(name)
    check_box(box(name))
    check_box(lambda: box(name))


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (replace(CHAIN, interlock={"revolute-left": ({"slider-1": True},), "slider-1": ({"revolute-left": True},)}), "unsolvable"),
        (replace(CHAIN, name="a box"), "cannot be written down: .*expected a name"),
        (lambda: box(f"chain-{next(NUMBERS)}"), "is another box when it is asked for again"),
        (lambda: "chain-4", "'chain-4' is no Lockbox"),
        (replace(CHAIN, joints=tuple(replace(j, place=(1, 7)) for j in CHAIN.joints)), "cannot be written down"),
    ],
)  # fmt: skip
def test_boxes_that_break_it(asked, said):
    with pytest.raises(AssertionError, match=said):
        check_box(asked)
