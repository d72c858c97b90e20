"""Laws of the puzzle, and what is no puzzle that can be played."""

import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe.boxes.box import Joint, Lockbox
from lockprobe.boxes.solve import fault_of


@settings(max_examples=25)
@given(st.data())
def test_attempts_in_every_configuration(boxes, data):
    """A joint moves if any clause holds entirely. Nothing else changes, and a second attempt undoes the first."""
    drawn = data.draw(boxes)
    for configuration, joint in itertools.product(itertools.product((False, True), repeat=4), range(4)):
        after, moved = drawn.attempt(configuration, joint)
        assert all(after[other] == configuration[other] for other in range(4) if other != joint)
        assert moved == (after[joint] != configuration[joint])
        assert drawn.attempt(after, joint)[0] == configuration
        state = dict(zip(drawn.names, configuration, strict=True))
        clauses = drawn.interlock.get(drawn.names[joint], ({},))
        expected = any(set(clause.items()) <= set(state.items()) for clause in clauses)
        assert drawn.may_move(configuration, joint) == moved == expected


@pytest.mark.parametrize(
    ("interlock", "reason"),
    [
        (
            {"a": ({"b": True},), "b": ({"c": True},), "c": ({"a": True},)},
            "unsolvable: nothing moves, every joint is locked at the start",
        ),
        ({"a": ({"b": True},), "b": ({"a": True},)}, "unsolvable: no sequence of attempts moves a"),
        (
            {"a": ({"b": True}, {"c": True, "b": False}), "c": ({"b": True},), "b": ({"c": False},)},
            "contradictory: {c = 1, b = 0} of target a holds in no configuration that can be reached",
        ),
        ({}, "too short: solved in 1 of at least 2 steps"),
        ({"a": ({"b": True},)}, None),
    ],
)
def test_reasons(interlock, reason):
    joints = tuple(Joint(name=name, kind="revolute") for name in "abc")
    box = Lockbox(name="x", joints=joints, interlock=interlock, initial=(False,) * 3, target="a")
    assert fault_of(box, shortest=2) == reason
