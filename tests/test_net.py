"""Every number of the kept studies is as it was. One that changes on purpose is renewed (``python tests/net.py``)."""

import pytest
from net import STUDIES, kept, numbers, same


@pytest.mark.parametrize("name", STUDIES)
def test_every_number_is_as_it_was(name, tmp_path):
    before, now = kept(name), numbers(name, tmp_path)
    assert list(now) == list(before)
    assert {of: (before[of], said) for of, said in now.items() if not same(before[of], said)} == {}
