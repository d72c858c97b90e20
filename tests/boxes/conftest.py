"""Boxes of every kind, and a solver that shares nothing with the library's."""

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
