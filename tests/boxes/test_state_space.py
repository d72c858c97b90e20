"""All configurations at once are all configurations one by one."""

import itertools

from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe.boxes.families import box, named_boxes
from lockprobe.boxes.state_space import holds, orders, space_of


def configurations(count):
    """Number and configuration of each."""
    return [
        (sum(1 << j for j in range(count) if bits[j]), bits) for bits in itertools.product((False, True), repeat=count)
    ]


@settings(max_examples=30)
@given(st.data())
def test_the_table_says_what_the_rule_says(boxes, data):
    drawn = data.draw(boxes)
    space = space_of(drawn)
    for number, configuration in configurations(4):
        assert [drawn.may_move(configuration, j) for j in range(4)] == space.may_move[number].tolist()


@settings(max_examples=30)
@given(st.data())
def test_steps_are_those_of_walking_about(boxes, data):
    drawn = data.draw(boxes)
    space, front, walked = space_of(drawn), {drawn.initial}, {drawn.initial: 0}
    while front:
        after = {
            drawn.attempt(configuration, j)[0]
            for configuration in front
            for j in range(4)
            if drawn.names[j] != drawn.target
        } - set(walked)
        walked |= dict.fromkeys(after, walked[next(iter(front))] + 1)
        front = after
    for number, configuration in configurations(4):
        assert space.steps[number] == walked.get(configuration, -1)
    assert sorted(space.reachable) == sorted(n for n, c in configurations(4) if c in walked)


@settings(max_examples=30)
@given(st.data())
def test_what_can_be_reached_can_be_reached_back(boxes, data):
    """The law behind "no dead ends": from each reachable configuration the same ones are reached as from the start."""
    drawn = data.draw(boxes)
    space = space_of(drawn)
    for number in space.reachable.tolist():
        moved = type(drawn)(
            name="x",
            joints=drawn.joints,
            interlock=drawn.interlock,
            initial=tuple(bool(number >> j & 1) for j in range(4)),
            target=drawn.target,
        )
        assert set(space_of(moved).reachable.tolist()) == set(space.reachable.tolist())


def test_a_clause_holds_where_all_its_positions_do():
    numbers = space_of(box("chain-3")).reachable
    found = holds(box("chain-3"), {"slider-1": True, "revolute-right": False}, numbers)
    assert [n for n, here in zip(numbers, found, strict=True) if here] == [0b010]
    assert holds(box("chain-3"), {}, numbers).all()


def test_orders_are_all_orders():
    assert {tuple(order) for order in orders(4).tolist()} == set(itertools.permutations(range(4)))


def test_no_named_box_takes_more_than_its_configurations():
    for name in named_boxes():
        space = space_of(box(name))
        assert len(space.reachable) <= 2 ** (space.joints - 1)
        assert space.optimum == space.steps[space.last[0]] + 1
