"""Money as it is written."""

import pytest

from lockprobe.studies.dollars import dollars


@pytest.mark.parametrize(
    ("amount", "said"),
    [(0, "0.00"), (0.1, "0.10"), (1234.5, "1,234.50"), (0.0144, "0.014"), (0.00001, "0.00001"), (0.0996, "0.10")],
)
def test_money_is_written_to_the_cent_or_to_two_digits(amount, said):
    assert dollars(amount) == said
