"""Parts of a study: every trial is in exactly one, and joined they are the study."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lockprobe.foundation.errors import BadValue
from lockprobe.studies.records.shard import Shard


@given(key=st.text(), of=st.integers(1, 60))
def test_every_key_is_in_exactly_one_part(key, of):
    assert sum(Shard(number=number, of=of).has(key) for number in range(1, of + 1)) == 1


@pytest.mark.parametrize(
    "text", ["", "3", "0/3", "4/3", "3/", "-1/3", "1/3/5", "1/100001", "x/y", " 1/3", "9" * 30 + "/9"]
)
def test_what_is_no_part_is_refused_in_a_line(text):
    with pytest.raises(BadValue) as refused:
        Shard.parse(text)
    assert "\n" not in str(refused.value)
