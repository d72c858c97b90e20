"""Boxes of every kind, and a solver that shares nothing with the library's."""

import numpy as np
import pytest
from hypothesis import strategies as st

from lockprobe.boxes.box import Joint, Lockbox

NAMES = ("a", "b", "c", "d")


@st.composite
def any_box(draw) -> Lockbox:
    """Four joints under any interlock whatever, from any start; most are odd, and many cannot be opened."""
    literals = {
        name: st.dictionaries(st.sampled_from([n for n in NAMES if n != name]), st.booleans(), max_size=3)
        for name in NAMES
    }
    return Lockbox(
        name="drawn",
        joints=tuple(Joint(name=name, kind=draw(st.sampled_from(["prismatic", "revolute"]))) for name in NAMES),
        interlock={
            name: tuple(draw(st.lists(literals[name], min_size=1, max_size=3)))
            for name in draw(st.sets(st.sampled_from(NAMES)))
        },
        initial=tuple(draw(st.lists(st.booleans(), min_size=4, max_size=4))),
        target=draw(st.sampled_from(NAMES)),
    )


@pytest.fixture(scope="session")
def boxes():
    """The strategy."""
    return any_box()


def optimum_by_sets(box):
    """The optimum by growing the set of configurations, a table with one axis per joint, until the target may move."""
    index = {name: axis for axis, name in enumerate(box.names)}
    shape = (2,) * len(index)
    allowed = []
    for name in box.names:
        table = np.zeros(shape, bool)
        for clause in box.interlock.get(name, ({},)):
            where = [slice(None)] * len(index)
            for other, position in clause.items():
                where[index[other]] = slice(int(position), int(position) + 1)
            table[tuple(where)] = True
        allowed.append(table)
    reached = np.zeros(shape, bool)
    reached[tuple(map(int, box.initial))] = True
    turned = [tuple(slice(None, None, -1 if a == axis else 1) for a in range(len(shape))) for axis in range(len(shape))]
    before, steps = None, 1
    while not (reached & allowed[index[box.target]]).any():
        if before is not None and (before == reached).all():
            return None
        before, steps = reached.copy(), steps + 1
        for name, axis in index.items():
            if name != box.target:
                reached |= (before & allowed[axis])[turned[axis]]
    return steps


@pytest.fixture(scope="session")
def brute_optimum():
    """That solver."""
    return optimum_by_sets
