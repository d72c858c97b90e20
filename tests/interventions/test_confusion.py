"""A confusion matrix as text: what is written is read again."""

from hypothesis import given
from hypothesis import strategies as st

from lockprobe.interventions.confusion import entries_of, rates_of

RATE = st.integers(0, 1000).map(lambda found: found / 1000)
MATRIX = st.dictionaries(
    st.from_regex(r"[A-Za-z][A-Za-z0-9_-]{0,10}", fullmatch=True), st.tuples(RATE, RATE), max_size=8
)


@given(MATRIX)
def test_entries_are_read_again(rates):
    assert rates_of(entries_of(rates)) == rates
