"""What a bridge says of viewers whose misreadings are known."""

import pytest
from benchmarked import benchmark

from lockprobe.statistics.bridge.bridge import bridge

worlds = benchmark("bridge_worlds")


def test_an_agent_that_misreads_at_random_and_acts_on_it_alone():
    found = worlds.played("misreads at random, rate 0.25", 3, 40)
    assert found.verdict() == "all"
    assert found.arm("replayed").share.value == 1
    assert found.arm("replayed").change == found.total
    assert found.misread.misread / found.misread.claims == pytest.approx(0.25, abs=0.06)


def test_an_agent_that_reads_well_and_decides_otherwise():
    found = worlds.played("reads well, decides otherwise", 3, 20)
    assert found.verdict() == "nothing misread"
    assert found.arm("replayed").share.verdict == "none"
    assert {one.told for one in found.arms} == {0}


def test_an_agent_that_misreads_by_joint_and_direction():
    found = worlds.played("misreads by joint and direction", 3, 40)
    assert (found.verdict(), found.verdict("profile"), found.verdict("symmetric")) == ("all", "all", "part")


def test_no_share_without_a_difference():
    found = worlds.played("misreads, to no effect", 3, 20)
    assert found.verdict() == found.verdict("profile") == "no difference"
    assert all(one.share is None for one in found.arms)


def test_an_agent_that_says_nothing_has_no_known_misreadings():
    found = worlds.played("decides otherwise, and says nothing", 3, 12)
    assert found.verdict() == "nothing said"
    assert all(one.share is None for one in found.arms)


def test_it_needs_blocks_with_all_three():
    assert bridge({}, {"words": "words", "pictures": "pictures", "replayed": "replayed"}) is None
