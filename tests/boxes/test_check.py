"""What cannot be played is refused for the right reason."""

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe.boxes.box import Joint, Lockbox
from lockprobe.boxes.state_space import fault_of


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


@settings(max_examples=30)
@given(st.data())
def test_what_passes_is_solvable_and_every_alternative_of_the_target_can_hold(boxes, brute_optimum, data):
    drawn = data.draw(boxes)
    fault, steps = fault_of(drawn), brute_optimum(drawn)
    assert (steps is None) == (fault is not None and fault.startswith("unsolvable"))
    if fault is None:
        for clause in drawn.interlock.get(drawn.target, ()):
            alone = replace(drawn, interlock={**drawn.interlock, drawn.target: (clause,)})
            assert brute_optimum(alone) is not None
