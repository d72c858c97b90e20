"""A box in characters."""

from lockprobe.boxes.families import box
from lockprobe.boxes.sketch import interlock_lines


def test_the_tree_of_a_box_with_everything():
    assert interlock_lines(box("common-effect-3")) == [
        "door (target)",
        "└─ lever-0 open",
        "   ├─ lever-1 open: always free",
        "   └─ or lever-2 open: always free",
    ]
    assert interlock_lines(box("reset")) == [
        "revolute-left (target)",
        "├─ slider-1 open",
        "│  └─ slider-2 open",
        "│     └─ revolute-right open: always free",
        "└─ and revolute-right closed: always free",
    ]
    assert interlock_lines(box("branched"))[-3:] == [
        "└─ slider-2 closed: see above",
        "branch-2",
        "└─ branch-1 open: see above",
    ]
