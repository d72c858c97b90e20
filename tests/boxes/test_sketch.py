"""A box in characters."""

import pytest

from lockprobe.boxes.families import box, named_boxes
from lockprobe.boxes.sketch import interlock_lines, panel_lines

NAMES = (*named_boxes(), "random-8-3")


@pytest.mark.parametrize("name", NAMES)
def test_every_joint_stands_on_the_panel_once(name):
    lines = panel_lines(box(name))
    assert len({len(line) for line in lines[:-1]}) == 1
    numbers = " ".join(lines[2::2][: (len(lines) - 3) // 2])
    found = [int(part.strip("*")) for part in numbers.replace("│", " ").split() if part.strip("*").isdigit()]
    assert sorted(found) == list(range(1, len(box(name).joints) + 1))
    target = box(name).target_index + 1
    assert f"{target}*" in numbers
    assert numbers.count("*") == 1


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
