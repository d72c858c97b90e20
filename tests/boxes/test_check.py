"""What cannot be played is refused for the right reason."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe.boxes.box import Joint, Lockbox
from lockprobe.boxes.check import fault_of
from lockprobe.boxes.families import box


def made(interlock, initial="000"):
    joints = tuple(Joint(name=name, kind="revolute") for name in "abc")
    return Lockbox(name="x", joints=joints, interlock=interlock, initial=tuple(b == "1" for b in initial), target="a")


@pytest.mark.parametrize(
    ("interlock", "kind", "reason"),
    [
        (
            {"a": ({"b": True},), "b": ({"c": True},), "c": ({"a": True},)},
            "nothing moves",
            "unsolvable: nothing moves, every joint is locked at the start",
        ),
        ({"a": ({"b": True},), "b": ({"a": True},)}, "unsolvable", "unsolvable: no sequence of attempts moves a"),
        (
            {"a": ({"b": True}, {"c": True, "b": False}), "c": ({"b": True},), "b": ({"c": False},)},
            "contradictory",
            "contradictory: {c = 1, b = 0} of target a holds in no configuration that can be reached",
        ),
        (
            {"a": ({}, {"b": True}), "b": ({"c": True},), "c": ({"b": True},)},
            "contradictory",
            "contradictory: {b = 1} of target a holds in no configuration that can be reached",
        ),
        ({"a": ({"b": False},)}, "too short", "too short: solved in 1 of at least 2 steps"),
        ({}, "too short", "too short: solved in 1 of at least 2 steps"),
    ],
)
def test_reasons(interlock, kind, reason):
    fault = fault_of(made(interlock), shortest=2)
    assert (fault.kind, fault.reason) == (kind, reason)


def test_where_it_starts_decides():
    interlock = {"a": ({"b": True},), "b": ({"a": True},)}
    assert fault_of(made(interlock)).kind == "unsolvable"
    assert fault_of(made(interlock, "010")) is None
    assert fault_of(made({"a": ({"b": True},)}), shortest=2) is None
    assert fault_of(made({"a": ({"b": True},)}), shortest=3).kind == "too short"


@settings(max_examples=30)
@given(st.data())
def test_what_passes_is_solvable_and_every_alternative_of_the_target_can_hold(boxes, brute_optimum, data):
    drawn = data.draw(boxes)
    fault, steps = fault_of(drawn), brute_optimum(drawn)
    assert (steps is None) == (fault is not None and fault.kind in ("nothing moves", "unsolvable"))
    if fault is None:
        for clause in drawn.interlock.get(drawn.target, ()):
            alone = Lockbox(
                name="x",
                joints=drawn.joints,
                interlock={**drawn.interlock, drawn.target: (clause,)},
                initial=drawn.initial,
                target=drawn.target,
            )
            assert brute_optimum(alone) is not None


def test_named_boxes_pass():
    assert fault_of(box("reset")) is None
    assert fault_of(box("reset"), shortest=6).kind == "too short"
