"""A report is made without the collector of garbage."""

import gc

import pytest

from lockprobe.report.processor import uncollected


def test_the_collector_is_as_it_was():
    with uncollected():
        assert not gc.isenabled()
        with uncollected():
            pass
        assert not gc.isenabled()
    assert gc.isenabled()
    with pytest.raises(ValueError, match="invalid literal"), uncollected():
        int("x")
    assert gc.isenabled()
