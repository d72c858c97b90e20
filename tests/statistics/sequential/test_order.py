"""The order of blocks: every block has a place of its own, and those that were planned earlier come first."""

from itertools import accumulate, product

from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe.statistics.sequential.order import BlockOrder

STEPS = st.lists(st.tuples(st.integers(0, 3), st.integers(0, 4)), min_size=1, max_size=4)


@settings(max_examples=60, deadline=None)
@given(first=st.tuples(st.integers(1, 3), st.integers(1, 5)), steps=STEPS)
def test_every_block_has_its_place_and_earlier_plans_come_first(first, steps):
    plans = (*accumulate([first, *steps], lambda plan, more: (plan[0] + more[0], plan[1] + more[1])),)
    blocks = [product(range(1, rows + 1), range(1, columns + 1)) for rows, columns in plans]
    order, expected = BlockOrder(plans=plans), list(dict.fromkeys(block for own in blocks for block in own))
    assert order.rank(*zip(*expected, strict=True)).tolist() == list(range(len(expected)))
    for n in range(1, len(plans)):
        own = list(product(range(1, plans[n - 1][0] + 1), range(1, plans[n - 1][1] + 1)))
        before = BlockOrder(plans=plans[:n]).rank(*zip(*own, strict=True))
        assert (order.rank(*zip(*own, strict=True)) == before).all()
