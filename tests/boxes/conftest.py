"""Boxes of every kind."""

from hypothesis import strategies as st

from lockprobe.boxes.box import Joint, Lockbox

NAMES = ("a", "b", "c", "d")


def clauses(joint):
    """Up to three clauses, whatever they ask of the other joints."""
    others = st.sampled_from([name for name in NAMES if name != joint])
    clause = st.dictionaries(others, st.booleans(), max_size=3)
    return st.lists(clause, min_size=1, max_size=3).map(tuple)


def any_box():
    """Four joints under any interlock, from any start; most are odd, and many cannot be opened."""
    kinds = st.sampled_from(["prismatic", "revolute"])
    return st.builds(
        Lockbox,
        name=st.just("drawn"),
        joints=st.tuples(*(st.builds(Joint, name=st.just(name), kind=kinds) for name in NAMES)),
        interlock=st.fixed_dictionaries({}, optional={name: clauses(name) for name in NAMES}),
        initial=st.tuples(*[st.booleans()] * 4),
        target=st.sampled_from(NAMES),
    )
