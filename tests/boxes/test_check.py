"""What cannot be played is refused for the right reason."""

import re
from dataclasses import replace

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
            "unsolvable: nothing moves, every joint is locked at the start: a waits for b, b for c, and c for a",
        ),
        (
            {"a": ({"b": True},), "b": ({"a": True},)},
            "unsolvable",
            "unsolvable: no sequence of attempts moves a: a waits for b, and b for a",
        ),
        (  # the cycle may lie before the target, and in the second alternative
            {"a": ({"b": True},), "b": ({"c": True, "a": True}, {"c": True}), "c": ({"b": True},)},
            "nothing moves",
            "unsolvable: nothing moves, every joint is locked at the start: b waits for c, and c for b",
        ),
        (  # b moves, so nothing waits for it: no cycle is named
            {"a": ({"b": True, "c": True},), "b": ({"c": False},), "c": ({"b": False},)},
            "unsolvable",
            "unsolvable: no sequence of attempts moves a",
        ),
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


@settings(max_examples=30)
@given(st.data())
def test_a_cycle_that_is_named_is_one_of_joints_that_never_move(boxes, brute_optimum, data):
    drawn = data.draw(boxes)
    fault = fault_of(drawn)
    if fault is None or " waits for " not in fault.reason:
        return
    pairs = re.findall(r"(\w+) (?:waits )?for (\w+)", fault.reason)
    assert [other for _, other in pairs] == [*(one for one, _ in pairs[1:]), pairs[0][0]]
    for one, other in pairs:
        assert brute_optimum(replace(drawn, target=one)) is None or one == drawn.target
        assert any(other in clause for clause in drawn.interlock[one])


def test_named_boxes_pass():
    assert fault_of(box("reset")) is None
    assert fault_of(box("reset"), shortest=6).kind == "too short"
