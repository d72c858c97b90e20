"""A box in characters."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe.boxes.families import box, named_boxes
from lockprobe.boxes.layouts import laid_out
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


@pytest.mark.parametrize("layout", ["zigzag", "ngram", "grid", "scattered"])
def test_rows_of_the_panel_run_from_above(layout):
    drawn = laid_out(box("chain-6"), layout, np.random.default_rng(1))
    lines = "\n".join(panel_lines(drawn)[2:-2:2])
    order = [int(part.strip("*")) - 1 for part in lines.replace("│", " ").split() if part.strip("*").isdigit()]
    heights = [drawn.joints[i].place[1] for i in order]
    assert all(later <= sooner + 0.12 for sooner, later in itertools.pairwise(heights))


def test_open_and_closed_look_different():
    drawn = box("chain-3")
    opened = type(drawn)(
        name="x", joints=drawn.joints, interlock=drawn.interlock, initial=(False, True, True), target=drawn.target
    )
    row = panel_lines(opened)[1]
    assert ("(|)" in row, "[-#]" in row, "(-)" in row, "[#-]" in row) == (True, True, True, False)


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
