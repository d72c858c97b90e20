"""Random numbers of populations: those of a study, or counted."""

import numpy as np

from lockprobe.simulation.montecarlo.compiled import SPAN, mixed, uniform
from lockprobe.simulation.montecarlo.streams import OF_FLIPS, OF_LISTING, Counted


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
