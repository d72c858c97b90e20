"""Random numbers of populations: those of a study, or counted."""

import itertools

import numpy as np
import pytest
from scipy.stats import chisquare, kstest

from lockprobe.foundation.seeds import generator
from lockprobe.simulation.montecarlo.compiled import SPAN, below, mixed, uniform
from lockprobe.simulation.montecarlo.streams import OF_FLIPS, OF_LISTING, Counted, FromTree


def counted(**settings):
    return Counted(**({"seed": 1, "joints": 4, "order": None, "flips": 20, "draws": 40} | settings))


def test_the_generator_is_splitmix64():
    """The first outputs from 1234567, as published with its Java and C versions."""
    found = [int(mixed(np.uint64(1234567), np.arange(1, 6, dtype=np.uint64))[i]) for i in range(5)]
    assert found == [
        6457827717110365317,
        3203168211198807973,
        9817491932198370423,
        4593380528125082431,
        16408922859458223821,
    ]


@pytest.mark.parametrize("limit", [2, 3, 625, 1024, 4096])
def test_whole_numbers_below_a_limit_are_alike(limit):
    taken = below(np.uint64(9), np.arange(200_000, dtype=np.uint64), np.uint64(limit))
    assert taken.max() == limit - 1
    assert chisquare(np.bincount(taken.astype(int), minlength=limit)).pvalue > 1e-4


def test_counted_numbers_are_uniform_and_of_one_trial_only():
    block = counted().block(0, 2_000)
    assert kstest(block.draws.ravel(), "uniform").pvalue > 1e-3
    assert kstest(block.flips.ravel(), "uniform").pvalue > 1e-3
    assert len(np.unique(np.concatenate([block.draws.ravel(), block.flips.ravel()]))) == 2_000 * 60
    assert abs(np.corrcoef(block.draws[:-1, 0], block.draws[1:, 0])[0, 1]) < 0.1


def test_counted_numbers_hang_on_seed_trial_and_place_alone():
    whole = counted().block(0, 50)
    for part in (counted().block(20, 5), counted(flips=3, draws=7).block(20, 5)):
        assert (part.orders == whole.orders[20:25]).all()
        assert (part.flips == whole.flips[20:25, : part.flips.shape[1]]).all()
        assert (part.draws == whole.draws[20:25, : part.draws.shape[1]]).all()
    assert not np.isin(counted(seed=2).block(0, 50).draws, whole.draws).any()


def test_no_trial_reaches_into_the_numbers_of_another():
    """Of the longest budget: two numbers a step for the agent, one for the flip, one a joint for the listing."""
    assert OF_FLIPS >= 2 * 10_000
    assert OF_FLIPS + 10_000 <= OF_LISTING
    assert OF_LISTING + 8 <= SPAN
    source = counted(draws=20_000)
    assert source.block(3, 1).draws[0, -1] == uniform(source.key, np.array([3 * SPAN + 19_999], np.uint64))[0]


def test_every_listing_is_equally_probable():
    orders = counted(joints=3, flips=0, draws=0).block(0, 30_000).orders
    found = [int((orders == order).all(1).sum()) for order in itertools.permutations(range(3))]
    assert chisquare(found).pvalue > 1e-4
    assert (counted(order=(0, 1, 2, 3)).block(0, 9).orders == np.arange(4)).all()


def test_one_trial_of_a_block_has_the_same_luck():
    for source in (counted(), counted(depth=5), FromTree(1, 1, 4, order=None, flips=20, draws=40)):
        block = source.block(0, 4)
        luck = source.luck(3)
        assert luck.order == tuple(block.orders[3])
        assert [luck.channel.random() for _ in range(20)] == block.flips[3].tolist()
        assert [luck.agent.random() for _ in range(40)] == block.draws[3].tolist()


def test_the_tree_is_that_of_a_study():
    block = FromTree(7, 3, 4, order=None, flips=2, draws=3).block(10, 1)
    stream = lambda name: generator(7, "rep", 3, "trial", 11, name)  # noqa: E731
    labels = stream("labels")
    labels.permutation(4)
    assert block.orders[0].tolist() == labels.permutation(4).tolist()
    assert block.flips[0].tolist() == stream("channel-0").random(2).tolist()
    assert block.draws[0].tolist() == stream("agent").random(3).tolist()
