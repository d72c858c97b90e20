"""The collector of cyclic garbage is spared for a while, and is afterwards as it was."""

import subprocess
import sys
from textwrap import dedent

import pytest


def in_a_fresh_process(code):
    """Run code where the collector is as Python starts it; here the tests run with another one."""
    before = """
    import gc
    from lockprobe.foundation.garbage import spared

    class Round:
        def __init__(self):
            self.self = self

    def rounds():
        return sum(isinstance(one, Round) for one in gc.get_objects())

    gc.set_threshold(700, 10, 10)
    """
    subprocess.run([sys.executable, "-c", dedent(before) + dedent(code)], check=True)


def test_what_was_there_is_not_looked_at_and_what_comes_is():
    in_a_fresh_process(
        """
        kept = Round()
        assert rounds() == 1
        with spared():
            assert gc.get_freeze_count() > 1000
            assert rounds() == 0  # what is frozen is not listed
            for _ in range(50_000):
                Round()
            assert 0 < rounds() < 20_000
            with spared():
                assert gc.get_threshold()[0] == 10_000
            assert gc.get_freeze_count() > 1000
        assert (gc.get_threshold(), gc.get_freeze_count()) == ((700, 10, 10), 0)
        gc.collect()
        assert rounds() == 1
        """
    )


@pytest.mark.parametrize("threshold", [(0, 10, 10), (50_000, 5, 5)])
def test_who_collects_less_goes_on_to(threshold):
    in_a_fresh_process(
        f"""
        gc.set_threshold(*{threshold})
        with spared():
            assert (gc.get_threshold(), gc.get_freeze_count()) == ({threshold}, 0)
        assert gc.get_threshold() == {threshold}
        """
    )


def test_what_somebody_else_froze_stays_so_and_no_more_is_frozen():
    in_a_fresh_process(
        """
        gc.freeze()
        frozen, one = gc.get_freeze_count(), Round()
        with spared():
            assert rounds() == 1
            assert gc.get_threshold()[0] == 10_000
        assert gc.get_freeze_count() == frozen
        """
    )
