"""The collector of cyclic garbage is spared for a while, and is afterwards as it was."""

import gc

import pytest

from lockprobe.foundation.garbage import spared

USUAL = (700, 10, 10)


@pytest.fixture(autouse=True)
def as_in_a_fresh_process():
    """The collector as Python starts it; the tests run with another one."""
    before, frozen = gc.get_threshold(), gc.get_freeze_count()
    gc.unfreeze()
    gc.set_threshold(*USUAL)
    gc.collect()
    yield
    gc.set_threshold(*before)
    if frozen:
        gc.freeze()


class Round:
    """Something that holds itself."""

    def __init__(self):
        self.self = self


def rounds():
    return sum(isinstance(one, Round) for one in gc.get_objects())


def test_what_was_there_is_not_looked_at_and_what_comes_is():
    kept = Round()
    assert rounds() == 1
    with spared():
        assert gc.get_freeze_count() > 1000
        assert rounds() == 0  # what is frozen is not listed
        for _ in range(50_000):
            Round()
        assert 0 < rounds() < 20_000
    assert (gc.get_threshold(), gc.get_freeze_count()) == (USUAL, 0)
    gc.collect()
    assert rounds() == 1
    assert kept.self is kept


@pytest.mark.parametrize("threshold", [(0, 10, 10), (50_000, 5, 5)])
def test_who_collects_less_goes_on_to(threshold):
    gc.set_threshold(*threshold)
    with spared():
        assert gc.get_threshold() == threshold
    assert gc.get_threshold() == threshold


def test_what_somebody_else_froze_stays_so_and_no_more_is_frozen():
    gc.freeze()
    one = Round()
    with spared():
        assert rounds() == 1
    assert gc.get_freeze_count() > 1000
    assert one.self is one
