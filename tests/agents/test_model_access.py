"""How hosted models are reached: what can be asked for."""

import pytest

from lockprobe.agents.model_access import Access
from lockprobe.foundation.errors import BadValue


@pytest.mark.parametrize(
    ("setting", "value"),
    [
        ("connections", 0),
        ("connections", 10_001),
        ("timeout", 0.0),
        ("timeout", float("nan")),
        ("timeout", 86_401.0),
        ("retries", -1),
        ("retries", 101),
        ("pause", -0.1),
        ("pause", 61.0),
    ],
)
def test_what_is_out_of_range_is_one_line(setting, value):
    with pytest.raises(BadValue, match=f"^{setting}: got .*, expected "):
        Access(**{setting: value})


def test_as_they_come_a_provider_that_is_down_is_given_up_on_after_about_half_a_minute():
    access = Access()
    assert 25 <= sum(access.pause * 2**number for number in range(access.retries)) <= 40
