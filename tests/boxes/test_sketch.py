"""A box in characters."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe.boxes.families import box, named_boxes
from lockprobe.boxes.sketch import ascii_only, interlock_lines, panel_lines

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


def test_what_is_told_is_drawn_and_nothing_else():
    drawn = box("chain-4")
    told = panel_lines(drawn, labels="DACB", positions=(True, None, False, None))
    assert [part.strip("│").split() for part in told[1:3]] == [
        ["(-)", "[?", "]", "[#-]", "(?)"],
        ["D*", "A", "C", "B"],
    ]
    assert "not told" in told[-1]
    assert panel_lines(drawn, positions=drawn.initial) == panel_lines(drawn)


@settings(max_examples=30)
@given(st.data())
def test_the_tree_names_every_position_that_is_asked_for(boxes, data):
    drawn = data.draw(boxes)
    lines = interlock_lines(drawn)
    locked = {name: c for name, c in drawn.interlock.items() if all(c)}
    wanted = sum(len(clause) for clauses in locked.values() for clause in clauses)
    assert sum(" open" in line or " closed" in line for line in lines) == wanted
    for name in drawn.names:
        assert any(name in line for line in lines)
    assert lines[0].startswith(f"{drawn.target} (target)")


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


@pytest.mark.parametrize("name", NAMES)
def test_it_survives_terminals_that_know_only_ascii(name):
    text = "\n".join([*panel_lines(box(name)), *interlock_lines(box(name))])
    plain = ascii_only(text)
    assert plain.isascii()
    assert [len(line) for line in plain.splitlines()] == [len(line) for line in text.splitlines()]
