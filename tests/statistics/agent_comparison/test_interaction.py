"""Does noise help one agent more: found where it does, not where only base rates differ."""

import numpy as np
import pytest

from lockprobe.statistics.agent_comparison.interaction import interaction
from lockprobe.statistics.agent_comparison.paired import Sheet

P = (0.0, 0.2, 0.4)


def sheet(success, blocks, seed):
    """An agent that solves the box with these chances at every p."""
    solved = (np.random.default_rng(seed).random((blocks, len(success))) < np.array(success)).astype(float)
    return Sheet(solved=solved, steps=20.0 - 10 * solved)


def found(first, second, blocks=30, seed=0, **more):
    return interaction(
        P, sheet(first, blocks, [seed, 1]), sheet(second, blocks, [seed, 2]), np.random.default_rng([seed, 3]), **more
    )


def test_noise_that_helps_one_agent_only_is_found_and_where():
    helped = found((0.5, 0.5, 0.5), (0.1, 0.2, 0.9), blocks=60)
    assert helped.p_value < 0.01
    assert [at.dose for at in helped.at] == [0.2, 0.4]
    assert helped.at[1].p_adjusted == helped.p_value
    assert helped.at[1].change.low < 0.8 < helped.at[1].change.high
    turned = found((0.1, 0.2, 0.9), (0.5, 0.5, 0.5), blocks=60)
    assert turned.at[1].change.value < 0


@pytest.mark.parametrize(("first", "second"), [((0.2,) * 3, (0.9,) * 3), ((0.1, 0.3, 0.5), (0.4, 0.6, 0.8))])
def test_equal_effects_of_noise_on_unequal_agents_are_rarely_taken_for_different_ones(first, second):
    """So few rejections, or fewer, come of a level of 5 % in 999 of 1000 cases."""
    rejected = sum(found(first, second, seed=seed, flips=400).p_value < 0.05 for seed in range(200))
    assert rejected <= 20


def test_looking_at_every_p_is_paid_for():
    """The p-value of the farthest change is that of all changes, and no smaller than of this change alone."""
    three = found((0.4, 0.5, 0.5), (0.4, 0.5, 0.8), seed=3)
    first, second = sheet((0.4, 0.5, 0.5), 30, [3, 1]), sheet((0.4, 0.5, 0.8), 30, [3, 2])
    farthest = min(three.at, key=lambda at: at.p_adjusted)
    place = [0, P.index(farthest.dose)]
    alone = interaction(
        (0.0, farthest.dose),
        *(Sheet(solved=one.solved[:, place], steps=one.steps[:, place]) for one in (first, second)),
        np.random.default_rng(3),
    )
    assert three.p_value >= alone.p_value
    one, of_three = alone.at[0].change, farthest.change
    assert (one.value, one.blocks) == (of_three.value, of_three.blocks)
    assert of_three.low < one.low < one.high < of_three.high


def test_the_clearest_change_is_that_of_the_test_and_not_the_largest():
    """At 0.2 nine of forty blocks change, all one way; at 0.4 more do, both ways."""
    found = interaction((0.0, 0.2, 0.4), *opposed(), np.random.default_rng(1))
    assert [at.change.value for at in found.at] == [9 / 40, -10 / 40]
    assert found.p_value == found.at[0].p_adjusted < 0.05 < found.at[1].p_adjusted
    assert found.clearest == found.at[0]


def opposed():
    """Two agents: what the second solves more than the first in blocks of luck, at three p."""
    apart = np.repeat([[1, 1, -1], [-1, -1, 1], [0, 1, 0], [0, 0, 0]], [12, 7, 9, 12], axis=0)
    first, second = (apart < 0).astype(float), (apart > 0).astype(float)
    return tuple(Sheet(solved=solved, steps=20.0 - 10 * solved) for solved in (first, second))


def test_a_block_without_the_lowest_p_is_dropped():
    first, second = sheet((0.5,) * 3, 12, 1), sheet((0.5,) * 3, 12, 2)
    first.solved[:4, 0] = np.nan
    second.solved[5, 1] = np.nan
    some = interaction(P, first, second, np.random.default_rng(1))
    assert [at.change.pairs for at in some.at] == [7, 8]
    first.solved[:, 0] = np.nan
    assert interaction(P, first, second, np.random.default_rng(1)) is None
