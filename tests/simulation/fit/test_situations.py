"""Situations are the distinct rows of some columns, and stand for all choices."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from lockprobe.simulation.fit.situations import Situations

ROWS = st.lists(st.tuples(st.sampled_from([0.0, -0.0, 0.5]), st.booleans(), st.integers(-1, 1)), max_size=30)


@given(rows=ROWS)
def test_choices_are_in_one_situation_exactly_if_no_column_differs(rows):
    table = np.array(rows).reshape(-1, 3)
    columns = [table[:, :2].reshape(-1, 2, 1), table[:, 2] > 0, table[:, 2].astype(np.int64)]
    found, first = Situations.of(*columns)
    seen = list(dict.fromkeys(rows))
    assert found.which.tolist() == [seen.index(row) for row in rows]
    assert found.counts.tolist() == [rows.count(row) for row in seen]
    assert first.tolist() == [rows.index(row) for row in seen]


@given(rows=ROWS.filter(len), data=st.data())
def test_some_choices_have_the_situations_in_which_one_of_them_is(rows, data):
    found, first = Situations.of(np.array(rows))
    chosen = np.array(data.draw(st.lists(st.booleans(), min_size=len(rows), max_size=len(rows))))
    some, kept = found.at(chosen)
    assert [rows[i] for i in first[kept][some.which]] == [row for row, there in zip(rows, chosen, strict=True) if there]
    assert some.counts.tolist() == np.bincount(some.which, minlength=kept.sum()).tolist()
    assert (some.counts > 0).all()
